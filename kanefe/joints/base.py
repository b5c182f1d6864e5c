"""Base classes of joints: coordinates, speeds, and the motion of the moving frame M seen from the fixed frame F."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from inspect import signature
from typing import Any, ClassVar, Self

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector, unit_vector
from kanefe.joints.coordinate_force import CoordinateForce
from kanefe.joints.held import Held
from kanefe.joints.joint_friction import JointFriction, RubbingSurfaces, Wanted, check_friction
from kanefe.joints.link import Link
from kanefe.joints.motion import Motion
from kanefe.joints.start import Start, Starts, are_given, start_value, start_values

AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


class Joint(ABC):
    """Motion of a body seen from its parent: ``v = V u``, ``w = W u`` and remainder accelerations, in components of F.

    A subclass is one kinematic pair, independent of the tree. It names its coordinates and speeds and defines the
    start, the pose and the partial velocities, and the remainders if V or W change with the coordinates. Driven
    coordinates (`motions`) keep their columns; the equations treat their speeds as known. The literal route calls these
    functions; the compiled one uses chains of links (`links`), among them links of one coordinate whose motion is a C
    function (`Link.given`). The joint of a user is checked for contradictions when it is added to a scene.

    Attributes
    ----------
    coordinate_names, speed_names : tuple of str
        With units in brackets: m or rad, m/s or rad/s. The rate of a coordinate is the speed of the same number, except
        for the four Euler parameters of a rotation, which have three speeds: the angular velocity in M.
    rotation_at : int or None
        Number of the first of the four Euler parameters in the coordinates, and of their three speeds in the speeds;
        None: the joint has no such rotation.
    holds_floating : bool
        Whether it can hold a flexible body without an interface fixed in its frame.
    armature : float
        Inertia of rotors against each of its speeds alone, of joints without forces along single coordinates.
    friction : JointFriction or None
        Friction proportional to the load of the joint, which then has a `bearing`.

    Examples
    --------
    A bead on a wire ``z = c x^2``; its coordinate is x:

    >>> import numpy as np
    >>> import kanefe as kf
    >>> class Wire(kf.Joint):
    ...     coordinate_names, speed_names = ("x [m]",), ("rate [m/s]",)
    ...     def __init__(self, c, x):
    ...         self.c, self.x = c, x
    ...     def initial_coordinates(self):
    ...         return np.array((self.x,))
    ...     def initial_speeds(self):
    ...         return np.zeros(1)
    ...     def pose(self, q):
    ...         return np.array((q[0], 0, self.c * q[0] ** 2)), np.eye(3)
    ...     def partial_velocities(self, q):
    ...         return np.array(((1,), (0,), (2 * self.c * q[0],))), np.zeros((3, 1))
    ...     def remainders(self, q, u):
    ...         return np.array((0, 0, 2 * self.c * u[0] ** 2)), np.zeros(3)
    >>> scene = kf.System(gravity=(0, 0, -9.81))
    >>> bead = scene.add_point("bead", 0.2, joint=Wire(0.5, 1.0))
    >>> result = scene.simulate((0.0, 1.0))
    >>> bool(abs(result.energy.balance_error).max() < 1e-6)
    True
    """

    coordinate_names: ClassVar[tuple[str, ...]] = ()
    speed_names: ClassVar[tuple[str, ...]] = ()
    rotation_at: ClassVar[int | None] = None
    holds_floating: ClassVar[bool] = False
    armature: float = 0.0
    friction: JointFriction | None = None

    def __new__(cls, *given: Any, **named: Any) -> Self:
        """Refuse the keyword `friction` if the kind of joint has none."""
        if "friction" in named and "friction" not in (known := signature(cls.__init__).parameters):
            raise ModelError(_no_friction(cls, "forces" in known and cls.rotation_at is None))
        return super().__new__(cls)

    @property
    def kind(self) -> str:
        """Name of the joint's kind, as in messages."""
        return type(self).__name__.lower()

    @property
    def motions(self) -> tuple[Motion | None, ...]:
        """Motion that drives each coordinate; None: it is free."""
        return (None,) * len(self.speed_names)

    @property
    def coordinate_forces(self) -> tuple[CoordinateForce | None, ...]:
        """Springs, dampers, friction and limits along each coordinate."""
        return (None,) * len(self.speed_names)

    @property
    def ranges(self) -> tuple[tuple[float, float] | None, ...]:
        """Smallest and largest value of each coordinate, at which a run fails with a message; None: no limit.

        Trial steps go a little beyond: the functions of the joint must be finite there.
        """
        return (None,) * len(self.speed_names)

    @abstractmethod
    def initial_coordinates(self) -> Vector:
        """Return q at the start, shape (coordinates,)."""

    @abstractmethod
    def initial_speeds(self) -> Vector:
        """Return u at the start, shape (speeds,)."""

    def given_start(self) -> tuple[list[bool], list[bool]]:
        """Return which coordinates and which speeds of the start are given, one of each for a speed.

        Loops keep these, and the others follow. A joint that does not say so gives all coordinates, and speeds other
        than zero: at rest is how a joint starts that nobody asks to move.
        """
        return [True] * len(self.speed_names), [bool(speed != 0.0) for speed in self.initial_speeds()]

    @abstractmethod
    def pose(self, q: Vector) -> tuple[Vector, Matrix]:
        """Return p_FoMo_F (3,) in m and A_FM (3, 3)."""

    @abstractmethod
    def partial_velocities(self, q: Vector) -> tuple[Matrix, Matrix]:
        """Return V and W (3, speeds) of M seen from F, in components of F (Eq. 13, 14)."""

    def remainders(self, q: Vector, u: Vector) -> tuple[Vector, Vector]:
        """Return Z and Y (3,): the acceleration of M seen from F without du, in components of F (Eq. 15, 16)."""
        return np.zeros(3), np.zeros(3)

    def coordinate_rates(self, q: Vector, u: Vector) -> Vector:
        """Return dq/dt, shape (coordinates,)."""
        return u

    def advance(self, q: Vector, step: Vector) -> Vector:
        """Return q moved by u times a time; Euler parameters stay on the rotation group."""
        return q + step

    def links(self) -> tuple[Link, ...] | None:
        """Return the joint as a chain of links, parent side first.

        None: the order-n route does not support it, and its scenes use the literal route.
        """
        return None

    def held(self) -> Held | None:
        """Return the constraints of the joint between two frames when it closes a loop; None: it cannot close one."""
        return None

    def bearing(self) -> RubbingSurfaces | None:
        """Return the part of the joint's reaction that loads its `friction`; None if it has none."""
        return None

    @property
    def is_fixed(self) -> bool:
        """Whether it allows no motion: M is F."""
        return not self.speed_names

    @property
    def is_free(self) -> bool:
        """Whether it moves freely in space."""
        links = self.links()
        return links is not None and len(links) == 1 and links[0].is_free

    @property
    def units(self) -> tuple[str, ...]:
        """Unit of a displacement along each speed: m or rad."""
        return tuple("rad" if "rad" in name else "m" for name in self.speed_names)

    def home(self) -> Vector:
        """Return the coordinates without displacement: zeros, and Euler parameters without rotation."""
        q = np.zeros(len(self.coordinate_names))
        if self.rotation_at is not None:
            q[self.rotation_at] = 1.0
        return q


