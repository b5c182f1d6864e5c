"""Numbers of lists."""

import numpy as np

from kanefe.kernels.compiler._numba import inlined


@inlined
def copy(source: np.ndarray, target: np.ndarray) -> None:
    """Copy numbers one by one: arrays cannot be assigned to slices where no memory is to be had."""
    for i in range(len(source)):
        target[i] = source[i]
