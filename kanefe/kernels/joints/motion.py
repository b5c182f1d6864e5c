"""Numbers of joints in lists of coordinates, speeds and forces, and what joints of all kinds share."""

from typing import NamedTuple

import numpy as np

from kanefe.kernels.language import Matrix, Symmetric, Vector, cross, inlined, is_above, rotation
from kanefe.kernels.tree import Motion

ROUND_OFF = 1e-14
"""Inertia along another direction, relative to the largest inertia of a body, below which it is round-off and counts as
zero."""


@inlined
def three(x: np.ndarray, at: int) -> Vector:
    """Read a vector of a list."""
    return Vector(x[at], x[at + 1], x[at + 2])


@inlined
def six(x: np.ndarray, at: int) -> Symmetric:
    """Read a symmetric matrix of a list."""
    return Symmetric(x[at], x[at + 1], x[at + 2], x[at + 3], x[at + 4], x[at + 5])


@inlined
def put_three(x: np.ndarray, at: int, a: Vector) -> None:
    """Write a vector to a list."""
    x[at], x[at + 1], x[at + 2] = a.x, a.y, a.z


@inlined
def orientation(q: np.ndarray, at: int) -> Matrix:
    """Return the rotation matrix of Euler parameters (Eq. 6)."""
    return rotation(q[at], q[at + 1], q[at + 2], q[at + 3])


@inlined
def has_inverse(S: Symmetric, inverse: Symmetric) -> bool:
    """Return whether inertias along all directions are above the round-off of the largest: by the two traces."""
    spread = S.trace * inverse.trace
    return is_above(spread, 0.0) and is_above(1.0 / ROUND_OFF, spread)  # also false for what is not a number


class Relative(NamedTuple):
    """Motion of a row as its parent sees it, in N.

    Attributes
    ----------
    slide, spin : Vector
        Velocity and angular velocity.
    pull, twist : Vector
        What the rates of these two have with du = 0.
    """

    slide: Vector
    spin: Vector
    pull: Vector
    twist: Vector


@inlined
def put_motion(frame: Motion, parent: Motion, r: Vector, relative: Relative) -> None:
    """Write position and motion of a row, at an arm r from its parent's origin, by the parent's (Eq. 13-16, 22-26)."""
    slide, spin, pull, twist = relative
    w, Y = parent.w, parent.Y
    swing = cross(w, r)
    frame.r, frame.p = r, parent.p + r
    frame.v, frame.w = parent.v + swing + slide, w + spin
    frame.Z = parent.Z + cross(Y, r) + cross(w, swing + 2.0 * slide) + pull
    frame.Y = Y + cross(w, spin) + twist
