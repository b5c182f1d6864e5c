"""The screw joint: rotation about one axis that carries the body along it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector, axis_rotation
from kanefe.joints.base import AxisJoint


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

    def __post_init__(self) -> None:
        super().__post_init__()
        if not np.isfinite(self.lead):
            raise ModelError(f"lead of a screw joint must be a finite length in m, not {self.lead!r}")

    def pose(self, q: Vector) -> tuple[Vector, Matrix]:
        advance = self.lead / (2 * np.pi) * q[0]
        return advance * self.direction, axis_rotation(self.direction, q[0])

    def partial_velocities(self, q: Vector) -> tuple[Matrix, Matrix]:
        axis = self.direction[:, None]
        return self.lead / (2 * np.pi) * axis, axis
