"""What method="auto" takes against the best method by hand at equal error: ``python tests/benchmarks/auto_choice.py``.

For each scene and tolerance the run of auto has an error against a reference; of the runs by hand that are at least as
accurate the fastest counts. Times are CPU times, the least of some runs, without the first.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
import warnings
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parents[1]))

import kanefe as kf
from benchmarks.goals import Figure, Goal
from kanefe.result import Result
from kanefe_fem import Material, Rectangle, beam_body, straight_beam

TOLERANCES = tuple(10.0 ** (-0.5 * i) for i in range(6, 17))
OF_AUTO = 1e-3, 1e-4, 1e-5, 1e-6
BY_HAND = "dop853", "vern9", "radau5", "extrapolation"
FINEST, FINEST_BY_SWEEPS = 1e-11, 1e-9
MOST_SECONDS, MOST_FOR_REFERENCE = 5.0, 120.0
LIMIT = 1.5

ALUMINIUM = Material(E=70e9, nu=0.33, rho=2700.0)
Observe = Callable[[Result], np.ndarray]


class Raced(NamedTuple):
    """A scene: what makes it, how long it runs (s), what of its result is compared, and the reference's method."""

    scene: kf.System
    seconds: float
    observe: Observe
    finest: str = "radau5"


def arm_under_control() -> Raced:
    """Return two beams with PD controllers in Python, damped by 2 %."""
    return Raced(_arm(is_sampled=False), 0.6, lambda result: result.position("tool"))


def arm_under_sampled_control() -> Raced:
    """Return the same, sampled at 1 kHz, by gains a fifth as high: with those it would not be stable."""
    return Raced(_arm(is_sampled=True), 0.3, lambda result: result.position("tool"), "extrapolation")


def hard_stop() -> Raced:
    """Return a pendulum that swings against a stop of 1e6 N m/rad."""
    scene = kf.System(gravity=(0, 0, -9.81))
    stop = kf.CoordinateForce(limits=(-0.5, 2.0), limit_stiffness=1e6, limit_damping=100.0)
    scene.add_rigid_body("rod", 1.0, 1 / 12, com=(0.5, 0, 0), joint=kf.Revolute("y", forces=stop))
    return Raced(scene, 1.0, lambda result: result.joint_coordinates("rod"))


def long_chain() -> Raced:
    """Return a chain of 32 rods on hinges with springs and dampers."""
    scene, parent = kf.System(gravity=(0, 0, -9.81)), None
    spring = kf.CoordinateForce(stiffness=500.0, damping=0.5)
    for i in range(32):
        joint = kf.Revolute("y", forces=spring)
        options = {} if parent is None else {"parent": parent, "at": (0.1, 0, 0)}
        parent = scene.add_rigid_body(f"rod {i}", 0.1, 1e-4, com=(0.05, 0, 0), joint=joint, **options)
    return Raced(scene, 1.0, lambda result: result.position("rod 31"))


def free_flight() -> Raced:
    """Return a beam that tumbles freely and vibrates, 3 mm at its ends."""
    beam = straight_beam(1.0, Rectangle(0.05, 0.01), ALUMINIUM, elements=8)
    body = beam_body(beam, {}, reduction=kf.FreeInterface(modes=6))
    scene = kf.System()
    joint = kf.Free(velocity=(1.0, 0, 0), angular_velocity=(0.1, 2.0, 0.2))
    shape = abs(body.node_displacements(np.eye(body.free_count)[0])).max()
    amplitude = np.eye(body.free_count)[0] * 3e-3 / shape
    scene.add_flexible_body("beam", body, joint=joint, modal_coordinates=amplitude)
    return Raced(scene, 1.0, lambda result: result.modal_coordinates("beam")[:, :1] * shape)


def rubbing_joint() -> Raced:
    """Return a pendulum whose hinge rubs."""
    scene = kf.System(gravity=(0, 0, -9.81))
    rub = kf.CoordinateForce(friction=0.3)
    scene.add_rigid_body("rod", 1.0, 1 / 12, com=(0.5, 0, 0), joint=kf.Revolute("y", forces=rub))
    return Raced(scene, 3.0, lambda result: result.joint_coordinates("rod"))


def bouncing_ball() -> Raced:
    """Return a ball that bounces and rolls on a floor that rubs."""
    scene = kf.System(gravity=(0, 0, -9.81))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    ball = scene.add_rigid_body("ball", 1.0, 4e-3, joint=kf.Free(position=(0, 0, 0.3), velocity=(1.0, 0, 0)))
    skin = scene.add_surface("skin", ball, kf.shapes.Sphere(0.1))
    scene.add_contact("drop", skin, floor, normal=kf.HuntCrossley(1e6, 0.3), friction=kf.Coulomb(0.3))
    return Raced(scene, 1.0, lambda result: result.position("ball"))


