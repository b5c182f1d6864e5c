"""Contacts at their limits: what sticks for twenty minutes, storms of impacts, mass ratios, stacks, tables, edges."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from kanefe.checks.robustness.case import Effort, Finding, StressCase
from kanefe.checks.robustness.runs import follow
from kanefe.checks.verification.contact import pushed_block, shaken_slope
from kanefe.contact import Coulomb, HuntCrossley, Restitution
from kanefe.contact.shapes import Box, Plane, Points, Sphere
from kanefe.joints import Free, Motion, Prismatic
from kanefe.result import Result
from kanefe.system import System

GRAVITY = 9.81
LAW = HuntCrossley(1e5, 0.5)
FRICTION = Coulomb(0.5)


def _ran(scene: System, span: float, rtol: float, **options: Any) -> Result:
    model = scene.freeze()
    return Result(model, follow(model, span, rtol=rtol, **options))


def _on_floor() -> tuple[System, Any]:
    scene = System(gravity=(0.0, 0.0, -GRAVITY))
    return scene, scene.add_surface("floor", scene.ground, Plane("z"))


def holding(effort: Effort, rtols: Sequence[float] = (1e-3, 1e-5)) -> Iterator[Finding]:
    """Hold a block on a slope that is shaken, for twenty minutes."""
    span = 1200.0 if not effort.is_quick else 20.0
    for mu in (0.8, 0.112):
        for rtol in rtols:
            result = _ran(shaken_slope(mu), 1.0 + span, rtol, output_step=span / 100)
            yield Finding(
                f"block on 5 degrees, shaken with 0.02 g at 1 Hz for {span:g} s, mu {mu:g}, rtol {rtol:g}",
                result.statistics["steps"],
                "slip [m]",
                float(result.contact("block on slope").slip[-1]),
                1e-12,
                "below the cone nothing slips",
            )


def impacts(effort: Effort) -> Iterator[Finding]:
    """Bounce thousands of times, without loss and with it."""
    count = effort.count(10000, 40)
    scene = System()
    walls = [
        scene.add_surface(f"wall {i}", scene.ground, Plane(n), at=(x, 0.0, 0.0))
        for i, (n, x) in enumerate((("x", -1e-3), ("-x", 1e-3)))
    ]
    mass = scene.add_point("mass", 1.0, joint=Prismatic("x", speed=1.0))
    for i, wall in enumerate(walls):
        scene.add_contact(f"impact {i}", mass, wall, normal=HuntCrossley(1e6))
    half = 2e-3 + math.pi / 1e3
    span = 1e-3 + half * (count - 1) + 1e-3
    result = _ran(scene, span, 1e-8, output_step=span / 50)
    touches = np.sort(np.concatenate([result.events[f"impact {i} touch"] for i in (0, 1)]))
    exact = 1e-3 + half * np.arange(count)
    late = float(np.abs(touches - exact).max()) if len(touches) == count else math.nan
    what, note = "mass between two walls", f"{result.statistics['steps']} steps"
    yield Finding(what, count, "time of an impact, missed or late [s]", late, 1e-7 * count, "2e-5 of 5 ms each", note)
    energy = result.energy
    error = float(np.abs(energy.balance_error).max() / energy.total[0])
    yield Finding(what, count, "energy, relative", error, 4e-7 * count, "rtol^(5/6) an impact, twice", note)
    yield from _chattering()


def _chattering() -> Iterator[Finding]:
    """Bounce ever faster until it lies."""
    scene, floor = _on_floor()
    ball = scene.add_point("ball", 1.0, joint=Prismatic("z", position=1.0))
    scene.add_contact("c", ball, floor, normal=Restitution(1e7, 0.8))
    result = _ran(scene, 6.0, 1e-9, output_step=0.05)
    note = f"{len(result.events['c touch'])} landings"
    sunk = abs(float(result.position("ball")[-1, 2]) + GRAVITY / 1e7)
    yield Finding(
        "ball of restitution 0.8 until it lies",
        1,
        "depth at rest, error [m]",
        sunk,
        1e-8,
        "a hundredth of the depth",
        note,
    )


def crowds(effort: Effort) -> Iterator[Finding]:
    """Stand on four legs, in a stack, in a wedge, under a millionfold mass."""
    for name, scene, span, levels in _crowds(effort):
        result = _ran(scene, span, 1e-6, output_step=span / 20)
        off = max(abs(float(result.position(body)[-1, axis]) - place) for body, axis, place in levels)
        speed = max(float(np.abs(result.velocity(body)[-1]).max()) for body, _, _ in levels)
        note = f"{result.statistics['steps']} steps"
        yield Finding(name, len(levels), "place at rest, error [m]", off, 1e-6, "a hundredth of what they sink", note)
        yield Finding(name, len(levels), "speed at rest [m/s]", speed, 1e-4, "what is left of the start", note)


Level = tuple[str, int, float]


def _crowds(effort: Effort) -> Iterator[tuple[str, System, float, Sequence[Level]]]:
    scene, floor = _on_floor()
    table = scene.add_rigid_body("table", 8.0, 1.0, joint=Free(position=(0.0, 0.0, 0.75)))
    feet = [(x, y, -0.75) for x in (-0.5, 0.5) for y in (-0.4, 0.4)]
    legs = scene.add_surface("legs", table, Points(feet))
    scene.add_contact("legs on floor", legs, floor, normal=LAW, friction=FRICTION)
    yield "table on four legs", scene, 8.0, [("table", 2, 0.75 - 8.0 * GRAVITY / LAW.stiffness)]

    count, side = effort.count(20, 4), 0.2
    scene, below = _on_floor()
    levels: list[Level] = []
    for i in range(count):
        height = side * (i + 0.5)
        box = scene.add_rigid_body(f"box {i}", 1.0, side**2 / 6.0, joint=Free(position=(0.0, 0.0, height + 1e-4 * i)))
        skin = scene.add_surface(f"skin {i}", box, Points([(x, y, -0.1) for x in (-0.1, 0.1) for y in (-0.1, 0.1)]))
        scene.add_contact(f"contact {i}", skin, below, normal=HuntCrossley(1e5, 2.0), friction=FRICTION)
        below = scene.add_surface(f"top {i}", box, Plane("z"), at=(0.0, 0.0, 0.1))
        sunk = sum(GRAVITY * (count - j) / 1e5 for j in range(i + 1))
        levels.append((f"box {i}", 2, height - sunk))
    yield f"stack of {count} boxes", scene, 15.0, levels

    for ratio in (1e3, 1e6):
        scene, floor = _on_floor()
        low = scene.add_rigid_body("low", 1.0, 0.4e-2, joint=Prismatic("z", position=0.1))
        high = scene.add_rigid_body("high", ratio, 0.4e-2, joint=Prismatic("z", position=0.3))
        balls = [scene.add_surface(f"skin of {b.name}", b, Sphere(0.1)) for b in (low, high)]
        stiffness = 1e5 * ratio
        law = HuntCrossley(stiffness, 5.0)
        scene.add_contact("low on floor", balls[0], floor, normal=law)
        scene.add_contact("high on low", balls[1], balls[0], normal=law)
        first = (1.0 + ratio) * GRAVITY / stiffness
        places = [("low", 2, 0.1 - first), ("high", 2, 0.3 - first - ratio * GRAVITY / stiffness)]
        yield f"ball under one of {ratio:g} times its mass", scene, 10.0, places

    scene = System(gravity=(0.0, 0.0, -GRAVITY))
    angle = math.radians(30.0)
    lean = math.sin(angle)
    walls = [scene.add_surface(f"wall {x:g}", scene.ground, Plane((x, 0.0, math.cos(angle)))) for x in (-lean, lean)]
    radius = 0.1
    start = Free(position=(0.0, 0.0, radius / math.cos(angle)))
    ball = scene.add_rigid_body("ball", 1.0, 0.4 * radius**2, joint=start)
    skin = scene.add_surface("skin", ball, Sphere(radius))
    for i, wall in enumerate(walls):
        scene.add_contact(f"side {i}", skin, wall, normal=LAW)
    depth = GRAVITY / (2.0 * math.cos(angle)) / LAW.stiffness
    yield "ball in a wedge of two planes", scene, 8.0, [("ball", 2, (radius - depth) / math.cos(angle))]


def driven(effort: Effort) -> Iterator[Finding]:
    """Ride on a deck that shakes at 10 Hz, and slide off an edge."""
    amplitude, omega = 1e-3, 2.0 * math.pi * 10.0  # 0.4 g
    scene = System(gravity=(0.0, 0.0, -GRAVITY))
    moving = Motion(
        lambda t: amplitude * math.sin(omega * t),
        lambda t: amplitude * omega * math.cos(omega * t),
        lambda t: -amplitude * omega**2 * math.sin(omega * t),
    )
    deck = scene.add_rigid_body("deck", 1.0, 1.0, joint=Prismatic("z", motion=moving))
    top = scene.add_surface("top", deck, Plane("z"))
    start = Free(position=(0.0, 0.0, -GRAVITY / 1e6), velocity=(0.0, 0.0, amplitude * omega))
    block = scene.add_rigid_body("block", 1.0, 0.01, joint=start)
    scene.add_contact("c", block, top, normal=HuntCrossley(1e6, 30.0), friction=FRICTION)
    span = 10.0 if not effort.is_quick else 1.0
    result = _ran(scene, span, 1e-8, output_step=1e-3)
    asked = GRAVITY - amplitude * omega**2 * np.sin(omega * result.times)
    late = result.times > 0.5 * span
    error = float(np.abs(result.contact("c").normal - asked)[late].max() / GRAVITY)
    share = (omega**2 / 1e6) * amplitude * omega**2 / GRAVITY
    yield Finding(
        "block on a deck that shakes at 10 Hz with 0.4 g",
        int(span * 10),
        "normal force, of the weight",
        error,
        2.0 * share + 1e-3,
        "it yields by (omega / omega of the contact)^2; the start has died away",
    )
    yield from _over_the_edge()


def _over_the_edge() -> Iterator[Finding]:
    """Slide off a box: friction ends with the support, and what falls falls freely."""
    scene = System(gravity=(0.0, 0.0, -GRAVITY))
    shelf = scene.add_surface("shelf", scene.ground, Box((2.0, 2.0, 0.2)), at=(0.0, 0.0, -0.1))
    ball = scene.add_rigid_body("ball", 1.0, 0.4e-2, joint=Free(position=(0.5, 0.0, 0.1), velocity=(3.0, 0.0, 0.0)))
    skin = scene.add_surface("skin", ball, Sphere(0.1))
    scene.add_contact("c", skin, shelf, normal=LAW, friction=FRICTION)
    result = _ran(scene, 1.0, 1e-8, output_step=1e-3)
    falling = float(result.acceleration("ball")[-1, 2]) + GRAVITY
    yield Finding(
        "ball over the edge of a box",
        1,
        "acceleration but for gravity [m/s2]",
        abs(falling),
        1e-9,
        "nothing touches it",
    )
    energy = result.energy
    error = float(np.abs(energy.balance_error).max() / energy.total[0])
    yield Finding("ball over the edge of a box", 1, "energy, relative", error, 1e-6, "rtol 1e-8, some events")


def balances(effort: Effort) -> Iterator[Finding]:
    """Account for the energy of a block that stops and of a ball that comes to rest."""
    scene, floor = _on_floor()
    ball = scene.add_point("ball", 1.0, joint=Prismatic("z", position=1.0))
    scene.add_contact("c", ball, floor, normal=Restitution(1e7, 0.8))
    for name, system, span, work in (
        ("block that stops by friction", pushed_block(1e6), 1.5, 12.5),
        ("ball that bounces until it lies", scene, 4.5, GRAVITY),
    ):
        result = _ran(system, span, 1e-10)
        error = float(np.abs(result.energy.balance_error).max() / work)
        yield Finding(
            f"{name}, rtol 1e-10",
            1,
            "energy, of the work done",
            error,
            1e-8,
            "a few dozen events, each with some 1e-10",
        )


CASES = (
    StressCase("sticking", "contacts that hold for twenty minutes", holding),
    StressCase("contact impacts", "thousands of impacts of contacts", impacts),
    StressCase("crowded contacts", "tables, stacks, wedges, mass ratios", crowds),
    StressCase("driven contacts", "decks that shake, edges", driven),
    StressCase("contact balance", "energy of contacts", balances),
)
