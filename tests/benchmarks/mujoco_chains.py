"""Chains against MuJoCo: a whole run at equal error, and an evaluation that is called from Python."""

from __future__ import annotations

import numpy as np

from benchmarks import engine_scenes as ours
from benchmarks.clocks import Race, check_agreement, coarsest, fill, microseconds, repeated, seconds
from benchmarks.goals import Figure, Goal
from benchmarks.peer_process import Peers
from benchmarks.work_precision.rigid_chain import END, GRAVITY, chain_links, chain_scene, chain_start
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


def _build(peers: Peers, count: int) -> str:
    name = f"MuJoCo's chain {count}"
    start = {"gravity": list(GRAVITY), "q": chain_start(count)}
    peers.ask("build_mujoco_chain", name=name, links=chain_links(count), **start)
    return name


def _end(scene: System, count: int, rtol: float) -> np.ndarray:
    """Return where the last link's centre of mass is at the end."""
    run = scene.simulate((0.0, END), output_times=[END], rtol=rtol, progress=False)
    return np.asarray(run.center_of_mass(f"link {count - 1}")[-1])


GROUPS = {runs_of_chains: list(RUN_GOALS.values()), calls_of_chains: list(CALL_GOALS.values())}