def sliding_boxes() -> Raced:
    """Return three boxes that drop by little, slide, and come to rest."""
    scene = kf.System(gravity=(0, 0, -9.81))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    for i in range(3):
        start = kf.Free(position=(0, 0.5 * i, 0.0525), velocity=(0.5, 0, 0))
        box = scene.add_rigid_body(f"box {i}", 5.0, 0.05, joint=start)
        skin = scene.add_surface(f"skin {i}", box, kf.shapes.Box((0.2, 0.2, 0.1)))
        scene.add_contact(f"on floor {i}", skin, floor, normal=kf.HuntCrossley(1e6, 1.0), friction=kf.Coulomb(0.2))
    return Raced(scene, 1.0, lambda result: np.hstack([result.position(f"box {i}") for i in range(3)]))


def sliding_block(damping: float) -> Raced:
    """Return a block on four points that slides down a slope to rest, its contacts damped by so much, s/m."""
    slope = 0.3
    scene = kf.System(gravity=(9.81 * math.sin(slope), 0, -9.81 * math.cos(slope)))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    start = kf.Free(position=(0, 0, 0.05), velocity=(2.0, 0, 0))
    block = scene.add_rigid_body("block", 1.0, (2e-3, 3e-3, 4e-3), joint=start)
    feet = [block.frame(at=(x, y, -0.05)) for x in (-0.1, 0.1) for y in (-0.1, 0.1)]
    scene.add_contact("feet", feet, floor, normal=kf.HuntCrossley(2.5e5, damping), friction=kf.Coulomb(0.5))
    return Raced(scene, 3.0, lambda result: result.position("block"), "dop853")


def car_on_loops() -> Raced:
    """Return a car on four wishbones, each a loop with its spring, that drops onto tyres on a moving road."""
    scene = kf.System(gravity=(0, 0, -9.81))
    chassis = scene.add_rigid_body("chassis", 700.0, (150.0, 500.0, 600.0), joint=kf.Free(position=(0, 0, 0.6)))
    rate, height = 2 * math.pi * 1.5, 0.03
    shake = kf.Motion(
        lambda t: height * math.cos(rate * t),
        lambda t: -height * rate * math.sin(rate * t),
        lambda t: -height * rate**2 * math.cos(rate * t),
    )
    road = scene.add_rigid_body("road", 1.0, 1.0, joint=kf.Prismatic("z", motion=shake))
    hinge = kf.Revolute("x")
    for corner, (x, side) in {"FR": (1.2, -1), "FL": (1.2, 1), "RR": (-1.2, -1), "RL": (-1.2, 1)}.items():
        y, half = 0.56 * side, (0, 0.15 * side, 0)
        on = {"parent": chassis, "joint": hinge, "com": half}
        lower = scene.add_rigid_body(f"lower {corner}", 4.0, 0.05, at=(x, y, -0.25), **on)
        end = (0, 0.3 * side, 0)
        wheel = {"parent": lower, "joint": hinge, "com": (0, 0, 0.1)}
        upright = scene.add_rigid_body(f"upright {corner}", 25.0, 0.5, at=end, **wheel)
        upper = scene.add_rigid_body(f"upper {corner}", 3.0, 0.04, at=(x, y, -0.05), **on)
        scene.add_loop_joint(f"ball {corner}", hinge, upright.frame(at=(0, 0, 0.2)), upper.frame(at=end))
        mount, seat = chassis.frame(at=(x, y, 0.25)), lower.frame(at=(0, 0.2 * side, 0))
        scene.add_spring(f"coil {corner}", mount, seat, stiffness=6e4, damping=3e3, rest_length=0.55)
        tyre, patch = {"stiffness": (5e4, 5e4, 2e5), "damping": (1e3, 1e3, 1e3)}, (x, y + 0.3 * side, 0.35)
        scene.add_bushing(f"tyre {corner}", road.frame(at=patch), upright, **tyre)
    return Raced(scene, 1.0, lambda result: result.position("chassis"))


