"""The revolute joint: rotation about one axis."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from kanefe.frames import Matrix, Vector, axis_rotation
from kanefe.joints.base import AxisJoint
from kanefe.joints.held import EVERYWHERE, Held
from kanefe.joints.joint_friction import RubbingSurfaces, Wanted, pads
from kanefe.joints.link import Link


@dataclass(frozen=True)
class Revolute(AxisJoint):
    """Rotation about an axis fixed in parent and child.

    The coordinate is the angle in rad, the speed its rate in rad/s. Parameters: see `AxisJoint`.

    Examples
    --------
    >>> hinge = Revolute("z", position=0.3)
    >>> hinge.pose(hinge.initial_coordinates())[1].round(3)[0, 0]
    0.955
    """

    coordinate_names: ClassVar[tuple[str, ...]] = ("angle [rad]",)
    speed_names: ClassVar[tuple[str, ...]] = ("rate [rad/s]",)
    _rubs: ClassVar[Wanted] = Wanted(needs=("radius",))

    def pose(self, q: Vector) -> tuple[Vector, Matrix]:
        return np.zeros(3), axis_rotation(self.direction, q[0])

    def partial_velocities(self, q: Vector) -> tuple[Matrix, Matrix]:
        return np.zeros((3, 1)), self.direction[:, None]

    def links(self) -> tuple[Link, ...]:
        return (Link.turning(self.direction),)

    def held(self) -> Held:
        return Held(along=EVERYWHERE, parallel=self.direction)

    def bearing(self) -> RubbingSurfaces | None:
        if self.friction is None or self.friction.radius is None:
            return None
        radius = self.friction.radius
        return pads(self.friction, self.direction, (radius,), (self.friction.collar or 0.0) / radius, 0.0)
