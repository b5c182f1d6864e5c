"""Vectors, rotations and small linear systems in kernels."""
