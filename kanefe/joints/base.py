"""What a joint is: coordinates, speeds, and the motion of its moving frame M seen from its fixed frame F."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector, numbers, unit_vector

AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


@dataclass(frozen=True)
class Motion:
    """A joint coordinate as a given function of time.

    Parameters
    ----------
    position, velocity, acceleration : callable
        t in s -> coordinate in rad or m, and its two time derivatives.

    Examples
    --------
    >>> spin = Motion(lambda t: 3.0 * t, lambda t: 3.0, lambda t: 0.0)
    """

    position: Callable[[float], float]
    velocity: Callable[[float], float]
    acceleration: Callable[[float], float]

    @classmethod
    def steady(cls, rate: float, start: float = 0.0) -> Motion:
        """Return the motion ``start + rate t`` (rad/s or m/s)."""
        return cls(lambda t: start + rate * t, lambda t: rate, lambda t: 0.0)

    def at(self, name: str, t: float, body: str) -> float:
        """Return the position, velocity or acceleration (by name) at time t.

        Raises
        ------
        ModelError
            If it is not finite; the message names the body and the time.
        """
        value = float(getattr(self, name)(t))
        if not math.isfinite(value):
            raise ModelError(
                f"the motion of body {body!r} must give finite numbers; its {name} at t = {t:.6g} s is {value}"
            )
        return value

    def check(self, where: str, times: Sequence[float] = (0.0, 1e-3)) -> None:
        """Raise a ModelError if one of the functions gives no finite number, or rates that contradict the position."""
        for name in ("position", "velocity", "acceleration"):
            function = getattr(self, name)
            if not callable(function):
                raise ModelError(f"{where}: {name} of a Motion must be a function of time, not {function!r}")
            for t in times:
                value = np.asarray(function(t), dtype=float)
                if value.shape != () or not np.isfinite(value):
                    raise ModelError(f"{where}: {name} at t = {t} s must be one finite number, not {function(t)!r}")
        for of, rate in (("position", "velocity"), ("velocity", "acceleration")):
            t, h = times[-1], 1e-6
            function, given = getattr(self, of), float(getattr(self, rate)(t))
            found = (float(function(t + h)) - float(function(t - h))) / (2 * h)
            # 1 %: enough for the slopes of any motion below some kHz, and far below a factor 2 pi or a wrong sign
            if abs(found - given) > 0.01 * max(abs(found), abs(given)) + 1e-6 * (1 + abs(float(function(t)))):
                raise ModelError(
                    f"{where}: at t = {t} s the {rate} of a Motion is {given:.6g}, but its {of} changes at "
                    f"{found:.6g} a second. "
                    f"Remedy: give the time derivative of the {of}"
                )


class Joint(ABC):
    """How a body moves seen from its parent: ``v = V u``, ``w = W u`` and remainders, all in components of F.

    A subclass is one kinematic pair: it names its coordinates and speeds and gives the five functions below. None of
    them knows the tree. Driven coordinates (`motion`) keep their columns; the equations treat their speeds as known.

    Attributes
    ----------
    coordinate_names, speed_names : tuple of str
        With units in brackets.
    motion : Motion or None
        The joint's coordinate as a function of time.
    """

    coordinate_names: ClassVar[tuple[str, ...]] = ()
    speed_names: ClassVar[tuple[str, ...]] = ()
    motion: Motion | None = None

    @property
    def kind(self) -> str:
        """Name of the joint's kind, as in messages."""
        return type(self).__name__.lower()

    @abstractmethod
    def initial_coordinates(self) -> Vector:
        """Return q at the start, shape (coordinates,)."""

    @abstractmethod
    def initial_speeds(self) -> Vector:
        """Return u at the start, shape (speeds,)."""

    @abstractmethod
    def pose(self, q: Vector) -> tuple[Vector, Matrix]:
        """Return p_FoMo_F (3,) in m and A_FM (3, 3)."""

    @abstractmethod
    def partial_velocities(self, q: Vector) -> tuple[Matrix, Matrix]:
        """Return V and W (3, speeds) of M seen from F, in components of F (Eq. 13, 14)."""

    def remainders(self, q: Vector, u: Vector) -> tuple[Vector, Vector]:
        """Return Z and Y (3,): acceleration of M seen from F that needs no du, in components of F (Eq. 15, 16)."""
        return np.zeros(3), np.zeros(3)

    @property
    def stiffness_and_damping(self) -> tuple[float, float]:
        """Stiffness and damping of the one coordinate, N m/rad or N/m and N m s/rad or N s/m; zero without a spring."""
        return 0.0, 0.0

    @property
    def rest_position(self) -> float:
        """Coordinate at which the spring is slack, rad or m."""
        return 0.0

    def coordinate_rates(self, q: Vector, u: Vector) -> Vector:
        """Return dq/dt, shape (coordinates,)."""
        return u

    def advance(self, q: Vector, step: Vector) -> Vector:
        """Return q moved by u times a time, on the rotation group where q is on it."""
        return q + step


