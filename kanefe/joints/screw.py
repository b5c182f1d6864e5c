"""The screw joint: rotation about one axis with a proportional translation along it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from kanefe.frames import Matrix, Vector, across, axis_rotation, shaped_numbers
from kanefe.joints.base import AxisJoint
from kanefe.joints.held import EVERYWHERE, Held
from kanefe.joints.joint_friction import RubbingSurfaces, Wanted, thread
from kanefe.joints.link import Link


@dataclass(frozen=True)
class Screw(AxisJoint):
    """Rotation about an axis with a proportional translation along it.

    The coordinate is the angle in rad, the speed its rate in rad/s. Further parameters: see `AxisJoint`.

    Parameters
    ----------
    lead : float
        Advance in a full turn, m; negative for a left-hand thread.

    Raises
    ------
    ModelError
        If the lead is not finite.
    """

    lead: float = 0.0

    coordinate_names: ClassVar[tuple[str, ...]] = ("angle [rad]",)
    speed_names: ClassVar[tuple[str, ...]] = ("rate [rad/s]",)
    _rubs: ClassVar[Wanted] = Wanted(needs=("radius",), lacks=("stribeck_speed", "collar", "length"))

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "lead", float(shaped_numbers(self.lead, (), "lead of a screw joint, m,")))

    def pose(self, q: Vector) -> tuple[Vector, Matrix]:
        advance = self.lead / (2 * np.pi) * q[0]
        return advance * self.direction, axis_rotation(self.direction, q[0])

    def partial_velocities(self, q: Vector) -> tuple[Matrix, Matrix]:
        axis = self.direction[:, None]
        return self.lead / (2 * np.pi) * axis, axis

    def links(self) -> tuple[Link, ...]:
        return (Link.winding(self.direction, self.lead / (2 * np.pi)),)

    def held(self) -> Held:
        axis = self.direction
        if self.lead == 0.0:
            return Held(along=EVERYWHERE, parallel=axis, facing=(axis,))
        return Held(along=across(axis), parallel=axis, thread=(axis, float(self.lead)), facing=(axis,))

    def bearing(self) -> RubbingSurfaces | None:
        if self.friction is None or self.friction.radius is None:
            return None
        return thread(self.friction.radius, self.lead, self.direction)
