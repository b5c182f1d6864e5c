"""Scenes on a deck that moves, for screened runs."""

from __future__ import annotations

import math

import numpy as np

import kanefe as kf

LENGTH, WIDTH, HEIGHT, MASS = 1.0, 0.8, 0.3, 200.0  # of a block on four feet, m and kg


def deck_motion(seed: int, span: float, rough: float = 1.0) -> kf.PoseTable:
    """Return a deck that begins to roll, pitch, yaw and heave, by some harmonics of random phases."""
    times = np.linspace(0.0, span, round(20 * span) + 1)
    random = np.random.default_rng(seed)
    rates, phases = random.uniform(0.5, 1.5, 8), random.uniform(0.0, 2.0 * math.pi, (6, 8))
    x = np.clip(times / 4.0, 0.0, 1.0)
    grown = rough * 0.5 * x**3 * (10.0 - 15.0 * x + 6.0 * x**2)
    sizes = (0.3, 0.4, 0.7, math.radians(4.0), math.radians(1.5), math.radians(0.5))
    sums = [
        size * grown * np.cos(np.outer(times, rates) + p).sum(axis=1) for size, p in zip(sizes, phases, strict=True)
    ]
    turns = [kf.euler_angles("xyz", angles) for angles in np.column_stack(sums[3:])]
    return kf.PoseTable(times, np.column_stack(sums[:3]), turns)


def block_on_deck(
    motion: kf.PoseTable | None,
    mu: float | None = 0.2,
    *,
    rope: float | None = None,
    breaking: float | None = None,
    is_child: bool = False,
) -> kf.System:
    """Return a block on four feet, on a deck that moves or stays; its rope, if any, pulls by so much (N) at first.

    Its joint is seen from the ground, or as a child of the deck from there.
    """
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    deck = scene.ground if motion is None else scene.add_frame("deck", joint=kf.Free(motion=motion))
    begun = None if motion is None else motion.at(0.0)
    place = np.array((0.0, 0.0, HEIGHT))
    joint = kf.Free(position=tuple(place))
    if begun is not None and not is_child:
        joint = kf.Free(position=tuple(begun.position + begun.axes @ place), orientation=begun.axes)
    block = scene.add_rigid_body("block", MASS, (12.0, 18.0, 24.0), joint=joint, parent=deck if is_child else None)
    surface = scene.add_surface("deck", deck, kf.shapes.Plane("z"))
    law = None if mu is None else kf.Coulomb(mu, stiffness=4e5, damping=2e3)
    for i, (sx, sy) in enumerate(((1, 1), (1, -1), (-1, 1), (-1, -1))):
        foot = block.frame((0.5 * sx * LENGTH, 0.5 * sy * WIDTH, -HEIGHT))
        scene.add_contact(f"foot {i}", foot, surface, normal=kf.HuntCrossley(4e5, 0.5), friction=law)
    if rope is not None:
        ends = block.frame((0.0, 0.0, 0.0)), deck.frame((0.0, 0.0, HEIGHT - 0.6))
        scene.add(kf.Rope("rope", ends, axial_stiffness=2e4, preload=rope, breaking_load=breaking))
    return scene
