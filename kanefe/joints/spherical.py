"""The spherical joint: rotation about a point, by Euler parameters."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from kanefe.errors import ModelError
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
from kanefe.joints.held import EVERYWHERE, Held
from kanefe.joints.joint_friction import JointFriction, RubbingSurfaces, Wanted, check_friction
from kanefe.joints.link import Link
from kanefe.joints.start import Guess, Starts, are_given, is_given, start_orientation, start_values
from kanefe.kernels.force_elements.coordinate_friction import BALL


@dataclass(frozen=True)
class Spherical(Joint):
    """Rotation about a point fixed in parent and child: 4 coordinates, 3 speeds.

    Parameters
    ----------
    orientation : array_like, shape (4,) or (3, 3), or Rotation of scipy, or Guess, optional
        At the start: Euler parameters, scalar first (`rotation_about`, `euler_angles`), or a matrix. Without it there
        is no rotation, or it follows where a loop needs it.
    angular_velocity : array_like, shape (3,), optional
        At the start, in rad/s, components of the moving frame: these are the speeds.
    motion : PoseMotion or PoseTable, optional
        Drives the joint as a whole, without positions; the start is then that of the motion, and the joint has no
        coordinates in the state. The driving moment is in `Result.joint_reaction`, its power in `Result.driving_force`,
        in W.
    forces : None
        Not possible along the coordinates of this joint: an error names the remedy.
    friction : JointFriction, optional
        Friction from the load of the joint.
    armature : float
        Inertia of rotors that turn with the joint, kg m2, against its angular acceleration about each axis: see
        `CoordinateForce`. It is MuJoCo's.

    Raises
    ------
    ModelError
        If a shape is wrong, a number is not finite or the orientation is not a rotation, or if a start is given beside
        the motion.
    """

    orientation: Orientation | Guess | None = None
    angular_velocity: Starts = None
    motion: GivenPose | None = None
    forces: None = None
    friction: JointFriction | None = None
    armature: float = 0.0

    rotation_at: ClassVar[int | None] = 0
    coordinate_names: ClassVar[tuple[str, ...]] = ("e0", "e1", "e2", "e3")
    speed_names: ClassVar[tuple[str, ...]] = ("wx [rad/s]", "wy [rad/s]", "wz [rad/s]")

    def __post_init__(self) -> None:
        refuse_forces(self.forces, self.kind)
        self.initial_coordinates()
        self.initial_speeds()
        check_drive(self, self.motion, ("orientation", "angular_velocity"), moves=False)
        check_friction(self.friction, self.kind, Wanted(needs=("radius",), lacks=("collar", "length")))
        if self.friction is not None and self.motion is not None:
            raise ModelError(
                "a spherical joint that follows a given pose has no friction from its load. Remedy: leave it out: "
                "it would only increase the driving force"
            )

    def initial_coordinates(self) -> Vector:
        return start_orientation(self.orientation, "orientation of a spherical joint")

    def initial_speeds(self) -> Vector:
        return start_values(self.angular_velocity, 3, "angular_velocity of a spherical joint")

    def given_start(self) -> tuple[list[bool], list[bool]]:
        return [is_given(self.orientation)] * 3, are_given(self.angular_velocity, 3)

    def pose(self, q: Vector) -> tuple[Vector, Matrix]:
        return np.zeros(3), rotation_matrix(q)

    def partial_velocities(self, q: Vector) -> tuple[Matrix, Matrix]:
        return np.zeros((3, 3)), rotation_matrix(q)  # w_FM_F = A_FM w_FM_M; its rate adds w x w = 0: no remainder

    def coordinate_rates(self, q: Vector, u: Vector) -> Vector:
        return euler_parameter_rates(q, u)

    def advance(self, q: Vector, step: Vector) -> Vector:
        e = multiply(q, euler_parameters_from_rotation_vector(step))
        return e / np.linalg.norm(e)

    def links(self) -> tuple[Link, ...]:
        return (Link.spherical(),)

    def held(self) -> Held:
        return Held(along=EVERYWHERE)

    def bearing(self) -> RubbingSurfaces | None:
        if self.friction is None or self.friction.radius is None:
            return None
        return RubbingSurfaces((self.friction.radius,) * 3, BALL, np.zeros(3))
