"""Where the extrapolation keeps what: named places in the memory of `kanefe.kernels.stepping`."""

from __future__ import annotations

from kanefe.kernels.stepping import OF_METHOD, REALS_OF_METHOD, ROWS_OF_METHOD

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
