"""Figures of time at equal error: kanefe's defaults against the peer's best, and against its own best method."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from benchmarks.clocks import Disagreement, Race, fill, repeated
from benchmarks.goals import Figure, Goal
from benchmarks.work_precision.catalogue import SCENES, USUAL
from benchmarks.work_precision.curves import Limits, curve, settled
from benchmarks.work_precision.machine import Machine
from benchmarks.work_precision.peer_curves import PeerScene, peer_curve, peer_run, peer_scenes
from benchmarks.work_precision.references import reference
from benchmarks.work_precision.runs import Point, run
from benchmarks.work_precision.scene import BenchScene, Setting
from benchmarks.work_precision.settings import AUTO, method_names, settings_of, steps_of
from kanefe.equations.model import Model
from kanefe.errors import KanefeError

HINGED = {8: "S3", 16: "S3-16", 32: "S3-32"}
"""Scenes by the number of normal modes."""

HINGED_ERRORS = {1e-4: 0.06, 1e-5: 0.03, 7e-6: 0.03}
"""Goals by the error in m."""

CHAINS = {5: ("S1", 1e-8, 0.7), 20: ("S1-20", 1e-6, 0.3)}
"""Scene, error in m and goal, by the number of links."""

AUTO_ERRORS = (1e-3, 1e-4, 1e-5, 1e-6)
AUTO_LIMIT = 1.5

HINGED_GOALS = {
    (modes, error): Goal(f"S3, {modes} modes: CPU time for {error:g} m / Exudyn's", limit)
    for modes in HINGED
    for error, limit in HINGED_ERRORS.items()
}
CHAIN_GOALS = {
    links: Goal(f"S1, {links} links: CPU time for {error:g} m / Exudyn's", limit)
    for links, (_, error, limit) in CHAINS.items()
}
AUTO_GOALS = {name: Goal(f"{name}: time of auto / best method, equal error", AUTO_LIMIT) for name in USUAL}


def hinged_bars(machine: Machine) -> list[Figure]:
    """Compare the hinged bar with 8, 16 and 32 modes."""
    figures = []
    for modes, name in HINGED.items():
        goals = {error: HINGED_GOALS[modes, error] for error in HINGED_ERRORS}
        figures += _against_peer(machine, SCENES[name](), goals)
    return figures


def chains(machine: Machine) -> list[Figure]:
    """Compare chains of rigid links."""
    figures = []
    for links, (name, error, _) in CHAINS.items():
        figures += _against_peer(machine, SCENES[name](), {error: CHAIN_GOALS[links]})
    return figures


def automatic(machine: Machine) -> list[Figure]:
    """Compare the method that is taken by itself with the best one, scene by scene."""
    figures = []
    for name, goal in AUTO_GOALS.items():
        try:
            figures.append(_auto_figure(SCENES[name](), goal, machine.rounds))
        except (Disagreement, KanefeError) as failure:
            figures.append(goal.skipped(str(failure).partition("\n")[0]))
    return figures


def _against_peer(machine: Machine, scene: BenchScene, goals: dict[float, Goal]) -> list[Figure]:
    """Return the figures of a scene: the best settings for each error are found first, and then run side by side."""
    peers, model = machine.peer(), scene.build()
    exact = reference(scene, model)
    limits = machine.limits
    # the peer's steps are fixed: so may ours be
    ours = [
        p
        for settings in (settings_of(scene, AUTO, limits.quick), steps_of(scene, AUTO, limits.quick))
        for p in curve(scene, settings, exact, limits)
    ]
    theirs = [
        (variant, p)
        for variant in peer_scenes(peers, scene, exact)
        for p in peer_curve(peers, variant, scene, exact, limits)
    ]
    figures = []
    for error, goal in goals.items():
        mine, other = settled(ours, error), settled([p for _, p in theirs], error)
        if mine is None or other is None:
            figures.append(goal.skipped(f"{'kanefe' if mine is None else 'Exudyn'} does not reach it"))
            continue
        variant = next(v for v, p in theirs if p is other)
        race = Race(_clock(model, scene, mine), _peer_clock(machine, variant, scene, other), machine.rounds)
        figures.append(goal.figure(race.ratio, f"{_told(mine, race.ours)}; {other.side} {_told(other, race.theirs)}"))
    return figures


def _auto_figure(scene: BenchScene, goal: Goal, rounds: int) -> Figure:
    """Return the worst ratio over errors that auto reaches."""
    model, limits = scene.build(), Limits(quick=True)
    exact = reference(scene, model)
    # all tolerances, also in a quick run: the next decade takes up to 1.7 times as long, above the limit
    points = [p for name in method_names() for p in curve(scene, settings_of(scene, name), exact, limits)]
    ratios = []
    for error in AUTO_ERRORS:
        best, auto = settled([p for p in points if p.method != AUTO], error), settled(_of(points, AUTO), error)
        if best is None or auto is None:
            continue
        race = Race(_clock(model, scene, auto), _clock(model, scene, best), rounds)
        ratios.append((race.ratio, f"{error:g} m: auto {_told(auto, race.ours)}; {_told(best, race.theirs)}"))
    if not ratios:
        return goal.skipped("auto reaches none of the errors")
    worst, remark = max(ratios)
    return goal.figure(worst, f"worst of {len(ratios)} errors, {remark}")


def _of(points: Sequence[Point], method: str) -> list[Point]:
    return [p for p in points if p.method == method]


def _told(point: Point, seconds: float) -> str:
    chosen = "" if point.chosen == point.method else f" ({point.chosen})"
    return f"{point.method}{chosen}, {point.setting}, {point.error:.1e} m in {1e3 * seconds:.3g} ms"


def _clock(model: Model, scene: BenchScene, point: Point) -> Callable[[], float]:
    """Return the clock of a run of ours, which is repeated where it is short."""
    setting = Setting(point.method, point.rtol, point.step)

    def go() -> None:
        run(model, scene, setting)

    count = fill(go)
    return lambda: repeated(go, count)


def _peer_clock(machine: Machine, variant: PeerScene, scene: BenchScene, point: Point) -> Callable[[], float]:
    setting = Setting(point.method.removesuffix(variant.label), point.rtol, point.step)
    return lambda: float(peer_run(machine.peer(), variant, scene, setting)["seconds"])
