"""Rigid contacts: a box that slides, a stack of boxes that lies still, many balls; CPU time of all of `simulate`."""

from __future__ import annotations

import numpy as np

import kanefe as kf
from benchmarks.clocks import check_agreement, fill, microseconds, repeated, seconds
from benchmarks.goals import Figure, Goal, median
from rigid_scenes import stack

SLIDE = Goal("rigid contact, a box that slides for a second: simulate [ms]", 10.0)
EVALUATION = Goal("rigid contact, a box that slides: evaluation [us]", 10.0)
STACK = Goal("rigid contacts, a stack of ten boxes for 2 s: simulate [s]", 0.2)
POURED = Goal("rigid contacts, 1,000 balls poured for 1 s: a contact and step [us]", 2.0)

MU, SPEED, GRAVITY = 0.2, 2.5, 9.81


def sliding_box() -> kf.System:
    """Return a box that slides on its four lower corners."""
    scene = kf.System(gravity=(0, 0, -GRAVITY))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    start = kf.Free(position=(0, 0, 0.1), velocity=(SPEED, 0, 0))
    box = scene.add_rigid_body("box", 1.0, 0.01, joint=start)
    corners = kf.shapes.Points([(x, y, -0.1) for x in (-0.1, 0.1) for y in (-0.1, 0.1)])
    scene.add_contact("c", scene.add_surface("skin", box, corners), floor, normal=kf.Rigid(), friction=kf.Coulomb(MU))
    return scene


def sliding(rounds: int) -> list[Figure]:
    """Measure a box that slides for a second, whose place is known."""
    scene = sliding_box()
    end = scene.simulate((0.0, 1.0), progress=False).position("box")[-1]
    check_agreement("box", end, (SPEED - 0.5 * MU * GRAVITY, 0.0, 0.1), 1e-9)
    times = [seconds(lambda: scene.simulate((0.0, 1.0), progress=False)) for _ in range(rounds + 1)][1:]
    model = scene.freeze()
    route, y = model.route, np.append(model.route.start(0.0), (0.0, 0.0))
    call = route.rates_call()
    call.at[:] = y

    def evaluate() -> None:
        call(0.0)

    one = repeated(evaluate, fill(evaluate))
    return [SLIDE.figure(1e3 * median(times)), EVALUATION.figure(1e6 * one, microseconds(one))]


def lying(rounds: int) -> list[Figure]:
    """Measure a stack at rest, which stays where it is."""
    scene = stack(10, 0.0)
    result = scene.simulate((0.0, 2.0), progress=False)
    check_agreement("stack", result.position("box 9")[-1], (-0.003, 0.0, 1.9), 1e-9)
    happened = sum(map(len, result.events.values()))
    times = [seconds(lambda: scene.simulate((0.0, 2.0), progress=False)) for _ in range(rounds + 1)][1:]
    return [STACK.figure(median(times), f"{happened} events")]


def poured_balls(count: int = 1000, radius: float = 0.02) -> kf.System:
    """Return balls that fall in layers of a hundred into a box without a lid."""
    scene, rng = kf.System(gravity=(0, 0, -GRAVITY)), np.random.default_rng(1)
    mass, across = 4.0 / 3.0 * np.pi * radius**3 * 2500.0, 12.7 * radius
    room = [scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))]
    for name, place, normal in (("left", -across, "x"), ("right", across, "-x")):
        room.append(scene.add_surface(name, scene.ground.frame(at=(place, 0, 0)), kf.shapes.Plane(normal)))
    for name, place, normal in (("front", -across, "y"), ("back", across, "-y")):
        room.append(scene.add_surface(name, scene.ground.frame(at=(0, place, 0)), kf.shapes.Plane(normal)))
    for i in range(count):
        layer, place = divmod(i, 100)
        at = 2.2 * radius * np.array((place // 10 - 4.5, place % 10 - 4.5, layer + 1.0))
        at[:2] += 0.1 * radius * rng.standard_normal(2)
        ball = scene.add_rigid_body(f"ball {i}", mass, 0.4 * mass * radius**2, joint=kf.Free(position=tuple(at)))
        room.append(scene.add_surface(f"skin {i}", ball, kf.shapes.Sphere(radius)))
    scene.add_contacts(room, normal=kf.Rigid(0.3), friction=kf.Coulomb(0.4))
    return scene


def pouring(rounds: int) -> list[Figure]:
    """Measure a thousand balls, of which each step has some contacts; once, since it takes long."""
    scene, told = poured_balls(), {}

    def run() -> None:
        told.update(scene.simulate((0.0, 1.0), progress=False).statistics)

    scene.simulate((0.0, 1e-3), progress=False)
    time = seconds(run)
    contacts, sweeps = told["contacts_of_steps"], told["sweeps"] / told["steps"]
    remark = f"{time:.3g} s, {contacts / told['steps']:.0f} contacts and {sweeps:.0f} sweeps a step"
    return [POURED.figure(1e6 * time / contacts, remark)]


GROUPS = {sliding: [SLIDE, EVALUATION], lying: [STACK], pouring: [POURED]}
"""Goals of each group, which stand in its place where it cannot be measured."""
