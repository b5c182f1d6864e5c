"""The order-n route: from the frozen scene to the tables of the kernels, and the calls of the kernels."""
