"""The polynomial through the nodes of a step of Radau's method: states within the step, and guesses of the next."""

from __future__ import annotations

import numpy as np

from kanefe.kernels._numba import inlined, kernel
from kanefe.kernels.radau_layout import (
    CHANGES,
    HAS_POLYNOMIAL,
    NODES,
    POLYNOMIAL,
    POLYNOMIAL_STEP,
    STAGES,
)
from kanefe.kernels.stepping import (
    MAP,
    MAP_SIZE,
    STATE,
    STATE_OLD,
    STEP,
    STRAIGHT,
    TIME,
    TIME_OLD,
)
from kanefe.kernels.vectors import copy


@inlined
def weight(table: np.ndarray, j: int, x: float) -> float:
    """Return at x, of the step, the polynomial that is one at node j and zero at the start and the other nodes."""
    nodes = table[NODES]
    value = x / nodes[j]
    for k in range(STAGES):
        if k != j:
            value *= (x - nodes[k]) / (nodes[j] - nodes[k])
    return value


@kernel
def guess_changes(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray) -> None:
    """Write the changes of a step to come: the polynomial of the last one goes on."""
    if integers[HAS_POLYNOMIAL]:
        ahead = reals[STEP] / reals[POLYNOMIAL_STEP]
        for k in range(STAGES):
            x = 1.0 + table[NODES, k] * ahead
            a, b, c = weight(table, 0, x), weight(table, 1, x), weight(table, 2, x) - 1.0
            change = vectors[CHANGES + k]
            for i in range(len(change)):
                change[i] = a * vectors[POLYNOMIAL, i] + b * vectors[POLYNOMIAL + 1, i] + c * vectors[POLYNOMIAL + 2, i]
    else:
        vectors[CHANGES : CHANGES + STAGES] = 0.0


def interpolate_radau(
    integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray, t: float, out: np.ndarray
) -> None:
    """Write the state at a time of the last step: the collocation polynomial, of order 3."""
    if t >= reals[TIME]:
        copy(vectors[STATE], out)
        return
    x = (t - reals[TIME_OLD]) / reals[POLYNOMIAL_STEP]
    a, b, c = weight(table, 0, x), weight(table, 1, x), weight(table, 2, x)
    for i in range(len(out)):
        change = a * vectors[POLYNOMIAL, i] + b * vectors[POLYNOMIAL + 1, i] + c * vectors[POLYNOMIAL + 2, i]
        out[i] = vectors[STATE_OLD, i] + change
    normalise(integers, out)


@kernel
def normalise(integers: np.ndarray, q: np.ndarray) -> None:
    """Bring Euler parameters to unit length."""
    for row in range(integers[MAP_SIZE]):
        if integers[MAP + 3 * row] != STRAIGHT:
            at = integers[MAP + 3 * row + 1]
            length = np.sqrt(q[at] ** 2 + q[at + 1] ** 2 + q[at + 2] ** 2 + q[at + 3] ** 2)
            for i in range(at, at + 4):
                q[i] /= length