def _arm(is_sampled: bool) -> kf.System:
    scene = kf.System(gravity=(0, 0, -9.81))
    parent, at = scene.ground, (0.0, 0.0, 0.3)
    wanted, share = {"one": (-0.3, -1.2, 4e3, 250.0), "two": (0.8, 0.2, 1e3, 60.0)}, 0.2 if is_sampled else 1.0
    for name, length, section in (("one", 0.6, Rectangle(0.06, 0.08)), ("two", 0.5, Rectangle(0.045, 0.06))):
        beam = straight_beam(length, section, ALUMINIUM, elements=10)
        ends = {"root": "clamped", "tip": "rigid"}
        body = beam_body(beam, ends, kf.CraigBampton(modes=8), kf.ModalDamping(0.02))
        joint = kf.Revolute("y", position=wanted[name][0])
        link = scene.add_flexible_body(name, body, parent=parent, at=at, joint=joint)
        tip = "elbow" if name == "one" else "tool"
        parent, at = scene.add_rigid_body(tip, 1.5, 2e-3, parent=link.interface("tip")), (0.05, 0.0, 0.0)

    def torque(name: str, t: float, angle: float, rate: float) -> float:
        start, end, kp, kd = wanted[name]
        s = min(t / 0.6, 1.0)
        way = start + (end - start) * s**3 * (10 - 15 * s + 6 * s * s)
        speed = (end - start) * 30 * s * s * (1 - s) ** 2 / 0.6
        return share * float(kp * (way - angle) + kd * (speed - rate))

    if is_sampled:
        reads = tuple(f"{what} {name}" for name in wanted for what in ("joint_coordinates", "joint_speeds"))
        scene.add_controller(
            "control",
            lambda t, r, memory: (torque("one", t, r[0], r[1]), torque("two", t, r[2], r[3])),
            every=1e-3,
            reads=reads,
            drives=("motor one", "motor two"),
        )
        return scene
    for name in wanted:

        def motor(t: float, state: kf.SceneState, name: str = name) -> float:
            return torque(name, t, float(state.joint_coordinates(name)[0]), float(state.joint_speeds(name)[0]))

        scene.add_motor(scene.body(name), motor)
    return scene


SCENES = {
    "PD arm in Python": arm_under_control,
    "PD arm sampled at 1 kHz": arm_under_sampled_control,
    "hard stop": hard_stop,
    "chain of 32": long_chain,
    "free flight that vibrates": free_flight,
    "car on four loops": car_on_loops,
    "joint friction": rubbing_joint,
    "ball that bounces and rolls": bouncing_ball,
    "three boxes that slide and stop": sliding_boxes,
    "block that slides to rest, weakly damped": partial(sliding_block, 0.5),
    "block that slides to rest, damped": partial(sliding_block, 20.0),
}


class Ran(NamedTuple):
    """What a run took (s of CPU), and its error; infinite if it did not end in time."""

    seconds: float
    error: float
    method: str


def ran(
    raced: Raced,
    method: str,
    rtol: float,
    reference: np.ndarray | None,
    rounds: int,
    most_seconds: float = MOST_SECONDS,
) -> tuple[Ran, np.ndarray]:
    """Run a scene some times; return the least time, the error against a reference, and what is observed."""
    best, found, name = math.inf, np.zeros(0), method
    for _ in range(rounds):
        scene = raced.scene.copy()
        began = time.process_time()
        result = scene.simulate(
            (0.0, raced.seconds), method=method, rtol=rtol, output_step=raced.seconds / 50, most_seconds=most_seconds
        )
        best = min(best, time.process_time() - began)
        found, name = raced.observe(result), result.status.kind
        if name != "finished":
            return Ran(math.inf, math.inf, name), found
        name = str(result).split("method", 1)[1].split("(", 1)[0].strip()
        if best > 1.0:
            break
    error = math.nan if reference is None else float(np.abs(found - reference).max())
    return Ran(best, error, name), found


def race(name: str, rounds: int) -> list[Figure]:
    """Return the worst ratio of a scene, and what it was made from."""
    raced = SCENES[name]()
    ran(raced, "auto", 1e-3, None, 1)  # what is compiled is compiled
    finest = FINEST if raced.finest == "radau5" else FINEST_BY_SWEEPS
    _, reference = ran(raced, raced.finest, finest, None, 1, MOST_FOR_REFERENCE)
    by_hand = []
    for method in BY_HAND:
        for rtol in TOLERANCES:
            try:
                run, _ = ran(raced, method, rtol, reference, rounds)
            except kf.ModelError:
                break
            by_hand.append(run)
    worst, remark = 0.0, ""
    for rtol in OF_AUTO:
        ours, _ = ran(raced, "auto", rtol, reference, rounds)
        best = min((run for run in by_hand if run.error <= ours.error), key=lambda run: run.seconds, default=ours)
        ratio = ours.seconds / min(best.seconds, ours.seconds)
        text = f"rtol {rtol:g}: {ours.method} {ours.seconds:.3g} s, error {ours.error:.1e}; "
        text += f"{best.method} {best.seconds:.3g} s"
        print(f"  {name}: {ratio:.2f}  {text}", flush=True)
        if ratio >= worst:
            worst, remark = ratio, text
    return [Goal(f"{name}: auto / best by hand at equal error", LIMIT).figure(worst, remark)]


def main() -> int:
    """Measure, as a command; exit with 1 if a goal is missed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default="", help="scenes whose name contains this")
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    figures = [figure for name in SCENES if options.only in name for figure in race(name, options.rounds)]
    for figure in figures:
        print(f"{figure.what}: {figure.value:.2f} ({figure.goal}) {'met' if figure.met else 'MISSED'}")
    return 0 if all(figure.met for figure in figures) else 1


if __name__ == "__main__":
    sys.exit(main())
