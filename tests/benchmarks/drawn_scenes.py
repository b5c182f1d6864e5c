"""Scenes drawn by a seed, which no default was tuned on: chains, trees and loops, with what makes methods differ.

Drawn are flexible links, springs from soft to stiff, damping or none, contacts (compliant or rigid), controllers
(continuous, or sampled at 100 Hz to 5 kHz) and loads that are smooth or jump. This file was written before ``auto`` is
changed to check itself, and is not changed after.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

import kanefe as kf
from kanefe_fem import Material, Rectangle, beam_body, straight_beam

ALUMINIUM = Material(E=70e9, nu=0.33, rho=2700.0)
GRAVITY = 9.81


class Drawn(NamedTuple):
    """A scene that was drawn.

    Attributes
    ----------
    scene : System
    seconds : float
        How long it runs, s.
    size : float
        Largest extent of what moves, m.
    bodies : tuple of str
        Those whose positions are compared.
    words : tuple of str
        What is in it.
    """

    scene: kf.System
    seconds: float
    size: float
    bodies: tuple[str, ...]
    words: tuple[str, ...]


class _Drawing:
    """A scene as it is drawn."""

    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng([20261126, seed])
        self.scene = kf.System(gravity=(0.0, 0.0, -GRAVITY))
        self.words: list[str] = []
        self.names: list[str] = []
        self.is_stiff = self.chance(0.4)
        self.is_damped = self.chance(0.6)
        self.words += ["stiff" if self.is_stiff else "soft", "damped" if self.is_damped else "undamped"]

    def chance(self, share: float) -> bool:
        """Return whether something happens that does so in a share of all cases."""
        return bool(self.rng.random() < share)

    def size(self, least: float, most: float) -> float:
        """Return a number of any order of magnitude between two."""
        return float(10.0 ** self.rng.uniform(math.log10(least), math.log10(most)))

    def spring(self, inertia: float) -> kf.CoordinateForce | None:
        """Return the spring of a hinge, by the frequency with which it would turn an inertia (kg m2)."""
        if not self.is_stiff and self.chance(0.5):
            return None
        rate = 2.0 * math.pi * (self.size(20.0, 300.0) if self.is_stiff else self.size(0.3, 5.0))
        damping = 2.0 * self.size(0.01, 0.3) * inertia * rate if self.is_damped else 0.0
        return kf.CoordinateForce(stiffness=inertia * rate**2, damping=damping)

    def link(self, parent: Any, at: tuple[float, float, float], length: float, axis: str, *, soft: bool = False) -> Any:
        """Add a rigid link along x on a hinge."""
        mass = self.size(0.2, 5.0) * length
        inertia = mass * length**2 / 12.0
        spring = None if soft else self.spring(mass * length**2 / 3.0)
        joint = kf.Revolute(axis, position=float(self.rng.uniform(-0.6, 0.6)), forces=spring)
        name = f"link {len(self.names)}"
        self.names.append(name)
        where = {} if parent is None else {"parent": parent}
        return self.scene.add_rigid_body(name, mass, inertia, com=(0.5 * length, 0, 0), at=at, joint=joint, **where)

    def beam(self, parent: Any, at: tuple[float, float, float], length: float) -> Any:
        """Add a flexible link along x on a hinge, and return the frame at its end."""
        width, height = self.size(0.01, 0.04), self.size(0.002, 0.01)
        shape = straight_beam(length, Rectangle(width, height), ALUMINIUM, elements=6)
        damping = kf.ModalDamping(self.size(0.003, 0.05)) if self.is_damped else None
        reduction = kf.CraigBampton(modes=int(self.rng.integers(3, 9)))
        body = beam_body(shape, {"root": "clamped", "tip": "rigid"}, reduction, damping=damping)
        name = f"beam {len(self.names)}"
        self.names.append(name)
        joint = kf.Revolute("y", position=float(self.rng.uniform(-0.4, 0.4)), forces=self.spring(0.3 * length**3))
        where = {} if parent is None else {"parent": parent}
        added = self.scene.add_flexible_body(name, body, at=at, joint=joint, **where)
        self.words.append("flexible")
        return added.interface("tip")

    def tree(self, is_chain: bool) -> float:
        """Add a chain or a tree of links, one of which may be flexible; return its extent, m."""
        count, length = int(self.rng.integers(2, 9)), self.size(0.15, 0.6)
        flexible = int(self.rng.integers(count)) if self.chance(0.45) else -1
        ends: list[tuple[Any, tuple[float, float, float]]] = [(None, (0.0, 0.0, 0.0))]
        for i in range(count):
            parent, at = ends[-1] if is_chain else ends[int(self.rng.integers(len(ends)))]
            if i == flexible:
                ends.append((self.beam(parent, at, length), (0.0, 0.0, 0.0)))
            else:
                axis = "y" if self.chance(0.7) else "z"
                ends.append((self.link(parent, at, length, axis), (length, 0.0, 0.0)))
        self.words.append("chain" if is_chain else "tree")
        return count * length

    def loops(self) -> float:
        """Add four-bars in a row, each closed by a spherical joint; return their extent, m."""
        length = self.size(0.2, 0.5)
        for i in range(int(self.rng.integers(1, 4))):
            left = self.link(None, (0.0, 1.5 * i * length, 0.0), length, "y", soft=True)
            right = self.link(None, (1.2 * length, 1.5 * i * length, 0.0), length, "y")
            ends = left.frame(at=(length, 0, 0)), right.frame(at=(length, 0, 0))
            rod = float(np.hypot(1.2 * length, 0.3 * length))
            self.scene.add_distance(f"rod {i}", *ends, rod)
        self.words.append("loop")
        return 4.0 * length

    def ball(self, size: float) -> None:
        """Add a ball that falls and bounces beside the rest."""
        floor = self.scene.add_surface("floor", self.scene.ground, kf.shapes.Plane("z"), at=(0.0, 0.0, -2.0 * size))
        radius, mass = 0.1 * size, self.size(0.1, 3.0)
        start = (3.0 * size, 0.0, -2.0 * size + radius + self.size(0.01, 0.3) * size)
        speed = (float(self.rng.uniform(0.0, 1.0)), 0.0, 0.0)
        ball = self.scene.add_rigid_body(
            "ball", mass, 0.4 * mass * radius**2, joint=kf.Free(position=start, velocity=speed)
        )
        self.names.append("ball")
        is_rigid = self.chance(0.3)
        law = (
            kf.Rigid(restitution=float(self.rng.uniform(0.0, 0.7)))
            if is_rigid
            else kf.HuntCrossley(self.size(1e4, 1e7), float(self.rng.uniform(0.05, 0.5)))
        )
        friction = kf.Coulomb(float(self.rng.uniform(0.1, 0.6))) if self.chance(0.7) else None
        skin = self.scene.add_surface("skin", ball, kf.shapes.Sphere(radius))
        self.scene.add_contact("drop", skin, floor, normal=law, friction=friction)
        self.words.append("rigid contact" if is_rigid else "contact")

    def control(self) -> None:
        """Add a controller that holds the first hinge by a torque."""
        first, gain = self.names[0], self.size(0.1, 3.0)
        if self.chance(0.5):
            every = 1.0 / self.size(100.0, 5000.0)
            self.scene.add_controller(
                "hold",
                lambda t, reads, memory: -gain * reads[0] - 0.05 * gain * reads[1],
                every=every,
                reads=(f"joint_coordinates {first}", f"joint_speeds {first}"),
                drives=f"motor {first}",
            )
            self.words.append("sampled controller")
            return

        def law(t: float, state: kf.SceneState) -> float:
            return -gain * float(state.joint_coordinates(first)[0]) - 0.05 * gain * float(state.joint_speeds(first)[0])

        self.scene.add_motor(self.scene.body(first), law)
        self.words.append("controller")

    def load(self) -> None:
        """Add a torque of the time in the first hinge: a sine, or one that jumps."""
        first, size, rate = self.names[0], self.size(0.05, 1.0), self.size(0.5, 10.0)
        is_smooth = self.chance(0.5)

        def of_time(t: float) -> float:
            wave = math.sin(2.0 * math.pi * rate * t)
            return size * (wave if is_smooth else math.copysign(1.0, wave))

        self.scene.add_motor(self.scene.body(first), of_time)
        self.words.append("smooth drive" if is_smooth else "drive with jumps")


def drawn(seed: int) -> Drawn:
    """Return the scene of a seed."""
    made = _Drawing(seed)
    kind = made.rng.random()
    size = made.tree(is_chain=kind < 0.45) if kind < 0.75 else made.loops()
    if made.chance(0.45):
        made.ball(size)
    if made.chance(0.45):
        made.control()
    if made.chance(0.5):
        made.load()
    seconds = float(made.rng.uniform(0.3, 1.5))
    return Drawn(made.scene, seconds, size, tuple(made.names), tuple(made.words))
