"""Poses as given functions of time, and the joint that follows one."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector, shaped_numbers
from kanefe.joints.base import Joint
from kanefe.joints.link import Link, LinkKernel
from kanefe.joints.motion import Motion


class PoseRates(NamedTuple):
    """Pose of a frame M seen from F at a time, and its velocities and accelerations.

    Attributes
    ----------
    position, velocity, acceleration : ndarray, shape (3,)
        Components of F: m, m/s, m/s2.
    axes : ndarray, shape (3, 3)
        A_FM.
    angular_velocity, angular_acceleration : ndarray, shape (3,)
        Components of M: rad/s, rad/s2.
    """

    position: Vector
    velocity: Vector
    acceleration: Vector
    axes: Matrix
    angular_velocity: Vector
    angular_acceleration: Vector


class GivenPose(ABC):
    """A given motion of a free or spherical joint: the base of `PoseMotion` and `PoseTable`."""

    @property
    @abstractmethod
    def moves(self) -> bool:
        """Whether it has positions; otherwise only rotations."""

    @property
    @abstractmethod
    def clock(self) -> Motion:
        """Time as a motion, defined where the pose is."""

    @abstractmethod
    def at(self, t: float) -> PoseRates:
        """Return pose, velocities and accelerations at time t (s)."""

    def over(self, times: Vector) -> PoseRates:
        """Return pose, velocities and accelerations at many times (T,): all arrays have T rows."""
        found = [self.at(t) for t in times.tolist()]
        return PoseRates(*(np.array(column) for column in zip(*found, strict=True)))

    def kernel(self) -> LinkKernel | None:
        """Return the compiled function of the pose; None: it can be computed only in Python."""
        return None

    @abstractmethod
    def check(self, where: str) -> None:
        """Raise a ModelError if functions of the user contradict each other."""


@dataclass(frozen=True, eq=False)
class PoseDriven(Joint):
    """The joint of a frame that follows a given pose: its only coordinate is the time.

    The partial velocities are then the velocities, the remainders are the accelerations (Eq. 13-16), and the driving
    force of the coordinate, in s, is the power of the drive in W.

    Parameters
    ----------
    given : GivenPose
    of_kind : str
        Kind of the driven joint.
    """

    given: GivenPose
    of_kind: str

    coordinate_names: ClassVar[tuple[str, ...]] = ("time [s]",)
    speed_names: ClassVar[tuple[str, ...]] = ("rate [s/s]",)

    @property
    def kind(self) -> str:
        return self.of_kind

    @property
    def motions(self) -> tuple[Motion | None, ...]:
        return (self.given.clock,)

    @property
    def units(self) -> tuple[str, ...]:
        return ("s",)

    def initial_coordinates(self) -> Vector:
        return np.zeros(1)

    def initial_speeds(self) -> Vector:
        return np.zeros(1)

    def pose(self, q: Vector) -> tuple[Vector, Matrix]:
        found = self.given.at(float(q[0]))
        return found.position, found.axes

    def partial_velocities(self, q: Vector) -> tuple[Matrix, Matrix]:
        found = self.given.at(float(q[0]))
        return found.velocity[:, None], (found.axes @ found.angular_velocity)[:, None]

    def remainders(self, q: Vector, u: Vector) -> tuple[Vector, Vector]:
        found = self.given.at(float(q[0]))
        square = u[0] ** 2
        return square * found.acceleration, square * (found.axes @ found.angular_acceleration)

    def links(self) -> tuple[Link, ...] | None:
        kernel = self.given.kernel()
        return None if kernel is None else (Link.given(kernel),)


def driven(joint: Joint) -> Joint:
    """Return the joint for the scene: a `PoseDriven` if a pose drives the joint as a whole, otherwise the joint."""
    motion = getattr(joint, "motion", None)
    if joint.rotation_at is None or not isinstance(motion, GivenPose):
        return joint
    return PoseDriven(motion, joint.kind)


def check_drive(joint: Joint, motion: object, starts: tuple[str, ...], *, moves: bool) -> None:
    """Raise a ModelError if a joint with Euler parameters cannot follow the given motion.

    Parameters
    ----------
    joint : Joint
    motion : object
        None: the joint is not driven.
    starts : tuple of str
        Names of the attributes of its start, which must be None.
    moves : bool
        Whether the joint allows translations.
    """
    what = f"armature of a {joint.kind} joint"
    if shaped_numbers(joint.armature, (), what) < 0.0:
        raise ModelError(f"{what} must be >= 0, not {joint.armature!r}")
    if motion is None:
        return
    if joint.armature:
        raise ModelError(f"{what} would only add to the moment that drives it. Remedy: leave one of them out")
    what = f"the motion of a {joint.kind} joint"
    if not isinstance(motion, GivenPose):
        raise ModelError(
            f"{what} must be a PoseMotion, a PoseTable or that of a point of a ship, not of type "
            f"{type(motion).__name__}. Remedy: one of them, of a ship ship.at(point); where single coordinates are "
            "driven, revolute and prismatic joints with massless frames between them (add_frame)"
        )
    if motion.moves and not moves:
        raise ModelError(f"{what} gives positions, but its point stays. Remedy: leave them out, or a Free joint")
    for name in starts:
        if getattr(joint, name) is not None:
            raise ModelError(
                f"a {joint.kind} joint that is driven by a motion takes its start from it. Remedy: leave out {name}"
            )
    motion.check(f"{joint.kind} joint")


def refuse_forces(forces: object, kind: str) -> None:
    """Raise a ModelError if forces are given along the coordinates of a joint with Euler parameters."""
    if forces is not None:
        raise ModelError(
            f"the coordinates of a {kind} joint cannot carry forces of their own. Remedy: a bushing, or revolute and "
            "prismatic joints with massless frames between them (add_frame)"
        )
