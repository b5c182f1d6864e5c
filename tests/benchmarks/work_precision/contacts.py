"""Figures of contacts: what sticks for twenty minutes, onset of slip, energy, and balls on a plane against Exudyn."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import cache, partial
from typing import Any, NamedTuple

from benchmarks.clocks import Race, check_agreement, fill, repeated
from benchmarks.goals import Figure, Goal
from benchmarks.peer_process import NoPeers
from benchmarks.work_precision.balls import (
    BOUNCING,
    DROPPED,
    ROLLING,
    Ball,
    bouncing_ball,
    dropped_ball,
    rolled_way,
    rolling_ball,
)
from benchmarks.work_precision.good_enough import fastest
from benchmarks.work_precision.machine import Machine
from benchmarks.work_precision.scene import Setting
from benchmarks.work_precision.settings import AUTO, TOLERANCES
from kanefe.checks.robustness.case import Effort
from kanefe.checks.verification.contact import GRAVITY, INCLINE, block_on_incline, run_of
from kanefe.integrate.run import integrate
from robustness.contact import balances, holding

STICKING_GOAL = Goal("K01, K01b, 1,200 s of shaking, rtol 1e-3 and 1e-8: largest slip [m]", 1e-12)
ONSET_GOAL = Goal("F01a, onset of slip, k = 1e7 N/m: error [s]", 1e-6)
RATE_GOAL = Goal("the same: distance from 1 of the power of 1 / k by which it falls", 0.05)
ENERGY_GOALS = {
    "block": Goal("K02, rtol 1e-10: energy not accounted for / work done", 1e-8),
    "ball": Goal("K08, rtol 1e-10: energy not accounted for / work done", 1e-8),
}
DROPPED_GOALS = {1e-6: Goal("ball that bounces on 1e5 N/m for 3 s: CPU time for 1e-06 m / Exudyn's", 1.0)}
BOUNCING_GOALS = {
    error: Goal(f"ball that bounces and slips: CPU time for {error:g} m / Exudyn's", 1.0) for error in (1e-4, 1e-6)
}
ROLLING_GOALS = {
    error: Goal(f"ball that slides and rolls: CPU time for {error:g} m / Exudyn's", 0.1) for error in (1e-4, 1e-5)
}

ONSET_STIFFNESS = 1e6, 1e7
FINEST = Setting("vern9", rtol=1e-12)
PEER_FINEST = Setting("dopri5", rtol=1e-11)
PEER_ZONES = 1e-2, 1e-3, 1e-4
"""Speeds below which Exudyn's friction is viscous, m/s; the second is its default."""

ALIKE = 1e-5
"""Relative difference of both sides' finest runs: steps of the peer do not end where a ball touches."""

STIFFER = 1e6, 1e7, 1e8
"""Contact stiffnesses of the slope on which a ball rolls, N/m: stiffer ones are closer to rigid."""


def sticking(machine: Machine) -> list[Figure]:
    """Hold a block on a slope that is shaken; in a quick run for 20 s."""
    found = list(holding(Effort(is_quick=machine.limits.quick), rtols=(1e-3, 1e-8)))
    worst = max(found, key=lambda finding: finding.worst)
    alike = "all alike" if len({finding.worst for finding in found}) == 1 else "not all alike"
    return [STICKING_GOAL.figure(worst.worst, f"{len(found)} runs, {alike}; worst: {worst.tried}")]


def late_on_incline(stiffness: float) -> float:
    """Return the error of the time at which the block of F01a begins to slip, against a rigid slope, s."""
    result = run_of(block_on_incline(stiffness), 0.7, 1e-9)
    (slip,) = (time for time in result.events["c slip"] if time > 0.1)
    limit = GRAVITY * (0.3 * math.cos(INCLINE) - math.sin(INCLINE))  # m/s2 down the slope
    rigid = 0.5 + math.asin(limit / (0.1 * (2.0 * math.pi) ** 2)) / (2.0 * math.pi)
    return abs(float(slip) - rigid)


def onset(machine: Machine) -> list[Figure]:
    """Compare the first slip of a block on a slope that moves with that of a rigid one, at two stiffnesses."""
    errors = [late_on_incline(stiffness) for stiffness in ONSET_STIFFNESS]
    rate = math.log10(errors[0] / errors[1])
    told = ", ".join(f"{error:.2g} s at {k:g} N/m" for k, error in zip(ONSET_STIFFNESS, errors, strict=True))
    return [ONSET_GOAL.figure(errors[1], told), RATE_GOAL.figure(abs(rate - 1.0), f"power {rate:.4f}")]


def energy(machine: Machine) -> list[Figure]:
    """Account for the energy of a block that stops and of a ball that comes to rest."""
    found = list(balances(Effort(is_quick=machine.limits.quick)))
    return [
        goal.figure(finding.worst, finding.tried)
        for finding in found
        for name, goal in ENERGY_GOALS.items()
        if finding.tried.startswith(name)
    ]


class _Trial(NamedTuple):
    """A ball as one program has it.

    Attributes
    ----------
    name : str
    place : callable
        Setting -> x and z of its centre at the end of a run, m.
    clock : callable
        Setting -> seconds of CPU of a run.
    """

    name: str
    place: Callable[[Setting], list[float]]
    clock: Callable[[Setting], float]


