"""Times at which steps end: those of tables that drive a scene, and where functions of the time change at once."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from kanefe.frames import Matrix
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.stepper import LEAST_STEPS
from kanefe.joints.motion import Motion
from kanefe.joints.rates_over_time import finite_rows, values_at
from kanefe.kernels.steppers.step_commands import FIRST_BREAKPOINT, LAST_KEPT
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

ROUND_OFF = 1e-9
"""Range of a function relative to its values below which it counts as constant."""


def breakpoints_of(dynamics: Dynamics, base: int, changes: np.ndarray) -> np.ndarray:
    """Return the values in `reals` from the place KNOTS, `base`, on, for a run; none where steps end anywhere.

    `changes` are those of `changes_of`. Knots of tables only count where steps that pass over them fail. At changes of
    functions all steps end: nothing is seen of a pulse by a step that passes over it. Where there are such, tables go
    without: one list has one rule.
    """
    breakpoints = changes if len(changes) else _breakpoints_of_tables(dynamics)
    if len(breakpoints) < 2:
        return np.zeros(0)
    head = np.zeros(FIRST_BREAKPOINT)
    head[0] = base + FIRST_BREAKPOINT + 1
    head[LAST_KEPT] = base + FIRST_BREAKPOINT + len(changes) if len(changes) else 0.0
    return np.concatenate((head, breakpoints))


def changes_of(dynamics: Dynamics, start: float, stop: float) -> np.ndarray:
    """Return the start (s) and the times at which steps end since functions of the time change there; none: no times.

    The functions are sampled all through the run. What is shorter than a sample, 1/960 of it, may still be missed; so
    may what functions of the state do.
    """
    moves = dynamics.calls_functions or any(load.motions for load in dynamics.model.loads)
    if not moves or not math.isfinite(stop - start):
        return np.zeros(0)
    times = sample_times(start, stop)
    change = np.zeros(len(times))
    for values in _samples(dynamics, times):
        change = np.maximum(change, _second_differences(values, len(times)))
    ends = {0}
    for first, last in _stretches(change):
        before, after = first - 1, last + 1
        if after - before > LOOKS:  # steps that begin in it see it
            ends |= {before, first, after}
        else:
            ends |= set(np.linspace(before, after, min(PIECES, after - before) + 1).round().astype(int).tolist())
    return times[sorted(ends)] if len(ends) > 1 else np.zeros(0)


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


def _samples(dynamics: Dynamics, times: np.ndarray) -> list[Sequence[Any] | Matrix]:
    """Return the values of what depends on time only: functions of the user, and motions of loads, also of tables.

    Tables of driven joints are left out, since they limit the steps themselves.
    """
    model = dynamics.model
    found: list[Sequence[Any] | Matrix] = [
        values_at(load.value, times)
        for load, _ in loads_with_values(model)
        if not (load.takes_state or load.is_constant or isinstance(load.function, Held))
    ]
    for motion, what in (given for load in model.loads for given in load.motions):
        if motion.pieces is not None:
            found.append(motion.over(np.clip(times, *motion.span), what)[:, :1])
    return found + [accelerations_at(model, motion, times) for motion, _ in model.motions if motion.pieces is None]


def _second_differences(values: Sequence[Any] | Matrix, count: int) -> np.ndarray:
    """Return the largest second difference of samples at each of a count, over their range; zero at both ends, (T,)."""
    found = np.zeros(count)
    sampled = finite_rows(values)
    if (known := len(sampled)) > 2:
        size, extent = np.abs(sampled).max(axis=0), np.ptp(sampled, axis=0)
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
