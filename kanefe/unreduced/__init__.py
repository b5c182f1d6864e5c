"""The equations of scenes with unreduced bodies, which have all degrees of freedom of their mesh in sparse matrices."""
