"""Where the generalised-alpha method keeps what, the state that its unknowns lead to, and the one within a step.

Unknown are the accelerations du1 at the end of a step and, where loads have internal states that move, these: z1. With
the algorithmic accelerations a and the coefficients of the table (Bruels, Cardona & Arnold 2012),

    (1 - alpha_m) a1 + alpha_m a0 = (1 - alpha_f) du1 + alpha_f du0,
    u1 = u0 + h ((1 - gamma) a0 + gamma a1),    q1 = q0 moved by  h u0 + h^2 ((1/2 - beta) a0 + beta a1).

Internal states are integrated by the backward difference of order 2, with the ratio r of the step to the one before:

    z1 = ((1 + r)^2 z0 - r^2 z_before + (1 + r) h dz1/dt) / (1 + 2 r);

what relaxes faster than a step is forgotten at once. The first step, and the one after an event, is Euler's.
"""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.vectors import copy
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.compiler.arrays import INTERPOLATE
from kanefe.kernels.compiler.entries import pointer
from kanefe.kernels.steppers.directions_wanted import BEHIND_DIRECTIONS, REALS_BEHIND_DIRECTIONS, SHARE_OF_RATES
from kanefe.kernels.steppers.mixing import ROWS_OF_MIXING
from kanefe.kernels.steppers.step_commands import (
    AT,
    COORDINATES,
    DAMPING_DIRECTION,
    ROWS_OF_METHOD,
    SHARE_DAMPING,
    SHARE_STIFFNESS,
    SLOPE,
    SPEEDS,
    STATE,
    STATE_OLD,
    STEP,
    STIFFNESS_DIRECTION,
    TIME,
    TIME_AT,
    TIME_OLD,
    move,
    move_within,
)

# Columns of the table's one row
ALPHA_M, ALPHA_F, GAMMA, BETA = range(4)

# Integers of the method: how many internal states are followed; whether a sweep does not know all that is stiff, so
# that the Newton matrix comes from the Jacobian; whether modes or joints are stiff at all; iterations of a step;
# whether a Jacobian is there, was made in this step, and is wanted for the next iteration; whether the jerk is known;
# how many steps were left before their iteration had converged; how often the last Newton step was halved; iterations
# of the step before its last Jacobian, which are not mixed with others
(
    FOLLOWED,
    TAKES_JACOBIAN,
    HAS_STIFFNESS,
    ITERATION,
    HAS_JACOBIAN,
    IS_FRESH,
    IS_WANTED,
    HAS_JERK,
    UNCONVERGED,
    HALVINGS,
    MIXED_FROM,
) = range(BEHIND_DIRECTIONS, BEHIND_DIRECTIONS + 11)

# Reals of the method: step after which a was found, step before the last state (0: none), step and share of the rates
# of the factors (0: none), size of the last correction, of what is allowed; times of the first and the last step that
# was left early, and the largest correction that such a one would have had
(
    STEP_OF_A,
    STEP_BEFORE,
    FACTORED,
    FACTORED_SHARE,
    CORRECTION,
    FIRST_UNCONVERGED,
    LAST_UNCONVERGED,
    LARGEST_LEFT,
) = range(REALS_BEHIND_DIRECTIONS, REALS_BEHIND_DIRECTIONS + 8)
REALS = REALS_BEHIND_DIRECTIONS + 8

# Rows of the method, most with what belongs to speeds and internal states in their places: what is allowed; the
# unknowns, those at the start of the step and at the start of the one before; a (and dz/dt) at the start, as the last
# step left it, and a as the step takes it, and at the end; its rate of change; the move of a step; the known part of
# z1; the last correction of the unknowns, and the next one or the error, the same of what is allowed; the state at the
# end; memory of the mixing; the Jacobian, or directions. Powers are with the quadratures: at the start of the step in
# KNOWN, of the one before in BEFORE
(
    ALLOWED,
    FOUND,
    AT_START,
    BEFORE,
    LEFT,
    BEGUN,
    ENDS,
    JERK,
    MOVE,
    KNOWN,
    CHANGE,
    TRIED,
    RESIDUAL,
    NEW,
    MEMORY,
) = range(ROWS_OF_METHOD, ROWS_OF_METHOD + 15)
JACOBIAN_ROWS = MEMORY + ROWS_OF_MIXING


def rows_needed(takes_jacobian: bool, directions: int) -> tuple[int, int, int]:
    """Return how many rows of vectors the method takes: so many, and so many for every speed and internal state.

    With a Jacobian a row for each of its rows, and one for each row of the factors, which has two numbers less. With
    directions two rows for each, one for each internal state, and the same for the factors and two columns.
    """
    if directions > 0:
        return JACOBIAN_ROWS + 3 * directions + 2, 0, 1
    return (JACOBIAN_ROWS + 2, 2, 2) if takes_jacobian else (JACOBIAN_ROWS, 0, 0)


AHEAD_SHARE = 1e-4
"""Time over which the rate of change of the accelerations is found, relative to the step."""


@inlined
def ratio(table: np.ndarray) -> float:
    """Return the derivative of a1 by du1."""
    return (1.0 - table[0, ALPHA_F]) / (1.0 - table[0, ALPHA_M])


