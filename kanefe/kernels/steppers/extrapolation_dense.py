"""What the extrapolation keeps, and its dense output: a polynomial through the start and all derivatives at the end.

The derivatives are extrapolated from backward differences of the substeps (Hairer & Ostermann 1990).
"""

from typing import Annotated

import numpy as np

from kanefe.kernels.language import INTERPOLATE, Array, Columns, copy, inlined, kernel, pointer
from kanefe.kernels.steppers.step_commands import Row, Step

LARGEST_COLUMNS = 12


class ExtrapolationStep(Step):
    """A step of the extrapolation."""

    column: int  # in work, and its substep
    substep: int
    aim: int  # columns aimed at
    taken: int  # columns of the last step
    filterings: int  # of the error
    was_rejected: bool
    has_kinks: bool
    is_stiff: bool  # modes or joints are
    error_before: float  # of the column before
    proposed: Annotated[np.ndarray, Columns(LARGEST_COLUMNS + 1)]  # step of each column
    difference: Row  # of the last two results
    first_slope: Row  # of the first substep
    tableau: Annotated[np.ndarray, Array(LARGEST_COLUMNS + 1, "size")]  # results
    substates: Annotated[
        np.ndarray, Array(LARGEST_COLUMNS * (LARGEST_COLUMNS + 1) // 2, "size")
    ]  # of all columns, one behind the other


@inlined
def first_substate(column: int) -> int:
    """Return the number of the first substate of a column."""
    return column * (column - 1) // 2


@kernel
def extrapolate(tableau: np.ndarray, column: int, first: int, new: np.ndarray, difference: np.ndarray) -> None:
    """Extrapolate the result of a column from those of the columns from `first` on (Aitken & Neville).

    Rows of the tableau hold the results of the column before, and on return those of this one but the last, `new`.
    """
    for k in range(1, column - first + 1):
        share, row = 1.0 / (column / (column - k) - 1.0), tableau[k - 1]
        for i in range(len(new)):
            difference[i] = share * (new[i] - row[i])
            row[i] = new[i]
            new[i] += difference[i]
    copy(new, tableau[column - first])


@kernel
def derive(step: ExtrapolationStep) -> None:
    """Write the derivatives at the end of the step over their factorials, times powers of the step.

    Row d of the tableau takes that of order d, extrapolated from the backward differences of all columns that have so
    many substeps; the first row takes what then is missing at the start.
    """
    columns, state, tableau, states, new = step.column, step.state, step.tableau, step.substates, step.at
    factor = 1.0
    for order in range(1, columns):
        for column in range(order, columns + 1):
            first = first_substate(column) - 1
            for i in range(column, order - 1, -1):  # in place, the last first
                before, now = states[first + i - 1] if i > 1 else state, states[first + i]
                for c in range(len(now)):
                    now[c] -= before[c]
        factor /= order
        for column in range(order, columns + 1):
            scale, last = column**order * factor, states[first_substate(column + 1) - 1]
            for c in range(len(new)):
                new[c] = scale * last[c]
            # rows at the end of the tableau hold the columns; the slope of the first substep is not wanted any more
            extrapolate(tableau[order:], column, order, new, step.first_slope)
        copy(new, tableau[order])
    # what the polynomial still misses at the start goes to the next power
    rest, end = tableau[0], step.difference
    for c in range(len(rest)):
        at_start, sign = end[c], -1.0
        for order in range(1, columns):
            at_start += sign * tableau[order, c]
            sign = -sign
        rest[c] = sign * (state[c] - at_start)


@pointer(INTERPOLATE)
def interpolate_extrapolating(
    integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray, t: float, out: np.ndarray
) -> None:
    """Write the state at a time of the last step: the polynomial of `derive`, in the time before the end."""
    step = ExtrapolationStep(integers, reals, vectors)
    if t == step.time:
        copy(step.state, out)
        return
    x, tableau, end = (t - step.time_old) / step.h - 1.0, step.tableau, step.difference
    for i in range(len(out)):
        value = tableau[0, i]
        for order in range(step.taken - 1, 0, -1):
            value = value * x + tableau[order, i]
        out[i] = value * x + end[i]
