"""The planar joint: free motion in the x-y plane of the parent."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from kanefe.frames import Matrix, Vector, axis_rotation
from kanefe.joints.base import SeveralCoordinatesJoint
from kanefe.joints.coordinate_force import CoordinateForce
from kanefe.joints.held import Held
from kanefe.joints.link import Link
from kanefe.joints.motion import Motion
from kanefe.joints.start import Start, Starts, are_given, start_value, start_values


@dataclass(frozen=True)
class Planar(SeveralCoordinatesJoint):
    """Translation in x and y of the parent and rotation about z: a body free in the plane, 3 speeds.

    Parameters
    ----------
    position : (float, float), optional
        x and y at the start in m, each also a Guess or None, which follows; so do the others.
    angle : float, optional
        Angle at the start in rad.
    velocity : (float, float), optional
        Rates of x and y at the start in m/s.
    rate : float, optional
        Rate of the angle at the start in rad/s.
    motion : three of Motion or None
        Drives single coordinates (x, y, angle), which then take their start from it.
    forces : three of CoordinateForce or None
        Spring, damper, friction and limits of each coordinate.

    Raises
    ------
    ModelError
        If the start is not finite or contradicts a motion.
    """

    position: Starts = None
    angle: Start = None
    velocity: Starts = None
    rate: Start = None
    motion: Sequence[Motion | None] = (None, None, None)
    forces: Sequence[CoordinateForce | None] = (None, None, None)

    holds_floating: ClassVar[bool] = True
    coordinate_names: ClassVar[tuple[str, ...]] = ("x [m]", "y [m]", "angle [rad]")
    speed_names: ClassVar[tuple[str, ...]] = ("vx [m/s]", "vy [m/s]", "rate [rad/s]")

    def __post_init__(self) -> None:
        self._check_coordinates()

    def initial_coordinates(self) -> Vector:
        angle = start_value(self.angle, "angle of a planar joint")
        return np.array([*start_values(self.position, 2, "position of a planar joint"), angle])

    def initial_speeds(self) -> Vector:
        rate = start_value(self.rate, "rate of a planar joint")
        return np.array([*start_values(self.velocity, 2, "velocity of a planar joint"), rate])

    def given_start(self) -> tuple[list[bool], list[bool]]:
        places = are_given(self.position, 2) + are_given(self.angle, 1)
        return places, are_given(self.velocity, 2) + are_given(self.rate, 1)

    def pose(self, q: Vector) -> tuple[Vector, Matrix]:
        return np.array((q[0], q[1], 0.0)), axis_rotation((0.0, 0.0, 1.0), q[2])

    def partial_velocities(self, q: Vector) -> tuple[Matrix, Matrix]:
        V, W = np.zeros((3, 3)), np.zeros((3, 3))
        V[0, 0] = V[1, 1] = W[2, 2] = 1.0
        return V, W

    def links(self) -> tuple[Link, ...]:
        x, y, z = np.eye(3)
        return Link.sliding(x), Link.sliding(y), Link.turning(z)

    def held(self) -> Held:
        z = np.eye(3)[2]
        return Held(along=(z,), parallel=z)
