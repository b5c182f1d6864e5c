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

BUILDING = Goal("20 links: building [ms]", 2.0)
FREEZING = Goal("20 links: freezing [ms]", 1.0)
AGAIN = Goal("20 links: a second run of no length [ms]", 0.5)
START = Goal("20 links: the same from another start [ms]", 0.8)
READING = Goal("20 links: first reading of a place, 1,001 times [ms]", 0.3)
RIGID = Goal("box on rigid contacts: a second run of no length [ms]", 0.5)
SERIAL = Goal("study of 100 runs / a loop of simulate", 1.1)
PROCESSES = Goal("study of 100 runs in two processes, CPU beyond that of a loop [s]", 0.5)

NO_LENGTH = 1e-9
"""Length of a run in which nothing happens, s."""

REPEATS = 10
"""Number of times that each is done in a round."""

ANGLES = np.linspace(0.0, 0.3, 100).tolist()


def chain(angle: float) -> kf.System:
    """Return five rods that swing from an angle in rad."""
    scene = kf.System(gravity=(0.0, -9.81, 0.0))
    body = scene.ground
    for i in range(5):
        at, joint = (1.0 if i else 0.0, 0.0, 0.0), kf.Revolute("z", position=angle)
        body = scene.add_rigid_body(f"rod {i}", 1.0, 1.0 / 12.0, com=(0.5, 0, 0), parent=body, at=at, joint=joint)
    return scene


def lowest(result: kf.Result) -> dict[str, float]:
    """Return the least angle of the first rod, rad."""
    return {"lowest": float(result.joint_coordinates("rod 0").min())}


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
    of_studies: [SERIAL, PROCESSES],
}
"""Goals of each group, which stand in its place where it cannot be measured."""
