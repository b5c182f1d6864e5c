"""Tables that kernels read, from the frozen scene."""
