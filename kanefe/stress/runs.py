"""Runs of the stress cases: which methods there are, and a run with any of them."""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.errors import ModelError, SimulationError
from kanefe.integrate.methods import METHODS
from kanefe.integrate.run import Trajectory, integrate
from kanefe.model import Model

LONG = ("energy-momentum", "rk4")
"""Methods for long runs of fixed steps, the best one first."""

EXPLICIT = ("dopri5", "dop853", "rk4")
"""Methods that follow every mode, however stiff."""

PLUGGED = ("scipy-", "sundials-")
"""How the names of methods of other packages start."""


def method_names() -> tuple[str, ...]:
    """Return the names of kanefe's own methods."""
    return tuple(name for name in METHODS if not name.startswith(PLUGGED))


def controlled_methods() -> tuple[str, ...]:
    """Return the methods that choose their steps."""
    return tuple(name for name in method_names() if METHODS[name].has_error_control)


def stepped_methods() -> tuple[str, ...]:
    """Return the methods that can take steps of a given size."""
    return tuple(name for name in method_names() if METHODS[name].has_fixed_steps)


def implicit_methods() -> tuple[str, ...]:
    """Return the methods that choose their steps and are not held down by stiff modes."""
    return tuple(name for name in controlled_methods() if name not in EXPLICIT)


def long_method(wanted: str | None) -> str:
    """Return the method of a long run: the one wanted, or the best there is."""
    return wanted or next(name for name in LONG if name in stepped_methods())


def check_long_method(name: str) -> None:
    """Raise a ModelError if no method of this name takes steps of a given size."""
    if name not in stepped_methods():
        raise ModelError(f"{name!r} is no method with fixed steps. Remedy: one of {', '.join(stepped_methods())}")


def run_of(
    model: Model, span: float, method: str, *, step: float, rtol: float = 1e-6, output_step: float | None = None
) -> Trajectory:
    """Run a model from t = 0 with a tolerance, or with a step if the method takes steps only."""
    control: dict[str, Any] = {"rtol": rtol} if METHODS[method].has_error_control else {"step": step}
    return integrate(model, (0.0, span), method=method, output_step=output_step, progress=False, **control)


def stepped_run(model: Model, count: int, step: float, method: str, samples: int) -> Trajectory:
    """Run a model for so many steps of one size, and keep its state at some of them."""
    return integrate(
        model, (0.0, count * step), method=method, step=step, output_step=count // samples * step, progress=False
    )


NOT_FINITE = "the states are not finite"


def failure_of(model: Model, span: float, **options: Any) -> str:
    """Return why a run from t = 0 could not be finished; "" if it was, with finite states."""
    try:
        run = integrate(model, (0.0, span), progress=False, **options)
    except SimulationError as problem:
        return str(problem)
    return "" if all_finite(run) else NOT_FINITE


def all_finite(run: Trajectory) -> bool:
    """Tell whether every number of a trajectory is finite."""
    return all(bool(np.all(np.isfinite(x))) for x in (run.coordinates, run.speeds, run.dissipated, run.work))
