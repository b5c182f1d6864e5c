"""Load factors at which a rest becomes unstable: buckling, divergence and flutter."""
