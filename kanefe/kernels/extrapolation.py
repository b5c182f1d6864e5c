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

from kanefe.kernels._numba import kernel
from kanefe.kernels.stepping import (
    ACCEPTED,
    AT,
    COORDINATES,
    DONE,
    ERROR,
    FAILED,
    FILTER_STEP,
    IMPLICIT,
    IS_FIXED,
    LAST_STEP,
    NEXT_OUTPUT,
    NEXT_STEP,
    OF_METHOD,
    PUSH_DAMPING,
    PUSH_STIFFNESS,
    REALS_OF_METHOD,
    REASON,
    REJECTED,
    ROWS_OF_METHOD,
    SHARE_DAMPING,
    SHARE_STIFFNESS,
    SLOPE,
    SMALLEST,
    SPEEDS,
    STAGE,
    STATE,
    STEP,
    STOP,
    TIME,
    TIME_AT,
    TIME_OLD,
    TOO_SMALL,
    WANTS_DENSE,
    accept,
    ask,
    clip,
    move,
    scaled_size,
)
from kanefe.kernels.vectors import copy

LARGEST_COLUMNS = 12

LARGEST_BESIDE_KINKS = 6
"""Columns of scenes whose forces have kinks: across one, the differences of further columns say nothing of errors."""

# Integers of the method: column in work and its substep, columns aimed at, columns of the last step, whether the step
# before was rejected, whether forces have kinks
COLUMN, SUBSTEP, AIM, TAKEN, WAS_REJECTED, HAS_KINKS = range(OF_METHOD, OF_METHOD + 6)

# Reals of the method: error and proposed step of each column
ERRORS = REALS_OF_METHOD
PROPOSED = REALS_OF_METHOD + LARGEST_COLUMNS + 2

# Rows of the method: difference of the last two results, results of the tableau, states of the substeps
DIFFERENCE = ROWS_OF_METHOD
TABLEAU = DIFFERENCE + 1
SUBSTATES = TABLEAU + LARGEST_COLUMNS + 1

BEGIN, MOVING, AFTER, LOOKING = range(4)

KINK = 100.0
"""Of the tolerance: by how much the rates at the end of a step, over the step, may differ from those of its dense
output. Without a kink they differ by less than 10."""


def rows_needed() -> int:
    """Return how many rows of vectors the method takes."""
    return SUBSTATES + LARGEST_COLUMNS * (LARGEST_COLUMNS + 1) // 2


def reals_needed() -> int:
    """Return how many reals the method takes."""
    return PROPOSED + LARGEST_COLUMNS + 2


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
        vectors[PUSH_STIFFNESS, i] = -h * vectors[AT, i]
        vectors[PUSH_DAMPING, i] = 0.0
    reals[SHARE_DAMPING], reals[SHARE_STIFFNESS] = h, h * h
    reals[TIME_AT] = reals[TIME] + integers[SUBSTEP] * h
    return ask(integers, IMPLICIT, MOVING)


@kernel
def _take_substep(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray) -> None:
    n, at, slope, step = integers[COORDINATES], vectors[AT], vectors[SLOPE], vectors[PUSH_STIFFNESS]
    h = reals[STEP] / integers[COLUMN]
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
    reals[FILTER_STEP] = reals[STEP] / column
    return scaled_size(integers, reals, vectors, difference, vectors[STATE], new)


@kernel
def _most_columns(integers: np.ndarray) -> int:
    return LARGEST_BESIDE_KINKS if integers[HAS_KINKS] else LARGEST_COLUMNS


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


