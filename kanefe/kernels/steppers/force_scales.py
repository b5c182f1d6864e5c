"""How exactly modes are followed: relative to the largest force that the modes of their body have had.

A force is a stiffness times a deflection. Where a body is bent by a ten-thousandth of its length, an error that is a
share of the length is ten thousand times that share of the force. An error e of a mode makes the force ``m omega^2 e``,
so that allowed along it is, with the tolerance r of the run,

    e = r F / omega^2,    F = max over the run so far of |omega^2 eta|,

with deflections eta relative to what moves the body by its size, for which m is the same of all modes; and no more than
the tolerance of positions.
"""

from __future__ import annotations

import numpy as np

from kanefe.kernels.compiler._numba import kernel
from kanefe.kernels.steppers.step_commands import (
    COORDINATES,
    LARGE,
    LARGEST_FORCES,
    LEAST_ALLOWED,
    MAP,
    MAP_SIZE,
    OF_FORCES,
    SCALE,
    STATE,
    STRAIGHT,
    UNIT,
)


@kernel
def put_force_scales(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray) -> None:
    """Write what is allowed along the modes of each body whose force is larger than before in STATE."""
    n, row = integers[COORDINATES], 0
    while row < integers[MAP_SIZE]:
        body, first, total = _body(integers, vectors, n, row), row, 0.0
        while row < integers[MAP_SIZE] and _body(integers, vectors, n, row) == body:
            at, i = integers[MAP + 3 * row + 1], n + integers[MAP + 3 * row + 2]
            total += (vectors[STATE, at] * vectors[UNIT, at] * _square(vectors, at, i)) ** 2
            row += 1
        if body == 0.0:
            continue
        at = integers[MAP + 3 * first + 1]
        if total <= vectors[LARGEST_FORCES, at]:
            continue
        vectors[LARGEST_FORCES, at] = total
        for k in range(first, row):
            at, i = integers[MAP + 3 * k + 1], n + integers[MAP + 3 * k + 2]
            allowed = reals[OF_FORCES] * np.sqrt(total) / _square(vectors, at, i)
            vectors[SCALE, at] = min(max(allowed, reals[LEAST_ALLOWED]) / vectors[UNIT, at], vectors[LARGE, at])
            vectors[SCALE, i] = vectors[SCALE, at] * vectors[LARGE, i] / vectors[LARGE, at]


@kernel
def _square(vectors: np.ndarray, at: int, i: int) -> float:
    """Return the square of the frequency of a mode, at least 1: scales of speeds are those of places times that."""
    return float((vectors[LARGE, i] / vectors[LARGE, at]) ** 2)


@kernel
def _body(integers: np.ndarray, vectors: np.ndarray, n: int, row: int) -> float:
    """Return the number of the body whose mode is in a row of the map; 0 of joints."""
    if integers[MAP + 3 * row] != STRAIGHT:
        return 0.0
    return float(vectors[UNIT, n + integers[MAP + 3 * row + 2]])
