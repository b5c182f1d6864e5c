"""Random scenes as plain data, which can be moved, turned, written in other units, reordered and split."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from kanefe.checks.robustness.bodies import lattice
from kanefe.checks.robustness.units import SI, Units
from kanefe.frames import multiply, rotation_matrix
from kanefe.joints import Cylindrical, Fixed, Free, Joint, Prismatic, Revolute, Spherical, Universal
from kanefe.scene.scene import Frame
from kanefe.system import System

KINDS = ("revolute", "prismatic", "cylindrical", "universal", "spherical", "free", "fixed")


@dataclass(frozen=True, eq=False)
class Part:
    """A body of a random scene, in SI units.

    Attributes
    ----------
    name, parent : str
        Parent "": the inertial frame.
    kind : str
        Of its joint.
    at, orientation : ndarray, (3,) and (4,)
        Where the joint sits on the parent, m, and Euler parameters.
    axes : ndarray, shape (2, 3)
        Of the joint.
    start, speeds : ndarray, shape (6,)
        Of the joint: as many of them as it has speeds, lengths first.
    mass : float
    com : ndarray, shape (3,)
    inertia : ndarray, shape (3, 3)
        About the centre of mass.
    lattice : int
        Number of the flexible body, -1: rigid.
    """

    name: str
    parent: str
    kind: str
    at: np.ndarray
    orientation: np.ndarray
    axes: np.ndarray
    start: np.ndarray
    speeds: np.ndarray
    mass: float = 0.0
    com: np.ndarray = field(default_factory=lambda: np.zeros(3))
    inertia: np.ndarray = field(default_factory=lambda: np.zeros((3, 3)))
    lattice: int = -1


@dataclass(frozen=True, eq=False)
class Pull:
    """A force in N and a torque, both constant, on a part at a point of it; `follows`: in its axes."""

    part: str
    force: np.ndarray
    torque: np.ndarray
    point: np.ndarray
    follows: bool


@dataclass(frozen=True, eq=False)
class Spring:
    """A spring and damper between points of two parts ("": the ground)."""

    a: str
    b: str
    at_a: np.ndarray
    at_b: np.ndarray
    stiffness: float
    damping: float
    rest: float


@dataclass(frozen=True, eq=False)
class Description:
    """A scene as plain data.

    Attributes
    ----------
    gravity : ndarray, shape (3,)
        m/s2.
    parts : tuple of Part
        Parents first.
    pulls, springs : tuple
    units : Units
        In which it is built.
    """

    gravity: np.ndarray
    parts: tuple[Part, ...]
    pulls: tuple[Pull, ...]
    springs: tuple[Spring, ...]
    units: Units = SI

    def build(self) -> System:
        """Return the scene."""
        return _build(self)

    def moved(self, shift: np.ndarray) -> Description:
        """Return the scene at another place: `shift` in m."""
        parts = tuple(replace(p, at=p.at + shift) if not p.parent else p for p in self.parts)
        springs = tuple(replace(s, at_a=s.at_a + shift) if not s.a else s for s in self.springs)
        return replace(self, parts=parts, springs=springs)

    def turned(self, e: np.ndarray) -> Description:
        """Return the scene, its gravity and its loads turned as a whole by Euler parameters."""
        Q = rotation_matrix(e)
        parts = tuple(
            replace(p, at=Q @ p.at, orientation=multiply(e, p.orientation)) if not p.parent else p for p in self.parts
        )
        pulls = tuple(p if p.follows else replace(p, force=Q @ p.force, torque=Q @ p.torque) for p in self.pulls)
        springs = tuple(replace(s, at_a=Q @ s.at_a) if not s.a else s for s in self.springs)
        return replace(self, gravity=Q @ self.gravity, parts=parts, pulls=pulls, springs=springs)

    def written_in(self, units: Units) -> Description:
        """Return the same scene in other units."""
        return replace(self, units=units)

    def reordered(self, rng: np.random.Generator) -> Description:
        """Return the scene with its bodies, loads and springs added in another order."""
        left, placed = [self.parts[i] for i in rng.permutation(len(self.parts))], [""]
        parts: list[Part] = []
        while left:
            ready = next(p for p in left if p.parent in placed)
            left.remove(ready)
            parts.append(ready)
            placed.append(ready.name)
        pulls = tuple(self.pulls[i] for i in rng.permutation(len(self.pulls)))
        springs = tuple(self.springs[i] for i in rng.permutation(len(self.springs)))
        return replace(self, parts=tuple(parts), pulls=pulls, springs=springs)

    def split(self, rng: np.random.Generator) -> Description:
        """Return the scene with every rigid body cut in two that a fixed joint holds together."""
        parts: list[Part] = []
        for part in self.parts:
            parts += [part] if part.lattice >= 0 else _halves(part, rng)
        return replace(self, parts=tuple(parts))


def _halves(part: Part, rng: np.random.Generator) -> list[Part]:
    """Return two bodies with the mass, centre of mass and inertia of one; the second anywhere in the first."""
    share = float(rng.uniform(0.2, 0.8))
    second = 0.5 * np.trace(part.inertia) * np.eye(3) - part.inertia  # int rho r r^T about the centre of mass
    reduced = part.mass * share * (1.0 - share)
    # what the distance of the two centres takes off the second moments must leave those of a body
    away = rng.standard_normal(3)
    away *= 0.5 * np.sqrt(np.linalg.eigvalsh(second)[0] / reduced) / np.linalg.norm(away)
    left = second - reduced * np.outer(away, away)
    inertia = np.trace(left) * np.eye(3) - left
    e, at = rng.standard_normal(4), rng.uniform(-0.3, 0.3, 3)
    A = rotation_matrix(e)
    first = replace(part, mass=(1.0 - share) * part.mass, com=part.com - share * away, inertia=(1.0 - share) * inertia)
    com = part.com + (1.0 - share) * away
    other = Part(
        f"{part.name} other",
        part.name,
        "fixed",
        at,
        e / np.linalg.norm(e),
        part.axes,
        np.zeros(6),
        np.zeros(6),
        share * part.mass,
        A.T @ (com - at),
        share * A.T @ inertia @ A,
    )
    return [first, other]


def random_description(seed: int, bodies: int = 6, flexible: float = 0.3) -> Description:
    """Return a random tree of bodies with loads and springs, `flexible` the share of flexible bodies."""
    rng = np.random.default_rng((seed, 7))
    parts: list[Part] = []
    for i in range(int(rng.integers(2, bodies + 1))):
        near = [p.name for p in parts[-3:]]
        parent = near[int(rng.integers(len(near)))] if near and rng.uniform() < 0.85 else ""
        is_flexible = bool(rng.uniform() < flexible)
        kind = KINDS[int(rng.integers(len(KINDS)))]
        if not parts and kind == "fixed":
            kind = "spherical"
        cloud = rng.standard_normal((6, 3)) * 0.1
        second = cloud.T @ cloud
        parts.append(
            Part(
                name=f"b{i}",
                parent=parent,
                kind=kind,
                at=rng.uniform(-0.5, 0.5, 3),
                orientation=rng.standard_normal(4),
                axes=_cross_axes(rng),
                start=rng.uniform(-0.5, 0.5, 6),
                speeds=rng.uniform(-1.0, 1.0, 6),
                mass=float(rng.uniform(0.5, 2.0)),
                com=rng.uniform(-0.2, 0.2, 3),
                inertia=np.trace(second) * np.eye(3) - second,
                lattice=int(rng.integers(3)) if is_flexible else -1,
            )
        )
    rigid = [p.name for p in parts if p.lattice < 0]
    pulls, springs = [], []
    for _ in range(2 if rigid else 0):
        name = rigid[int(rng.integers(len(rigid)))]
        vectors = rng.standard_normal((3, 3))
        pulls.append(Pull(name, vectors[0], 0.3 * vectors[1], 0.2 * vectors[2], bool(rng.integers(2))))
        other = ["", *rigid][int(rng.integers(len(rigid) + 1))]
        if other != name:
            springs.append(
                Spring(
                    other,
                    name,
                    rng.uniform(0.5, 1.5, 3),
                    rng.uniform(-0.3, 0.3, 3),
                    *(float(x) for x in rng.uniform((1.0, 0.1, 0.2), (5.0, 0.5, 0.8))),
                )
            )
    return Description(rng.uniform(-5, 5, 3), tuple(parts), tuple(pulls), tuple(springs))


def _cross_axes(rng: np.random.Generator) -> np.ndarray:
    """Return two unit vectors across each other."""
    columns, _ = np.linalg.qr(rng.standard_normal((3, 3)))
    return np.ascontiguousarray(columns[:, :2].T)


def listed(array: np.ndarray) -> list[float]:
    """Return the numbers of an array."""
    return list(array.tolist())


def _joint(part: Part, units: Units) -> Joint:
    x, v = part.start, part.speeds
    L, S, W = units.length, units.speed, units.rate
    first, second = part.axes
    if part.kind == "revolute":
        return Revolute(first, position=x[3], speed=v[3] * W)
    if part.kind == "prismatic":
        return Prismatic(first, position=x[0] * L, speed=v[0] * S)
    if part.kind == "cylindrical":
        joint = Cylindrical(first)
        values = [(x[0] * L, v[0] * S) if "[m]" in name else (x[3], v[3] * W) for name in joint.coordinate_names]
        return Cylindrical(first, position=[a for a, _ in values], speed=[b for _, b in values])
    if part.kind == "universal":
        return Universal(first, second, position=listed(x[3:5]), speed=listed(v[3:5] * W))
    e = np.concatenate(([1.0], x[3:]))
    if part.kind == "spherical":
        return Spherical(orientation=listed(e), angular_velocity=listed(v[3:] * W))
    if part.kind == "free":
        return Free(
            position=listed(x[:3] * L),
            orientation=listed(e),
            velocity=listed(v[:3] * S),
            angular_velocity=listed(v[3:] * W),
        )
    return Fixed()


def _build(scene: Description) -> System:
    units = scene.units
    system = System(gravity=listed(scene.gravity * units.acceleration))
    frames: dict[str, Frame] = {"": system.ground}
    for part in scene.parts:
        where: dict[str, Any] = {
            "parent": frames[part.parent],
            "at": part.at * units.length,
            "orientation": part.orientation,
            "joint": _joint(part, units),
        }
        if part.lattice >= 0:
            body = lattice(part.lattice, modes=2, units=units)
            frames[part.name] = system.add_flexible_body(part.name, body, **where).interface("tip")
        else:
            frames[part.name] = system.add_rigid_body(
                part.name,
                part.mass * units.mass,
                part.inertia * units.inertia,
                com=listed(part.com * units.length),
                **where,
            )
    _add_loads(scene, system, frames)
    return system


def _add_loads(scene: Description, system: System, frames: dict[str, Frame]) -> None:
    units = scene.units
    for pull in scene.pulls:
        target = frames[pull.part]
        system.add_force(
            target, listed(pull.force * units.force), point=listed(pull.point * units.length), follows=pull.follows
        )
        system.add_torque(target, listed(pull.torque * units.moment), follows=pull.follows)
    for i, spring in enumerate(scene.springs):
        ends: Sequence[Frame] = (
            frames[spring.a].frame(at=listed(spring.at_a * units.length)),
            frames[spring.b].frame(at=listed(spring.at_b * units.length)),
        )
        system.add_spring(
            f"s{i}",
            *ends,
            stiffness=spring.stiffness * units.stiffness,
            damping=spring.damping * units.damping,
            rest_length=spring.rest * units.length,
        )
