"""Steps across a kink of a law, taken again up to there."""

import numpy as np

from kanefe.kernels.events.roots_of_step import first_acting
from kanefe.kernels.events.watched_run import Does, WatchedRun
from kanefe.kernels.language import copy, exact
from kanefe.kernels.steppers.step_commands import Run, Step, begin_at, step_of, take_back_outputs

BEYOND_KINK = 0.01
"""Share of a step that may lie beyond the zero at which a law changes: what is interpolated across that is as wrong as
the law there, in the powers of this share."""

LEAST_AGAIN = 1e8
"""Length of a step, in multiples of the shortest, below which none is taken again: it has no kink to speak of."""


@exact
def steps_again(watched: WatchedRun, run: Run, found: int) -> bool:
    """Return whether the last step is taken again, up to just behind the first zero in it at which a law changes.

    What a polynomial says of the state there is wrong where the step goes across that. `found`: zeros of the step.
    """
    acting = first_acting(watched, found, False) if found > 0 else np.inf
    for i in range(found):
        does = watched.kinds[int(watched.found[i, 1])]
        if watched.found[i, 0] == acting and does != Does.ENDS_STEP and does != Does.CHANGES:
            return False
    step = step_of(run)
    if not acting < np.inf or not step_again(step, acting):
        return False
    take_back_outputs(run, step.time)
    return True


@exact
def step_again(step: Step, t: float) -> bool:
    """Go back to the start of the last step of a method, for one to just behind a time; return whether that is of use.

    Not where the time is near either end, and where steps are fixed.
    """
    start, end = step.time_old, step.time
    left = BEYOND_KINK * (end - start)
    if step.is_fixed or step.stage == 0 or not (start + left < t < end - left):
        return False
    if t - start < LEAST_AGAIN * step.smallest:
        return False
    copy(step.state_old, step.state)
    step.steps -= 1
    step.rejected += 1
    begin_at(step, start)
    step.next_step = (1.0 + 0.5 * BEYOND_KINK) * (t - start)
    return True
