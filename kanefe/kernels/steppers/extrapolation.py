"""The linearly implicit Euler method, extrapolated: order and step adaptive, one sweep a substep, no Newton iteration.

A substep treats the stiffness and damping of modes and joints implicitly, everything else explicitly:

    (M + h C + h^2 K) z = F - h K u,    u+ = u + h z,    q+ = q moved by h u+  (rotations by the exponential map).

Its error has an expansion in powers of h, whatever part of the forces is in C and K, so that the results of 1, 2, 3,
... substeps extrapolate to any order (Deuflhard 1985; Hairer & Wanner, Solving Ordinary Differential Equations II,
1996, IV.9). Stiff modes do not hold the step down. The dense output is a polynomial through the state at the start and
the state and its derivatives at the end, extrapolated from backward differences (Hairer & Ostermann 1990).
"""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.vectors import copy
from kanefe.kernels.compiler._numba import kernel
from kanefe.kernels.compiler.arrays import ADVANCE
from kanefe.kernels.compiler.entries import pointer
from kanefe.kernels.steppers.extrapolation_dense import (
    AIM,
    COLUMN,
    DIFFERENCE,
    ERROR_BEFORE,
    FILTERINGS,
    FIRST_SLOPE,
    HAS_KINKS,
    LARGEST_COLUMNS,
    PROPOSED,
    SUBSTATES,
    SUBSTEP,
    TABLEAU,
    TAKEN,
    WAS_REJECTED,
    derive,
)
from kanefe.kernels.steppers.step_commands import (
    ACCEPTED,
    AT,
    COORDINATES,
    DAMPING_DIRECTION,
    DONE,
    ERROR,
    FAILED,
    HAS_LOOPS,
    IMPLICIT,
    IS_FIXED,
    IS_STIFF,
    LARGEST,
    LARGEST_OF_DRIVES,
    LAST_STEP,
    MAP,
    MAP_SIZE,
    NEXT_OUTPUT,
    NEXT_STEP,
    PROJECT,
    REASON,
    REJECTED,
    SETTLES,
    SHARE_DAMPING,
    SHARE_STIFFNESS,
    SLOPE,
    SMALLEST,
    SPEEDS,
    STAGE,
    START,
    STATE,
    STEP,
    STIFFNESS_DIRECTION,
    STOP,
    STRAIGHT,
    TIME,
    TIME_AT,
    TOO_SMALL,
    WANTS_DENSE,
    accept,
    ask,
    clip,
    move,
    scaled_size,
    turn,
)

LEAST_BESIDE_KINKS, LARGEST_BESIDE_KINKS = 4, 6
"""Least and largest number of columns for scenes whose forces have kinks: across a kink, the differences of many
columns are no error estimate, and those of few are easily too small."""

BEGIN, MOVING, FILTERING, LOOKING, AFTER, PROJECTED = range(6)

MOST_FILTERINGS = 2
"""Largest number of filterings of an error: each divides unresolved vibrations by their frequency times the substep."""

NEAR = 30.0
"""Error, in multiples of the tolerance, of the previous column below which the error of a column next to kinks is
accepted."""

KINK = 100.0
"""Largest difference between the rates at the end of a step, relative to the step, and those of its dense output, in
multiples of the tolerance. Without a kink it is below 10."""


@kernel
def _begin_column(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, column: int) -> int:
    integers[COLUMN] = column
    integers[SUBSTEP] = 0
    copy(vectors[STATE], vectors[AT])
    return _ask_substep(integers, reals, vectors)


@kernel
def _ask_substep(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray) -> int:
    n, m = integers[COORDINATES], integers[SPEEDS]
    h = reals[STEP] / integers[COLUMN]
    for i in range(n, n + m):
        vectors[STIFFNESS_DIRECTION, i] = -h * vectors[AT, i]
        vectors[DAMPING_DIRECTION, i] = 0.0
    reals[SHARE_DAMPING], reals[SHARE_STIFFNESS] = h, h * h
    reals[TIME_AT] = reals[TIME] + integers[SUBSTEP] * h
    return ask(integers, IMPLICIT, MOVING)


