"""Error against cost over stiffness and damping of friction's anchors: ``python tests/benchmarks/friction_anchors.py``.

Joints are measured by what an anchor yields by at the limit of friction (of the scene's length, or rad), contacts by
the stiffness of their anchors over that of the normal law; both by the share of critical damping. Scenes with closed
forms, or with rigid solutions by pieces; `RANDOM` ones by a seed, from which no default was chosen.
"""

from __future__ import annotations

import argparse
import json
import math
import platform
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parents[1]))

import kanefe as kf
from kanefe.equations import contact_masses, joint_frictions
from kanefe.result import Result
from kanefe.scene import contacts
from robustness.shaken_blocks import exact, random_block

G = 9.81
NORMAL = 1e7
YIELDS = 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-10
STIFFNESSES = 1.0, 10.0, 100.0
RATIOS = 0.1, 0.3, 1.0, 3.0


class Found(NamedTuple):
    """Error of a place (of the scene's length or rad) and of an instant (of the span), and what the run cost."""

    place: float
    instant: float
    steps: int
    evaluations: int


Case = Callable[[float], Found]


def _found(result: Result, place: float, told: Sequence[float] = (), wanted: Sequence[float] = ()) -> Found:
    span = float(result.times[-1])
    told = np.asarray(told)
    late = [float(np.abs(told - t).min()) / span if len(told) else 1.0 for t in wanted]
    counted = result.statistics
    return Found(abs(float(place)), max(late, default=0.0), int(counted["steps"]), int(counted["evaluations"]))


def wheel(rtol: float) -> Found:
    """Let a wheel coast on its journal bearing until it stops."""
    scene = kf.System(gravity=(0, 0, -G))
    joint = kf.Revolute("y", speed=10.0, friction=kf.JointFriction(0.1, 0.01))
    scene.add_rigid_body("wheel", 2.0, 0.02, joint=joint)
    result, stop = scene.simulate((0.0, 12.0), rtol=rtol), 100.0 / G
    turned = result.joint_coordinates("wheel")[-1, 0] / (5.0 * stop) - 1.0
    return _found(result, turned, result.events["wheel stick"], [stop])


def _swings(acceleration: Callable[[float, float, float], float], angle: float, holds: Callable[[float], bool]):
    """Return the stops of a swing under rigid friction, and where it stays; `acceleration` of angle, rate and way."""
    t, stops = 0.0, []
    while not holds(angle):
        way = math.copysign(1.0, acceleration(angle, 0.0, 0.0))

        def turns(_: float, y: np.ndarray) -> float:
            return float(y[1])

        turns.terminal, turns.direction = True, -way
        rates = lambda _, y, way=way: (y[1], acceleration(y[0], y[1], way))  # noqa: E731
        run = solve_ivp(rates, (t, t + 99.0), (angle, 0.0), "DOP853", rtol=1e-12, atol=1e-14, events=turns)
        t, angle = float(run.t[-1]), float(run.y[0, -1])
        stops.append(t)
    return stops, angle


def pendulum(rtol: float, mu: float = 0.3, radius: float = 0.05, start: float = 1.0) -> Found:
    """Swing on a journal bearing, which feels the centrifugal force too."""
    mass, inertia, lever = 2.0, 0.02, 0.3

    def acceleration(angle: float, rate: float, way: float) -> float:
        found = 0.0
        for _ in range(60):
            x = lever * (found * math.cos(angle) - rate**2 * math.sin(angle))
            z = lever * (found * math.sin(angle) + rate**2 * math.cos(angle)) + G
            moment = -mass * G * lever * math.sin(angle) - way * mu * radius * mass * math.hypot(x, z)
            found = moment / (inertia + mass * lever**2)
        return found

    stops, rest = _swings(acceleration, start, lambda angle: lever * abs(math.sin(angle)) <= mu * radius)
    scene = kf.System(gravity=(0, 0, -G))
    joint = kf.Revolute("y", position=start, friction=kf.JointFriction(mu, radius))
    scene.add_rigid_body("bob", mass, inertia, com=(0, 0, -lever), joint=joint)
    result = scene.simulate((0.0, stops[-1] + 1.0), rtol=rtol)
    return _found(result, result.joint_coordinates("bob")[-1, 0] - rest, result.events["bob stick"], stops)


