"""What a point of a contact does at one state."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kanefe.frames import Vector


def along_surface(x: Vector, n: Vector) -> Vector:
    """Return the part of a vector across a unit normal."""
    return x - (x @ n) * n


class Touch(NamedTuple):
    """What a point does.

    Attributes
    ----------
    depth : float
        Of its lowest place in the surface, m; below 0: the gap.
    end : int
        What it is fixed in.
    point, normal : ndarray, shape (3,)
        Where it touches, and away from the surface, in N.
    normal_force : float
        Normal force, N.
    along : ndarray, shape (3,)
        Velocity along the surface, m/s.
    tangential : ndarray, shape (3,)
        Friction, against the motion, N.
    stretch, stretch_rate : ndarray, shape (3,)
        Of the anchor's spring, in N.
    slip_margin : float
        Pull above what friction can take, N: it slips where this is above zero.
    moment : ndarray, shape (3,)
        Of friction against turning, on what touches, in N, N m.
    share : float
        Of the stiffness of the contact.
    """

    depth: float
    end: int
    point: Vector
    normal: Vector
    normal_force: float = 0.0
    along: Vector = np.zeros(3)
    tangential: Vector = np.zeros(3)
    stretch: Vector = np.zeros(3)
    stretch_rate: Vector = np.zeros(3)
    slip_margin: float = 0.0
    moment: Vector = np.zeros(3)
    share: float = 1.0
