"""The translation joint: a body that moves relative to its parent without rotation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from kanefe.frames import Matrix, Vector
from kanefe.joints.base import SeveralCoordinatesJoint
from kanefe.joints.coordinate_force import CoordinateForce
from kanefe.joints.held import Held
from kanefe.joints.link import Link
from kanefe.joints.motion import Motion
from kanefe.joints.start import Starts


@dataclass(frozen=True)
class Translation(SeveralCoordinatesJoint):
    """Translation along x, y and z of the joint's fixed frame F: 3 speeds, for points.

    Parameters
    ----------
    position : (float, float, float), optional
        x, y and z at the start, m, each also a Guess or None, which follows.
    velocity : (float, float, float), optional
        Their rates at the start, m/s.
    motion : three of Motion or None
        Drives single coordinates, which then take their start from it.
    forces : three of CoordinateForce or None
        Spring, damper, friction and limits of each coordinate.

    Raises
    ------
    ModelError
        If the start is not three finite numbers or contradicts a motion.

    Examples
    --------
    >>> thrown = Translation(velocity=(3.0, 0.0, 4.0))
    """

    position: Starts = None
    velocity: Starts = None
    motion: Sequence[Motion | None] = (None, None, None)
    forces: Sequence[CoordinateForce | None] = (None, None, None)

    coordinate_names: ClassVar[tuple[str, ...]] = ("x [m]", "y [m]", "z [m]")
    _rates: ClassVar[str] = "velocity"
    speed_names: ClassVar[tuple[str, ...]] = ("vx [m/s]", "vy [m/s]", "vz [m/s]")

    def __post_init__(self) -> None:
        self._check_coordinates()

    def pose(self, q: Vector) -> tuple[Vector, Matrix]:
        return q, np.eye(3)

    def partial_velocities(self, q: Vector) -> tuple[Matrix, Matrix]:
        return np.eye(3), np.zeros((3, 3))

    def links(self) -> tuple[Link, ...]:
        x, y, z = np.eye(3)
        return Link.sliding(x), Link.sliding(y), Link.sliding(z)

    def held(self) -> Held:
        x, _, z = np.eye(3)
        return Held(parallel=z, is_aligned=True, facing=(x, z))
