"""The universal joint: two successive rotations about crossing axes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector, axis_rotation, cross
from kanefe.joints.base import SeveralCoordinatesJoint, axis_direction
from kanefe.joints.coordinate_force import CoordinateForce
from kanefe.joints.held import EVERYWHERE, Held
from kanefe.joints.link import Link
from kanefe.joints.motion import Motion
from kanefe.joints.start import Starts


@dataclass(frozen=True)
class Universal(SeveralCoordinatesJoint):
    """Rotation about an axis of the parent, then about an axis that the first rotation carries: 2 speeds.

    Parameters
    ----------
    first, second : "x", "y", "z" or three numbers
        The axis fixed in the joint's frame F, and the other one at zero angles; not parallel.
    position, speed : (float, float), optional
        Angles (rad) and their rates (rad/s) at the start, each also a Guess or None, which follows.
    motion : (Motion or None, Motion or None)
        Drives single coordinates, which then take their start from it.
    forces : (CoordinateForce or None, CoordinateForce or None)
        Spring, damper, friction and limits of each coordinate.

    Raises
    ------
    ModelError
        If an axis has no length, the axes are parallel, or the start is not two finite numbers.

    Examples
    --------
    >>> cardan = Universal("x", "y", position=(0.2, -0.1))
    """

    first: str | Sequence[float] = "x"
    second: str | Sequence[float] = "y"
    position: Starts = None
    speed: Starts = None
    motion: Sequence[Motion | None] = (None, None)
    forces: Sequence[CoordinateForce | None] = (None, None)
    directions: tuple[np.ndarray, np.ndarray] = field(init=False, repr=False, compare=False)

    coordinate_names: ClassVar[tuple[str, ...]] = ("first angle [rad]", "second angle [rad]")
    speed_names: ClassVar[tuple[str, ...]] = ("first rate [rad/s]", "second rate [rad/s]")

    def __post_init__(self) -> None:
        axes = axis_direction(self.first, self.kind), axis_direction(self.second, self.kind)
        if np.linalg.norm(cross(*axes)) < 1e-6:
            raise ModelError("the axes of a universal joint are parallel. Remedy: cross them, or use a revolute joint")
        object.__setattr__(self, "directions", axes)
        self._check_coordinates()

    def pose(self, q: Vector) -> tuple[Vector, Matrix]:
        first, second = (axis_rotation(axis, angle) for axis, angle in zip(self.directions, q, strict=True))
        return np.zeros(3), first @ second

    def partial_velocities(self, q: Vector) -> tuple[Matrix, Matrix]:
        return np.zeros((3, 2)), np.column_stack((self.directions[0], self._carried(q)))

    def remainders(self, q: Vector, u: Vector) -> tuple[Vector, Vector]:
        return np.zeros(3), u[0] * u[1] * cross(self.directions[0], self._carried(q))

    def links(self) -> tuple[Link, ...]:
        first, second = self.directions
        return Link.turning(first), Link.turning(second)

    def held(self) -> Held:
        return Held(along=EVERYWHERE, angle=self.directions)

    def _carried(self, q: Vector) -> Vector:
        """Return the second axis in components of F."""
        return axis_rotation(self.directions[0], q[0]) @ self.directions[1]
