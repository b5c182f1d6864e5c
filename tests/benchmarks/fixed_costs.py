"""What users pay beside the steps of small runs: making a scene, another start, a reading, a study of short runs."""

from __future__ import annotations

import resource
from collections.abc import Callable

import numpy as np

import kanefe as kf
from benchmarks.around_a_run import links
from benchmarks.clocks import Race, seconds
from benchmarks.goals import Figure, Goal, median
from benchmarks.rigid_contacts import sliding_box
from benchmarks.studied_chain import chain, lowest
from benchmarks.work_precision.rigid_chain import chain_scene

BUILDING = Goal("20 links: building [ms]", 2.0)
FREEZING = Goal("20 links: freezing [ms]", 1.0)
AGAIN = Goal("20 links: a second run of no length [ms]", 0.5)
START = Goal("20 links: the same from another start [ms]", 0.3)
READING = Goal("20 links: first reading of a place, 1,001 times [ms]", 0.3)
RIGID = Goal("box on rigid contacts: a second run of no length [ms]", 0.5)
CHAIN = Goal("chain of 5, 2 s by auto, rtol 1e-3: a second simulate [ms]", 0.5)
CHAIN_FIXED = Goal("the same, a run of no length [ms]", 0.1)
FIRST_BALL = Goal("a fresh ball on a floor: freeze and the first run of 3 s [ms]", 1.5)
SECOND_BALL = Goal("the same: the second run [ms]", 0.5)
SERIAL = Goal("study of 100 runs / a loop of simulate", 1.1)
PROCESSES = Goal("study of 100 runs in two processes, CPU beyond that of a loop [s]", 0.5)

NO_LENGTH = 1e-9
"""Length of a run in which nothing happens, s."""

REPEATS = 10
"""Number of times that each is done in a round."""

ANGLES = np.linspace(0.0, 0.3, 100).tolist()


def of_small_runs(rounds: int) -> list[Figure]:
    """Measure what comes before and after the steps of a chain."""
    scene = links()
    run = scene.simulate((0.0, 0.1))
    starts = iter([run.at(t) for t in run.times[-rounds * REPEATS - 1 :]])

    def frozen() -> float:
        one = links()
        return seconds(one.freeze)

    def read() -> float:
        result = scene.simulate((0.0, 1.0), output_step=1e-3)
        return seconds(lambda: result.position("link 19"))

    def again() -> float:
        return seconds(lambda: scene.simulate((0.0, NO_LENGTH)))

    def started() -> float:
        return seconds(lambda: scene.simulate((0.0, NO_LENGTH), start=next(starts)))

    clocks = {BUILDING: lambda: seconds(links), FREEZING: frozen, AGAIN: again, START: started, READING: read}
    return [_milliseconds(goal, clock, rounds) for goal, clock in clocks.items()]


def of_rigid_contacts(rounds: int) -> list[Figure]:
    """Measure the same of a box that slides."""
    scene = sliding_box()
    scene.simulate((0.0, NO_LENGTH), progress=False)
    return [_milliseconds(RIGID, lambda: seconds(lambda: scene.simulate((0.0, NO_LENGTH), progress=False)), rounds)]


def of_short_runs(rounds: int) -> list[Figure]:
    """Measure whole runs of which the steps are the smaller part."""
    scene = chain_scene(5)

    def of_chain(stop: float) -> float:
        return seconds(lambda: scene.simulate((0.0, stop), rtol=1e-3, progress=False))

    balls = [_of_a_ball() for _ in range(rounds * REPEATS + 1)][1:]
    return [
        _milliseconds(CHAIN, lambda: of_chain(2.0), rounds),
        _milliseconds(CHAIN_FIXED, lambda: of_chain(NO_LENGTH), rounds),
        FIRST_BALL.figure(1e3 * median([first for first, _ in balls])),
        SECOND_BALL.figure(1e3 * median([second for _, second in balls])),
    ]


def _of_a_ball() -> tuple[float, float]:
    """Return the CPU times of freeze and the first run of a new scene, and of the second run, s."""
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    ball = scene.add_rigid_body("ball", 1.0, 4e-3, joint=kf.Free(position=(0.0, 0.0, 1.0)))
    skin = scene.add_surface("skin", ball, kf.shapes.Sphere(0.1))
    scene.add_contact("contact", skin, floor, normal=kf.HuntCrossley(1e5))

    def run() -> None:
        scene.simulate((0.0, 3.0), progress=False)

    return seconds(run), seconds(run)


def of_studies(rounds: int) -> list[Figure]:
    """Compare a study with a loop over the same scenes, and count what new processes take."""
    study = kf.Study(chain, lowest, duration=1.0, angle=ANGLES)

    def loop() -> None:
        for angle in ANGLES:
            lowest(chain(angle).simulate((0.0, 1.0)))

    loop()
    race = Race(lambda: seconds(lambda: study.run("serial", progress=False)), lambda: seconds(loop), rounds)
    beyond = [_with_children(lambda: study.run("processes", workers=2, progress=False)) for _ in range(rounds)]
    return [
        SERIAL.figure(race.ratio, f"{race.ours:.3g} s against {race.theirs:.3g} s"),
        PROCESSES.figure(median(beyond) - race.theirs),
    ]


def _milliseconds(goal: Goal, clock: Callable[[], float], rounds: int) -> Figure:
    return goal.figure(1e3 * median([clock() for _ in range(rounds * REPEATS + 1)][1:]))


def _with_children(function: Callable[[], object]) -> float:
    """Return the CPU time of a call and of the processes that it starts and ends, s."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    own = seconds(function)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return own + after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


GROUPS = {
    of_small_runs: [BUILDING, FREEZING, AGAIN, START, READING],
    of_rigid_contacts: [RIGID],
    of_short_runs: [CHAIN, CHAIN_FIXED, FIRST_BALL, SECOND_BALL],
    of_studies: [SERIAL, PROCESSES],
}
"""Goals of each group, which stand in its place where it cannot be measured."""
