"""Times at which steps end: those of tables that drive a scene, and where functions of the time change at once."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import numpy as np

from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.stepper import LEAST_STEPS
from kanefe.kernels.stepping import FIRST_KNOT, LAST_KEPT
from kanefe.loads.controller import Held
from kanefe.order_n.inputs import loads_with_values

LOOKS = 32
"""Samples of a function of the time in the longest step."""

SAMPLES = LEAST_STEPS * LOOKS
"""Of a run, but for the first."""

SUDDEN = 0.5 * (2.0 * math.pi / LOOKS) ** 2
"""Second difference of the samples, over their range, from which on a change may hide in a step: that of a vibration
with a period as long as the longest step."""

LIVELY = 0.125 * SUDDEN
"""And down to which it lasts, about what is sudden: a vibration falls below it for a twelfth of its period."""

PAUSE = LOOKS // 8
"""Samples with less than that within a change, at most."""

PIECES = 8
"""Steps at least over a change that is no longer than the longest step."""

ROUND_OFF = 1e-9
"""Of its values: a function with less range is taken for constant."""


def knots_of(dynamics: Dynamics, base: int, changes: np.ndarray) -> np.ndarray:
    """Return what stands in `reals` from the place KNOTS, `base`, on, for a run; nothing where steps end anywhere.

    `changes` are those of `changes_of`. Knots of tables only count where steps that pass over them fail. At changes of
    functions all steps end: nothing is seen of a pulse by a step that passes over it. Where there are such, tables go
    without: one list has one rule.
    """
    knots = changes if len(changes) else _knots_of_tables(dynamics)
    if len(knots) < 2:
        return np.zeros(0)
    head = np.zeros(FIRST_KNOT)
    head[0] = base + FIRST_KNOT + 1
    head[LAST_KEPT] = base + FIRST_KNOT + len(changes) if len(changes) else 0.0
    return np.concatenate((head, knots))


def changes_of(dynamics: Dynamics, start: float, stop: float) -> np.ndarray:
    """Return the start (s) and the times at which steps end since functions of the time change there; none: no times.

    The functions are sampled all through the run. What is shorter than a sample, 1/960 of it, may still be missed; so
    may what functions of the state do.
    """
    functions = _functions_of_time(dynamics)
    if not functions or not math.isfinite(stop - start):
        return np.zeros(0)
    times = np.linspace(start, stop, SAMPLES + 1)
    change = np.zeros(len(times))
    for function in functions:
        change = np.maximum(change, _second_differences(function, times))
    ends = {0}
    for first, last in _stretches(change):
        before, after = first - 1, last + 1
        if after - before > LOOKS:  # steps that begin in it see it
            ends |= {before, first, after}
        else:
            ends |= set(np.linspace(before, after, min(PIECES, after - before) + 1).round().astype(int).tolist())
    return times[sorted(ends)] if len(ends) > 1 else np.zeros(0)


def _functions_of_time(dynamics: Dynamics) -> list[Callable[[float], Any]]:
    """Return the functions of the user that look at the time alone: of loads, and accelerations of driven joints."""
    model = dynamics.model
    found: list[Callable[[float], Any]] = [
        load.value
        for load, _ in loads_with_values(model)
        if not (load.takes_state or load.is_constant or isinstance(load.function, Held))
    ]
    given = [motion.acceleration for motion, _ in model.drives if motion.pieces is None]
    return found + [acceleration for acceleration in given if acceleration is not None]


def _second_differences(function: Callable[[float], Any], times: np.ndarray) -> np.ndarray:
    """Return the largest second difference of a function at each time, over its range; zero at both ends, (T,)."""
    values: list[Any] = []
    with suppress(Exception):  # of the user: the run tells of it, if it comes there
        for t in times.tolist():
            values.append(function(t))
    found = np.zeros(len(times))
    if len(values) > 2:
        sampled = np.array(values, dtype=float).reshape(len(values), -1)
        size, extent = np.abs(sampled).max(axis=0), np.ptp(sampled, axis=0)
        sampled = sampled[:, extent > ROUND_OFF * size] / extent[extent > ROUND_OFF * size]
        found[1 : len(values) - 1] = np.abs(np.diff(sampled, 2, axis=0)).max(axis=1, initial=0.0)
    return found


def _stretches(change: np.ndarray) -> list[tuple[int, int]]:
    """Return the first and last number of the samples of each change, in order."""
    lively = np.flatnonzero(change > LIVELY)
    parts = np.split(lively, np.flatnonzero(np.diff(lively) > PAUSE) + 1)
    return [(int(part[0]), int(part[-1])) for part in parts if len(part) and change[part].max() > SUDDEN]


def _knots_of_tables(dynamics: Dynamics) -> np.ndarray:
    """Return the knots of the tables that drive a scene, s."""
    tables = [motion.pieces[:, 0] for motion, _ in dynamics.model.drives if motion.pieces is not None]
    knots = np.unique(np.concatenate([table for table in tables if len(table) > 1] or [np.zeros(0)]))
    if len(knots) < 2:
        return np.zeros(0)
    # two tables of the same times may differ by round-off
    return np.asarray(knots[np.concatenate(([True], np.diff(knots) > 1e-9 * (knots[-1] - knots[0])))])