def _no_friction(kind: type[Joint], has_forces: bool) -> str:
    """Return why a kind of joint has no friction, and the remedy."""
    if not kind.speed_names:
        remedy = "leave it out: nothing moves in it"
    elif has_forces:
        remedy = "CoordinateForce(friction=...) in its forces, or a chain of joints that have it"
    else:
        remedy = "a contact with friction=Coulomb(...), or a chain of joints that have it"
    name = kind.kind if isinstance(kind.kind, str) else kind.__name__.lower()
    return (
        f"a {name} joint has no friction from its load: revolute, prismatic, cylindrical, screw and "
        f"spherical joints have. Remedy: {remedy}"
    )


def axis_direction(axis: str | Sequence[float], kind: str) -> Vector:
    """Return the unit vector of an axis: "x", "y", "z" or three numbers; a ModelError names the joint's kind."""
    direction = AXES.get(axis) if isinstance(axis, str) else axis
    if direction is None:
        raise ModelError(f"axis of a {kind} joint: {axis!r} is not x, y, z or three numbers. Remedy: one of these")
    return unit_vector(direction, f"the axis of a {kind} joint")


class ScalarJoint(Joint):
    """Common part of the joints whose coordinates are distances and angles, with their rates as speeds."""

    _rubs: ClassVar[Wanted] = Wanted()

    def _check_coordinates(self) -> None:
        """Raise a ModelError if a motion or force has the wrong type, or if the start contradicts a motion."""
        motions, forces = self.motions, self.coordinate_forces
        count = len(self.coordinate_names)
        for what, given, kind, made in (
            ("motion", motions, Motion, "kf.Motion(position, velocity, acceleration), Motion.steady or Motion.table"),
            ("forces", forces, CoordinateForce, "kf.CoordinateForce(stiffness=, damping=, ...)"),
        ):
            if len(given) != count or not all(x is None or isinstance(x, kind) for x in given):
                wanted = f"a {kind.__name__}" if count == 1 else f"{count} of {kind.__name__} or None"
                got = given[0] if len(given) == 1 else given
                raise ModelError(f"{what} of a {self.kind} joint must be {wanted}, not {got!r}. Remedy: {made}")
        check_friction(self.friction, self.kind, self._rubs)
        if self.friction is not None and any(force is not None and force.friction > 0.0 for force in forces):
            raise ModelError(
                f"a {self.kind} joint has either friction from its load or a CoordinateForce with friction. Remedy: "
                "preload of JointFriction for what is there always"
            )
        values = zip(self.initial_coordinates(), self.initial_speeds(), strict=True)
        are_kept = zip(*self.given_start(), strict=True)
        for name, motion, kept, (position, speed) in zip(self.coordinate_names, motions, are_kept, values, strict=True):
            if motion is None:
                continue
            if any(kept) or position != 0.0 or speed != 0.0:
                raise ModelError(
                    f"the {name.partition(' [')[0]} of a {self.kind} joint that is driven by a motion takes its start "
                    "from it. Remedy: leave out position and speed, or None in their place"
                )
            motion.check(f"{self.kind} joint")


