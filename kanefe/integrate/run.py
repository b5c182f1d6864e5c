"""The one loop that runs a model in time with any method."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from kanefe.equations_of_motion import WORKS
from kanefe.errors import ModelError
from kanefe.frames import Vector
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.explicit import ExplicitStepper
from kanefe.integrate.generalised_alpha import GeneralisedAlphaStepper, stiffest_rate
from kanefe.integrate.generalised_alpha_unreduced import UnreducedStepper
from kanefe.integrate.runge_kutta import RungeKuttaStepper
from kanefe.model import Model


class Stepper(Protocol):
    """A method in the middle of a run."""

    name: str
    rejected: int

    @property
    def t(self) -> float:
        """Time reached in s."""
        ...

    def initial_state(self) -> Vector:
        """Return the state at the start."""
        ...

    def step(self) -> None:
        """Take one accepted step."""
        ...

    def states(self, times: np.ndarray) -> np.ndarray:
        """Return the states at times within the last step."""
        ...


METHODS: dict[str, Callable[[Dynamics, float, float, float, float, np.ndarray], Stepper]] = {
    ExplicitStepper.name: ExplicitStepper,
    GeneralisedAlphaStepper.name: GeneralisedAlphaStepper,
}

LARGEST_EXPLICIT_STEPS = 2000.0
"""Steps that the explicit method would need for the elastic modes, above which "auto" takes the implicit one."""

OUTPUTS = 500

LARGEST_STORE = 2**32
"""Bytes of states and accelerations of unreduced bodies above which a run asks for fewer outputs."""

DEFAULT_RTOL = 1e-6


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
    if rtol is not None and not (math.isfinite(rtol) and 0 < rtol < 1):
        raise ModelError(f"rtol must lie between 0 and 1, not {rtol!r}")
    name, reason = _choose(model, method, start, stop)
    if (step is None) == (name == RungeKuttaStepper.name):
        raise ModelError(
            f"{name} needs a step in s" if step is None else f"step has no meaning for {name}, which chooses its own"
        )
    if step is not None:
        if rtol is not None:
            raise ModelError(f"rtol has no meaning for {name}, whose steps are fixed. Remedy: leave it out")
        if not (math.isfinite(step) and 0 < step <= stop - start):
            raise ModelError(f"step must be above zero s and within the span, not {step!r}")
        if output_step is None:
            output_step = step * max(1, round((stop - start) / step / OUTPUTS))
    times = _output_times(start, stop, output_step)
    if atol is not None and name != ExplicitStepper.name:
        raise ModelError(
            f"atol has no meaning for {name}, which "
            f"{'has no error control' if step else 'scales errors by the size of the bodies'}. Remedy: leave it out"
        )
    if atol is not None and not (math.isfinite(atol) and atol > 0):
        raise ModelError(f"atol must be above zero, not {atol!r}")
    _check_room(model, times)
    began = time.perf_counter()
    dynamics = Dynamics(model)
    stepper: Stepper
    if step is not None:
        stepper = RungeKuttaStepper(dynamics, start, stop, step, times)
    else:
        rtol = DEFAULT_RTOL if rtol is None else rtol
        make = UnreducedStepper if model.has_unreduced else METHODS[name]
        stepper = make(dynamics, start, stop, rtol, 1e-3 * rtol if atol is None else atol, times)
    states = np.empty((len(times), model.coordinate_count + model.free_count + WORKS))
    states[0] = stepper.initial_state()
    rates: np.ndarray | None = None
    if isinstance(stepper, UnreducedStepper):
        rates = np.empty((len(times), model.free_count))
        rates[0] = stepper.initial_accelerations()
    stored, steps = 1, 0
    with _progress_bar(progress, stop - start) as bar:
        while stored < len(times):
            before = stepper.t
            stepper.step()
            steps += 1
            reached = stored + int(np.searchsorted(times[stored:], stepper.t, side="right"))
            if reached > stored:
                states[stored:reached] = stepper.states(times[stored:reached])
                if rates is not None and isinstance(stepper, UnreducedStepper):
                    rates[stored:reached] = stepper.accelerations(times[stored:reached])
                stored = reached
            bar.update(stepper.t - before)
    n, m = model.coordinate_count, model.free_count
    return Trajectory(
        times=times,
        coordinates=states[:, :n],
        speeds=states[:, n : n + m],
        dissipated=states[:, n + m],
        work=states[:, n + m + 1],
        statistics={
            "method": name,
            "reason": reason,
            **({"rtol": rtol} if rtol is not None else {"step": step}),
            "steps": steps,
            "rejected": stepper.rejected,
            "evaluations": dynamics.evaluations,
            **(stepper.statistics if isinstance(stepper, UnreducedStepper) else {}),
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


def _choose(model: Model, method: str, start: float, stop: float) -> tuple[str, str]:
    if method != "auto":
        names = (*METHODS, RungeKuttaStepper.name)
        if method not in names:
            raise ModelError(f"there is no method {method!r}. Remedy: auto, {', '.join(names)}")
        if model.has_unreduced and method != GeneralisedAlphaStepper.name:
            raise ModelError(
                f"method {method!r} would need a step for the highest mode of the mesh: an unreduced body is run by "
                "'generalised-alpha'. Remedy: that method, or reduction=CraigBampton(modes=20)"
            )
        return method, "asked for"
    if model.has_unreduced:
        return GeneralisedAlphaStepper.name, "the highest modes of an unreduced body are stiff"
    rate = stiffest_rate(model, start)
    # DOP853 is stable up to |h w| = 6, but where modes are excited its error control asks for |h w| of about 2
    if (stop - start) * rate / 2.0 > LARGEST_EXPLICIT_STEPS:
        reason = f"elastic modes up to {rate / (2 * math.pi):.3g} Hz are stiff over {stop - start:g} s"
        return GeneralisedAlphaStepper.name, reason
    return ExplicitStepper.name, "no stiff elastic modes"


def _progress_bar(wanted: bool | None, span: float) -> Any:
    """Return a progress bar in simulated seconds; a silent one off a terminal."""
    from tqdm import tqdm

    shown = sys.stderr.isatty() if wanted is None else wanted
    layout = "{desc}: {percentage:3.0f}%|{bar}| {n:.3g}/{total:.3g} s [{elapsed}<{remaining}]"
    return tqdm(total=span, desc="simulate", disable=not shown, bar_format=layout, leave=False)
