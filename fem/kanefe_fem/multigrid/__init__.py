"""Large stiffness matrices without their factors: multigrid, the conjugate gradients and modes that it serves."""