@inlined
def delay(table: np.ndarray, h: float) -> float:
    """Return by how much the time of a is after that of the state, s; below zero.

    So chosen at the start and where the step changes, it leaves order 2 to speeds, accelerations and constraint forces
    from the first step on (Arnold, Bruels & Cardona 2015).
    """
    return (table[0, ALPHA_M] - table[0, ALPHA_F]) * h


@kernel
def know_step(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray) -> None:
    """Write what a step has by its length: shares of C, K and of rates, the known part of z1, and a first guess."""
    n, h, last = integers[COORDINATES], reals[STEP], reals[STEP_BEFORE]
    end = n + integers[SPEEDS] + integers[FOLLOWED]
    reals[SHARE_DAMPING] = table[0, GAMMA] * ratio(table) * h
    reals[SHARE_STIFFNESS] = table[0, BETA] * ratio(table) * h * h
    r = h / last if last > 0.0 else 0.0
    reals[SHARE_OF_RATES] = (1.0 + r) * h / (1.0 + 2.0 * r) if integers[FOLLOWED] > 0 else 0.0
    for i in range(n, end):
        start, before = vectors[AT_START, i], vectors[BEFORE, i]
        vectors[KNOWN, i] = ((1.0 + r) ** 2 * start - r * r * before) / (1.0 + 2.0 * r)
        vectors[FOUND, i] = start + r * (start - before)
    for i in range(n, n + integers[SPEEDS]):
        vectors[BEGUN, i] = vectors[LEFT, i]
        if integers[HAS_JERK]:
            vectors[BEGUN, i] += (delay(table, h) - delay(table, reals[STEP_OF_A])) * vectors[JERK, i]


@kernel
def reach(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray, out: np.ndarray) -> None:
    """Write a1, the move and the state that follow from the unknowns; the quadratures stay."""
    n, m, h = integers[COORDINATES], integers[SPEEDS], reals[STEP]
    alpha_m, alpha_f, gamma, beta = table[0, ALPHA_M], table[0, ALPHA_F], table[0, GAMMA], table[0, BETA]
    state, found = vectors[STATE], vectors[FOUND]
    for i in range(n, n + m):
        begun = vectors[BEGUN, i]
        ends = ((1.0 - alpha_f) * found[i] + alpha_f * vectors[AT_START, i] - alpha_m * begun) / (1.0 - alpha_m)
        vectors[ENDS, i] = ends
        vectors[MOVE, i] = h * (state[i] + h * ((0.5 - beta) * begun + beta * ends))
        out[i] = state[i] + h * ((1.0 - gamma) * begun + gamma * ends)
    move(integers, state, vectors[MOVE], n, out)
    for i in range(n + m, len(out)):
        out[i] = found[i] if i < n + m + integers[FOLLOWED] else state[i]


@kernel
def put_end(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray) -> None:
    """Put what is to be evaluated: the end of the step, and for a linearly implicit evaluation what it is pushed by."""
    reach(integers, reals, vectors, table, vectors[AT])
    push_by(integers, reals, vectors, vectors[FOUND])
    reals[TIME_AT] = reals[TIME] + reals[STEP]


@kernel
def push_by(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, accelerations: np.ndarray) -> None:
    """Put the pushes with which a linearly implicit evaluation gives x of ``M x = F`` where x are the accelerations."""
    n = integers[COORDINATES]
    for i in range(n, n + integers[SPEEDS]):
        vectors[DAMPING_DIRECTION, i] = reals[SHARE_DAMPING] * accelerations[i]
        vectors[STIFFNESS_DIRECTION, i] = reals[SHARE_STIFFNESS] * accelerations[i]


@kernel
def put_ahead(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray) -> None:
    """Put the state a little later, for the rate of change of the accelerations."""
    n, m, e = integers[COORDINATES], integers[SPEEDS], AHEAD_SHARE * reals[STEP]
    at, state, du = vectors[AT], vectors[STATE], vectors[AT_START]
    copy(state, at)
    for i in range(n, n + m):
        vectors[MOVE, i] = e * (state[i] + 0.5 * e * du[i])
        at[i] = state[i] + e * du[i]
    move(integers, state, vectors[MOVE], n, at)
    for i in range(n + m, n + m + integers[FOLLOWED]):
        at[i] += e * vectors[SLOPE, i]
    reals[TIME_AT] = reals[TIME] + e


@pointer(INTERPOLATE)
def interpolate_generalised_alpha(
    integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray, t: float, out: np.ndarray
) -> None:
    """Write the state at a time of the last step: of third order, on the rotation group; powers are straight lines."""
    copy(vectors[STATE], out)
    if t == reals[TIME]:
        return
    n, m, h = integers[COORDINATES], integers[SPEEDS], reals[TIME] - reals[TIME_OLD]
    old, s, part = vectors[STATE_OLD], vectors[MOVE], vectors[SLOPE]
    x = (t - reals[TIME_OLD]) / h
    move_within(integers, old, vectors[STATE], s, x, h, part, out)
    for i in range(n + m, len(out) - 2):
        out[i] = (1.0 - x) * old[i] + x * vectors[STATE, i]
    for i in range(len(out) - 2, len(out)):
        start, end = vectors[BEFORE, i], vectors[KNOWN, i]
        out[i] = old[i] + h * x * (start + 0.5 * x * (end - start))
