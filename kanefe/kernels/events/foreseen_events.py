"""Events just behind a step, from which the run goes on, and how far the next step may go where they are further ahead.

At an event of a load its force has a kink. No method has its order across one: a step that passes it is tried again and
again, with shorter lengths. Instead it ends just before the event, where the forces are smooth, and so the polynomial
of the step holds on: the event is found on that, and the run goes on anew from there. No evaluation is made for it.

A polynomial that meets state and rate at both ends of a step has an error like ``x^2 (1 - x)^2`` at x of the step. In
its middle, where it may be well above that of the step itself, this is 1/16; at x = 1.01 it is 1e-4, a 600th of that.
"""

from typing import NamedTuple

import numpy as np

from kanefe.kernels.events.event_search import crossing_between, is_over, sign_of
from kanefe.kernels.events.watched_run import Does, WatchedRun
from kanefe.kernels.language import RealRows, exact, inlined
from kanefe.kernels.steppers.breakpoints import next_breakpoint
from kanefe.kernels.steppers.step_commands import Run, step_of


class Foresight(NamedTuple):
    """How far ahead events are looked for."""

    farthest: float = 16.0
    """Longest time ahead for which values are extrapolated, in multiples of the last step: twice what a step grows
    by."""
    places: int = 8
    """Number of places ahead at which signs are looked at."""
    farthest_sharp: float = 2.0
    sharpened: float = 0.8
    """Time to an event, in multiples of the last step, up to which its polynomial tells better when it comes than
    values in the step, since they are of a lower order; and the share of that time at whose end they are looked at
    instead."""
    fineness: float = 1e-9
    """Accuracy of a moment foreseen, relative to the time ahead that is looked at."""


FORESIGHT = Foresight()


@exact
def time_to_event(found: RealRows, watched: WatchedRun, t: float, last_step: float, next_step: float) -> float:
    """Return how long it is to the next event whose action needs no Python, at most to the end of a step; or infinity.

    Parameters
    ----------
    found : ndarray, shape (T, values)
        Values of functions; in the last four rows from the first quarter of the last step to its end.
    watched : WatchedRun
    t : float
        End of the last step, s.
    last_step, next_step : float
        Length of the step before, and the one that the error allows, s.
    """
    nearest, quarter = np.inf, 0.25 * last_step
    ahead = min(next_step, FORESIGHT.farthest * last_step) / quarter
    for event in range(len(watched.columns)):
        column = watched.columns[event]
        y3, y2, y1, y0 = found[-1, column], found[-2, column], found[-3, column], found[-4, column]
        if watched.kinds[event] >= Does.ACTS or is_over(t, watched.last[event], watched.span):
            continue
        if not abs(y3) > watched.noise[event] or watched.directions[event] * sign_of(y3) > 0.0:
            continue
        first, second = y3 - y2, y3 - 2.0 * y2 + y1
        differences = (y3, first, second, second - (y2 - 2.0 * y1 + y0))
        before = 0.0
        for place in range(1, FORESIGHT.places + 1):
            x = ahead * place / FORESIGHT.places
            if not _cubic(differences, x) * y3 > 0.0:
                a, b = _cubic(differences, before), _cubic(differences, x)
                nearest = min(
                    nearest, crossing_between(_cubic, differences, (before, a), (x, b), FORESIGHT.fineness * ahead)
                )
                break
            before = x
    return nearest * quarter


@inlined
def smooth_until(run: Run) -> float:
    """Return up to when the forces of a run are as smooth as in the last step, but for events, s."""
    step = step_of(run)
    end = step.stop
    if step.breakpoint_count > 0:
        i = next_breakpoint(step)
        if i < step.breakpoint_count:
            end = min(end, step.breakpoints[i])
    return end


@exact
def _cubic(differences: tuple[float, float, float, float], x: float) -> float:
    """Return the cubic through four values, so many of their distances behind the last one (Newton, backward)."""
    y, first, second, third = differences
    return y + x * (first + 0.5 * (x + 1.0) * (second + (x + 2.0) / 3.0 * third))
