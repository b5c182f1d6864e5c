"""The rates of the states of a run, all at once: a method of integration that visits states and takes no step."""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.vectors import copy
from kanefe.kernels.compiler.arrays import ADVANCE, INTERPOLATE
from kanefe.kernels.compiler.entries import pointer
from kanefe.kernels.steppers.step_commands import AT, DONE, RATES, SLOPE, STAGE, STEPS, TIME_AT, ask

TIME_OF, STATE_OF = 0, 1


@pointer(ADVANCE)
def revisit(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray) -> int:
    """Ask for the rates at one state after the other; write them in the place of the states.

    Rows of the table are a time (s) and a state. `integers` count in STEPS the rows that are done.
    """
    if integers[STAGE]:
        copy(vectors[SLOPE], table[integers[STEPS], STATE_OF:])
        integers[STEPS] += 1
    if integers[STEPS] == len(table):
        return DONE
    reals[TIME_AT] = table[integers[STEPS], TIME_OF]
    copy(table[integers[STEPS], STATE_OF:], vectors[AT])
    return ask(integers, RATES, 1)


@pointer(INTERPOLATE)
def between_states(
    integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray, t: float, out: np.ndarray
) -> None:
    """Write nothing: there are no steps to look into."""
