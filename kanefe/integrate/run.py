"""The one loop that runs a model in time with any method."""

from __future__ import annotations

import math
import sys
import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from kanefe.equations_of_motion import WORKS
from kanefe.errors import ModelError, SimulationError
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.methods import choose
from kanefe.integrate.stepper import StepFailure, TellsAccelerations
from kanefe.model import Model

OUTPUTS = 500

CHUNK = 2000
"""Steps taken in one go."""

LARGEST_STORE = 2**32
"""Bytes of states and accelerations of unreduced bodies above which a run asks for fewer outputs."""


@dataclass(frozen=True, eq=False)
class Trajectory:
    """States of a run at its output times.

    Attributes
    ----------
    times : ndarray, shape (T,)
        s.
    coordinates : ndarray, shape (T, coordinates)
    speeds : ndarray, shape (T, free)
    dissipated, work : ndarray, shape (T,)
        Energy taken by damping and given by loads and drives since the start, J.
    statistics : dict
        Method, why it was chosen, steps, rejected steps, evaluations, seconds; with unreduced bodies also how often
        their matrices were factored and how many iterations there were.
    accelerations : ndarray, shape (T, free), or None
        du, kept of scenes with unreduced bodies, where it costs more than it takes room.
    """

    times: np.ndarray
    coordinates: np.ndarray
    speeds: np.ndarray
    dissipated: np.ndarray
    work: np.ndarray
    statistics: dict[str, Any]
    accelerations: np.ndarray | None = None


def integrate(
    model: Model,
    t_span: tuple[float, float],
    *,
    rtol: float | None = None,
    atol: float | None = None,
    method: str = "auto",
    step: float | None = None,
    output_step: float | None = None,
    progress: bool | None = None,
) -> Trajectory:
    """Run a model in time.

    Parameters
    ----------
    model : Model
    t_span : (float, float)
        Start and end in s.
    rtol : float, optional
        Relative error of a step; default 1e-6.
    atol : float, optional
        Absolute error of a step, for "dop853" only; default 1e-3 rtol.
    method : "auto", "dop853", "generalised-alpha" or "rk4"
        "auto" takes the explicit method unless elastic modes would hold it to more than 2000 steps. "rk4" is the
        classical Runge-Kutta method of order 4 with fixed steps and without error control.
    step : float, optional
        Of "rk4", s.
    output_step : float, optional
        Time between stored states in s; default a 500th of the span, or for "rk4" the nearest number of whole steps.
    progress : bool, optional
        Show a progress bar with the time left; default: only on a terminal.

    Returns
    -------
    Trajectory

    Raises
    ------
    ModelError
        If an option makes no sense.
    SimulationError
        If the run cannot be finished; the message says when and what to try.
    """
    start, stop = checked_span(t_span)
    choice = choose(model, method, start, stop, rtol, step, atol)
    if step is not None and output_step is None:
        output_step = step * max(1, round((stop - start) / step / OUTPUTS))
    times = _output_times(start, stop, output_step)
    _check_room(model, times)
    began = time.perf_counter()
    stepper = choice.make(Dynamics(model))
    states = np.empty((len(times), model.coordinate_count + model.free_count + WORKS))
    states[0] = stepper.state()
    rates: np.ndarray | None = None
    if isinstance(stepper, TellsAccelerations):
        rates = np.empty((len(times), model.free_count))
        rates[0] = stepper.accelerations(times[:1])[0]
    stored = 1
    with _progress_bar(progress, stop - start) as bar:
        while stored < len(times):
            before = stepper.t
            try:
                passed = stepper.march(times[stored:], states[stored:], CHUNK if rates is None else 1)
            except StepFailure as failure:
                message = f"at t = {stepper.t:.6g} s {failure.reason}. Remedy: {failure.remedy}"
                raise SimulationError(message) from failure
            if rates is not None and isinstance(stepper, TellsAccelerations):
                rates[stored : stored + passed] = stepper.accelerations(times[stored : stored + passed])
            stored += passed
            bar.update(stepper.t - before)
    n, m = model.coordinate_count, model.free_count
    return Trajectory(
        times=times,
        coordinates=states[:, :n],
        speeds=states[:, n : n + m],
        dissipated=states[:, n + m],
        work=states[:, n + m + 1],
        statistics={
            "method": choice.name,
            "reason": choice.reason,
            **choice.control,
            **stepper.statistics,
            "seconds": time.perf_counter() - began,
        },
        accelerations=rates,
    )


def _check_room(model: Model, times: np.ndarray) -> None:
    size = 24 * model.free_count * len(times)
    if model.has_unreduced and size > LARGEST_STORE:
        raise ModelError(
            f"{len(times)} states of {model.free_count} speeds take {size / 2**30:.1f} GiB. Remedy: a larger "
            f"output_step, which leaves at most {LARGEST_STORE // (24 * model.free_count)} of them"
        )


def checked_span(t_span: tuple[float, float]) -> tuple[float, float]:
    """Return start and end in s; a ModelError says what is wrong with them."""
    try:
        start, stop = (float(t) for t in t_span)
    except (TypeError, ValueError) as error:
        raise ModelError(f"t_span must be two times in s, such as (0.0, 5.0), not {t_span!r}") from error
    if not (math.isfinite(start) and math.isfinite(stop) and stop > start):
        raise ModelError(f"t_span {t_span!r} must run forward: two finite times, the end after the start")
    return start, stop


def _output_times(start: float, stop: float, step: float | None) -> np.ndarray:
    if step is None:
        return np.linspace(start, stop, OUTPUTS + 1)
    if not (math.isfinite(step) and 0 < step):
        raise ModelError(f"output_step must be above zero s, not {step!r}")
    count = max(1, round((stop - start) / step))
    if abs(count * step - (stop - start)) <= 1e-9 * (stop - start):
        return np.linspace(start, stop, count + 1)
    return np.append(np.arange(start, stop, step), stop)


def _progress_bar(wanted: bool | None, span: float) -> Any:
    """Return a progress bar in simulated seconds; a silent one off a terminal."""
    from tqdm import tqdm

    shown = sys.stderr.isatty() if wanted is None else wanted
    layout = "{desc}: {percentage:3.0f}%|{bar}| {n:.3g}/{total:.3g} s [{elapsed}<{remaining}]"
    return tqdm(total=span, desc="simulate", disable=not shown, bar_format=layout, leave=False)