def hinge(rtol: float) -> Found:
    """Swing against a friction that is given."""
    inertia, torque, cap = 1.0 / 3.0, 0.5 * G, 0.3
    stops, rest = _swings(
        lambda angle, rate, way: (torque * math.cos(angle) - way * cap) / inertia,
        0.0,
        lambda angle: torque * abs(math.cos(angle)) <= cap,
    )
    scene = kf.System(gravity=(0, 0, -G))
    joint = kf.Revolute("y", forces=kf.CoordinateForce(friction=cap))
    scene.add_rigid_body("rod", 1.0, 1.0 / 12.0, com=(0.5, 0, 0), joint=joint)
    result = scene.simulate((0.0, stops[-1] + 1.0), rtol=rtol)
    return _found(result, result.joint_coordinates("rod")[-1, 0] - rest, result.events["rod stick"], stops)


class Stuck(NamedTuple):
    """Stick and slip of a mass on a spring: k, speed of the base, static and sliding friction, mass; in SI."""

    k: float = 100.0
    speed: float = 0.1
    static: float = 4.0
    sliding: float = 2.5
    mass: float = 1.0

    @property
    def times(self) -> tuple[np.ndarray, np.ndarray]:
        """Four slips, and what follows each."""
        w, D = math.sqrt(self.k / self.mass), (self.static - self.sliding) / self.k
        slipping = 2.0 / w * (math.pi - math.atan(D * w / self.speed))
        slips = self.static / self.k / self.speed + (2.0 * D / self.speed + slipping) * np.arange(4)
        return slips, slips + slipping

    def found(self, result: Result, name: str, subject: str) -> Found:
        """Compare a run that ends between the fourth slip and the fifth."""
        slips, sticks = self.times
        D = (self.static - self.sliding) / self.k
        place = self.sliding / self.k - D + self.speed * (result.times[-1] - sticks[-1])
        told = np.concatenate([result.events[f"{subject} {what}"] for what in ("slip", "stick")])
        wanted = np.concatenate((slips, sticks))
        return _found(result, (result.position(name)[-1, 0] - place) / D, told, wanted)

    @property
    def span(self) -> float:
        """A moment after the fourth stick, s."""
        slips, sticks = self.times
        return float(sticks[-1] + 0.2 * (slips[1] - sticks[0]))


STUCK = Stuck()


def stick_and_slip(rtol: float, stuck: Stuck = STUCK) -> Found:
    """Slip and stick on a base that is driven."""
    scene = kf.System()
    base = scene.add_frame("base", joint=kf.Prismatic("x", motion=kf.Motion.steady(stuck.speed)))
    forces = kf.CoordinateForce(friction=stuck.sliding, static_friction=stuck.static)
    mass = scene.add_rigid_body("mass", stuck.mass, parent=base, joint=kf.Prismatic("x", forces=forces))
    scene.add_spring("spring", scene.ground.frame(at=(-1, 0, 0)), mass, stiffness=stuck.k, rest_length=1.0)
    return stuck.found(scene.simulate((0.0, stuck.span), rtol=rtol), "mass", "mass")


def slider(rtol: float) -> Found:
    """Slide up to a stop on an incline that holds."""
    scene = kf.System(gravity=(G * math.sin(0.2), 0, -G * math.cos(0.2)))
    scene.add_rigid_body("block", 2.0, 0.01, joint=kf.Prismatic("x", speed=1.0, friction=kf.JointFriction(0.3)))
    braking = G * (0.3 * math.cos(0.2) - math.sin(0.2))
    result = scene.simulate((0.0, 1.0 / braking + 0.5), rtol=rtol)
    way = result.joint_coordinates("block")[-1, 0] * 2.0 * braking - 1.0
    return _found(result, way, result.events["block stick"], [1.0 / braking])


def screw(rtol: float, share: float) -> Found:
    """Hold by a screw, or not, 0.2 % from its threshold."""
    lead, radius, mass, inertia = 0.05, 0.04, 3.0, 0.01
    tangent = lead / (2.0 * math.pi * radius)
    mu = share * tangent
    scene = kf.System(gravity=(0, 0, -G))
    joint = kf.Screw("z", lead=lead, friction=kf.JointFriction(mu, radius))
    scene.add_rigid_body("nut", mass, inertia, joint=joint)
    arm = min(0.0, radius * (mu - tangent) / (1.0 + mu * tangent))
    rate = mass * G * arm / (inertia - mass * lead / (2.0 * math.pi) * arm)
    result = scene.simulate((0.0, 2.0), rtol=rtol)
    return _found(result, result.joint_coordinates("nut")[-1, 0] - 2.0 * rate)


