"""Times at which steps end: those of tables that drive a scene, and where functions of the time change at once."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from kanefe.frames import Matrix, Vector
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.jumps import NO_CHANGES, Changes, jumps_of, without
from kanefe.integrate.stepper import LEAST_STEPS
from kanefe.joints.motion import Motion
from kanefe.joints.rates_over_time import finite_rows, values_at
from kanefe.loads.controller import Held
from kanefe.order_n.tables.inputs import loads_with_values
from kanefe.tree.model_data import ModelData

LOOKS = 32
"""Number of samples of a function of time in the longest step."""

SAMPLES = LEAST_STEPS * LOOKS
"""Number of samples in a run, without the first."""

ABRUPT = 0.5 * (2.0 * math.pi / LOOKS) ** 2
"""Second difference of the samples, relative to their range, from which a step may hide a change: that of a vibration
whose period is the longest step."""

LIVELY = 0.125 * ABRUPT
"""Second difference down to which a change lasts: that of a vibration is below it for a twelfth of its period."""

PAUSE = LOOKS // 8
"""Largest number of successive samples below this within one change."""

PIECES = 8
"""Least number of steps over a change that is no longer than the longest step."""

TOGETHER = 1e-12
"""Time difference of two jumps relative to the run, below which they are one: that of round-off in how a function finds
its time."""

ROUND_OFF = 1e-9
"""Range of a function relative to its values below which it counts as constant."""


def breakpoints_of(dynamics: Dynamics, changes: Changes) -> tuple[np.ndarray, np.ndarray]:
    """Return the breakpoints of a run and the sides before them, s; none where steps end anywhere.

    `changes` are those of `changes_of`. Knots of tables only count where steps that pass over them fail, and have no
    sides. At changes of functions all steps end: nothing is seen of a pulse by a step that passes over it. Where there
    are such, tables go without: one list has one rule.
    """
    breakpoints = changes.ends if len(changes.ends) else _breakpoints_of_tables(dynamics)
    if len(breakpoints) + len(changes.before) < 2:
        return np.zeros(0), np.zeros(0)
    return breakpoints, changes.before


def changes_of(dynamics: Dynamics, start: float, stop: float) -> Changes:
    """Return the times at which steps end since functions of the time change there.

    The functions are sampled all through the run, and their jumps found between the samples. What is shorter than a
    sample, 1/960 of it, may still be missed; so may what functions of the state do.
    """
    moves = dynamics.calls_functions or any(load.motions for load in dynamics.model.loads)
    if not moves or not math.isfinite(stop - start):
        return NO_CHANGES
    began, times = time.perf_counter(), sample_times(start, stop)
    change = np.zeros(len(times))
    jumps = {start: start}
    for function, values in _of_users(dynamics, times):
        rows = finite_rows(values)
        own = jumps_of(function, times, rows)
        jumps |= dict(zip(own.after.tolist(), own.before.tolist(), strict=True))
        change = np.maximum(change, _second_differences(without(own, times, rows), rows, len(times)))
    for motion, what in (given for load in dynamics.model.loads for given in load.motions):
        if motion.pieces is not None:
            rows = motion.over(np.clip(times, *motion.span), what)[:, :1]
            kinks, rest = _kinks(motion.pieces, times, rows)
            jumps |= {t: math.nextafter(t, -math.inf) for t in kinks.tolist() if start < t < stop}
            change = np.maximum(change, _second_differences(rest, rows, len(times)))
    ends = set[int]()
    for first, last in _stretches(change):
        before, after = first - 1, last + 1
        if after - before > LOOKS:  # steps that begin in it see it
            ends |= {before, first, after}
        else:
            ends |= set(np.linspace(before, after, min(PIECES, after - before) + 1).round().astype(int).tolist())
    beside = {t: t for t in times[sorted(ends)].tolist()} | jumps
    if len(beside) < 2:
        return NO_CHANGES._replace(seconds=time.perf_counter() - began)
    found = np.array(sorted(_apart(beside, stop - start).items()))
    return Changes(found[:, 0], found[:, 1], time.perf_counter() - began)


def _apart(jumps: dict[float, float], span: float) -> dict[float, float]:
    """Return times of changes, and those before them, without those that differ from one before by round-off alone.

    Two functions that jump at the same time may do so at numbers beside each other: they jump together then.
    """
    found = dict[float, float]()
    last = -math.inf
    for after, before in sorted(jumps.items()):
        if before - last > TOGETHER * span:
            found[after], last = before, after
        elif last in found:
            found[after] = min(found.pop(last), before)
            last = after
    return found


def sample_times(start: float, stop: float) -> np.ndarray:
    """Return the times at which functions of time are sampled before a run from start to stop, s."""
    return np.linspace(start, stop, SAMPLES + 1)


def accelerations_at(model: ModelData, motion: Motion, times: np.ndarray) -> Matrix:
    """Return what the acceleration of a motion gives at times, up to the first where it gives no number, (T, 1).

    The model keeps it from one question of a run to the next: see `kanefe.integrate.set_up.check_motions`.
    """
    key = (id(motion), float(times[0]), float(times[-1]))
    if key not in model.looks and motion.acceleration is not None:
        model.looks[key] = finite_rows(values_at(motion.acceleration, times))
    return model.looks[key]


def _of_users(dynamics: Dynamics, times: np.ndarray) -> list[tuple[Callable[[float], Any], Sequence[Any] | Matrix]]:
    """Return the functions of the user that depend on time only, with their values.

    Of driven joints the accelerations. Tables of theirs are left out, since they limit the steps themselves.
    """
    model = dynamics.model
    found: list[tuple[Callable[[float], Any], Sequence[Any] | Matrix]] = [
        (load.function, values_at(load.value, times))
        for load, _ in loads_with_values(model)
        if not (load.takes_state or load.is_constant or isinstance(load.function, Held))
    ]
    for motion, _ in model.motions:
        if motion.pieces is None and motion.acceleration is not None:
            found.append((motion.acceleration, accelerations_at(model, motion, times)))
    return found


def _kinks(pieces: Matrix, times: np.ndarray, rows: Matrix) -> tuple[Vector, Matrix]:
    """Return where the rate of a motion jumps between its pieces, s, and samples of its position as without that.

    That is where samples would see it too.
    """
    width = np.diff(pieces[:, 0])
    jumps = pieces[1:, 2] - (pieces[:-1, 2] + width * (2.0 * pieces[:-1, 3] + 3.0 * width * pieces[:-1, 4]))
    is_kink = np.abs(jumps) * (times[1] - times[0]) > LIVELY * np.ptp(rows)
    kinks = pieces[1:, 0][is_kink]
    rest = rows.copy()
    for t, jump in zip(kinks.tolist(), jumps[is_kink].tolist(), strict=True):
        rest[:, 0] -= jump * np.maximum(times - t, 0.0)
    return kinks, rest


def _second_differences(sampled: Matrix, given: Matrix, count: int) -> np.ndarray:
    """Return the largest second difference of samples at each of a count, zero at both ends, (T,).

    Relative to the range of those that are given, of which jumps may have been taken out.
    """
    found = np.zeros(count)
    if (known := len(sampled)) > 2:
        size, extent = np.abs(given).max(axis=0), np.ptp(given, axis=0)
        sampled = sampled[:, extent > ROUND_OFF * size] / extent[extent > ROUND_OFF * size]
        found[1 : known - 1] = np.abs(np.diff(sampled, 2, axis=0)).max(axis=1, initial=0.0)
    return found


def _stretches(change: np.ndarray) -> list[tuple[int, int]]:
    """Return the first and last number of the samples of each change, in order."""
    lively = np.flatnonzero(change > LIVELY)
    parts = np.split(lively, np.flatnonzero(np.diff(lively) > PAUSE) + 1)
    return [(int(part[0]), int(part[-1])) for part in parts if len(part) and change[part].max() > ABRUPT]


def _breakpoints_of_tables(dynamics: Dynamics) -> np.ndarray:
    """Return the breakpoints of the tables that drive a scene, s."""
    tables = [motion.pieces[:, 0] for motion, _ in dynamics.model.motions if motion.pieces is not None]
    breakpoints = np.unique(np.concatenate([table for table in tables if len(table) > 1] or [np.zeros(0)]))
    if len(breakpoints) < 2:
        return np.zeros(0)
    # two tables of the same times may differ by round-off
    return np.asarray(
        breakpoints[np.concatenate(([True], np.diff(breakpoints) > 1e-9 * (breakpoints[-1] - breakpoints[0])))]
    )
