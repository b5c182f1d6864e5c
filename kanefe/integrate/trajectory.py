"""What a run leaves behind: states at the output times, how it ended and what it cost.

The times at which a run stores its states.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeGuard

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import numbers
from kanefe.integrate.sampling import ControllerLog
from kanefe.integrate.status import RunStatus
from kanefe.tree.bending import Bent
from kanefe.tree.model_data import QUADRATURES, ModelData


@dataclass(frozen=True, eq=False)
class Trajectory:
    """States of a run at its output times.

    Attributes
    ----------
    times : ndarray, shape (T,)
        s. Those wanted up to where the run came; the last one is that time if the run ended before the span.
    coordinates : ndarray, shape (T, coordinates)
    speeds : ndarray, shape (T, free)
    dissipated, work : ndarray, shape (T,)
        Energy taken by damping and given by loads, drives and actions of events since the start, J.
    statistics : dict
        Method, why it was chosen, steps, rejected steps, evaluations and what else the method counts; "seconds" in
        all, and "seconds_by_part".
    accelerations : ndarray, shape (T, free), or None
        du, kept of scenes with unreduced bodies, where it costs more than it takes room.
    status : RunStatus or None
        How the run ended; None of states that come from elsewhere.
    events : mapping of str to ndarray
        Times at which each event happened, s.
    internal : ndarray, shape (T, states)
        Internal states of loads, switches of constraints, and what controllers hold.
    controllers : mapping of str to ControllerLog
        Their samples.
    bent : sequence of Bent
        Where each flexible body was bent the most at a step.
    records : mapping of str to Recorded
        What was recorded beside, by column.
    """

    times: np.ndarray
    coordinates: np.ndarray
    speeds: np.ndarray
    dissipated: np.ndarray
    work: np.ndarray
    statistics: dict[str, Any]
    accelerations: np.ndarray | None = None
    status: RunStatus | None = None
    events: Mapping[str, np.ndarray] = field(default_factory=dict)
    internal: np.ndarray = field(default_factory=lambda: np.zeros((0, 0)))
    controllers: Mapping[str, ControllerLog] = field(default_factory=dict)
    bent: Sequence[Bent] = ()
    records: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def of_states(cls, model: ModelData, times: np.ndarray, states: np.ndarray, **rest: Any) -> Trajectory:
        """Return a trajectory from whole states (T, state and quadratures); `rest` are its other attributes."""
        n, m = model.coordinate_count, model.free_count
        return cls(
            times=times,
            coordinates=states[:, :n],
            speeds=states[:, n : n + m],
            dissipated=states[:, -QUADRATURES],
            work=states[:, -1],
            internal=states[:, n + m : -QUADRATURES],
            **rest,
        )

    def __post_init__(self) -> None:
        if not self.internal.size:
            object.__setattr__(self, "internal", np.zeros((len(self.times), 0)))

    def raise_for_status(self) -> None:
        """Raise a SimulationError if the run failed.

        Raises
        ------
        SimulationError
        """
        if self.status is not None:
            self.status.raise_if_failed()


OUTPUTS = 500
"""Default number of output intervals."""

MOST_OUTPUTS = 100_000_000
"""Largest number of outputs: for one pendulum they would take 3 GiB, so that more is a mistake."""


def is_finite_number(value: object) -> bool:
    """Return whether an option is a finite number."""
    if type(value) is float:  # as most are: every run asks for some
        return math.isfinite(value)
    given = numbers(value)
    return given.shape == () and bool(np.isfinite(given))


def checked_span(t_span: tuple[float, float]) -> tuple[float, float]:
    """Return start and end in s; a ModelError says what is wrong with them."""
    try:
        start, stop = t_span if _are_floats(t_span) else map(float, numbers(t_span))
    except (TypeError, ValueError) as error:
        count = np.size(t_span)
        what = repr(t_span) if count < 3 else f"{count}. Remedy: output_times= for those to be stored"
        raise ModelError(f"t_span must be two times in s, such as (0.0, 5.0), not {what}") from error
    if not (math.isfinite(start) and math.isfinite(stop) and stop > start):
        raise ModelError(f"t_span {t_span!r} must run forward: two finite times, the end after the start")
    return start, stop


def _are_floats(given: object) -> TypeGuard[tuple[float, float]]:
    """Return whether a span is a pair of plain numbers, as most are."""
    return type(given) is tuple and len(given) == 2 and type(given[0]) is type(given[1]) is float


def wanted_times(
    start: float,
    stop: float,
    output_step: float | None = None,
    given: Sequence[float] | np.ndarray | None = None,
    fixed_step: float | None = None,
) -> np.ndarray:
    """Return the times wanted, ascending, shape (T,), s.

    Parameters
    ----------
    start, stop : float
        s.
    output_step : float, optional
        Time between them; default a 500th of the span, or with fixed steps the nearest number of whole steps.
    given : array_like, optional
        The times themselves.
    fixed_step : float, optional
        Of the method.

    Raises
    ------
    ModelError
        If they make no sense.
    """
    if given is not None:
        if output_step is not None:
            raise ModelError("output_step and output_times were both given. Remedy: one of the two")
        return _checked_times(given, start, stop)
    if output_step is None and fixed_step is not None:
        output_step = fixed_step * max(1, round((stop - start) / fixed_step / OUTPUTS))
    if output_step is None:
        return _evenly(start, stop, OUTPUTS)
    if not (is_finite_number(output_step) and output_step > 0):
        raise ModelError(f"output_step must be above zero s, not {output_step!r}")
    if (stop - start) / output_step > MOST_OUTPUTS:
        raise ModelError(
            f"output_step of {output_step:g} s asks for {(stop - start) / output_step:.3g} states. Remedy: a larger "
            f"one; at most {MOST_OUTPUTS:,} are stored"
        )
    count = max(1, round((stop - start) / output_step))
    if abs(count * output_step - (stop - start)) <= 1e-9 * (stop - start):
        return _evenly(start, stop, count)
    return np.append(np.arange(start, stop, output_step), stop)


def _evenly(start: float, stop: float, count: int) -> np.ndarray:
    """Return `count` + 1 evenly spaced times from start to stop: as linspace of numpy, which takes longer."""
    times = np.arange(count + 1) * ((stop - start) / count)
    times += start
    times[-1] = stop
    return times


def _checked_times(given: Sequence[float] | np.ndarray, start: float, stop: float) -> np.ndarray:
    try:
        times = np.array(given, dtype=float)
    except (TypeError, ValueError) as error:
        raise ModelError(f"output_times must be times in s, not {given!r}") from error
    if times.ndim != 1 or not len(times) or not np.all(np.isfinite(times)):
        raise ModelError(f"output_times must be one or more finite times in s, shape {times.shape} was given")
    if np.any(np.diff(times) <= 0.0):
        raise ModelError("output_times must ascend, each time once. Remedy: np.unique(times)")
    if times[0] < start or times[-1] > stop:
        raise ModelError(
            f"output_times reach from {times[0]:g} to {times[-1]:g} s, the run from {start:g} to {stop:g} s. "
            "Remedy: another t_span"
        )
    return times
