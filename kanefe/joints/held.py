"""What a joint holds between two frames when it closes a loop."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kanefe.frames import Vector

EVERYWHERE = tuple(np.eye(3))
"""Directions in which a fixed point is held."""


@dataclass(frozen=True, eq=False)
class Held:
    """What a joint holds of a frame b on a frame a. Unit vectors have the same components in both.

    Attributes
    ----------
    along : tuple of ndarray, each (3,)
        Directions of a along which b's origin stays at a's.
    parallel : ndarray or None, shape (3,)
        Axis of b that stays parallel to that of a.
    is_aligned : bool
        Whether b does not turn about that axis either.
    angle : (ndarray, ndarray) or None, each (3,)
        A direction of a and one of b that keep their angle.
    thread : (ndarray, float) or None
        Axis, and advance of b along it in a full turn about it, m, not zero.
    facing : tuple of ndarray, each (3,)
        Directions that must be the same in a and b, where what is held would do with the opposite ones as well.
    """

    along: tuple[Vector, ...] = ()
    parallel: Vector | None = None
    is_aligned: bool = False
    angle: tuple[Vector, Vector] | None = None
    thread: tuple[Vector, float] | None = None
    facing: tuple[Vector, ...] = ()

    @property
    def takes_points(self) -> bool:
        """Whether it holds nothing but a point on a point, so that its ends need no axes."""
        return len(self.along) == 3 and self.parallel is None and self.angle is None and self.thread is None
