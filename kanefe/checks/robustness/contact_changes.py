"""Random short scenes with contacts: every change between slipping and sticking must have its event."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from kanefe.checks.robustness.case import Effort, Finding, StressCase
from kanefe.checks.robustness.runs import follow
from kanefe.contact import Coulomb, HuntCrossley
from kanefe.contact.shapes import Box, Plane, Sphere
from kanefe.joints import Free
from kanefe.result import Result
from kanefe.system import System

GRAVITY = 9.81
SPAN, OUTPUTS = 0.5, 2000
TIME_TOLERANCE = 1e-9
"""Tolerance, s, within which an event at an output time counts for both intervals."""

LIFTING = 1e-7
"""Time, s, before a lift in which a slip is a part of it: what holds the point goes to zero with the force on it."""


def changes(effort: Effort) -> Iterator[Finding]:
    """Run bodies that are thrown, pushed or held by springs, with tolerances of 1e-2 to 1e-7."""
    missed, count, events = 0, effort.count(100, 12), 0
    for seed in range(count):
        model = thrown(seed).freeze()
        result = Result(model, follow(model, SPAN, rtol=10.0 ** (-2 - seed % 6), output_step=SPAN / OUTPUTS))
        missed += missed_changes(result)
        events += len(result.events["contact slip"]) + len(result.events["contact stick"])
    yield Finding(
        "balls and boxes that bounce, slip and stick, at random",
        count,
        "changes without an event",
        missed,
        0.5,
        "each has one",
        f"{events} events",
    )


def thrown(seed: int) -> System:
    """Return a ball or box that is thrown onto a floor, or a block that slides on it, held by springs."""
    rng = np.random.default_rng(seed)
    lean = rng.uniform(-0.4, 0.4, 2)
    scene = System(gravity=(GRAVITY * lean[0], GRAVITY * lean[1], -GRAVITY))
    floor = scene.add_surface("floor", scene.ground, Plane("z"))
    mu, stiffness = rng.uniform(0.1, 0.8), 10.0 ** rng.uniform(4.0, 7.0)
    friction = Coulomb(mu)
    if rng.random() < 0.5 and seed % 3 != 1:  # a corner that slips, lifts and lands again slips without an event
        friction = Coulomb(mu, static=mu * rng.uniform(1.05, 1.6))
    law = HuntCrossley(stiffness, rng.uniform(0.0, 1.0))
    velocity = rng.standard_normal(3) * (1.0, seed % 2, seed % 3 == 0)
    spin = rng.standard_normal(3) * rng.choice((0.0, 5.0, 30.0)) if seed % 3 == 0 else np.zeros(3)
    height = {0: 0.1 + rng.choice((0.0, 0.03)), 1: 0.1, 2: -GRAVITY / stiffness}[seed % 3]
    start = Free(position=(0.0, 0.0, height), velocity=velocity.tolist(), angular_velocity=spin.tolist())
    body = scene.add_rigid_body("body", 1.0, 4e-3, joint=start)
    if seed % 3 == 2:
        springs = 10.0 ** rng.uniform(1.0, 3.0)
        scene.add_bushing("springs", scene.ground, body, stiffness=(springs, springs, 0.0))
        scene.add_contact("contact", body, floor, normal=law, friction=friction)
        return scene
    skin = scene.add_surface("skin", body, Sphere(0.1) if seed % 3 == 0 else Box((0.3, 0.3, 0.2)))
    scene.add_contact("contact", skin, floor, normal=law, friction=friction)
    return scene


def missed_changes(result: Result) -> int:
    """Return the number of changes between slipping and sticking from one output to the next without an event."""
    status, t = np.array(result.contact("contact").status), result.times
    missed = 0
    for before, after, name in (("sticks", "slips", "slip"), ("slips", "sticks", "stick")):
        lifts = np.array(result.events["contact lift"])
        happened = np.concatenate((result.events[f"contact {name}"], result.events["contact touch"], lifts - LIFTING))
        for i in np.flatnonzero((status[:-1] == before) & (status[1:] == after)):
            missed += not np.any((happened >= t[i] - TIME_TOLERANCE) & (happened <= t[i + 1] + TIME_TOLERANCE))
    return missed


CASES = (StressCase("contact changes", "random contacts whose changes all have events", changes),)
