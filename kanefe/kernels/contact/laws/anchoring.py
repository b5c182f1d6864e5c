"""What friction by an anchor makes of a pull (Eq. 11): see `kanefe.kernels.contact.laws.friction_law`."""

from collections import namedtuple
from typing import Any

from kanefe.kernels.constraints.tolerances import HELD_BEYOND
from kanefe.kernels.contact.falling import slip_speed
from kanefe.kernels.contact.laws.friction_law import Rubbed, Sliding
from kanefe.kernels.language import Vector, across, inlined, norm

Slip = namedtuple("Slip", "least limit damping speed exponent")
"""Friction of fast slipping and the limit of what is held, N; damping of what slips, N s/m; over which speed friction
falls from the limit, m/s, 0: at once, and by which exponent."""


@inlined
def pull_of(k: Any, c: Any, point: Sliding) -> Vector:
    """Return what spring and damper of an anchor ask for."""
    return k * across(point.stretch, point.normal) + c * point.along


@inlined
def by_anchor(k: Any, c: Any, pull: Vector, size: Any, point: Sliding, slip: Slip) -> Rubbed:
    """Return what an anchor gives of a pull, whose size is as friction measures it.

    What is held gives way beyond the limit, or beyond somewhat more where an event ends the stick. With s the speed of
    the slip, ``c s`` is what falling friction leaves of the pull: ``damping s + F(s) = size``.
    """
    kept = 0.0 * size + 1.0
    if point.is_held or slip.speed == 0.0:
        limit = slip.limit if point.is_held else slip.least
        most, beyond = HELD_BEYOND * limit if point.waits else limit, size - limit
        if size.real > 0.0 and size.real > most.real:
            kept = most / size
    else:
        if size.real > 0.0:
            fall = slip.limit - slip.least
            kept -= c * slip_speed(size, slip.least, fall, slip.damping, slip.speed, slip.exponent) / size
        beyond = size * (1.0 - kept)
    force = kept * pull
    return Rubbed(force, (1.0 / c) * (force - k * point.stretch), k, (1.0 - kept) * norm(pull) / c, beyond)
