"""Description of a robot, independent of its file: links, joints, couplings, closures, and elements left out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector, numbers, shaped_numbers
from kanefe.joints import CoordinateForce, Fixed, Free, Guess, Joint, Planar, Spherical
from kanefe.robots.compensation import Handed
from kanefe.robots.joint_forces import AxisForces, Coefficients, JointForces, PoseForces, is_linear_law
from kanefe.robots.pose import Pose

if TYPE_CHECKING:
    from kanefe.robots.looks import LinkLook


@dataclass(frozen=True)
class LinkJoint:
    """One joint between a link's parent and the link.

    Attributes
    ----------
    name : str
    joint : Joint
    fixed : Pose
        Pose of the joint's fixed frame F, relative to the parent link or to the previous joint.
    moving : Pose
        Pose of the next frame relative to the joint's moving frame M.
    forces : JointForces, optional
        Those that `joint` cannot have along its coordinates.
    """

    name: str
    joint: Joint
    fixed: Pose = field(default_factory=Pose)
    moving: Pose = field(default_factory=Pose)
    forces: JointForces | None = None


@dataclass(frozen=True)
class RobotLink:
    """A link: its mass, and the joints that carry it, in order.

    Attributes
    ----------
    name : str
    parent : str or None
        None: the ground.
    joints : tuple of LinkJoint
        At least one.
    mass : float
        kg.
    center : ndarray, shape (3,)
        Centre of mass in the frame of the link, m.
    inertia : ndarray, shape (3, 3)
        About the centre of mass in the axes of the link, kg m2.
    compensation : float
        Part of its weight that is compensated at its centre of mass; 1: it is weightless.
    """

    name: str
    parent: str | None
    joints: tuple[LinkJoint, ...]
    mass: float
    center: Vector
    inertia: Matrix
    compensation: float = 0.0

    @property
    def moves(self) -> bool:
        """Whether it moves relative to its parent."""
        return any(not made.joint.is_fixed for made in self.joints)


@dataclass(frozen=True)
class Coupling:
    """``sum c_i q_i = constant`` over joints by name; the first, with c = 1, follows the other, if there is one."""

    name: str
    coefficients: Mapping[str, float]
    constant: float


COORDINATES = {
    0: "none, because it is fixed",
    1: "one number, in rad or m",
    3: "three numbers: two distances in m and an angle in rad",
    4: "four numbers: Euler parameters, scalar first",
    7: "seven numbers: position in m and Euler parameters, scalar first",
}
"""Number of coordinates of a joint -> what `positions` gives."""

Ends = tuple[tuple[str | None, Pose], tuple[str | None, Pose]]


@dataclass(frozen=True)
class Closure:
    """A joint that closes a loop between frames of two links; None: of the ground."""

    name: str
    joint: Joint
    ends: Ends


@dataclass
class NotTaken:
    """Elements of a file that are not in the scene: names by kind, apart those that would change the motion.

    Limits of joints and collision shapes, which nearly every file has, act only where a motion reaches them: they are
    listed with what is silent.
    """

    acting: dict[str, list[str]] = field(default_factory=dict)
    silent: dict[str, list[str]] = field(default_factory=dict)

    def add_acting(self, kind: str, name: str) -> None:
        """Add an element that would change the motion."""
        self.acting.setdefault(kind, []).append(name)

    def add_silent(self, kind: str, name: str) -> None:
        """Add an element that would not change the motion."""
        self.silent.setdefault(kind, []).append(name)


@dataclass
class Robot:
    """Content of a file, parents before their children."""

    name: str
    links: list[RobotLink] = field(default_factory=list)
    couplings: list[Coupling] = field(default_factory=list)
    closures: list[Closure] = field(default_factory=list)
    handed: list[Handed] = field(default_factory=list)
    looks: list[LinkLook] = field(default_factory=list)
    not_taken: NotTaken = field(default_factory=NotTaken)


@dataclass(frozen=True)
class Choices:
    """Options of a reader for joints.

    Attributes
    ----------
    positions : mapping of str to float or sequence of float
        Coordinates of joints at the start, m or rad; several in MuJoCo's order.
    forces : bool
        Whether springs, dampers and friction of the file act.
    limit_stiffness, limit_damping : float
        Of stops at the limits, N/m and N s/m, or N m/rad and N m s/rad; without stiffness limits are ignored.
    guesses, speeds : mapping of str to sequence of float
        Near what coordinates joints start that are not in `positions`, and near what speeds: those of a keyframe, m,
        rad, Euler parameters, and 1/s.
    limited : list of str
        Joints with stops.
    coupled : dict of str to float
        Where the couplings put joints at the start.
    """

    positions: Mapping[str, float | Sequence[float]]
    forces: bool
    limit_stiffness: float | None
    limit_damping: float
    guesses: Mapping[str, Sequence[float]] = field(default_factory=dict)
    speeds: Mapping[str, Sequence[float]] = field(default_factory=dict)
    limited: list[str] = field(default_factory=list)
    coupled: dict[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.limit_stiffness is not None and shaped_numbers(self.limit_stiffness, (), "limit_stiffness") <= 0.0:
            raise ModelError(f"limit_stiffness must be > 0, or None for no stops, not {self.limit_stiffness!r}")
        if shaped_numbers(self.limit_damping, (), "limit_damping") < 0.0:
            raise ModelError(f"limit_damping must be >= 0, not {self.limit_damping!r}")
        if self.limit_damping and self.limit_stiffness is None:
            raise ModelError("limit_damping without limit_stiffness does nothing. Remedy: give limit_stiffness")
        if not isinstance(self.positions, Mapping):
            raise ModelError(
                f"positions must be a dict of joints and numbers, such as {{'elbow': 0.5}}, not {self.positions!r}"
            )
        for name, value in self.positions.items():
            given = numbers(value)
            if given.ndim > 1 or not given.size or not np.isfinite(given).all():
                raise ModelError(
                    f"positions: that of joint {name!r} must be a finite number, in rad or m, or a list of them if the "
                    f"joint has several coordinates, not {value!r}"
                )

    def take_couplings(self, couplings: Sequence[Coupling], usual: Mapping[str, float]) -> None:
        """Find where couplings put joints: what is given stays, then what leads, and what follows moves.

        Parameters
        ----------
        couplings : sequence of Coupling
        usual : dict of str to float
            Where the file puts each joint with one coordinate, rad or m.
        """
        pairs: list[tuple[str, str | None]] = [(*coupling.coefficients, None)[:2] for coupling in couplings]  # type: ignore[misc]
        known = {name: self.one(name) for name in usual if name in self.positions}
        for _ in couplings:  # what leads a follower that is given, through chains
            for (follower, leader), coupling in zip(pairs, couplings, strict=True):
                if leader is not None and follower in known and leader not in known:
                    known[leader] = (known[follower] - coupling.constant) / -coupling.coefficients[leader]
        followers = {follower for follower, _ in pairs if follower not in known}
        known |= {leader: usual[leader] for _, leader in pairs if leader and leader not in {*known, *followers}}
        for _ in couplings:
            for (follower, leader), coupling in zip(pairs, couplings, strict=True):
                if follower not in known and (leader is None or leader in known):
                    moved = -coupling.coefficients[leader] * known[leader] if leader is not None else 0.0
                    known[follower] = coupling.constant + moved
        self.coupled.update(known)

    def one(self, name: str) -> float:
        """Return the given coordinate of a joint that has one."""
        return float(self.several(name, 1)[0])

    def several(self, name: str, count: int) -> Vector:
        """Return the given coordinates of a joint that has `count`."""
        given = np.atleast_1d(numbers(self.positions[name]))
        if given.size != count:
            what = COORDINATES[count]
            raise ModelError(f"positions: joint {name!r} takes {what}; it was given {self.positions[name]!r}")
        return given

    def start(self, name: str, usual: float) -> float | Guess:
        """Return where a joint with one coordinate starts: as given, or near where couplings or the file put it."""
        return self.one(name) if name in self.positions else Guess(self.coupled.get(name, usual))

    def speed(self, name: str) -> Guess | None:
        """Return near what speed a joint with one coordinate starts, rad/s or m/s."""
        return Guess(self.speeds[name][0]) if name in self.speeds else None

    def free(self, name: str, usual: Sequence[float] | None = None) -> Free:
        """Return a free joint at its start: position, and Euler parameters, scalar first."""
        if name in self.positions:
            usual = self.several(name, 7).tolist()
            self._check_orientation(name, usual[3:])
        rates = self.speeds.get(name, (0.0,) * 6)
        speeds = Guess(rates[:3]), Guess(rates[3:])
        if name in self.guesses and name not in self.positions:
            near = self.guesses[name]
            return Free(Guess(near[:3]), Guess(near[3:]), *speeds)
        if usual is None:
            return Free(None, None, *speeds)
        return Free(tuple(usual[:3]), tuple(usual[3:]), *speeds)

    def ball(self, name: str) -> Spherical:
        """Return a spherical joint at its start."""
        speed = Guess(self.speeds[name]) if name in self.speeds else None
        if name in self.positions:
            given = self.several(name, 4).tolist()
            self._check_orientation(name, given)
            return Spherical(orientation=tuple(given), angular_velocity=speed)
        near = Guess(self.guesses[name]) if name in self.guesses else None
        return Spherical(orientation=near, angular_velocity=speed)

    def planar(self, name: str, forces: Sequence[CoordinateForce | None]) -> Planar:
        """Return a planar joint at its start."""
        if name not in self.positions:
            return Planar(forces=forces)
        x, y, angle = self.several(name, 3).tolist()
        return Planar(position=(x, y), angle=angle, forces=forces)

    def fixed(self, name: str) -> Fixed:
        """Return a fixed joint, which takes no start."""
        if name in self.positions:
            self.several(name, 0)
        return Fixed()

    def _check_orientation(self, name: str, e: Sequence[float]) -> None:
        if not any(e):
            raise ModelError(f"positions: the Euler parameters of joint {name!r} are all zero. Remedy: 1, 0, 0, 0")

    def coordinate_force(
        self,
        name: str,
        not_taken: NotTaken,
        *,
        limits: tuple[float | None, float | None] = (None, None),
        stiffness: float = 0.0,
        rest: float = 0.0,
        damping: float = 0.0,
        friction: float = 0.0,
        armature: float = 0.0,
    ) -> CoordinateForce | None:
        """Return the force along a coordinate, None if there is none; record what is left out."""
        what: dict[str, object] = {"armature": armature} if armature else {}
        for kind, value in (("stiffness", stiffness), ("damping", damping), ("friction", friction)):
            if value and self.forces:
                what[kind] = value
            elif value:
                not_taken.add_acting(f"{kind} of joints", name)
        if "stiffness" in what:
            what["rest"] = rest
        if limits != (None, None) and self.limit_stiffness is None:
            not_taken.add_silent("limits of joints (limit_stiffness= takes them)", name)
        elif limits != (None, None) and limits[0] == limits[1]:
            not_taken.add_acting("limits without a range between them", name)
        elif limits != (None, None):
            self.limited.append(name)
            what |= {"limits": limits, "limit_stiffness": self.limit_stiffness, "limit_damping": self.limit_damping}
        try:
            return CoordinateForce(**what) if what else None  # type: ignore[arg-type]
        except ModelError as error:
            raise ModelError(f"joint {name!r}: {error}") from error

    def axis_forces(
        self, name: str, not_taken: NotTaken, stiffness: Coefficients, damping: Coefficients, rest: float
    ) -> AxisForces | None:
        """Return springs and dampers along a coordinate that no CoordinateForce is, None if it is one."""
        if is_linear_law(stiffness, damping):
            return None
        return AxisForces(stiffness, damping, rest) if self._act(name, not_taken, stiffness, damping) else None

    def pose_forces(
        self, name: str, not_taken: NotTaken, stiffness: Coefficients, damping: Coefficients, rest: Pose, free: bool
    ) -> PoseForces | None:
        """Return springs and dampers of a free or spherical joint, None if there are none."""
        if not any((*stiffness, *damping)) or not self._act(name, not_taken, stiffness, damping):
            return None
        return PoseForces(stiffness, damping, rest, free)

    def _act(self, name: str, not_taken: NotTaken, stiffness: Coefficients, damping: Coefficients) -> bool:
        """Return whether forces act, and record them if they do not."""
        for kind, values in (("stiffness", stiffness), ("damping", damping)):
            if any(values) and not self.forces:
                not_taken.add_acting(f"{kind} of joints", name)
        return self.forces

    def check_limits(self, source: Path) -> None:
        """Raise a ModelError if stops are requested and no joint of a file has limits."""
        if self.limit_stiffness is not None and not self.limited:
            raise ModelError(f"limit_stiffness does nothing: no joint of {source} has limits. Remedy: leave it out")