def shaft(rtol: float) -> Found:
    """Slide and turn in a bearing."""
    mass, radius, mu = 2.0, 0.05, 0.2
    scene = kf.System(gravity=(0, 0, -G))
    joint = kf.Cylindrical("x", speed=(0.6, 0.8 / radius), friction=kf.JointFriction(mu, radius))
    scene.add_rigid_body("shaft", mass, mass * radius**2, joint=joint)
    result, stop = scene.simulate((0.0, 0.8), rtol=rtol), 1.0 / (mu * G)
    slid, turned = result.joint_coordinates("shaft")[-1]
    off = math.hypot(slid - 0.3 * stop, turned * radius - 0.4 * stop) / (0.5 * stop)
    return _found(result, off, result.events["shaft stick"], [stop])


def chain(rtol: float) -> Found:
    """Swing three links on bearings across each other, against a run with a thousandth of the yield and rtol 1e-11."""

    def end(rtol: float) -> Result:
        scene, parent = kf.System(gravity=(0, 0, -G)), None
        for i in range(3):
            where = {"parent": parent, "at": (0, 0, -0.2)} if parent is not None else {}
            joint = kf.Revolute("xy"[i % 2], position=0.8, friction=kf.JointFriction(0.3, 0.01))
            parent = scene.add_rigid_body(f"b{i}", 0.5, (2e-3, 2e-3, 1e-4), com=(0, 0, -0.1), joint=joint, **where)
        return scene.simulate((0.0, 1.5), rtol=rtol)

    if not _KEPT:
        with anchors(1e-12, 1.0):
            _KEPT.append(end(1e-11).position("b2")[-1])
    result = end(rtol)
    return _found(result, float(np.linalg.norm(result.position("b2")[-1] - _KEPT[0])) / 0.6)


_KEPT: list[np.ndarray] = []


def _floor(gravity: float = G) -> tuple[kf.System, kf.Surface]:
    scene = kf.System(gravity=(0, 0, -gravity))
    return scene, scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))


def pushed(rtol: float) -> Found:
    """Push a block, which stops."""
    scene, floor = _floor()
    start = kf.Free(position=(0, 0, -G / NORMAL), velocity=(5.0, 0, 0))
    block = scene.add_rigid_body("block", 1.0, 0.01, joint=start)
    scene.add_contact("c", block, floor, normal=kf.HuntCrossley(NORMAL, 0.3), friction=kf.Coulomb(0.5))
    result, stop = scene.simulate((0.0, 1.5), rtol=rtol), 10.0 / G
    return _found(result, result.position("block")[-1, 0] / (2.5 * stop) - 1.0, result.events["c stick"], [stop])


def belt(rtol: float) -> Found:
    """Be taken along by a belt, and slip back."""
    stuck, (scene, top) = STUCK, _floor(10.0)
    start = kf.Free(position=(0, 0, -10.0 / NORMAL), velocity=(stuck.speed, 0, 0))
    mass = scene.add_rigid_body("mass", 1.0, 0.01, joint=start)
    options = {"normal": kf.HuntCrossley(NORMAL, 0.3), "friction": kf.Coulomb(0.25, static=0.4)}
    scene.add_contact("c", mass, top, surface_velocity=(stuck.speed, 0, 0), **options)
    scene.add_bushing("spring", scene.ground, mass, stiffness=(stuck.k, 0, 0))
    return stuck.found(scene.simulate((0.0, stuck.span), rtol=rtol), "mass", "c")


def rolling(rtol: float) -> Found:
    """Slide until it rolls."""
    scene, floor = _floor()
    start = kf.Free(position=(0, 0, 0.1 - G / NORMAL), velocity=(2.0, 0, 0))
    ball = scene.add_rigid_body("ball", 1.0, 4e-3, joint=start)
    skin = scene.add_surface("skin", ball, kf.shapes.Sphere(0.1))
    scene.add_contact("c", skin, floor, normal=kf.HuntCrossley(NORMAL, 0.3), friction=kf.Coulomb(0.2))
    rolls = 4.0 / (1.4 * G)
    way = 2.0 * rolls - 0.1 * G * rolls**2 + 10.0 / 7.0 * (0.5 - rolls)
    result = scene.simulate((0.0, 0.5), rtol=rtol)
    return _found(result, result.position("ball")[-1, 0] / way - 1.0, result.events["c stick"], [rolls])