class SeveralCoordinatesJoint(ScalarJoint):
    """Common part of the scalar joints with more than one coordinate.

    Attributes
    ----------
    motion : sequence of Motion or None
        Drives single coordinates, which then take their start from it.
    forces : sequence of CoordinateForce or None
        Spring, damper, friction and limits of each coordinate.
    """

    position: Starts
    motion: Sequence[Motion | None]
    forces: Sequence[CoordinateForce | None]

    _rates: ClassVar[str] = "speed"

    def initial_coordinates(self) -> Vector:
        return self._start("position")

    def initial_speeds(self) -> Vector:
        return self._start(self._rates)

    def given_start(self) -> tuple[list[bool], list[bool]]:
        count = len(self.speed_names)
        return are_given(self.position, count), are_given(getattr(self, self._rates), count)

    def _start(self, name: str) -> Vector:
        return start_values(getattr(self, name), len(self.speed_names), f"{name} of a {self.kind} joint")

    @property
    def motions(self) -> tuple[Motion | None, ...]:
        return _one_each(self.motion)

    @property
    def coordinate_forces(self) -> tuple[CoordinateForce | None, ...]:
        return _one_each(self.forces)


class OneCoordinateJoint(ScalarJoint):
    """Common part of the joints with one coordinate.

    Attributes
    ----------
    position, speed : float, Guess or None
        Coordinate (rad or m) and its rate at the start; None: it follows.
    motion : Motion or None
        Drives the coordinate, which then takes its start from it.
    forces : CoordinateForce or None
        Spring, damper, friction and limits along the coordinate.
    """

    position: Start
    speed: Start
    motion: Motion | None
    forces: CoordinateForce | None

    @property
    def motions(self) -> tuple[Motion | None, ...]:
        return (self.motion,)

    @property
    def coordinate_forces(self) -> tuple[CoordinateForce | None, ...]:
        return (self.forces,)

    def initial_coordinates(self) -> Vector:
        return np.array([start_value(self.position, f"position of a {self.kind} joint")])

    def initial_speeds(self) -> Vector:
        return np.array([start_value(self.speed, f"speed of a {self.kind} joint")])

    def given_start(self) -> tuple[list[bool], list[bool]]:
        return are_given(self.position, 1), are_given(self.speed, 1)


def _one_each(given: Sequence[Any]) -> tuple[Any, ...]:
    return tuple(given) if isinstance(given, (tuple, list)) else (given,)


@dataclass(frozen=True)
class AxisJoint(OneCoordinateJoint):
    """Common part of the joints with one axis.

    Parameters
    ----------
    axis : "x", "y", "z" or three numbers
        Direction in the joint's fixed frame F; its length does not matter.
    position, speed : float or Guess, optional
        Coordinate (rad or m) and its rate at the start. A number is kept, also 0; without one it is zero, or follows
        where a loop needs it.
    motion : Motion, optional
        Drives the coordinate, which then takes its start from it.
    forces : CoordinateForce, optional
        Spring, damper, friction and limits along the coordinate.
    friction : JointFriction, optional
        Friction from the load of the joint.

    Raises
    ------
    ModelError
        If the axis has no length, or the start is not finite or contradicts the motion.
    """

    axis: str | Sequence[float] = "z"
    position: Start = None
    speed: Start = None
    motion: Motion | None = None
    forces: CoordinateForce | None = None
    friction: JointFriction | None = None
    direction: np.ndarray = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "direction", axis_direction(self.axis, self.kind))
        self._check_coordinates()
