"""The polynomial through the nodes of a step of Radau's method: states within the step, and guesses of the next.

Where Radau's method keeps what: named places in the memory of `kanefe.kernels.steppers.step_commands`, and in its
table.
"""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.vectors import copy
from kanefe.kernels.compiler._numba import inlined, kernel, vector_kernel
from kanefe.kernels.compiler.arrays import INTERPOLATE
from kanefe.kernels.compiler.entries import pointer
from kanefe.kernels.steppers.step_commands import (
    MAP,
    MAP_SIZE,
    OF_METHOD,
    REALS_OF_METHOD,
    ROWS_OF_METHOD,
    STATE,
    STATE_OLD,
    STEP,
    STRAIGHT,
    TIME,
    TIME_OLD,
)

FARTHEST = 16.0
"""Longest step for which the polynomial of the last one is extrapolated, in multiples of that: behind a very short
step, such as one across an event, it is round-off."""


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
    """Write the changes of a step to come by extrapolating the polynomial of the last one, if that was long enough."""
    if integers[HAS_POLYNOMIAL] and reals[STEP] <= FARTHEST * reals[POLYNOMIAL_STEP]:
        ahead = reals[STEP] / reals[POLYNOMIAL_STEP]
        for k in range(STAGES):
            x = 1.0 + table[NODES, k] * ahead
            a, b, c = weight(table, 0, x), weight(table, 1, x), weight(table, 2, x) - 1.0
            change = vectors[CHANGES + k]
            for i in range(len(change)):
                change[i] = a * vectors[POLYNOMIAL, i] + b * vectors[POLYNOMIAL + 1, i] + c * vectors[POLYNOMIAL + 2, i]
    else:
        vectors[CHANGES : CHANGES + STAGES] = 0.0


@pointer(INTERPOLATE)
def interpolate_radau(
    integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray, t: float, out: np.ndarray
) -> None:
    """Write the state at a time of the last step: the collocation polynomial, of order 3."""
    if t == reals[TIME]:
        copy(vectors[STATE], out)
        return
    x = (t - reals[TIME_OLD]) / reals[POLYNOMIAL_STEP]
    a, b, c = weight(table, 0, x), weight(table, 1, x), weight(table, 2, x)
    _go_along(vectors[STATE_OLD], vectors[POLYNOMIAL : POLYNOMIAL + STAGES], a, b, c, out)
    normalise(integers, out)


@vector_kernel
def _go_along(old: np.ndarray, rows: np.ndarray, a: float, b: float, c: float, out: np.ndarray) -> None:
    """Write a state and so many times three changes of it."""
    for i in range(len(out)):
        out[i] = old[i] + (a * rows[0, i] + b * rows[1, i] + c * rows[2, i])


@kernel
def normalise(integers: np.ndarray, q: np.ndarray) -> None:
    """Bring Euler parameters to unit length."""
    for row in range(integers[MAP_SIZE]):
        if integers[MAP + 3 * row] != STRAIGHT:
            at = integers[MAP + 3 * row + 1]
            length = np.sqrt(q[at] ** 2 + q[at + 1] ** 2 + q[at + 2] ** 2 + q[at + 3] ** 2)
            for i in range(at, at + 4):
                q[i] /= length


STAGES = 3


# Integers of the method: node and iteration in work; whether no step has been accepted since the start, or since what
# is held has changed; whether the last try was rejected, the Jacobian is that of this state, is wanted, and a step's
# polynomial is there to extrapolate; how many internal states of loads are followed as speeds are
NODE, ITERATION, IS_FIRST, WAS_REJECTED, IS_FRESH, IS_WANTED, HAS_POLYNOMIAL, FOLLOWED = range(OF_METHOD, OF_METHOD + 8)


# Reals of the method: step of the factors (0: none) and of the polynomial, sizes of the last two corrections, rate of
# convergence, its share of the remaining error, step and error of the last accepted step, step for which the Jacobian
# was made
(
    FACTORED,
    POLYNOMIAL_STEP,
    CORRECTION,
    RATIO,
    RATE_OF_CONVERGENCE,
    REMAINING,
    OLD_STEP,
    OLD_ERROR,
    DIFFERENTIATED_STEP,
) = range(REALS_OF_METHOD, REALS_OF_METHOD + 9)


REALS = REALS_OF_METHOD + 9


# Rows of the method: rates at the start of the step, changes Z at the nodes, the same transformed, rates at the nodes,
# Z of the last accepted step, error, workspace: a complex vector of the state and one of the speeds, rates of
# rotations with which the matrices were made, the Jacobian (derivatives of the rates of speeds, states and quadratures
# by tangents, then by speeds and states); and the factors
START = ROWS_OF_METHOD


CHANGES = START + 1


TRANSFORMED = CHANGES + STAGES


RATES_AT = TRANSFORMED + STAGES


POLYNOMIAL = RATES_AT + STAGES


ESTIMATE = POLYNOMIAL + STAGES


ROOM = ESTIMATE + 1


TURNS = ROOM + 4


JACOBIAN_ROWS = TURNS + 1


# Rows of the table: nodes, T and its inverse, weights of the error estimate, and gamma, alpha, beta
NODES, T, INVERSE, WEIGHTS, EIGENVALUES = 0, 1, 1 + STAGES, 1 + 2 * STAGES, 2 + 2 * STAGES


def rows_needed() -> tuple[int, int, int]:
    """Return how many rows of vectors the method takes: so many, and so many for every speed and internal state.

    A row has two numbers for every speed, one for every state, and two more: one for each row of the Jacobian, and
    for three squares of factors with their pivots two for each speed and three for each state.
    """
    return JACOBIAN_ROWS + 2, 3, 4
