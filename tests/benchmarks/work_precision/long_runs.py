"""Figures of whole runs: the peak of the spin-up, what tumbling conserves, free flight, and the test suite."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from dataclasses import replace

import numpy as np

from benchmarks.clocks import FEW_ROUNDS, Race, seconds
from benchmarks.goals import Figure, Goal
from benchmarks.work_precision import spinning_arm, steel_bar
from benchmarks.work_precision.good_enough import coarsest, fastest
from benchmarks.work_precision.machine import Machine
from benchmarks.work_precision.peer_curves import (
    BEAM_ELEMENTS,
    GENERALISED_ALPHA,
    PeerScene,
    beam_scene,
    free_scene,
    of_steps,
    peer_run,
    sampled,
)
from benchmarks.work_precision.runs import run
from benchmarks.work_precision.scene import BenchScene, Setting
from benchmarks.work_precision.settings import AUTO, settings_of
from kanefe.checks.robustness.case import Effort
from kanefe.checks.robustness.drift import free_flight as flights
from kanefe.checks.robustness.drift import invariants
from kanefe.equations.model import Model
from kanefe.integrate.methods.table import METHODS

SPIN_UP_GOAL = Goal("S2, spin-up with stiffening: CPU time for the peak to 0.5 % / Exudyn's", 0.3)
TUMBLING_GOAL = Goal("S4, 10 s: CPU time for drifts of 1e-6 and 1e-7 / Exudyn's for 5e-6 and 5e-5", 0.03)
FLIGHT_GOAL = Goal("free flight, energy-momentum, 1e6 steps: relative drift", 1e-10)
SUITE_GOAL = Goal("whole test suite on 2 cores [min]", 10.0)

PEAK_TOLERANCE = 5e-3
LONG = 10.0
"""Duration of S4, s."""

SAMPLES = 100
OUR_DRIFTS, PEER_DRIFTS = (1e-6, 1e-7), (5e-6, 5e-5)
"""Relative drifts of energy and of angular momentum."""

FLIGHT_METHOD = "energy-momentum"
CONSERVING = ("extrapolation", "energy-momentum")
"""Methods whose fixed steps are tried on S4 in addition to the tolerances of auto."""

PATIENCE = 30.0
"""Wall-clock time after which a run of S4 is given up, s."""
SUITE_CORES = 2


def spin_up(machine: Machine) -> list[Figure]:
    """Compare the reduced arm with the peer's geometrically exact beam of four elements, both just good enough."""
    peers, scene = machine.peer(), spinning_arm.spinning_arm(4, "S2")
    model, every = scene.build(), scene.end / scene.outputs

    def own_error(setting: Setting) -> float:
        return _peak_error(scene.measured(model, run(model, scene, setting)))

    def peer_error(setting: Setting) -> float:
        return _peak_error(sampled(peer_run(peers, beam, scene, setting, every), scene))

    beam = beam_scene(peers, scene, BEAM_ELEMENTS[0])
    mine, own = coarsest(settings_of(scene, AUTO), own_error, PEAK_TOLERANCE)
    other, theirs = coarsest(beam.settings, peer_error, PEAK_TOLERANCE)
    race = Race(
        lambda: seconds(lambda: run(model, scene, mine)),
        lambda: peer_run(peers, beam, scene, other)["seconds"],
        machine.rounds,
    )
    remark = (
        f"{mine.text}: {100 * own:.2g} % in {1e3 * race.ours:.3g} ms; Exudyn, {BEAM_ELEMENTS[0]} elements, "
        f"{other.text}: {100 * theirs:.2g} % in {1e3 * race.theirs:.3g} ms"
    )
    return [SPIN_UP_GOAL.figure(race.ratio, remark)]


