"""Friction that falls with the speed of slipping, from static to kinetic, as Stribeck found it."""

from __future__ import annotations

import math

from kanefe.kernels.force_elements.falling_friction import slip_speed as slip_speed_where_it_falls


def share_of_static(slip: float, speed: float) -> float:
    """Return how much of the fall from static friction is still to come at a speed of slipping, of 1 at rest."""
    return math.exp(-((slip / speed) ** 2))


def slip_speed(pull: float, least: float, fall: float, damping: float, speed: float) -> float:
    """Return how fast an anchor slips (m/s): the root of ``c s + F(s) = pull``, 0 if there is none.

    ``F(s) = least + fall exp(-(s/speed)^2)``.

    Parameters
    ----------
    pull : float
        What spring and damper of the anchor ask for, N.
    least, fall : float
        Friction of fast slipping, and how much more it is at rest, N.
    damping : float
        Of the anchor, N s/m.
    speed : float
        In which it falls, m/s; 0: at once.
    """
    if speed == 0.0:
        return max(0.0, (pull - least) / damping)
    return float(slip_speed_where_it_falls(pull, least, fall, damping, speed))