def axis_direction(axis: str | Sequence[float], kind: str) -> Vector:
    """Return the unit vector of an axis: "x", "y", "z" or three numbers; a ModelError names the joint's kind."""
    direction = AXES.get(axis) if isinstance(axis, str) else axis
    if direction is None:
        raise ModelError(f"axis of a {kind} joint: {axis!r} is not x, y, z or three numbers")
    return unit_vector(direction, f"the axis of a {kind} joint")


def start_values(value: object, count: int, what: str) -> Vector:
    """Return `count` finite numbers of a joint's start; a ModelError names what they are."""
    array = numbers(value)
    if array.shape != (count,) or not np.all(np.isfinite(array)):
        raise ModelError(f"{what} must be {count} finite numbers, not {value!r}")
    return array


def start_orientation(value: object, what: str) -> Vector:
    """Return unit Euler parameters of a joint's start; a ModelError names what they are."""
    e = start_values(value, 4, what)
    if np.linalg.norm(e) < 1e-12:
        raise ModelError(f"{what}: four zeros are no rotation. Remedy: (1, 0, 0, 0)")
    return e / np.linalg.norm(e)


@dataclass(frozen=True)
class AxisJoint(Joint):
    """Common part of the joints with one axis.

    Parameters
    ----------
    axis : "x", "y", "z" or three numbers
        Direction in the joint's fixed frame F; its length does not matter.
    position, speed : float
        Coordinate (rad or m) and its rate at the start.
    motion : Motion, optional
        Drives the coordinate; then `position` and `speed` must stay at zero.
    stiffness, damping : float
        Of a spring and damper across the joint: N m/rad and N m s/rad for an angle, N/m and N s/m for a distance.
    rest : float
        Coordinate at which the spring is slack (rad or m).

    Raises
    ------
    ModelError
        If the axis has no length, the start contradicts the motion, or stiffness or damping is negative.
    """

    axis: str | Sequence[float] = "z"
    position: float = 0.0
    speed: float = 0.0
    motion: Motion | None = None
    stiffness: float = 0.0
    damping: float = 0.0
    rest: float = 0.0
    direction: np.ndarray = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "direction", axis_direction(self.axis, self.kind))
        for name in ("position", "speed", "rest"):
            if not np.isfinite(getattr(self, name)):
                raise ModelError(f"{name} of a {self.kind} joint must be finite, not {getattr(self, name)!r}")
        for name in ("stiffness", "damping"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value >= 0):
                raise ModelError(f"{name} of a {self.kind} joint must be finite and >= 0, not {value!r}")
        if self.motion is not None:
            if self.position != 0.0 or self.speed != 0.0:
                raise ModelError(
                    f"a {self.kind} joint that is driven by a motion takes its start from it. "
                    "Remedy: leave out position and speed"
                )
            self.motion.check(f"{self.kind} joint")

    @property
    def stiffness_and_damping(self) -> tuple[float, float]:
        return self.stiffness, self.damping

    @property
    def rest_position(self) -> float:
        return self.rest

    def initial_coordinates(self) -> Vector:
        return np.array([self.position], dtype=float)

    def initial_speeds(self) -> Vector:
        return np.array([self.speed], dtype=float)