def tumbling(machine: Machine) -> list[Figure]:
    """Compare how long it takes to keep energy and angular momentum of the tumbling bar for 10 s."""
    if machine.limits.quick:
        return [TUMBLING_GOAL.skipped("the peer's runs take minutes, which is too long for a quick run")]
    peers = machine.peer()
    scene = replace(steel_bar.tumbling(), end=LONG, outputs=SAMPLES)
    model = scene.build()
    bar = free_scene(peers, scene)

    def own_excess(setting: Setting) -> float:
        return _excess(_own_drifts(model, scene, setting), OUR_DRIFTS)

    def peer_excess(setting: Setting) -> float:
        return _excess(_peer_drifts(machine, bar, scene, setting), PEER_DRIFTS)

    def own_seconds(setting: Setting) -> float:
        return seconds(lambda: run(model, scene, setting))

    def peer_seconds(setting: Setting) -> float:
        return float(peer_run(peers, bar, scene, setting)["seconds"])

    # whole steps between outputs: what is kept is kept at steps
    by_steps = [[Setting(name, step=2e-2 / 2**i) for i in range(9)] for name in CONSERVING if name in METHODS]
    mine = fastest([settings_of(scene, AUTO), *by_steps], own_excess, own_seconds)
    peer_settings = [of_steps(GENERALISED_ALPHA, 4e-4, 5e-5), of_steps("rk4", 1.2e-4, 3e-5)]
    other = fastest(peer_settings, peer_excess, peer_seconds)
    race = Race(lambda: own_seconds(mine), lambda: peer_seconds(other), FEW_ROUNDS)
    drifts = _own_drifts(model, scene, mine)
    remark = (
        f"{mine.text}: {drifts[0]:.1e} and {drifts[1]:.1e} in {1e3 * race.ours:.3g} ms; "
        f"Exudyn, {other.text}, in {race.theirs:.3g} s"
    )
    return [TUMBLING_GOAL.figure(race.ratio, remark)]


def free_flight(machine: Machine) -> list[Figure]:
    """Follow the invariants of free flight over a million steps; a drift that grows misses the goal."""
    if FLIGHT_METHOD not in METHODS:
        return [FLIGHT_GOAL.skipped(f"there is no method {FLIGHT_METHOD!r}")]
    found = list(flights(Effort(is_quick=machine.limits.quick, method=FLIGHT_METHOD)))
    worst = max(found, key=lambda finding: finding.worst / finding.limit)
    steps = max(finding.count for finding in found)
    return [FLIGHT_GOAL.figure(worst.worst, f"{steps:.0e} steps; worst: {worst.figure} of {worst.tried}")]


def suite_time(machine: Machine) -> list[Figure]:
    """Time the tests of a repository by the clock on the wall."""
    if machine.tests is None:
        return [SUITE_GOAL.skipped("asked for by --tests REPOSITORY")]
    cores = sorted(machine.all_cores)[:SUITE_CORES]
    command = [sys.executable, "-m", "pytest", "-q"]

    def on_its_cores() -> None:
        if cores:
            os.sched_setaffinity(0, cores)

    start = time.perf_counter()
    done = subprocess.run(
        command, cwd=machine.tests, capture_output=True, text=True, check=False, preexec_fn=on_its_cores
    )
    minutes = (time.perf_counter() - start) / 60.0
    last = (done.stdout.strip().splitlines() or ["no output"])[-1]
    if done.returncode:
        return [SUITE_GOAL.skipped(f"the tests fail after {minutes:.1f} min: {last}")]
    return [SUITE_GOAL.figure(minutes, last)]


def _peak_error(values: np.ndarray) -> float:
    return abs(spinning_arm.peak(values) / spinning_arm.PEAK - 1.0)


def _excess(drifts: tuple[float, float], allowed: tuple[float, float]) -> float:
    """Return the largest drift as a part of what is allowed."""
    return max(a / b for a, b in zip(drifts, allowed, strict=True))


def _drifts(energy: np.ndarray, angular: np.ndarray) -> tuple[float, float]:
    """Return the largest relative changes of an energy (T,) and an angular momentum (T, 3)."""
    turned = np.linalg.norm(angular - angular[0], axis=1).max() / np.linalg.norm(angular[0])
    return float(np.abs(energy / energy[0] - 1.0).max()), float(turned)


def _own_drifts(model: Model, scene: BenchScene, setting: Setting) -> tuple[float, float]:
    energy, _, angular = invariants(model, run(model, scene, setting, PATIENCE))
    return _drifts(energy, angular)


def _peer_drifts(machine: Machine, bar: PeerScene, scene: BenchScene, setting: Setting) -> tuple[float, float]:
    answer = peer_run(machine.peer(), bar, scene, setting, scene.end / SAMPLES)
    rows = np.array(answer["samples"])
    return _drifts(rows[:, 1], rows[:, 2:5])
