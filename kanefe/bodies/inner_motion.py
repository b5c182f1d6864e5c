"""Motion of a frame of a flexible body, seen from the body."""

from __future__ import annotations

from typing import NamedTuple

from kanefe.frames import Matrix, Vector


class InnerMotion(NamedTuple):
    """Motion of a frame n of a flexible body seen from G, in components of G.

    Attributes
    ----------
    p, A : ndarray, shapes (3,), (3, 3)
        Place (m) and rotation A_Gn.
    v, w : ndarray, shape (3,)
        Velocity and angular velocity.
    motion : ndarray, shape (6, k)
        Their derivatives by the rates of the coordinates.
    Z, Y : ndarray, shape (3,)
        Remainder accelerations.
    """

    p: Vector
    A: Matrix
    v: Vector
    w: Vector
    motion: Matrix
    Z: Vector
    Y: Vector
