"""The prismatic joint: translation along one axis."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from kanefe.frames import Matrix, Vector, across
from kanefe.joints.base import AxisJoint
from kanefe.joints.held import Held
from kanefe.joints.joint_friction import RubbingSurfaces, Wanted, pads
from kanefe.joints.link import Link


@dataclass(frozen=True)
class Prismatic(AxisJoint):
    """Translation along an axis fixed in the parent.

    The coordinate is the distance in m, the speed its rate in m/s. Parameters: see `AxisJoint`.
    """

    coordinate_names: ClassVar[tuple[str, ...]] = ("distance [m]",)
    speed_names: ClassVar[tuple[str, ...]] = ("rate [m/s]",)
    _rubs: ClassVar[Wanted] = Wanted(lacks=("collar",))

    def pose(self, q: Vector) -> tuple[Vector, Matrix]:
        return q[0] * self.direction, np.eye(3)

    def partial_velocities(self, q: Vector) -> tuple[Matrix, Matrix]:
        return self.direction[:, None], np.zeros((3, 1))

    def links(self) -> tuple[Link, ...]:
        return (Link.sliding(self.direction),)

    def held(self) -> Held:
        axis, sides = self.direction, across(self.direction)
        return Held(along=sides, parallel=axis, is_aligned=True, facing=(axis, sides[0]))

    def bearing(self) -> RubbingSurfaces | None:
        if self.friction is None:
            return None
        return pads(
            self.friction, self.direction, (1.0,), 0.0, 1.0 / self.friction.radius if self.friction.radius else 0.0
        )
