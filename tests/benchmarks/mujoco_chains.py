"""Chains against MuJoCo: whole runs at equal error, from one start and from many, and an evaluation from Python."""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks import engine_scenes as ours
from benchmarks.clocks import Race, check_agreement, coarsest, fill, microseconds, repeated, seconds
from benchmarks.goals import Figure, Goal
from benchmarks.peer_process import Peers
from benchmarks.work_precision.rigid_chain import END, GRAVITY, chain_links, chain_scene, chain_start
from kanefe.batches.many_runs import simulate_many
from kanefe.result import Result
from kanefe.system import System

ERROR = 1e-3
"""Of the place of the last link at the end, m, which both sides have to reach."""

RUN_GOALS = {
    count: Goal(f"S1 rigid chain, N={count}, {END:g} s to {ERROR:g} m: simulate by auto / MuJoCo's RK4", limit)
    for count, limit in ((5, 0.9), (20, 0.5), (100, 0.06))
}
CALL_GOALS = {
    count: Goal(f"S1 right-hand side, N={count}, from Python: time / MuJoCo's mj_forward", limit)
    for count, limit in ((5, 0.9), (20, 0.8))
}

MANY_LINKS, STARTS = 20, 100
MANY_GOAL = Goal(f"S1, {STARTS} random starts, N={MANY_LINKS}, to {ERROR:g} m: simulate_many / MuJoCo's rollout", 0.7)

TOLERANCES = tuple(10.0 ** (-0.5 * i) for i in range(4, 15))
STEPS = tuple(round(20 * 2 ** (0.5 * i)) for i in range(22))
"""Numbers of steps of the peer."""


def runs_of_chains(peers: Peers, rounds: int) -> list[Figure]:
    """Compare runs, each at its coarsest setting with a small enough error; ours is a whole `simulate`."""
    figures = []
    for count, goal in RUN_GOALS.items():
        name = _build(peers, count)
        scene = chain_scene(count)
        exact = _end(scene, count, 1e-10)

        def error_of_theirs(steps: int, name: str = name, exact: np.ndarray = exact) -> float:
            return float(np.linalg.norm(peers.ask("solve", name=name, steps=steps, h=END / steps)["end"] - exact))

        def error_of_ours(rtol: float, scene: System = scene, count: int = count, exact: np.ndarray = exact) -> float:
            return float(np.linalg.norm(_end(scene, count, rtol) - exact))

        steps, rtol = coarsest(STEPS, error_of_theirs, ERROR), coarsest(TOLERANCES, error_of_ours, ERROR)
        race = Race(
            lambda s=scene, r=rtol: seconds(lambda: s.simulate((0.0, END), rtol=r, progress=False)),
            lambda n=name, k=steps: peers.ask("solve", name=n, steps=k, h=END / k)["seconds"],
            2 * rounds,
        )
        remark = f"{1e3 * race.ours:.3g} ms with rtol {rtol:.2g} against {1e3 * race.theirs:.3g} ms with {steps} steps"
        figures.append(goal.figure(race.ratio, remark))
    return figures


def calls_of_chains(peers: Peers, rounds: int) -> list[Figure]:
    """Compare one right-hand side of the chain with the peer's, both called from Python."""
    figures = []
    for count, goal in CALL_GOALS.items():
        name, evaluate = _build(peers, count), ours.evaluation(chain_scene(count).freeze())
        check_agreement(name, evaluate()[count:], peers.ask("call", name=name, count=1)["end"])
        calls = fill(evaluate)
        race = Race(
            lambda f=evaluate, c=calls: repeated(f, c),
            lambda n=name, c=calls: peers.ask("call", name=n, count=c)["seconds"] / c,
            rounds,
        )
        figures.append(goal.figure(race.ratio, f"{microseconds(race.ours)} against {microseconds(race.theirs)}"))
    return figures


def runs_from_many_starts(peers: Peers, rounds: int) -> list[Figure]:
    """Compare many runs, each side at its coarsest setting whose error is small enough in the median of the starts.

    (Some of the chains are so near to chaos that no coarse step follows them.)
    """
    name, scene, random = _build(peers, MANY_LINKS), chain_scene(MANY_LINKS), np.random.default_rng(1)
    q = np.array(chain_start(MANY_LINKS)) + random.uniform(-0.3, 0.3, (STARTS, MANY_LINKS))
    starts = np.hstack((q, random.uniform(-0.5, 0.5, (STARTS, MANY_LINKS))))

    def many(rtol: float) -> tuple[Result, ...]:
        options = {"output_times": [END], "rtol": rtol, "threads": 1, "progress": False}
        return simulate_many(scene, (0.0, END), starts, **options)

    def ends(rtol: float) -> np.ndarray:
        return np.array([run.center_of_mass(f"link {MANY_LINKS - 1}")[-1] for run in many(rtol)])

    def theirs(steps: int) -> dict[str, Any]:
        return peers.ask("roll_out", name=name, starts=starts.tolist(), steps=steps, h=END / steps)

    def error(found: Any) -> float:
        return float(np.median(np.linalg.norm(np.array(found) - exact, axis=1)))

    exact = ends(1e-10)
    steps = coarsest(STEPS[6:11], lambda count: error(theirs(count)["ends"]), ERROR)
    rtol = coarsest(TOLERANCES[:5], lambda value: error(ends(value)), ERROR)
    race = Race(lambda: seconds(lambda: many(rtol)), lambda: theirs(steps)["seconds"], rounds)
    remark = f"{1e3 * race.ours:.3g} ms with rtol {rtol:.2g} against {1e3 * race.theirs:.3g} ms with {steps} steps"
    return [MANY_GOAL.figure(race.ratio, remark)]


def _build(peers: Peers, count: int) -> str:
    name = f"MuJoCo's chain {count}"
    start = {"gravity": list(GRAVITY), "q": chain_start(count)}
    peers.ask("build_mujoco_chain", name=name, links=chain_links(count), **start)
    return name


def _end(scene: System, count: int, rtol: float) -> np.ndarray:
    """Return where the last link's centre of mass is at the end."""
    run = scene.simulate((0.0, END), output_times=[END], rtol=rtol, progress=False)
    return np.asarray(run.center_of_mass(f"link {count - 1}")[-1])


GROUPS = {
    runs_of_chains: list(RUN_GOALS.values()),
    runs_from_many_starts: [MANY_GOAL],
    calls_of_chains: list(CALL_GOALS.values()),
}
