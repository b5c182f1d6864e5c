"""Rigid contacts at their limits: impacts without end, paradoxes, redundant legs, stacks, mass ratios, crowds."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from kanefe.checks.robustness.case import Effort, Finding, StressCase
from kanefe.checks.robustness.runs import ended, follow
from kanefe.checks.verification.rigid_contact import on_floor, rocking_block
from kanefe.contact import Coulomb, Rigid
from kanefe.contact.shapes import Plane, Points, Sphere
from kanefe.frames import rotation_about
from kanefe.joints import Free, Prismatic
from kanefe.result import Result
from kanefe.system import System

GRAVITY = 9.81


def _ran(scene: System, span: float, **options: Any) -> Result:
    model = scene.freeze()
    return Result(model, follow(model, span, **options))


def impacts(effort: Effort) -> Iterator[Finding]:
    """Bounce thousands of times, and infinitely often."""
    count = effort.count(10_000, 20)
    scene = System()
    walls = [
        scene.add_surface(f"wall {i}", scene.ground, Plane(n), at=(x, 0.0, 0.0))
        for i, (n, x) in enumerate((("x", -1e-3), ("-x", 1e-3)))
    ]
    mass = scene.add_point("mass", 1.0, joint=Prismatic("x", speed=1.0))
    for i, wall in enumerate(walls):
        scene.add_contact(f"impact {i}", mass, wall, normal=Rigid(1.0))
    result = _ran(scene, 2e-3 * count, rtol=1e-8, output_step=2e-3 * count / 10)
    touches = np.sort(np.concatenate([result.events[f"impact {i} touch"] for i in (0, 1)]))
    exact = 1e-3 + 2e-3 * np.arange(count)
    late = float(np.abs(touches - exact).max()) if len(touches) == count else math.nan
    what = "mass between two rigid walls"
    yield Finding(what, count, "time of an impact, missed or late [s]", late, 1e-12 * count, "round-off of each")
    energy = float(np.abs(result.energy.balance_error).max() / result.energy.total[0])
    yield Finding(what, count, "energy, relative", energy, 1e-14 * count, "round-off of each")
    for e in (0.5,) if effort.is_quick else (0.5, 0.9):
        scene, floor = on_floor()
        ball = scene.add_point("ball", 1.0, joint=Prismatic("z", position=1.0))
        scene.add_contact("c", ball, floor, normal=Rigid(e))
        rest = math.sqrt(2.0 / GRAVITY) * (1.0 + e) / (1.0 - e)
        result = _ran(scene, 1.2 * rest, rtol=1e-8, output_step=rest / 10)
        found = result.events["c rest"]
        off = abs(float(found[0]) - rest) if len(found) == 1 else math.nan
        yield Finding(f"ball of restitution {e:g}", 1, "time of rest, error [s]", off, 1e-9, "that of the series")
    if effort.is_quick:
        return
    result = _ran(rocking_block(0.3, size=(1.0, 1.0)), 1.5, rtol=1e-7, output_step=0.1)
    turn = float(np.abs(result.angular_velocity("block")[-1]).max())
    note = f"{len(result.events['c touch'])} impacts"
    yield Finding("block that rocks down", 1, "spin at rest [rad/s]", turn, 1e-9, "it is at rest", note)


def paradoxes(effort: Effort) -> Iterator[Finding]:
    """Push rods over a rough floor: a run ends with cause and remedy, or goes on; it never hangs."""
    bad = 0
    tries = [(mu, deg, v) for mu in (0.5, 1.4, 3.0) for deg in (30.0, 60.0, 80.0) for v in (-4.0, 4.0)]
    tries = tries[:: 1 if not effort.is_quick else 6]
    for mu, degrees, v in tries:
        scene, floor = on_floor()
        angle = math.radians(degrees)
        start = Free(
            position=(0.5 * math.cos(angle), 0.0, 0.5 * math.sin(angle)),
            orientation=rotation_about("y", -angle),
            velocity=(v, 0.0, 0.0),
        )
        rod = scene.add_rigid_body("rod", 1.0, (1e-3, 1.0 / 12.0, 1.0 / 12.0), joint=start)
        scene.add_contact("c", rod.frame(at=(-0.5, 0, 0)), floor, normal=Rigid(), friction=Coulomb(mu))
        model = scene.freeze()
        try:
            status = ended(model, 0.3, rtol=1e-6, output_step=0.1).status
        except Exception as error:  # noqa: BLE001  (what is counted here)
            bad += "Painleve" not in str(error)
            continue
        bad += status is None or not (status.is_finished or ("Painleve" in status.reason and bool(status.remedy)))
    yield Finding("rods pushed over rough floors", len(tries), "runs that hang or do not say why", bad, 0, "none does")


def crowds(effort: Effort) -> Iterator[Finding]:
    """Stand on four legs, in a wedge, in a stack, under a millionfold mass; fall into a box by the hundred."""
    for name, scene, span, bodies in _standing(effort):
        result = _ran(scene, span, rtol=1e-6, output_step=span / 4)
        off = max(float(np.abs(result.position(body) - result.position(body)[0]).max()) for body in bodies)
        note = f"{result.statistics['steps']} steps"
        yield Finding(name, len(bodies), "way from where it was put [m]", off, 1e-10, "what is rigid stays", note)
    for count in (effort.count(200, 20),):
        scene = falling_balls(count)
        result = _ran(scene, 1.0)
        energy = float(np.abs(result.energy.balance_error).max() / np.abs(result.energy.total).max())
        deepest = result.statistics["penetration"]
        note = f"{result.statistics['steps']} steps, up to {deepest:.2g} m deep"
        what = "balls that fall into a box, over impacts"
        yield Finding(what, count, "energy, relative", energy, 1e-12, "the books of a step are exact", note)
        yield Finding(what, count, "depth, of a radius", deepest / RADIUS, 0.1, "what they move in some steps", note)


def _standing(effort: Effort) -> Iterator[tuple[str, System, float, list[str]]]:
    span = 0.2 if effort.is_quick else 5.0
    scene, floor = on_floor()
    table = scene.add_rigid_body("table", 8.0, 1.0, com=(0.2, 0.1, 0.0), joint=Free(position=(0.0, 0.0, 0.75)))
    legs = scene.add_surface("legs", table, Points([(x, y, -0.75) for x in (-0.5, 0.5) for y in (-0.4, 0.4)]))
    scene.add_contact("legs on floor", legs, floor, normal=Rigid(), friction=Coulomb(0.5))
    yield "table on four legs, its weight off the middle", scene, span, ["table"]

    scene = System(gravity=(0.0, 0.0, -GRAVITY))
    sides = [scene.add_surface(f"side {s}", scene.ground, Plane((s, 0.0, 1.0))) for s in (-1.0, 1.0)]
    ball = scene.add_rigid_body("ball", 1.0, 4e-3, joint=Free(position=(0.0, 0.0, 0.1 * math.sqrt(2.0))))
    skin = scene.add_surface("skin", ball, Sphere(0.1))
    for side in sides:
        scene.add_contact(f"on {side.name}", skin, side, normal=Rigid(), friction=Coulomb(0.5))
    yield "ball in a wedge", scene, span, ["ball"]

    count, names = effort.count(20, 3), []
    scene, below = on_floor()
    for i in range(count):
        mass = 1e6 if i == count - 1 else 1.0
        ball = scene.add_rigid_body(f"ball {i}", mass, 4e-3 * mass, joint=Prismatic("z", position=0.1 + 0.2 * i))
        skin = scene.add_surface(f"skin {i}", ball, Sphere(0.1))
        scene.add_contact(f"contact {i}", skin, below, normal=Rigid())
        below = skin
        names.append(ball.name)
    yield f"stack of {count} balls under a millionfold mass", scene, 0.2 * span, names


RADIUS = 0.05


def falling_balls(count: int, seed: int = 0, restitution: float = 0.5, friction: float = 0.3) -> System:
    """Return balls above the floor of a box of 1 m, with random speeds."""
    rng = np.random.default_rng(seed)
    scene, floor = on_floor()
    sides = (("x", (0.0, 0.0, 0.0)), ("-x", (1.0, 0.0, 0.0)), ("y", (0.0, 0.0, 0.0)), ("-y", (0.0, 1.0, 0.0)))
    surfaces = [
        floor,
        *(scene.add_surface(f"side {i}", scene.ground, Plane(n), at=at) for i, (n, at) in enumerate(sides)),
    ]
    for i in range(count):
        layer, (column, row) = i // 25, divmod(i % 25, 5)
        place = np.array((0.1 + 0.2 * column, 0.1 + 0.2 * row, 0.1 + 0.15 * layer)) + rng.uniform(-0.01, 0.01, 3)
        v, w = 0.5 * rng.standard_normal(3), rng.standard_normal(3)
        start = Free(position=place.tolist(), velocity=v.tolist(), angular_velocity=w.tolist())
        ball = scene.add_rigid_body(f"ball {i}", 1.0, 0.4 * RADIUS**2, joint=start)
        surfaces.append(scene.add_surface(f"skin {i}", ball, Sphere(RADIUS)))
    scene.add_contacts(surfaces, normal=Rigid(restitution), friction=Coulomb(friction))
    return scene


CASES = (
    StressCase("rigid impacts", "ten thousand impacts, and infinitely many", impacts),
    StressCase("rigid paradoxes", "friction that has no answer", paradoxes),
    StressCase("rigid crowds", "redundant legs, wedges, stacks, mass ratios, balls in a box", crowds),
)
