"""Vibrations with which a run begins: whether a tolerance asks to follow them."""

from __future__ import annotations

import numpy as np

from kanefe.frames import Vector
from kanefe.integrate.dynamics import Dynamics
from kanefe.kernels.stepping import AT, PUSH_STIFFNESS, SLOPE
from kanefe.tree.scales import coordinate_moves, modal_frequencies

FIRST_SHARE = 0.05
"""Of the span: the first step where nothing vibrates."""

FIRST_PERIODS = 20.0
"""Radians of the lowest mode over which the trial step brings vibrations to rest."""

UNSEEN = 20.0
"""Of the absolute tolerance, which is a tenth of the relative one unless it is given: vibrations that are damped."""


def are_seen(dynamics: Dynamics, t: float, y: Vector, longest: float, rtol: float, atol: Vector) -> bool:
    """Tell whether modes vibrate by more than the tolerances from a state on.

    A linearly implicit trial step over some periods of the lowest mode, but no longer than `longest` s, brings the
    deflections close to where they would come to rest; their change is the size of the vibrations.

    Parameters
    ----------
    dynamics : Dynamics
        Of a scene in order n.
    t, longest : float
        s.
    y : ndarray
        State.
    rtol : float
        Relative to the deflection.
    atol : ndarray
        Absolute, for each component of the state.
    """
    model = dynamics.model
    rates = modal_frequencies(model)
    if not np.any(rates > 0.0):
        return False
    h = min(longest, FIRST_PERIODS / float(rates[rates > 0.0].min()))
    n, m = model.coordinate_count, model.free_count
    vectors = np.zeros((PUSH_STIFFNESS + 1, len(y)))
    vectors[AT] = y
    vectors[PUSH_STIFFNESS, n : n + m] = -h * y[n : n + m]
    dynamics.implicit_rate(t, vectors, h, h * h)
    modes = [(at, speed) for turns, at, speed in coordinate_moves(model) if not turns and rates[speed] > 0.0]
    return any(
        h * abs(y[n + speed] + h * vectors[SLOPE, n + speed]) > UNSEEN * atol[at] + rtol * abs(y[at])
        for at, speed in modes
    )
