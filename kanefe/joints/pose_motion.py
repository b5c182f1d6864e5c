"""Poses as functions of time, given with their rates."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector, axial, orientation_parameters, rotation_matrix, shaped_numbers, skew
from kanefe.joints.given_pose import GivenPose, PoseRates
from kanefe.joints.link import LinkKernel
from kanefe.joints.motion import TIME, Motion, check_span
from kanefe.joints.pose_in_python import PoseInPython
from kanefe.joints.pose_table import PoseTable

LINEAR = ("position", "velocity", "acceleration")
ANGULAR = ("orientation", "angular_velocity", "angular_acceleration")

STEP = 1e-6
"""Step of central differences, s."""

Function = Callable[[float], Any]

FINE = 4
"""Number of samples of the run per sample at which a pose is compared with its rates, because every call is in Python.
"""


@dataclass(frozen=True, eq=False)
class PoseMotion(GivenPose):
    """The pose of a frame as functions of time, with exact velocities and accelerations, to drive a joint.

    The functions are called in Python, once in each evaluation; its `table` stays in compiled code.

    Parameters
    ----------
    position, velocity, acceleration : callable, optional
        t in s -> (3,), components of the joint's fixed frame F, m, m/s, m/s2. All three, or none: no translation.
    orientation : callable, optional
        t -> Euler parameters (4,), scalar first, of any length, a matrix A_FM (3, 3), or a Rotation of scipy.
    angular_velocity, angular_acceleration : callable, optional
        t -> (3,), components of the moving frame M, rad/s, rad/s2. All three of the rotation, or none: no rotation.
        The angular acceleration is the rate of the components of the angular velocity in M.
    span : (float, float)
        First and last time at which the pose is defined, s.

    Raises
    ------
    ModelError
        If a function is missing. In a joint also if a value has another shape, is not finite, not a rotation, or not
        the rate of another.

    Examples
    --------
    A deck that rolls by 0.1 rad in 10 s:

    >>> import numpy as np
    >>> import kanefe as kf
    >>> w, roll = 0.2 * np.pi, np.array((0.1, 0.0, 0.0))
    >>> motion = kf.PoseMotion(
    ...     orientation=lambda t: kf.rotation_about("x", 0.1 * np.sin(w * t)),
    ...     angular_velocity=lambda t: roll * w * np.cos(w * t),
    ...     angular_acceleration=lambda t: -roll * w**2 * np.sin(w * t),
    ... )
    >>> scene = kf.System()
    >>> deck = scene.add_frame("deck", joint=kf.Spherical(motion=motion.table(np.linspace(0.0, 60.0, 601))))
    """

    position: Function | None = None
    velocity: Function | None = None
    acceleration: Function | None = None
    orientation: Function | None = None
    angular_velocity: Function | None = None
    angular_acceleration: Function | None = None
    span: tuple[float, float] = (-math.inf, math.inf)

    def __post_init__(self) -> None:
        for names in (LINEAR, ANGULAR):
            missing = [name for name in names if getattr(self, name) is None]
            if missing and len(missing) < len(names):
                raise ModelError(
                    f"a PoseMotion needs {', '.join(names[:2])} and {names[2]}; {' and '.join(missing)} is missing. "
                    "Remedy: give the time derivatives, or sample the pose and use PoseTable"
                )
            for name in names:
                if getattr(self, name) is not None and not callable(getattr(self, name)):
                    raise ModelError(f"{name} of a PoseMotion must be a function of time, not {getattr(self, name)!r}")
        check_span(self.span, "a PoseMotion")
        if self.position is None and self.orientation is None:
            raise ModelError("a PoseMotion needs position or orientation as functions of time; neither is given")

    @property
    def moves(self) -> bool:
        return self.position is not None

    def kernel(self) -> LinkKernel:
        return self._called.kernel()

    @cached_property
    def _called(self) -> PoseInPython:
        return PoseInPython(self)

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in vars(self).items() if name != "_called"}  # which is of one process

    @property
    def clock(self) -> Motion:
        return _Clock(*TIME, span=self.span, pose=self)

    def at(self, t: float) -> PoseRates:
        self._called.raise_interrupt()
        p, v, a = (self._vector(name, t) for name in LINEAR)
        w, dw = (self._vector(name, t) for name in ANGULAR[1:])
        return PoseRates(p, v, a, rotation_matrix(self._parameters(t)), w, dw)

    def table(self, times: Sequence[float] | Vector) -> PoseTable:
        """Return the table of the pose and of its rates at some times, for compiled code.

        Pose, velocities and accelerations are those of the functions at the times; between them the error of the pose
        is of the sixth power of the distance of the times, that of accelerations of the fourth.

        Parameters
        ----------
        times : array_like, shape (n,)
            Increasing, at least two, s.
        """
        found: dict[str, Any] = {"positions": None, "orientations": None}
        instants = np.atleast_1d(np.asarray(times, dtype=float))
        if self.position is not None:
            plural = ("positions", "velocities", "accelerations")
            for name, key in zip(LINEAR, plural, strict=True):
                found[key] = np.array([self._vector(name, float(t)) for t in instants])
        if self.orientation is not None:
            found["orientations"] = np.array([self._parameters(float(t)) for t in instants])
            for name, key in zip(ANGULAR[1:], ("angular_velocities", "angular_accelerations"), strict=True):
                found[key] = np.array([self._vector(name, float(t)) for t in instants])
        return PoseTable(times, **found)

    def check(self, where: str) -> None:
        first, last = self.span
        start = min(max(0.0, first), last)
        later = start + 1e-3 if start + 2e-3 < last else 0.5 * (first + last)
        self.at(start)
        here, back, ahead = (self.at(t) for t in (later, later - STEP, later + STEP))
        turned = -0.5 * axial((ahead.axes - back.axes) @ here.axes.T) @ here.axes
        found = {
            "velocity": (ahead.position - back.position, here.velocity, here.position),
            "acceleration": (ahead.velocity - back.velocity, here.acceleration, here.velocity),
            "angular_velocity": (turned, here.angular_velocity, np.ones(3)),
            "angular_acceleration": (
                ahead.angular_velocity - back.angular_velocity,
                here.angular_acceleration,
                here.angular_velocity,
            ),
        }
        for name, (change, given, of) in found.items():
            rate = change / (2.0 * STEP)
            # as for a Motion: accepts differences of motions of some kHz, but no wrong sign or frame
            allowed = 0.01 * max(np.linalg.norm(rate), np.linalg.norm(given)) + 1e-6 * (1.0 + np.linalg.norm(of))
            if np.linalg.norm(rate - given) > allowed:
                raise ModelError(
                    f"{where}: at t = {later:.6g} s the {name} of a PoseMotion is {given.tolist()}, but what it is the "
                    f"rate of changes at {rate.tolist()} a second. Remedy: the time derivative; angular ones are in "
                    "components of the moving frame, in rad"
                )

    def check_over(self, times: Vector, what: str) -> None:
        """Raise a ModelError that names the motion as `what`, if rates contradict the pose in a run, times (T,)."""
        from kanefe.joints.rates_over_time import contradiction, refuse

        position, velocity, acceleration = self.position, self.velocity, self.acceleration
        if position is not None and velocity is not None and acceleration is not None:
            refuse(contradiction((position, velocity, acceleration), times), LINEAR, what)
        if self.orientation is None:
            return

        @cache
        def axes(t: float) -> Matrix:
            return rotation_matrix(self._parameters(t))

        def turning(t: float) -> Matrix:
            return axes(t) @ skew(self._vector(ANGULAR[1], t))

        def turning_rate(t: float) -> Matrix:
            w, dw = (skew(self._vector(name, t)) for name in ANGULAR[1:])
            return axes(t) @ (w @ w + dw)

        found = contradiction((axes, turning, turning_rate), times)
        if found is not None:  # in components of M
            A = axes(found.time)
            change, rate, given = (
                -0.5 * axial(A.T @ x.reshape(3, 3)) for x in (found.change, found.found, found.given)
            )
            found = found._replace(change=change, found=rate, given=given)
        refuse(found, ANGULAR, what)

    def _vector(self, name: str, t: float) -> Vector:
        function: Function | None = getattr(self, name)
        if function is None:
            return np.zeros(3)
        return shaped_numbers(function(t), (3,), f"{name} of a PoseMotion at t = {t:.6g} s")

    def _parameters(self, t: float) -> Vector:
        if self.orientation is None:
            return np.array((1.0, 0.0, 0.0, 0.0))
        return orientation_parameters(self.orientation(t), f"orientation of a PoseMotion at t = {t:.6g} s")


@dataclass(frozen=True)
class _Clock(Motion):
    """The time as the motion of a pose whose functions are compared with their rates before a run."""

    pose: PoseMotion | None = None

    def check_over(self, times: Vector, what: str, accelerations: Matrix | None = None) -> None:
        if self.pose is not None:
            self.pose.check_over(times[::FINE], what)
