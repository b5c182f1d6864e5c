"""The free joint: three translations and a rotation by Euler parameters."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from kanefe.frames import (
    Matrix,
    Orientation,
    Vector,
    euler_parameter_rates,
    euler_parameters_from_rotation_vector,
    multiply,
    rotation_matrix,
)
from kanefe.joints.base import Joint
from kanefe.joints.given_pose import GivenPose, check_drive, refuse_forces
from kanefe.joints.link import Link
from kanefe.joints.start import Guess, Starts, are_given, is_given, start_orientation, start_values


@dataclass(frozen=True)
class Free(Joint):
    """No constraint between parent and child: 7 coordinates, 6 speeds.

    Coordinates: position in the parent (m) and Euler parameters, scalar first. Speeds: rates of the position (m/s,
    components of the parent) and the angular velocity in the *moving* frame (rad/s), as the paper chooses them.

    Parameters
    ----------
    position : array_like, shape (3,), optional
        At the start, in m. What is not given, or a Guess, follows where a loop needs it, and else is zero.
    orientation : array_like, shape (4,) or (3, 3), or Rotation of scipy, or Guess, optional
        At the start: Euler parameters, scalar first (`rotation_about`, `euler_angles`), or a matrix.
    velocity : array_like, shape (3,), optional
        At the start, in m/s, components of the parent.
    angular_velocity : array_like, shape (3,), optional
        At the start, in rad/s, components of the moving frame.
    motion : PoseMotion or PoseTable, optional
        Drives the joint as a whole; the start is then that of the motion, and the joint has no coordinates in the
        state. The driving force is in `Result.joint_reaction`, its power in `Result.driving_force`, in W.
    forces : None
        Not possible along the coordinates of this joint: an error names the remedy.
    armature : float
        Inertia against each of its accelerations, kg and kg m2, without weight and momentum: MuJoCo's, of a body on the
        ground.

    Raises
    ------
    ModelError
        If a shape is wrong, a number is not finite or the orientation is not a rotation, or if a start is given beside
        the motion.

    Examples
    --------
    A base that follows a measured motion:

    >>> times = np.linspace(0.0, 2.0, 21)
    >>> heave = np.column_stack((0.0 * times, 0.0 * times, 0.1 * np.sin(times)))
    >>> import kanefe as kf
    >>> base = kf.Free(motion=kf.PoseTable(times, heave))
    """

    position: Starts = None
    orientation: Orientation | Guess | None = None
    velocity: Starts = None
    angular_velocity: Starts = None
    motion: GivenPose | None = None
    forces: None = None
    armature: float = 0.0

    rotation_at: ClassVar[int | None] = 3
    holds_floating: ClassVar[bool] = True
    coordinate_names: ClassVar[tuple[str, ...]] = ("x [m]", "y [m]", "z [m]", "e0", "e1", "e2", "e3")
    speed_names: ClassVar[tuple[str, ...]] = (
        "vx [m/s]",
        "vy [m/s]",
        "vz [m/s]",
        "wx [rad/s]",
        "wy [rad/s]",
        "wz [rad/s]",
    )

    def __post_init__(self) -> None:
        refuse_forces(self.forces, self.kind)
        self.initial_coordinates()
        self.initial_speeds()
        check_drive(self, self.motion, ("position", "orientation", "velocity", "angular_velocity"), moves=True)

    def initial_coordinates(self) -> Vector:
        e = start_orientation(self.orientation, "orientation of a free joint")
        return np.concatenate((start_values(self.position, 3, "position of a free joint"), e))

    def initial_speeds(self) -> Vector:
        of = (("velocity", self.velocity), ("angular_velocity", self.angular_velocity))
        return np.concatenate([start_values(value, 3, f"{name} of a free joint") for name, value in of])

    def given_start(self) -> tuple[list[bool], list[bool]]:
        places = [*are_given(self.position, 3), *[is_given(self.orientation)] * 3]
        return places, [*are_given(self.velocity, 3), *are_given(self.angular_velocity, 3)]

    def pose(self, q: Vector) -> tuple[Vector, Matrix]:
        return q[:3], rotation_matrix(q[3:])

    def partial_velocities(self, q: Vector) -> tuple[Matrix, Matrix]:
        V, W = np.zeros((3, 6)), np.zeros((3, 6))
        V[:, :3] = np.eye(3)
        W[:, 3:] = rotation_matrix(q[3:])  # w_FM_F = A_FM w_FM_M; its rate adds w x w = 0: no remainder
        return V, W

    def coordinate_rates(self, q: Vector, u: Vector) -> Vector:
        return np.concatenate((u[:3], euler_parameter_rates(q[3:], u[3:])))

    def advance(self, q: Vector, step: Vector) -> Vector:
        e = multiply(q[3:], euler_parameters_from_rotation_vector(step[3:]))
        return np.concatenate((q[:3] + step[:3], e / np.linalg.norm(e)))

    def links(self) -> tuple[Link, ...]:
        return (Link.free(),)
