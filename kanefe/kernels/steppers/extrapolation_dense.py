"""Dense output of the extrapolation: a polynomial through the state at the start and all derivatives at the end.

The derivatives are extrapolated from backward differences of the substeps (Hairer & Ostermann 1990).

Where the extrapolation keeps what: named places in the memory of `kanefe.kernels.steppers.step_commands`.
"""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.vectors import copy
from kanefe.kernels.compiler._numba import kernel
from kanefe.kernels.compiler.arrays import INTERPOLATE
from kanefe.kernels.compiler.entries import pointer
from kanefe.kernels.steppers.step_commands import (
    AT,
    OF_METHOD,
    REALS_OF_METHOD,
    ROWS_OF_METHOD,
    STATE,
    STEP,
    TIME,
    TIME_OLD,
)


@kernel
def derive(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray) -> None:
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
            # Aitken & Neville over the columns from `order` on, rows at the end of the tableau as workspace
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


@pointer(INTERPOLATE)
def interpolate_extrapolating(
    integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray, t: float, out: np.ndarray
) -> None:
    """Write the state at a time of the last step: the polynomial of `derive`, in the time before the end."""
    if t == reals[TIME]:
        copy(vectors[STATE], out)
        return
    x = (t - reals[TIME_OLD]) / reals[STEP] - 1.0
    columns = integers[TAKEN]
    for i in range(len(out)):
        value = vectors[TABLEAU, i]
        for order in range(columns - 1, 0, -1):
            value = value * x + vectors[TABLEAU + order, i]
        out[i] = value * x + vectors[DIFFERENCE, i]


LARGEST_COLUMNS = 12


# Integers of the method: column in work and its substep, columns aimed at, columns of the last step, whether the step
# before was rejected, how often the error has been filtered, whether forces have kinks
COLUMN, SUBSTEP, AIM, TAKEN, WAS_REJECTED, FILTERINGS, HAS_KINKS = range(OF_METHOD, OF_METHOD + 7)


# Reals of the method: error of the column before, proposed step of each column
ERROR_BEFORE = REALS_OF_METHOD


PROPOSED = REALS_OF_METHOD + 1


# Rows of the method: difference of the last two results, slope of the first substep, results of the tableau, states of
# the substeps
DIFFERENCE = ROWS_OF_METHOD


FIRST_SLOPE = DIFFERENCE + 1


TABLEAU = FIRST_SLOPE + 1


SUBSTATES = TABLEAU + LARGEST_COLUMNS + 1


def rows_needed() -> int:
    """Return how many rows of vectors the method takes."""
    return SUBSTATES + LARGEST_COLUMNS * (LARGEST_COLUMNS + 1) // 2


def reals_needed() -> int:
    """Return how many reals the method takes."""
    return PROPOSED + LARGEST_COLUMNS + 2