@kernel
def _take_substep(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray) -> None:
    n, at, slope, step = integers[COORDINATES], vectors[AT], vectors[SLOPE], vectors[STIFFNESS_DIRECTION]
    h = reals[STEP] / integers[COLUMN]
    if integers[SUBSTEP] == 0:
        copy(slope, vectors[FIRST_SLOPE])
    for i in range(n, len(at)):
        at[i] += h * slope[i]
        step[i] = h * at[i]
    move(integers, at, step, n, at)
    column = integers[COLUMN]
    copy(at, vectors[SUBSTATES + column * (column - 1) // 2 + integers[SUBSTEP]])
    integers[SUBSTEP] += 1


@kernel
def _extrapolate(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray) -> float:
    """Put the result of the column into the tableau (Aitken & Neville); return the size of the last difference."""
    column = integers[COLUMN]
    difference = vectors[DIFFERENCE]
    new = vectors[AT]  # T_j1, then T_j2, ...; the rows of the tableau hold those of the column before
    for order in range(1, column):
        share = 1.0 / (column / (column - order) - 1.0)
        row = vectors[TABLEAU + order - 1]
        for i in range(len(new)):
            difference[i] = share * (new[i] - row[i])
            row[i] = new[i]
            new[i] += difference[i]
    copy(new, vectors[TABLEAU + column - 1])
    if column == 1:
        return np.inf
    integers[FILTERINGS] = 0
    return scaled_size(integers, reals, vectors, difference, vectors[STATE], new)


@kernel
def _most_columns(integers: np.ndarray) -> int:
    return LARGEST_BESIDE_KINKS if integers[HAS_KINKS] else LARGEST_COLUMNS


@kernel
def _ask_filter(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray) -> int:
    """Request the sweep of the first substep again, with directional products for the last difference."""
    n, m = integers[COORDINATES], integers[SPEEDS]
    h = reals[STEP] / integers[COLUMN]
    difference, state = vectors[DIFFERENCE], vectors[STATE]
    copy(state, vectors[AT])
    for i in range(n, n + m):
        vectors[DAMPING_DIRECTION, i] = h * difference[i]
        vectors[STIFFNESS_DIRECTION, i] = h * (h * difference[i] - state[i])
    for row in range(integers[MAP_SIZE]):
        if integers[MAP + 3 * row] == STRAIGHT:
            vectors[STIFFNESS_DIRECTION, n + integers[MAP + 3 * row + 2]] += h * difference[integers[MAP + 3 * row + 1]]
    reals[TIME_AT] = reals[TIME]
    return ask(integers, IMPLICIT, FILTERING)


@kernel
def _filter(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray) -> float:
    """Replace the difference (a, b) of coordinates and speeds by what a substep makes of it; return its size.

    That is ``b' = (M + h C + h^2 K)^-1 (M b - h K a)`` and ``a' = a + h b'``: slow motions stay, vibrations which the
    substep does not resolve are damped. They are damped in the result too, so that they need not hold the step down
    (as in Hairer & Wanner 1996, IV.8, for RADAU5).
    """
    n, m = integers[COORDINATES], integers[SPEEDS]
    h = reals[STEP] / integers[COLUMN]
    difference, slope, first = vectors[DIFFERENCE], vectors[SLOPE], vectors[FIRST_SLOPE]
    for i in range(n, n + m):
        difference[i] -= slope[i] - first[i]
    turn(integers, vectors[STATE], h, difference, n, difference)
    return scaled_size(integers, reals, vectors, difference, vectors[STATE], vectors[TABLEAU + integers[COLUMN] - 1])


@kernel
def _work(column: int) -> float:
    """Return how many sweeps so many columns take."""
    return 0.5 * column * (column + 1)


@kernel
def _work_per_time(reals: np.ndarray, column: int) -> float:
    return _work(column) / reals[PROPOSED + column]


@kernel
def _choose_next(integers: np.ndarray, reals: np.ndarray) -> None:
    """Choose columns and length of the next step: the least work for the time (Hairer & Wanner 1996, IV.9)."""
    column, step = integers[COLUMN], reals[STEP]
    most = _most_columns(integers) - 1
    best = min(column, most)
    if column > 2 and _work_per_time(reals, column - 1) < 0.8 * _work_per_time(reals, column):
        best = column - 1
    elif column > 2 and _work_per_time(reals, column) < 0.9 * _work_per_time(reals, column - 1):
        best = min(column + 1, most)
    if column == 2:
        best = 3
    if integers[HAS_KINKS]:
        best = max(best, LEAST_BESIDE_KINKS)
    if integers[WAS_REJECTED]:
        best = min(best, column)
        proposed = min(step, reals[PROPOSED + best])
    elif best <= column:
        proposed = reals[PROPOSED + best]
    else:
        proposed = reals[PROPOSED + column] * _work(best) / _work(column)
    integers[AIM] = best
    # a step cut short says little about the next one
    reals[NEXT_STEP] = max(proposed, reals[NEXT_STEP]) if step < reals[NEXT_STEP] else proposed


@pointer(ADVANCE)
def advance_extrapolating(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray) -> int:
    """Continue the method: see `kanefe.kernels.steppers.step_commands`."""
    stage = integers[STAGE]
    if stage == MOVING:
        _take_substep(integers, reals, vectors)
        column = integers[COLUMN]
        if integers[SUBSTEP] < column:
            return _ask_substep(integers, reals, vectors)
        reals[ERROR] = _extrapolate(integers, reals, vectors)
        if integers[IS_FIXED]:
            if column < integers[AIM]:
                return _begin_column(integers, reals, vectors, column + 1)
            return _finish(integers, reals, vectors)
        if column == 1:
            return _begin_column(integers, reals, vectors, 2)
        if _is_to_be_filtered(integers, reals):
            return _ask_filter(integers, reals, vectors)
        command = _judge(integers, reals, vectors)
    elif stage == FILTERING:
        reals[ERROR] = _filter(integers, reals, vectors)
        integers[FILTERINGS] += 1
        if _is_to_be_filtered(integers, reals):
            return _ask_filter(integers, reals, vectors)
        command = _judge(integers, reals, vectors)
    elif stage == LOOKING:
        if _kink(integers, reals, vectors) <= KINK:
            return _accept_last(integers, reals, vectors)
        command = _reject(integers, reals, 0.2)
    elif stage == AFTER and integers[HAS_LOOPS]:
        h = reals[STEP] / integers[TAKEN]
        reals[SHARE_STIFFNESS] = h * h  # in a metric of masses alone the loops would push stiff modes
        return ask(integers, PROJECT, PROJECTED)
    else:
        if stage == BEGIN and integers[AIM] == 0:
            integers[AIM] = min(6, _most_columns(integers) - 1)
        command = START
    if command != START:
        return command
    if reals[TIME] >= reals[STOP]:
        return ask(integers, DONE, AFTER)
    if min(reals[NEXT_STEP], reals[LARGEST], reals[LARGEST_OF_DRIVES]) < _least(integers, reals):
        integers[REASON] = TOO_SMALL
        return ask(integers, FAILED, AFTER)
    clip(integers, reals, reals[NEXT_STEP])
    return _begin_column(integers, reals, vectors, 1)


@kernel
def _is_to_be_filtered(integers: np.ndarray, reals: np.ndarray) -> bool:
    """Return whether the error decides on the step, and could be one of vibrations only."""
    return (
        1.0 < reals[ERROR] < np.inf
        and integers[COLUMN] >= integers[AIM] - 1
        and integers[IS_STIFF] == 1
        and integers[FILTERINGS] < MOST_FILTERINGS
    )


@kernel
def _judge(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray) -> int:
    """Accept the last result, continue with the next column, or give the step up and return START."""
    column, aim, error = integers[COLUMN], integers[AIM], reals[ERROR]
    bounded = min(max(error, 1e-12), 1e12)
    reals[PROPOSED + column] = reals[STEP] * min(10.0, max(0.02, 0.94 * (0.65 / bounded) ** (1.0 / column)))
    before, reals[ERROR_BEFORE] = reals[ERROR_BEFORE], error
    if error <= 1.0 and column >= aim - 1:
        if not integers[HAS_KINKS]:
            return _finish(integers, reals, vectors)
        if column > 2 and before < NEAR:
            return _look_ahead(integers, reals, vectors)
        if column < LARGEST_BESIDE_KINKS:
            return _begin_column(integers, reals, vectors, column + 1)
    # the error that the columns to come would have to take away
    hopeless = 1.0
    for j in range(column + 1, aim + 2):
        hopeless *= j
    is_last = column >= min(aim + 1, _most_columns(integers))
    if not is_last and ((column < aim - 1 and error < 1e8) or error <= 4.0 * hopeless):
        return _begin_column(integers, reals, vectors, column + 1)
    best = min(max(min(aim, column), 2), _most_columns(integers) - 1)
    is_cheaper = best > 2 and column >= best and _work_per_time(reals, best - 1) < 0.8 * _work_per_time(reals, best)
    if is_cheaper and integers[IS_STIFF] == 0:
        best -= 1
    integers[AIM] = max(best, LEAST_BESIDE_KINKS) if integers[HAS_KINKS] else best
    # an error of vibrations hardly falls with the step until it resolves them: the longer steps are tried first
    least = 0.25 if integers[IS_STIFF] else 0.02
    return _reject(integers, reals, min(max(reals[PROPOSED + best] / reals[STEP], least), 0.7))


@kernel
def _least(integers: np.ndarray, reals: np.ndarray) -> float:
    """Return the smallest step for the columns aimed at: what they let grow, they do up to a step in proportion."""
    return reals[SMALLEST] * min(integers[AIM] + 1, LARGEST_COLUMNS) / LARGEST_COLUMNS


@kernel
def _reject(integers: np.ndarray, reals: np.ndarray, share: float) -> int:
    """Give the step up for a share of it, and return START, or FAILED."""
    integers[REJECTED] += 1
    integers[WAS_REJECTED] = 1
    reals[NEXT_STEP] = share * reals[STEP]
    if reals[NEXT_STEP] < _least(integers, reals):
        integers[REASON] = TOO_SMALL
        return ask(integers, FAILED, AFTER)
    return START


@kernel
def _finish(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray) -> int:
    """Accept the last result of the tableau."""
    copy(vectors[TABLEAU + integers[COLUMN] - 1], vectors[DIFFERENCE])
    left = _end(integers, reals) - reals[NEXT_OUTPUT]
    if integers[WANTS_DENSE] or left > 0.0 or (left == 0.0 and integers[SETTLES]):
        derive(integers, reals, vectors)
    return _accept_last(integers, reals, vectors)


@kernel
def _end(integers: np.ndarray, reals: np.ndarray) -> float:
    return reals[STOP] if integers[LAST_STEP] else reals[TIME] + reals[STEP]


@kernel
def _accept_last(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray) -> int:
    """Accept the result that `_finish` or `_look_ahead` has kept."""
    if not integers[IS_FIXED]:
        _choose_next(integers, reals)
        integers[WAS_REJECTED] = 0
    integers[TAKEN] = integers[COLUMN]
    ask(integers, ACCEPTED, AFTER)
    return accept(integers, reals, vectors, vectors[DIFFERENCE])


@kernel
def _look_ahead(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray) -> int:
    """Ask for the rates at the end: what begins behind the last substep, such as a contact, no column has seen."""
    n, m = integers[COORDINATES], integers[SPEEDS]
    copy(vectors[TABLEAU + integers[COLUMN] - 1], vectors[DIFFERENCE])
    derive(integers, reals, vectors)
    copy(vectors[DIFFERENCE], vectors[AT])
    for i in range(n, n + m):
        vectors[STIFFNESS_DIRECTION, i] = vectors[DAMPING_DIRECTION, i] = 0.0
    reals[SHARE_DAMPING] = reals[SHARE_STIFFNESS] = 0.0
    reals[TIME_AT] = _end(integers, reals)
    return ask(integers, IMPLICIT, LOOKING)


@kernel
def _kink(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray) -> float:
    """Return by how much of the tolerance the speeds change more over a step at the rates at its end than they did."""
    n, m = integers[COORDINATES], integers[SPEEDS]
    change = vectors[SUBSTATES]  # free again
    change[:] = 0.0
    for i in range(n, n + m):
        change[i] = reals[STEP] * vectors[SLOPE, i] - vectors[TABLEAU + 1, i]
    return scaled_size(integers, reals, vectors, change, vectors[STATE], vectors[DIFFERENCE])
