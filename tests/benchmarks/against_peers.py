"""Figures against the peers: chains of rigid links, and a tumbling flexible body."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import engine_scenes as ours
from benchmarks import loops
from benchmarks.clocks import Race, check_agreement, fill, microseconds, repeated, seconds
from benchmarks.goals import Figure, Goal
from benchmarks.peer_process import Peers
from benchmarks.work_precision.peer_curves import save_matrices
from benchmarks.work_precision.rigid_chain import GRAVITY, chain_links, chain_scene, chain_start
from benchmarks.work_precision.steel_bar import FREE_MODES, bar_model, free_start
from kanefe.checks.verification.scenes import frame_at

# By the number of links. The peer needs some 0.1 s for each run of so many steps.
CHAIN_STEPS = {1: 40000, 5: 10000, 20: 2000, 100: 50}
CHAIN_GOALS = {
    count: Goal(f"S1 rigid chain, N={count}: time of an RK4 step / Exudyn's", limit)
    for count, limit in ((1, 0.05), (5, 0.07), (20, 0.05), (100, 0.018))
}
CALL_GOALS = {
    count: Goal(f"S1 right-hand side, N={count}: time / Pinocchio's aba", limit)
    for count, limit in ((20, 0.6), (100, 0.3))
}
BODY_GOAL = Goal(f"S4 tumbling body, {FREE_MODES} modes: time of an RK4 step / Exudyn's", 0.3)
MIXED_GOAL = Goal("100 rigid bodies and 10 flexible: time of a generalised-alpha step / Exudyn's", 0.1)
MIXED_LINKS, MIXED_BARS, MIXED_STEPS = 100, 10, 50
CAR_STEP_GOAL = Goal("car on four loops: time of a generalised-alpha step / Exudyn's", 0.1)
CAR_ERROR_GOAL = Goal("car on four loops, an upright to 1e-6 m: time / Exudyn's", 0.1)
CAR_REST, CAR_END, CAR_STEPS, CAR_ERROR = 0.3, 0.5, (200, 100), 1e-6  # rad, s, steps of ours and theirs, m
CLOSE = 1e-5
"""Largest relative difference of positions: the peer closes joints to the tolerance of its iteration."""

BAR_CELLS = (10, 2, 1)
BAR_STEP = 5e-5


def rigid_chains(peers: Peers, rounds: int) -> list[Figure]:
    """Compare steps of the chain with the peer's tree in joint coordinates, both with the same method and step."""
    figures = []
    for count, steps in CHAIN_STEPS.items():
        model = chain_scene(count).freeze()
        name = f"chain {count}"
        _build_chain(peers, name, count)
        check_agreement(
            name, ours.run(model, 50)[-3:], peers.ask("solve", name=name, steps=50, h=ours.STEP)["end"][-3:]
        )
        race = Race(
            lambda m=model, s=steps: seconds(lambda: ours.run(m, s)) / s,
            lambda n=name, s=steps: peers.ask("solve", name=n, steps=s, h=ours.STEP)["seconds"] / s,
            rounds,
        )
        remark = f"{microseconds(race.ours)} a step against {microseconds(race.theirs)}"
        figures.append(CHAIN_GOALS[count].figure(race.ratio, remark))
    return figures


def articulated_bodies(peers: Peers, rounds: int) -> list[Figure]:
    """Compare one right-hand side of the chain with Pinocchio's forward dynamics, both called from Python."""
    figures = []
    for count, goal in CALL_GOALS.items():
        model = chain_scene(count).freeze()
        evaluate = ours.evaluation(model)
        name = f"chain {count}"
        _build_chain(peers, name, count)
        check_agreement(name, evaluate()[count:], peers.ask("call", name=name, count=1)["end"])
        calls = fill(evaluate)
        race = Race(
            lambda f=evaluate, c=calls: repeated(f, c),
            lambda n=name, c=calls: peers.ask("call", name=n, count=c)["seconds"] / c,
            rounds,
        )
        remark = f"{microseconds(race.ours)} a call from Python against {microseconds(race.theirs)}"
        figures.append(goal.figure(race.ratio, remark))
    return figures


def tumbling_body(peers: Peers, rounds: int) -> list[Figure]:
    """Compare steps of a free flexible body with the peer's floating frame with as many modes of the same matrices."""
    full = bar_model(BAR_CELLS)
    model = ours.free_bar(full)
    velocity, omega = free_start()
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "bar.npz"
        save_matrices(full, file)
        peers.ask(
            "build_flexible",
            name="bar",
            file=str(file),
            modes=FREE_MODES,
            velocity=velocity,
            omega=omega,
        )
    run: dict[str, Any] = {"name": "bar", "h": BAR_STEP}
    check_agreement("bar", ours.run(model, 400, BAR_STEP)[:3], peers.ask("solve", steps=400, **run)["end"])
    steps = 2000
    race = Race(
        lambda: seconds(lambda: ours.run(model, steps, BAR_STEP)) / steps,
        lambda: peers.ask("solve", steps=steps, **run)["seconds"] / steps,
        rounds,
    )
    remark = f"{microseconds(race.ours)} a step against {microseconds(race.theirs)}; {len(full.nodes)} nodes"
    return [BODY_GOAL.figure(race.ratio, remark)]


