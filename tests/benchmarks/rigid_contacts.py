"""Rigid contacts: a box that slides, and a stack of boxes that lies still; CPU time of all of `simulate`."""

from __future__ import annotations

import numpy as np

import kanefe as kf
from benchmarks.clocks import check_agreement, fill, microseconds, repeated, seconds
from benchmarks.goals import Figure, Goal, median
from rigid_scenes import stack

SLIDE = Goal("rigid contact, a box that slides for a second: simulate [ms]", 10.0)
EVALUATION = Goal("rigid contact, a box that slides: evaluation [us]", 10.0)
STACK = Goal("rigid contacts, a stack of ten boxes for 2 s: simulate [s]", 0.2)

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
        call(0.0, False, (0.0, 0.0))

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


GROUPS = {sliding: [SLIDE, EVALUATION], lying: [STACK]}
"""Goals of each group, which stand in its place where it cannot be measured."""
