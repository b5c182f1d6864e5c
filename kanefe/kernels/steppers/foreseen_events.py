"""How far the next step may go: to the next event that the last one lets foresee.

At an event of a load its force has a kink. No method has its order across one: a step that passes it is tried again and
again, with shorter lengths. Instead it ends just before the event, and the next one, which is very short, crosses it.
"""

from __future__ import annotations

import numpy as np

from kanefe.kernels.compiler._numba import exact
from kanefe.kernels.compiler.arrays import Integers, RealRows, Reals
from kanefe.kernels.steppers.event_search import crossing_between, sign_of

FARTHEST = 16.0
"""Longest time ahead for which values are extrapolated, in multiples of the last step: twice what a step grows by."""

PLACES = 8
"""Number of places ahead at which signs are looked at."""

BEFORE = 1e-6
"""Time before an event at which a step ends, relative to what is left to it: hardly more than extrapolation is worth
where motions are smooth, and little enough to be crossed at once."""

CROSSED = 1e-5
"""Time to an event that the next step crosses, relative to the length that it would have without one."""

FINENESS = 1e-9
"""Accuracy of a moment foreseen, relative to the time ahead that is looked at."""


@exact
def step_to_event(
    found: RealRows, columns: Integers, directions: Integers, noise: Reals, last_step: float, next_step: float
) -> float:
    """Return the longest next step (s) that passes no event, or crosses it where it is near; infinity without one.

    Parameters
    ----------
    found : ndarray, shape (T, values)
        Values of functions; in the last four rows from the first quarter of the last step to its end.
    columns, directions : ndarray of int, shape (events,)
        Of each event its column, and the way through zero that counts: 1, -1, or 0 for both.
    noise : ndarray, shape (events,)
        Up to which size a value has no sign.
    last_step, next_step : float
        Length of the step before, and the one that the error allows, s.
    """
    nearest, quarter = np.inf, 0.25 * last_step
    ahead = min(next_step, FARTHEST * last_step) / quarter
    for event in range(len(columns)):
        column = columns[event]
        y3, y2, y1, y0 = found[-1, column], found[-2, column], found[-3, column], found[-4, column]
        if not abs(y3) > noise[event] or directions[event] * sign_of(y3) > 0.0:
            continue
        first, second = y3 - y2, y3 - 2.0 * y2 + y1
        differences = (y3, first, second, second - (y2 - 2.0 * y1 + y0))
        before = 0.0
        for place in range(1, PLACES + 1):
            x = ahead * place / PLACES
            if not _cubic(differences, x) * y3 > 0.0:
                a, b = _cubic(differences, before), _cubic(differences, x)
                nearest = min(nearest, crossing_between(_cubic, differences, before, x, a, b, FINENESS * ahead))
                break
            before = x
    if not nearest < np.inf:
        return np.inf
    left = nearest * quarter
    return left * (1.0 - BEFORE) if left > CROSSED * next_step else max(2.0 * left, BEFORE * next_step)


@exact
def _cubic(differences: tuple[float, float, float, float], x: float) -> float:
    """Return the cubic through four values, so many of their distances behind the last one (Newton, backward)."""
    y, first, second, third = differences
    return y + x * (first + 0.5 * (x + 1.0) * (second + (x + 2.0) / 3.0 * third))
