"""Random scenes whose answers are known by brute force: every source far finer than any accuracy that is asked for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

import kanefe as kf
from kanefe.certified.values import values_of
from kanefe_fem import Material, Rectangle, beam_body, straight_beam

DENSITY = 2700.0
"""kg/m3"""


@dataclass
class KnownScene:
    """A scene with its answers.

    Attributes
    ----------
    name : str
    build : callable
        ``build(level) -> System``; 0: as a user would; 1 and 2: with bodies of far more modes and elements.
    span : float
        s.
    of : list of Quantity
    accuracy : float
    held : list
        What has to live as long as the scene.
    """

    name: str
    build: Callable[[int], kf.System]
    span: float
    of: list[kf.Quantity]
    accuracy: float
    held: list[Any] = field(default_factory=list)

    def read(self, result: kf.Result, count: int) -> list[Any]:
        """Return the values of the quantities, of a result with so many outputs for each."""
        return [values for quantity in self.of for values in values_of(quantity, result, count)]

    def reference(self, times: np.ndarray) -> tuple[list[Any], np.ndarray]:
        """Return the values of the quantities at some times, by brute force, and how far they are known.

        They are known as far as a second run with a lesser model, a looser tolerance and half the outputs gives them.
        """
        runs = []
        for level, rtol, count in ((1, 1e-10, 4), (2, 1e-11, 8)):
            options = {"output_times": dense(times, count), "most_seconds": 120.0}
            result = self.build(level).simulate((0.0, self.span), rtol=rtol, **options)
            assert result.status.is_finished
            runs.append(self.read(result, count))
        return runs[1], np.array([a.apart(b) for a, b in zip(*runs, strict=True)])


def dense(times: np.ndarray, count: int) -> np.ndarray:
    """Return so many times as many times."""
    return np.unique(np.concatenate([times[:-1] + np.diff(times) * i / count for i in range(count)] + [times]))


def beam_scene(rng: np.random.Generator) -> KnownScene:
    """Return a damped beam, clamped or hinged to a hub, with a load at its tip, gravity, or a hub that is driven."""
    length, height = rng.uniform(0.3, 2.0), rng.uniform(0.01, 0.05)
    width = height * rng.uniform(0.8, 1.5)
    material = Material(E=rng.uniform(50e9, 210e9), nu=0.3, rho=DENSITY)
    slowest = 3.516 / (2 * np.pi) * np.sqrt(material.E * height**2 / 12 / DENSITY) / length**2
    elements, modes = int(rng.integers(4, 17)), int(rng.integers(2, 9))
    kind, tip = rng.choice(["force", "gravity", "driven"]), bool(rng.integers(2))
    span, ratio = rng.uniform(0.5, 2.0) / slowest, rng.uniform(0.01, 0.05)
    heavy = rng.uniform(0.05, 0.5) * DENSITY * length * width * height
    stiffness = 3 * material.E * width * height**3 / 12 / length**3
    push, ramp = 0.02 * length * stiffness, rng.uniform(0.3, 1.0) / slowest
    angle = rng.uniform(0.1, 0.4)
    held: list[Any] = []

    def pushed(t: float) -> tuple[float, float, float]:
        return (0.0, push * np.sin(np.pi * t / ramp) ** 2 if t < ramp else 0.0, 0.0)

    rate = 2 * np.pi / span
    turned = kf.Motion(
        lambda t: angle * (t / span - np.sin(rate * t) / (2 * np.pi)),
        lambda t: angle / span * (1 - np.cos(rate * t)),
        lambda t: angle / span * rate * np.sin(rate * t),
    )

    def build(level: int) -> kf.System:
        model = straight_beam(
            length, Rectangle(width, height), material, elements=(elements, 32, 64)[level], planar=True
        )
        held.append(model)
        loads = ("gravity", "angular acceleration", "centrifugal") if level else ()
        reduction = kf.CraigBampton(modes=(modes, 16, 32)[level], loads=loads)
        interfaces = {"root": "clamped", "tip": "rigid"}
        damping = kf.RayleighDamping(stiffness=ratio / (np.pi * slowest))
        body = beam_body(model, interfaces, reduction, damping, stiffening="full" if level else "none")
        scene = kf.System(gravity=(0, -9.81 if kind == "gravity" else 0.0, 0))
        joint = kf.Revolute("z", motion=turned) if kind == "driven" else kf.Fixed()
        beam = scene.add_flexible_body("beam", body, joint=joint)
        if tip:
            scene.add_rigid_body("tip", heavy, heavy * 1e-3 * length**2, parent=beam.interface("tip"))
        if kind == "force":
            scene.add_force(beam.interface("tip"), pushed)
        return scene

    of = [
        kf.Quantity("deflection beam/tip translation_y"),
        kf.Quantity("coupling_force beam/root moment_z", over=str(rng.choice(["time", "rms", "largest", "final"]))),
    ]
    return KnownScene(f"beam {kind}{' with tip' if tip else ''}", build, span, of, 10 ** rng.uniform(-4, -2), held)


def rigid_scene(rng: np.random.Generator) -> KnownScene:
    """Return a chain of rods that swing, with springs and dampers in their joints."""
    count = int(rng.integers(1, 4))
    lengths, masses = rng.uniform(0.3, 1.0, count), rng.uniform(0.5, 2.0, count)
    starts, springs = rng.uniform(-0.6, 0.6, count), rng.uniform(0.0, 20.0, count)
    damping = rng.uniform(0.0, 0.5, count)
    span = rng.uniform(0.5, 3.0)

    def build(level: int) -> kf.System:
        scene = kf.System(gravity=(0, -9.81, 0))
        parent: Any = scene.ground
        for i in range(count):
            at = (0.0, 0.0, 0.0) if i == 0 else (lengths[i - 1], 0.0, 0.0)
            hold = kf.CoordinateForce(float(springs[i]), damping=float(damping[i]))
            joint = kf.Revolute("z", position=float(starts[i]), forces=hold)
            inertia = float(masses[i] * lengths[i] ** 2 / 12)
            com = (0.5 * float(lengths[i]), 0.0, 0.0)
            parent = scene.add_rigid_body(
                f"rod {i}", float(masses[i]), inertia, com=com, parent=parent, at=at, joint=joint
            )
        return scene

    last = f"rod {count - 1}"
    of = [
        kf.Quantity(f"joint_coordinates {last}"),
        kf.Quantity("joint_reaction rod 0 force_y", over=str(rng.choice(["time", "rms", "largest", "final"]))),
        kf.Quantity(lambda result: float(result.energy.kinetic.max()), name="largest kinetic energy"),
    ]
    return KnownScene(f"chain of {count}", build, span, of, 10 ** rng.uniform(-6, -2))


def contact_scene(rng: np.random.Generator) -> KnownScene:
    """Return a ball that is thrown on a plane, and bounces and rolls."""
    mass, radius, height = rng.uniform(0.2, 2.0), rng.uniform(0.05, 0.2), rng.uniform(0.1, 0.5)
    speed, mu = rng.uniform(0.2, 2.0), rng.uniform(0.1, 0.6)
    fall = np.sqrt(2 * height / 9.81)

    def build(level: int) -> kf.System:
        scene = kf.System(gravity=(0, 0, -9.81))
        joint = kf.Free(position=(0.0, 0.0, radius + height), velocity=(speed, 0.0, 0.0))
        ball = scene.add_rigid_body("ball", mass, 0.4 * mass * radius**2, joint=joint)
        floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane())
        sphere = scene.add_surface("sphere", ball, kf.shapes.Sphere(radius))
        normal = kf.HuntCrossley(mass * 9.81 / 1e-4, damping=0.3)
        scene.add_contact("bounce", sphere, floor, normal=normal, friction=kf.Coulomb(mu))
        return scene

    of = [
        kf.Quantity("position ball x"),
        kf.Quantity("position ball z"),
        kf.Quantity(lambda result: float(result.events["bounce touch"][0]), name="first touch"),
    ]
    return KnownScene("ball", build, float(fall * rng.uniform(1.3, 2.5)), of, 10 ** rng.uniform(-4, -2))


KINDS = (beam_scene, beam_scene, rigid_scene, contact_scene)


def known_scene(seed: int) -> KnownScene:
    """Return a scene of a seed."""
    rng = np.random.default_rng((63, seed))
    return KINDS[seed % len(KINDS)](rng)