@kernel
def _derive(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray) -> None:
    """Write the derivatives at the end of the step over their factorials, times powers of the step.

    Row d of the tableau takes that of order d, extrapolated from the backward differences of all columns that have so
    many substeps; the first row takes what then is missing at the start.
    """
    columns = integers[COLUMN]
    factor = 1.0
    for order in range(1, columns):
        for column in range(order, columns + 1):
            first = SUBSTATES + column * (column - 1) // 2 - 1
            for i in range(column, order - 1, -1):  # in place, the last first
                before, now = vectors[first + i - 1] if i > 1 else vectors[STATE], vectors[first + i]
                for c in range(len(now)):
                    now[c] -= before[c]
        factor /= order
        for column in range(order, columns + 1):
            scale = column**order * factor
            last = vectors[SUBSTATES + column * (column - 1) // 2 + column - 1]
            # Aitken & Neville over the columns from `order` on, rows at the end of the tableau as room
            new = vectors[AT]
            for c in range(len(new)):
                new[c] = scale * last[c]
            for k in range(1, column - order + 1):
                share = 1.0 / (column / (column - k) - 1.0)
                row = vectors[TABLEAU + order + k - 1]
                for c in range(len(new)):
                    change = share * (new[c] - row[c])
                    row[c] = new[c]
                    new[c] += change
            copy(new, vectors[TABLEAU + column])
        copy(vectors[AT], vectors[TABLEAU + order])
    # what the polynomial still misses at the start goes to the next power
    rest = vectors[TABLEAU]
    for c in range(len(rest)):
        at_start, sign = vectors[DIFFERENCE, c], -1.0
        for order in range(1, columns):
            at_start += sign * vectors[TABLEAU + order, c]
            sign = -sign
        rest[c] = sign * (vectors[STATE, c] - at_start)


def advance_extrapolating(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray) -> int:
    """Go on with the method: see `kanefe.kernels.stepping`."""
    stage = integers[STAGE]
    if stage == MOVING:
        _take_substep(integers, reals, vectors)
        column = integers[COLUMN]
        if integers[SUBSTEP] < column:
            return _ask_substep(integers, reals, vectors)
        error = _extrapolate(integers, reals, vectors)
        aim = integers[AIM]
        if integers[IS_FIXED]:
            if column < aim:
                return _begin_column(integers, reals, vectors, column + 1)
            return _finish(integers, reals, vectors)
        if column == 1:
            return _begin_column(integers, reals, vectors, 2)
        reals[ERRORS + column] = reals[ERROR] = error
        bounded = min(max(error, 1e-12), 1e12)
        reals[PROPOSED + column] = reals[STEP] * min(10.0, max(0.02, 0.94 * (0.65 / bounded) ** (1.0 / column)))
        if error <= 1.0 and column >= aim - 1:
            return _look_ahead(integers, reals, vectors) if integers[HAS_KINKS] else _finish(integers, reals, vectors)
        # the error that the columns to come would have to take away
        hopeless = 1.0
        for j in range(column + 1, aim + 2):
            hopeless *= j
        is_last = column >= min(aim + 1, _most_columns(integers))
        if not is_last and ((column < aim - 1 and error < 1e8) or error <= 4.0 * hopeless):
            return _begin_column(integers, reals, vectors, column + 1)
        integers[REJECTED] += 1
        integers[WAS_REJECTED] = 1
        best = min(max(min(aim, column), 2), _most_columns(integers) - 1)
        if best > 2 and column >= best and _work_per_time(reals, best - 1) < 0.8 * _work_per_time(reals, best):
            best -= 1
        integers[AIM] = best
        reals[NEXT_STEP] = min(reals[PROPOSED + best], 0.7 * reals[STEP])
        if reals[NEXT_STEP] < reals[SMALLEST]:
            integers[REASON] = TOO_SMALL
            return ask(integers, FAILED, AFTER)
    elif stage == LOOKING:
        if _kink(integers, reals, vectors) <= KINK:
            return _accept_last(integers, reals, vectors)
        integers[REJECTED] += 1
        integers[WAS_REJECTED] = 1
        reals[NEXT_STEP] = 0.2 * reals[STEP]
        if reals[NEXT_STEP] < reals[SMALLEST]:
            integers[REASON] = TOO_SMALL
            return ask(integers, FAILED, AFTER)
    elif stage == BEGIN:
        if reals[NEXT_STEP] <= 0.0:
            # long at first: vibrations which it does not resolve are damped by it, and hold up one that grows
            reals[NEXT_STEP] = 0.05 * (reals[STOP] - reals[TIME])
        if integers[AIM] == 0:
            integers[AIM] = min(6, _most_columns(integers) - 1)
    if reals[TIME] >= reals[STOP]:
        return ask(integers, DONE, AFTER)
    clip(integers, reals, reals[NEXT_STEP])
    return _begin_column(integers, reals, vectors, 1)


@kernel
def _finish(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray) -> int:
    """Accept the last result of the tableau."""
    copy(vectors[TABLEAU + integers[COLUMN] - 1], vectors[DIFFERENCE])
    if integers[WANTS_DENSE] or reals[NEXT_OUTPUT] < _end(integers, reals):
        _derive(integers, reals, vectors)
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
    _derive(integers, reals, vectors)
    copy(vectors[DIFFERENCE], vectors[AT])
    for i in range(n, n + m):
        vectors[PUSH_STIFFNESS, i] = vectors[PUSH_DAMPING, i] = 0.0
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


def interpolate_extrapolating(
    integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray, t: float, out: np.ndarray
) -> None:
    """Write the state at a time of the last step: the polynomial of `_derive`, in the time before the end."""
    if t >= reals[TIME]:
        copy(vectors[STATE], out)
        return
    x = (t - reals[TIME_OLD]) / reals[STEP] - 1.0
    columns = integers[TAKEN]
    for i in range(len(out)):
        value = vectors[TABLEAU, i]
        for order in range(columns - 1, 0, -1):
            value = value * x + vectors[TABLEAU + order, i]
        out[i] = value * x + vectors[DIFFERENCE, i]