def dropped(machine: Machine) -> list[Figure]:
    """Compare a ball that bounces upright: the same forces in both programs, and so the same motion."""
    return _same_motion(machine, "dropped", dropped_ball(), DROPPED, DROPPED_GOALS)


def bouncing(machine: Machine) -> list[Figure]:
    """Compare a ball that slips at each bounce, so that friction is the same force in both programs."""
    return _same_motion(machine, "bouncing", bouncing_ball(), BOUNCING, BOUNCING_GOALS)


def _same_motion(machine: Machine, name: str, ball: Ball, end: float, goals: dict[float, Goal]) -> list[Figure]:
    ours, theirs = _own(ball, end), _peer(machine, name, ball, 1e-3, end)
    exact = ours.place(FINEST)
    check_agreement(f"ball, {name}", exact, theirs.place(PEER_FINEST), ALIKE)
    return _raced(machine, [ours], [theirs], lambda place: math.dist(place, exact), goals)


def rolling(machine: Machine) -> list[Figure]:
    """Compare a ball that slides down a slope until it rolls, with that on a rigid slope."""
    ours = [_own(rolling_ball(stiffness), ROLLING) for stiffness in STIFFER]
    theirs = [
        _peer(machine, f"rolling {stiffness:g} {zone:g}", rolling_ball(stiffness), zone, ROLLING)
        for stiffness in STIFFER
        for zone in PEER_ZONES
    ]
    return _raced(machine, ours, theirs, lambda place: abs(place[0] - rolled_way()), ROLLING_GOALS)


def _own(ball: Ball, end: float) -> _Trial:
    model = ball.model()

    def place(setting: Setting) -> list[float]:
        found = integrate(model, (0.0, end), output_step=end, progress=False, **setting.options)
        found.raise_for_status()
        return [float(found.coordinates[-1, i]) for i in (0, 2)]

    def clock(setting: Setting) -> float:
        return repeated(lambda: place(setting), fill(lambda: place(setting), 0.02))

    return _Trial(f"k {ball.stiffness:g} N/m", place, clock)


def _peer(machine: Machine, name: str, ball: Ball, zone: float, end: float) -> _Trial:
    peers = machine.peer()
    peers.ask("build_ball", name=name, zone=zone, ball=ball.request)

    ran = partial(_ran, machine, name, end)

    def place(setting: Setting) -> list[float]:
        x, _, z = ran(setting)["end"]
        return [x, z]

    told = f"k {ball.stiffness:g} N/m, friction viscous below {zone:g} m/s"
    return _Trial(told, place, lambda setting: float(ran(setting)["seconds"]))


def _ran(machine: Machine, name: str, end: float, setting: Setting) -> dict[str, Any]:
    size = {"rtol": setting.rtol} if setting.step is None else {"step": setting.step}
    return machine.peer().ask("solve", name=name, method=setting.method, end=end, **size)


def _raced(
    machine: Machine,
    ours: Sequence[_Trial],
    theirs: Sequence[_Trial],
    far: Callable[[list[float]], float],
    goals: dict[float, Goal],
) -> list[Figure]:
    """Return the figures: the fastest of each side that is near enough, side by side."""
    coarse = 2 if machine.limits.quick else 1
    own = [[Setting(AUTO, rtol=rtol) for rtol in TOLERANCES[1:15:coarse]]]
    peer = [
        [Setting("generalised-alpha", step=1e-2 / 2**i) for i in range(0, 9, coarse)],
        [Setting("dopri5", rtol=rtol) for rtol in TOLERANCES[1:17:coarse]],
    ]
    sides = [(_errors(ours, far), own), (_errors(theirs, far), peer)]
    figures = []
    for allowed, goal in goals.items():
        try:
            (mine, a), (other, b) = (_best(errors, curves, allowed) for errors, curves in sides)
        except NoPeers as failure:
            figures.append(goal.skipped(str(failure)))
            continue
        race = Race(partial(mine.clock, a), partial(other.clock, b), machine.rounds)
        told = f"{a.text}, {mine.name}, {1e3 * race.ours:.3g} ms"
        told += f"; Exudyn, {b.text}, {other.name}, {1e3 * race.theirs:.3g} ms"
        figures.append(goal.figure(race.ratio, told))
    return figures


Errors = list[tuple[_Trial, Callable[[Setting], float]]]


def _errors(trials: Sequence[_Trial], far: Callable[[list[float]], float]) -> Errors:
    """Return with each trial the error of a setting, which is found once."""
    return [(trial, cache(lambda setting, trial=trial: far(trial.place(setting)))) for trial in trials]


def _best(trials: Errors, curves: list[list[Setting]], allowed: float) -> tuple[_Trial, Setting]:
    """Return the fastest of all trials that are near enough."""
    found: list[tuple[float, int, _Trial, Setting]] = []
    for trial, error in trials:
        with suppress(NoPeers):
            setting = fastest(curves, partial(_share, error, allowed), trial.clock)
            found.append((trial.clock(setting), len(found), trial, setting))
    if not found:
        raise NoPeers(f"none comes within {allowed:g} m")
    return min(found)[2:]


def _share(error: Callable[[Setting], float], allowed: float, setting: Setting) -> float:
    return error(setting) / allowed
