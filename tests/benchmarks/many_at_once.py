"""Many runs in one call: against as many calls, on one core, and on two threads against one.

    PYTHONPATH=.:fem:tests:tests/shared python tests/benchmarks/many_at_once.py [--quick] [--only tree] [--json FILE]

The runs of both sides are the same to the last bit, which is checked first. The figure of two threads is of wall time:
it needs a machine that does nothing else.
"""

from __future__ import annotations

import argparse
import sys
import time
import warnings
from collections.abc import Callable, Sequence
from importlib.resources import as_file, files
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(1, str(Path(__file__).resolve().parents[1] / "shared"))

from benchmarks import command_line
from benchmarks.clocks import Race, seconds, use_all_cores
from benchmarks.goals import Figure, Goal

SEEDS, BODIES, END = 32, 20, 2.0
"""Runs in a call, bodies of the tree, and duration of each run in s."""

RTOL = 1e-6

DECK_END, WAVES = 10.0, 5
"""Duration of each run of the helicopter in s, and sea state."""

STARTS = Goal(f"rigid tree of {BODIES}, {SEEDS} starts: one call / {SEEDS} calls, CPU", 1.0 / 3.0)
MASSES = Goal(
    f"rigid trees of {BODIES}, {SEEDS} seeds of masses, built and run: one call / {SEEDS} calls, CPU", 1.0 / 3.0
)
DECK = Goal(f"helicopter on a deck, {SEEDS} seeds of waves: one call / {SEEDS} calls, CPU", 0.5)
THREADS = Goal(f"rigid tree of {BODIES}, {8 * SEEDS} starts: two threads / one, wall", 1.0 / 1.8)


def tree(seed: int = 0):  # type: ignore[no-untyped-def]  # kanefe is imported once the core is chosen
    """Return a tree of rigid bodies on hinges that branches twice, with masses by a seed."""
    import numpy as np

    import kanefe as kf

    rng = np.random.default_rng(seed)
    scene, bodies = kf.System(gravity=(0.0, 0.0, -9.81)), []
    for i in range(BODIES):
        parent = scene.ground if i == 0 else bodies[4 if i == 12 else 8 if i == 16 else i - 1]
        joint = kf.Revolute("yz"[i % 2], position=0.1)
        mass = rng.uniform(0.8, 1.2)
        where = {"parent": parent, "at": (0.5 if i else 0.0, 0.0, 0.0)}
        bodies.append(
            scene.add_rigid_body(f"body {i}", mass, (0.01, 0.05, 0.05), com=(0.25, 0, 0), joint=joint, **where)
        )
    return scene


def starts_of(scene, count: int):  # type: ignore[no-untyped-def]
    import numpy as np

    first = scene.freeze().initial_state
    return first + 0.3 * np.random.default_rng(1).uniform(-1.0, 1.0, (count, len(first)))


def helicopters() -> list[object]:
    """Return the helicopter on its skids on a deck, once for each seed of the waves."""
    import kanefe as kf
    from kanefe_fem.sramss import spatial_gear, spatial_scene

    with as_file(files("kanefe_fem") / "data" / "skid_gear.msh") as path:
        gear = spatial_gear(path)
    found = []
    for seed in range(SEEDS):
        ship = kf.Ship(kf.example_rao(), kf.Sea.state(WAVES, seed=seed), heading_deg=60.0)
        found.append(spatial_scene(gear, ship.at((-45.0, 0.0, 6.0), duration=DECK_END)))
    return found


def check_same(found: Sequence[object], alone: Sequence[object]) -> None:
    import numpy as np

    for many, one in zip(found, alone, strict=True):
        np.testing.assert_array_equal(many.run.states, one.run.states)  # type: ignore[attr-defined]


def compared(goal: Goal, at_once: Callable[[], object], one_by_one: Callable[[], object], rounds: int) -> Figure:
    race = Race(lambda: seconds(at_once), lambda: seconds(one_by_one), rounds)
    return goal.figure(race.ratio, f"{1e3 * race.ours:.3g} ms against {1e3 * race.theirs:.3g} ms")


def of_starts(rounds: int) -> Figure:
    import kanefe as kf

    scene = tree()
    starts, span = starts_of(scene, SEEDS), (0.0, END)

    def at_once() -> Sequence[object]:
        return kf.simulate_many(scene, span, starts, threads=1, rtol=RTOL, progress=False)

    def one_by_one() -> Sequence[object]:
        return [scene.simulate(span, start=start, rtol=RTOL, progress=False) for start in starts]

    check_same(at_once(), one_by_one())
    return compared(STARTS, at_once, one_by_one, rounds)


def of_masses(rounds: int) -> Figure:
    import kanefe as kf

    span = (0.0, END)

    def at_once() -> Sequence[object]:
        return kf.simulate_many(list(map(tree, range(SEEDS))), span, threads=1, rtol=RTOL, progress=False)

    def one_by_one() -> Sequence[object]:
        return [tree(seed).simulate(span, rtol=RTOL, progress=False) for seed in range(SEEDS)]

    check_same(at_once(), one_by_one())
    return compared(MASSES, at_once, one_by_one, rounds)


def of_decks(rounds: int) -> Figure:
    import kanefe as kf

    scenes, span = helicopters(), (0.0, DECK_END)

    def at_once() -> object:
        return kf.simulate_many(scenes, span, threads=1, rtol=RTOL, progress=False)

    def one_by_one() -> object:
        return [scene.simulate(span, rtol=RTOL, progress=False) for scene in scenes]  # type: ignore[attr-defined]

    return compared(DECK, at_once, one_by_one, 1 if rounds < 9 else 3)


def of_threads(rounds: int) -> Figure:
    import kanefe as kf

    scene = tree()
    starts = starts_of(scene, 8 * SEEDS)

    def wall(threads: int) -> float:
        began = time.perf_counter()
        kf.simulate_many(scene, (0.0, END), starts, threads=threads, rtol=RTOL, output_step=END, progress=False)
        return time.perf_counter() - began

    with use_all_cores():
        race = Race(lambda: wall(2), lambda: wall(1), rounds)
    return THREADS.figure(race.ratio, f"{1e3 * race.ours:.3g} ms against {1e3 * race.theirs:.3g} ms")


GROUPS = {"tree, starts": of_starts, "tree, masses": of_masses, "tree, threads": of_threads, "deck": of_decks}


def measured(options: argparse.Namespace) -> list[Figure]:
    """Measure the groups that are asked for."""
    warnings.simplefilter("ignore")
    rounds = 3 if options.quick else 9
    return [group(rounds) for name, group in GROUPS.items() if options.only in name]


if __name__ == "__main__":
    options = command_line.parser(__doc__, quick="fewer repetitions").parse_args()
    sys.exit(command_line.run(options, measured))
