"""Links: the parts of joints that the rows of the order-n route know."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from kanefe.frames import Matrix, Vector, turn_to
from kanefe.kernels.layout import AXIS, FIXED, FREE, REVOLUTE, SPHERICAL

Z = (0.0, 0.0, 1.0)
SPEEDS = {FIXED: 0, SPHERICAL: 3, FREE: 6}
"""Of links that do not have one."""


@dataclass(frozen=True, eq=False)
class Link:
    """A part of a joint that moves in one way; a joint is a chain of them, each on the one before.

    Made by the functions below. Axes are given at zero coordinates, in components of the joint's fixed frame F.

    Attributes
    ----------
    kind : int
        Of the rows of `kanefe.kernels.layout`.
    axis : ndarray, shape (3,)
        Unit vector.
    along, about : float
        Travel (m) along the axis and turn (rad) about it of a unit of the coordinate.

    Examples
    --------
    A sleeve that slides on a bar and turns about it:

    >>> bar = np.array((1.0, 0.0, 0.0))
    >>> links = Link.sliding(bar), Link.turning(bar)
    """

    kind: int
    axis: Vector = field(default_factory=lambda: np.array(Z))
    along: float = 0.0
    about: float = 0.0

    @classmethod
    def fixed(cls) -> Link:
        """Return a link that does not move."""
        return cls(FIXED)

    @classmethod
    def turning(cls, axis: Vector) -> Link:
        """Return a link that turns about an axis: an angle in rad, and its rate."""
        return cls(REVOLUTE, axis, 0.0, 1.0)

    @classmethod
    def sliding(cls, axis: Vector) -> Link:
        """Return a link that slides along an axis: a distance in m, and its rate."""
        return cls(AXIS, axis, 1.0, 0.0)

    @classmethod
    def winding(cls, axis: Vector, advance: float) -> Link:
        """Return a link that turns about an axis and advances on it, in m/rad: an angle in rad, and its rate."""
        return cls(AXIS, axis, advance, 1.0)

    @classmethod
    def spherical(cls) -> Link:
        """Return a link that turns about a point: four Euler parameters, and the angular velocity in what turns."""
        return cls(SPHERICAL)

    @classmethod
    def free(cls) -> Link:
        """Return a link that moves freely: coordinates and speeds of `kanefe.Free`."""
        return cls(FREE)

    @property
    def turn(self) -> Matrix:
        """A rotation that brings z to the axis, (3, 3)."""
        return turn_to(self.axis)

    @property
    def speed_count(self) -> int:
        """How many speeds of the joint are those of the link."""
        return SPEEDS.get(self.kind, 1)

    @property
    def coordinate_count(self) -> int:
        """How many coordinates of the joint are those of the link: a rotation has four."""
        return self.speed_count + (self.kind in (SPHERICAL, FREE))

    @property
    def is_fixed(self) -> bool:
        """Whether it does not move."""
        return self.kind == FIXED

    @property
    def is_turn(self) -> bool:
        """Whether it turns about its axis and does nothing else."""
        return self.kind == REVOLUTE

    @property
    def is_slide(self) -> bool:
        """Whether it slides along its axis and does nothing else."""
        return self.kind == AXIS and (self.along, self.about) == (1.0, 0.0)

    @property
    def is_free(self) -> bool:
        """Whether it moves freely in space."""
        return self.kind == FREE
