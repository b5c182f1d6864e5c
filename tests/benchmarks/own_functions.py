"""Functions of the user in an arm of two flexible links: in Python, compiled, continuous and sampled at 1 kHz."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

import kanefe as kf
from benchmarks.clocks import Race, microseconds, repeated, seconds
from benchmarks.goals import Figure, Goal
from benchmarks.sampled_arm import LINKS, SECONDS, arm_scene, controlled, run

EVALUATION = Goal(
    "five Python functions of places and speeds in an arm of two flexible links, an evaluation [us]", 50.0
)
CONTINUOUS = Goal("PD arm, rtol 1e-4: compiled controller at 1 kHz / the same law compiled and continuous", 1.5)
WITHOUT = Goal("PD arm, rtol 1e-4: compiled controller at 1 kHz / the arm falling without it", 1.5)
CALLED = Goal("PD arm, controller at 1 kHz: a sample in Python / compiled, the difference [us]", 10.0)

RTOL = 1e-4
ONE, TWO = (tuple(link[name] for name in ("angle", "to", "kp", "kd")) for link in LINKS)


def law(link: tuple[float, ...]) -> Callable[[float, Any], float]:
    """Return what drives a joint along a quintic, of its angle and rate."""
    start, end, kp, kd = link
    span = SECONDS

    def torque(t: float, reads: Any) -> float:
        s = min(t / span, 1.0)
        wanted = start + (end - start) * s**3 * (10 - 15 * s + 6 * s * s)
        speed = (end - start) * 30 * s * s * (1 - s) ** 2 / span
        return kp * (wanted - reads[0]) + kd * (speed - reads[1])

    return torque


def sampled(t: float, reads: Any, memory: Any) -> tuple[float, float]:
    """Return the torques of both joints."""
    s, found = min(t / SECONDS, 1.0), np.zeros(2)
    for i, (start, end, kp, kd) in enumerate((ONE, TWO)):
        wanted = start + (end - start) * s**3 * (10 - 15 * s + 6 * s * s)
        speed = (end - start) * 30 * s * s * (1 - s) ** 2 / SECONDS
        found[i] = kp * (wanted - reads[i]) + kd * (speed - reads[2 + i])
    return found[0], found[1]


HOLD = law(ONE), law(TWO)


def in_python(t: float, reads: Any, memory: Any) -> tuple[float, float]:
    """Return the same in Python."""
    return HOLD[0](t, (reads[0], reads[2])), HOLD[1](t, (reads[1], reads[3]))


def continuous() -> kf.System:
    """Return the arm with the same law, that looks at it all the time."""
    scene = arm_scene()
    for name, link in (("one", ONE), ("two", TWO)):
        reads = f"joint_coordinates {name}", f"joint_speeds {name}"
        scene.add_motor(scene.body(name), kf.compiled(law(link), reads=reads))
    return scene


def of_samples(rounds: int) -> list[Figure]:
    """Compare runs with a sampled controller with those without."""
    ours, python = (controlled(arm_scene(), function).freeze() for function in (kf.compiled(sampled), in_python))
    figures = []
    for goal, scene in ((CONTINUOUS, continuous()), (WITHOUT, arm_scene())):
        other = scene.freeze()
        run(ours, RTOL), run(other, RTOL)
        race = Race(lambda: seconds(lambda: run(ours, RTOL)), lambda m=other: seconds(lambda: run(m, RTOL)), rounds)
        figures.append(goal.figure(race.ratio, f"{1e3 * race.ours:.3g} ms against {1e3 * race.theirs:.3g} ms"))
    race = Race(lambda: seconds(lambda: run(python, RTOL)), lambda: seconds(lambda: run(ours, RTOL)), rounds)
    own = 1e6 * (race.ours - race.theirs) / 500.0
    return [
        *figures,
        CALLED.figure(own, f"{1e3 * race.ours:.3g} ms against {1e3 * race.theirs:.3g} ms, of 500 samples"),
    ]


def of_evaluations(rounds: int) -> list[Figure]:
    """Time evaluations with five functions in Python, of joints, places and speeds."""
    scene = arm_scene()
    one, two, tool, elbow = (scene.body(name) for name in ("one", "two", "tool", "elbow"))
    scene.add_motor(one, lambda t, s: HOLD[0](t, (s.joint_coordinates("one")[0], s.joint_speeds("one")[0])))
    scene.add_motor(two, lambda t, s: HOLD[1](t, (s.joint_coordinates("two")[0], s.joint_speeds("two")[0])))
    scene.add_force(tool, lambda t, s: -0.1 * s.velocity("tool"))
    scene.add_torque(tool, lambda t, s: (0.0, 0.0, -0.01 * s.angular_velocity("tool")[2]))
    scene.add_force(elbow, lambda t, s: -2.0 * s.position("two", "tip"))
    model = scene.freeze()
    y = np.append(model.initial_state, (0.0, 0.0))
    taken, alone = (
        min(repeated(lambda route=one.route: route.evaluate(0.1, y), 2000) for _ in range(2 * rounds))
        for one in (model, arm_scene().freeze())
    )
    return [EVALUATION.figure(1e6 * taken, f"{microseconds(alone)} without functions")]


GROUPS = {of_samples: [CONTINUOUS, WITHOUT, CALLED], of_evaluations: [EVALUATION]}