def shaken(rtol: float, seed: int) -> Found:
    """Shake a block on a slope, along it and across."""
    block, scene = random_block(seed), kf.System(gravity=(0, 0, -G))
    known, motions = exact(block), [block._motion(i) for i in (0, 1)]
    plate = scene.add_rigid_body("carriage", 1.0, 1.0, joint=kf.Prismatic("x", motion=motions[0]))
    if block.strokes[1]:
        plate = scene.add_rigid_body("plate", 1.0, 1.0, parent=plate, joint=kf.Prismatic("y", motion=motions[1]))
    top = scene.add_surface("top", plate, kf.shapes.Plane("z"), orientation=kf.rotation_about("y", block.slope))
    normal = np.array((math.sin(block.slope), 0.0, math.cos(block.slope)))
    place = np.append(block.plate(0.0, 0), 0.0) - block.held(0.0) / block.mu / NORMAL * normal
    body = scene.add_rigid_body(
        "block", 1.0, 0.01, joint=kf.Free(position=place, velocity=np.append(block.plate(0.0, 1), 0.0))
    )
    scene.add_contact("c", body, top, normal=kf.HuntCrossley(NORMAL, 0.3), friction=kf.Coulomb(block.mu))
    result = scene.simulate((0.0, block.span), rtol=rtol)
    off = result.position("block")[-1] - np.append(block.plate(block.span, 0), 0.0)
    along = np.array((math.cos(block.slope), 0.0, -math.sin(block.slope)))
    drift = math.hypot(along @ off - known.moved[0], off[1] - known.moved[1]) / max(block.strokes)
    told = np.concatenate([result.events[f"c {what}"] for what in ("slip", "stick")])
    return _found(result, drift, told, [t for t in (*known.slips, *known.sticks) if t > 0.0])


def random_stuck(rtol: float, seed: int) -> Found:
    """Slip and stick with numbers by a seed."""
    rng = np.random.default_rng(seed)
    static = 10.0 ** rng.uniform(-0.5, 1.5)
    k, speed = 10.0 ** rng.uniform(1.0, 3.0), 10.0 ** rng.uniform(-2.0, 0.0)
    return stick_and_slip(rtol, Stuck(k, speed, static, static * rng.uniform(0.4, 0.9), 10.0 ** rng.uniform(-0.5, 0.7)))


def random_pendulum(rtol: float, seed: int) -> Found:
    """Swing with numbers by a seed."""
    rng = np.random.default_rng(seed)
    return pendulum(rtol, rng.uniform(0.1, 0.4), rng.uniform(0.02, 0.06), rng.uniform(0.5, 1.5))


def _seeded(case: Callable[[float, int], Found], seeds: range) -> dict[str, Case]:
    return {f"{case.__name__} {seed}": lambda rtol, seed=seed: case(rtol, seed) for seed in seeds}


JOINTS: dict[str, Case] = {
    "wheel": wheel,
    "pendulum": pendulum,
    "hinge": hinge,
    "stick and slip": stick_and_slip,
    "slider": slider,
    "screw below": lambda rtol: screw(rtol, 0.998),
    "screw above": lambda rtol: screw(rtol, 1.002),
    "shaft": shaft,
    "chain": chain,
}
CONTACTS: dict[str, Case] = {"pushed": pushed, "belt": belt, "rolling": rolling, **_seeded(shaken, range(8))}
RANDOM: dict[str, dict[str, Case]] = {
    "joints": {**_seeded(random_stuck, range(100, 112)), **_seeded(random_pendulum, range(100, 108))},
    "contacts": _seeded(shaken, range(100, 116)),
}