def implicit_steps(peers: Peers, rounds: int) -> list[Figure]:
    """Compare steps of generalised-alpha of a long chain and flexible bodies; the peer has redundant coordinates."""
    full = bar_model(BAR_CELLS)
    model = ours.mixed(MIXED_LINKS, MIXED_BARS, full)
    velocity, omega = free_start()
    chain = {"links": chain_links(MIXED_LINKS), "gravity": list(GRAVITY), "q": chain_start(MIXED_LINKS)}
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "bar.npz"
        save_matrices(full, file)
        bars = {"file": str(file), "modes": FREE_MODES, "count": MIXED_BARS, "velocity": velocity, "omega": omega}
        peers.ask("build_mixed", name="mixed", chain=chain, bars=bars)
    request: dict[str, Any] = {"name": "mixed", "h": ours.STEP, "steps": MIXED_STEPS}

    def steps() -> np.ndarray:
        return ours.run(model, MIXED_STEPS, method="generalised-alpha")

    q = steps()
    end = MIXED_STEPS * ours.STEP
    link = frame_at(model, f"link {MIXED_LINKS - 1}", (end, q, np.zeros(model.free_count)))
    last = link.p_NoFo_N + link.A_NF @ np.array(chain["links"][-1]["com"])
    free = next(body for body in model.bodies if body.name == f"bar {MIXED_BARS - 1}").free_coordinates()[0][:3]
    check_agreement("mixed", [*last, *q[free]], peers.ask("solve", **request)["end"], CLOSE)
    race = Race(
        lambda: seconds(steps) / MIXED_STEPS, lambda: peers.ask("solve", **request)["seconds"] / MIXED_STEPS, rounds
    )
    remark = f"{microseconds(race.ours)} a step against {microseconds(race.theirs)}"
    return [MIXED_GOAL.figure(race.ratio, remark)]


def car_on_loops(peers: Peers, rounds: int) -> list[Figure]:
    """Compare a car on four loops: a step of generalised-alpha, and the time to an error of 1e-6 m."""
    scene = loops.car(True, CAR_REST)
    car = {
        "gravity": list(map(float, scene.gravity)),
        "position": [0.0, 0.0, 0.5],
        "corners": list(loops.CORNERS.values()),
        "chassis": {"mass": 1200.0, "inertia": [300.0, 1500.0, 1700.0], "com": [0.0, 0.0, 0.0]},
        "lower arm": {"mass": 5.0, "inertia": [0.1, 0.05, 0.1], "com": [0.0, 0.15, 0.0]},
        "upper arm": {"mass": 3.0, "inertia": [0.05, 0.03, 0.05], "com": [0.0, 0.12, 0.0]},
        "upright": {"mass": 15.0, "inertia": [0.3, 0.3, 0.3], "com": [0.0, 0.0, 0.1]},
        "wheel": {"mass": 18.0, "inertia": [0.5, 0.9, 0.5], "com": [0.0, 0.0, 0.0]},
        "spring": {**loops.SPRING, "rest": CAR_REST},
        "spin": 30.0,
        "rod": 0.3,
    }
    peers.ask("build_car", name="car", car=car)
    last = f"{list(loops.CORNERS)[-1]} upright"

    def run(**how: Any) -> np.ndarray:
        found = scene.simulate((0.0, CAR_END), output_times=[CAR_END], **how)
        return np.asarray(found.center_of_mass(last)[-1])

    mine, theirs = CAR_STEPS
    fixed = {"method": "generalised-alpha", "step": CAR_END / mine}
    true = run(rtol=1e-11)
    answer = peers.ask("solve", name="car", steps=theirs, h=CAR_END / theirs)
    for end in (run(**fixed), run(), answer["end"]):
        check_agreement("car on four loops", true, end, CAR_ERROR)

    def solve() -> float:
        return float(peers.ask("solve", name="car", steps=theirs, h=CAR_END / theirs)["seconds"])

    step = Race(lambda: seconds(lambda: run(**fixed)) / mine, lambda: solve() / theirs, rounds)
    whole = Race(lambda: seconds(run), solve, rounds)
    return [
        CAR_STEP_GOAL.figure(step.ratio, f"{microseconds(step.ours)} against {microseconds(step.theirs)}"),
        CAR_ERROR_GOAL.figure(whole.ratio, f"{microseconds(whole.ours)} against {microseconds(whole.theirs)}"),
    ]


def _build_chain(peers: Peers, name: str, count: int) -> None:
    peers.ask(
        "build_chain",
        name=name,
        links=chain_links(count),
        gravity=list(GRAVITY),
        q=chain_start(count),
    )


GROUPS = {
    rigid_chains: list(CHAIN_GOALS.values()),
    articulated_bodies: list(CALL_GOALS.values()),
    tumbling_body: [BODY_GOAL],
    implicit_steps: [MIXED_GOAL],
    car_on_loops: [CAR_STEP_GOAL, CAR_ERROR_GOAL],
}
