"""The kernels of scenes that move in one plane: three speeds a body."""
