"""The constraints of a joint between two frames when it closes a loop."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kanefe.frames import Vector

EVERYWHERE = tuple(np.eye(3))
"""Directions along which a fixed point is held."""


@dataclass(frozen=True, eq=False)
class Held:
    """The constraints of a joint on a frame b relative to a frame a. Unit vectors have the same components in both.

    Attributes
    ----------
    along : tuple of ndarray, each (3,)
        Directions of a along which the origin of b has no displacement from that of a.
    parallel : ndarray or None, shape (3,)
        Axis that stays parallel in a and b.
    is_aligned : bool
        Whether rotation about that axis is prevented too.
    angle : (ndarray, ndarray) or None, each (3,)
        A direction of a and one of b whose angle is constant.
    thread : (ndarray, float) or None
        Axis, and advance of b along it in a full turn, m, not zero.
    facing : tuple of ndarray, each (3,)
        Directions that must be the same in a and b, if the constraints would also allow opposite ones.
    """

    along: tuple[Vector, ...] = ()
    parallel: Vector | None = None
    is_aligned: bool = False
    angle: tuple[Vector, Vector] | None = None
    thread: tuple[Vector, float] | None = None
    facing: tuple[Vector, ...] = ()

    @property
    def takes_points(self) -> bool:
        """Whether it only holds a point on a point, so that its ends need no axes."""
        return len(self.along) == 3 and self.parallel is None and self.angle is None and self.thread is None
