"""Steps across a kink of a law, taken again up to there."""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.vectors import copy
from kanefe.kernels.compiler._numba import exact
from kanefe.kernels.compiler.arrays import Integers, RealRows, Reals
from kanefe.kernels.events.roots_of_step import first_acting
from kanefe.kernels.events.watched_run import CHANGES, ENDS_STEP, WatchedRun
from kanefe.kernels.steppers.step_commands import (
    IS_FIXED,
    NEXT_STEP,
    REJECTED,
    SMALLEST,
    STAGE,
    STATE,
    STATE_OLD,
    STEPS,
    TIME,
    TIME_OLD,
    Run,
    begin_at,
    take_back_outputs,
)

BEYOND_KINK = 0.01
"""Share of a step that may lie beyond the zero at which a law changes: what is interpolated across that is as wrong as
the law there, in the powers of this share."""

LEAST_AGAIN = 1e8
"""Length of a step, in multiples of the shortest, below which none is taken again: it has no kink to speak of."""


@exact
def steps_again(watched: WatchedRun, run: Run, vectors: RealRows, found: int) -> bool:
    """Return whether the last step is taken again, up to just behind the first zero in it at which a law changes.

    What a polynomial says of the state there is wrong where the step goes across that. `found`: zeros of the step.
    """
    acting = first_acting(watched, found, False) if found > 0 else np.inf
    for i in range(found):
        kind = watched.kinds[int(watched.found[i, 1])]
        if watched.found[i, 0] == acting and kind != ENDS_STEP and kind != CHANGES:
            return False
    if not acting < np.inf or not step_again(run.integers, run.reals, vectors, acting):
        return False
    take_back_outputs(run, run.reals[TIME])
    return True


@exact
def step_again(integers: Integers, reals: Reals, vectors: RealRows, t: float) -> bool:
    """Go back to the start of the last step of a method, for one to just behind a time; return whether that is of use.

    Not where the time is near either end, and where steps are fixed.
    """
    start, end = reals[TIME_OLD], reals[TIME]
    left = BEYOND_KINK * (end - start)
    if integers[IS_FIXED] != 0 or integers[STAGE] == 0 or not (start + left < t < end - left):
        return False
    if t - start < LEAST_AGAIN * reals[SMALLEST]:
        return False
    copy(vectors[STATE_OLD], vectors[STATE])
    integers[STEPS] -= 1
    integers[REJECTED] += 1
    begin_at(integers, reals, start)
    reals[NEXT_STEP] = (1.0 + 0.5 * BEYOND_KINK) * (t - start)
    return True
