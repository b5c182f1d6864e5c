"""What a probe of a contact does at one state."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from kanefe.frames import Vector, cross
from kanefe.loads.base import End

if TYPE_CHECKING:
    from kanefe.contact.friction_couples import Couple


def along_surface(x: Vector, n: Vector) -> Vector:
    """Return the part of a vector across a unit normal."""
    return x - (x @ n) * n


class Touch(NamedTuple):
    """What a probe does.

    Attributes
    ----------
    depth : float
        Of its lowest point in the surface, m; below 0: the gap.
    end : int
        What it is fixed in.
    point, normal : ndarray, shape (3,)
        Where it touches, and away from the surface, in N.
    press : float
        Normal force, N.
    elastic, potential : float
        The elastic part of it, and the energy of that and of the anchor's spring.
    rate : float
        Of the depth, m/s.
    along : ndarray, shape (3,)
        Velocity along the surface, of which `carried` is that of a belt.
    carried : ndarray, shape (3,)
    pull, drag : ndarray, shape (3,)
        What the anchor's spring and damper ask for, and what friction gives of it, against the motion.
    slip_rate : float
        Of the path that is slid, m/s.
    stretch, stretch_rate : ndarray, shape (3,)
        Of the anchor's spring, in N.
    reserve : float
        Pull above what friction can take, N: it slips where this is above zero.
    couple : Couple or None
        Of friction against turning.
    """

    depth: float
    end: int
    point: Vector
    normal: Vector
    press: float = 0.0
    elastic: float = 0.0
    potential: float = 0.0
    rate: float = 0.0
    along: Vector = np.zeros(3)
    carried: Vector = np.zeros(3)
    pull: Vector = np.zeros(3)
    drag: Vector = np.zeros(3)
    stretch: Vector = np.zeros(3)
    stretch_rate: Vector = np.zeros(3)
    slip_rate: float = 0.0
    reserve: float = 0.0
    couple: Couple | None = None


def velocity_past(surface: End, end: End, point: Vector) -> Vector:
    """Return the velocity of what touches at a point in N, seen from the surface there, m/s, in N."""
    return end.v + cross(end.w, point - end.p) - surface.v - cross(surface.w, point - surface.p)
