"""The cylindrical joint: translation along one axis and rotation about it, independent of each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from kanefe.frames import Matrix, Vector, across, axis_rotation
from kanefe.joints.base import SeveralCoordinatesJoint, axis_direction
from kanefe.joints.coordinate_force import CoordinateForce
from kanefe.joints.held import Held
from kanefe.joints.joint_friction import JointFriction, RubbingSurfaces, Wanted, pads
from kanefe.joints.link import Link
from kanefe.joints.motion import Motion
from kanefe.joints.start import Starts


@dataclass(frozen=True)
class Cylindrical(SeveralCoordinatesJoint):
    """Translation along and rotation about an axis fixed in parent and child: 2 speeds.

    Parameters
    ----------
    axis : "x", "y", "z" or three numbers
        Direction in the joint's fixed frame F.
    position : (float, float), optional
        Distance (m) and angle (rad) at the start, each also a Guess or None, which follows.
    speed : (float, float), optional
        Their rates at the start, m/s and rad/s.
    motion : (Motion or None, Motion or None)
        Drives single coordinates, which then take their start from it.
    forces : (CoordinateForce or None, CoordinateForce or None)
        Spring, damper, friction and limits of each coordinate.
    friction : JointFriction, optional
        Friction from the load of the joint.

    Raises
    ------
    ModelError
        If the axis has no length or the start is not two finite numbers.

    Examples
    --------
    >>> sleeve = Cylindrical("x", position=(0.1, 0.0), speed=(0.0, 5.0))
    """

    axis: str | Sequence[float] = "z"
    position: Starts = None
    speed: Starts = None
    motion: Sequence[Motion | None] = (None, None)
    forces: Sequence[CoordinateForce | None] = (None, None)
    friction: JointFriction | None = None
    direction: np.ndarray = field(init=False, repr=False, compare=False)

    coordinate_names: ClassVar[tuple[str, ...]] = ("distance [m]", "angle [rad]")
    speed_names: ClassVar[tuple[str, ...]] = ("rate [m/s]", "rate [rad/s]")
    _rubs: ClassVar[Wanted] = Wanted(needs=("radius",), lacks=("collar",))

    def __post_init__(self) -> None:
        object.__setattr__(self, "direction", axis_direction(self.axis, self.kind))
        self._check_coordinates()

    def pose(self, q: Vector) -> tuple[Vector, Matrix]:
        return q[0] * self.direction, axis_rotation(self.direction, q[1])

    def partial_velocities(self, q: Vector) -> tuple[Matrix, Matrix]:
        zero = np.zeros(3)
        return np.column_stack((self.direction, zero)), np.column_stack((zero, self.direction))

    def links(self) -> tuple[Link, ...]:
        return Link.sliding(self.direction), Link.turning(self.direction)

    def held(self) -> Held:
        return Held(along=across(self.direction), parallel=self.direction)

    def bearing(self) -> RubbingSurfaces | None:
        if self.friction is None or self.friction.radius is None:
            return None
        return pads(self.friction, self.direction, (1.0, self.friction.radius), 0.0, 0.0)