@contextmanager
def anchors(measure: float, ratio: float, of: str = "joints") -> Iterator[None]:
    """Have anchors of what is not given yield by so much, or be so stiff, and so damped."""
    kept = joint_frictions.YIELD, joint_frictions.DAMPING_RATIO, contacts.STIFFNESS_RATIO, contact_masses.DAMPING_RATIO
    if of == "joints":
        joint_frictions.YIELD, joint_frictions.DAMPING_RATIO = measure, ratio
    else:
        contacts.STIFFNESS_RATIO, contact_masses.DAMPING_RATIO = measure, ratio
    try:
        yield
    finally:
        joint_frictions.YIELD, joint_frictions.DAMPING_RATIO = kept[:2]
        contacts.STIFFNESS_RATIO, contact_masses.DAMPING_RATIO = kept[2:]


def row(cases: dict[str, Case], measure: float, ratio: float, of: str, rtol: float) -> list[float]:
    """Return measure, ratio, median and largest error of places and instants, steps and evaluations in all."""
    with anchors(measure, ratio, of):
        found = [case(rtol) for case in cases.values()]
    place, instant = np.array([one.place for one in found]), np.array([one.instant for one in found if one.instant])
    sums = sum(one.steps for one in found), sum(one.evaluations for one in found)
    return [measure, ratio, np.median(place), place.max(), np.median(instant), instant.max(), *map(float, sums)]


def table(rows: list[list[float]], first: str) -> dict[str, object]:
    """Return a table of `docs/data`."""
    columns = [
        first,
        "of critical damping",
        "place: median",
        "worst",
        "instant: median",
        "worst",
        "steps",
        "evaluations",
    ]
    forms = ".0e", ".1f", ".1e", ".1e", ".1e", ".1e", ".0f", ".0f"
    told = [[f"{x:{form}}" for x, form in zip(entry, forms, strict=True)] for entry in rows]
    return {"columns": columns, "rows": told}


def draw(found: dict[str, list[list[float]]], path: Path) -> None:
    """Draw the worst error of places against steps."""
    import matplotlib.pyplot as plt

    figure, both = plt.subplots(1, 2, figsize=(9.0, 3.8), layout="constrained")
    for axes, (name, form) in zip(both, (("joints", "yield {:.0e}"), ("contacts", "{:g} k normal")), strict=True):
        rows = found[name]
        for ratio in sorted({entry[1] for entry in rows}):
            own = [entry for entry in rows if entry[1] == ratio]
            axes.loglog([e[6] for e in own], [e[3] for e in own], ".-", label=f"{ratio:g} of critical")
            for entry in own if ratio == 1.0 else []:
                axes.annotate(
                    form.format(entry[0]), (entry[6], entry[3]), fontsize=7, xytext=(4, 4), textcoords="offset points"
                )
        axes.set(title=name, xlabel="steps in all", ylabel="worst error of a place")
        axes.grid(color="0.9", which="both")
        axes.legend(fontsize="small")
    figure.savefig(path, dpi=110)


def main() -> None:
    """Measure, print, and write what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rtol", type=float, default=1e-6)
    parser.add_argument("--json", type=Path)
    parser.add_argument("--png", type=Path)
    parser.add_argument("--machine", default=platform.processor() or platform.machine())
    given = parser.parse_args()
    warnings.simplefilter("ignore")
    found: dict[str, list[list[float]]] = {}
    grids = ("joints", JOINTS, YIELDS), ("contacts", CONTACTS, STIFFNESSES)
    for name, cases, measures in grids:
        found[name] = []
        for measure in measures:
            for ratio in RATIOS:
                found[name].append(row(cases, measure, ratio, name, given.rtol))
                print(name, " ".join(f"{x:.3g}" for x in found[name][-1]), flush=True)
    for name, measures in (("joints", (1e-5, joint_frictions.YIELD)), ("contacts", (1.0, 1.0))):
        for measure, ratio in zip(measures, (0.1, 1.0), strict=True):
            entry = row(RANDOM[name], measure, ratio, name, given.rtol)
            found.setdefault(f"random-{name}", []).append(entry)
            print("random", name, " ".join(f"{x:.3g}" for x in entry), flush=True)
    if given.json:
        firsts = {"joints": "yield", "contacts": "stiffness, of the normal law's"}
        tables = {name: table(rows, firsts[name.split("-")[-1]]) for name, rows in found.items()}
        where = {"machine": given.machine, "date": f"{datetime.now(UTC):%Y-%m-%d}"}
        told = {**where, "command": "python tests/benchmarks/friction_anchors.py", "tables": tables}
        given.json.write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
    if given.png:
        draw(found, given.png)


if __name__ == "__main__":
    main()
