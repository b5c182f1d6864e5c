"""Runs of the stress cases, and the methods of integration they use."""

from __future__ import annotations

import warnings
from typing import Any

from kanefe.equations.model import Model
from kanefe.errors import ModelError, SimulationError, SimulationWarning
from kanefe.integrate.auto.choice import choose
from kanefe.integrate.methods.table import METHODS, own_methods
from kanefe.integrate.options import RunOptions
from kanefe.integrate.run import integrate
from kanefe.integrate.trajectory import Trajectory

LONG = ("energy-momentum", "rk4")
"""Methods for long runs with fixed steps."""

LONGEST = 900.0
"""Wall-clock time after which a run is stopped, s."""


def controlled_methods(model: Model | None = None) -> tuple[str, ...]:
    """Return the methods with error control; only those that can run `model`, if given."""
    names = tuple(name for name in own_methods() if METHODS[name].has_error_control)
    return names if model is None else tuple(name for name in names if suits(name, model))


def stepped_methods() -> tuple[str, ...]:
    """Return the methods that can take steps of fixed size."""
    return tuple(name for name in own_methods() if METHODS[name].has_fixed_steps)


def is_accurate(method: str) -> bool:
    """Return whether a method is of higher order than 2."""
    return METHODS[method].order > 2


def tolerance(method: str, accurate: float, low_order: float) -> float:
    """Return rtol of a run: `low_order` for methods of order 2, else `accurate`; not less than the method allows."""
    return max(accurate if is_accurate(method) else low_order, METHODS[method].least_rtol)


def long_methods(wanted: str | None) -> tuple[str, ...]:
    """Return the methods of long runs: the requested one, or the available ones of `LONG`."""
    return (wanted,) if wanted else tuple(name for name in LONG if name in stepped_methods())


def suits(method: str, model: Model) -> bool:
    """Return whether a method can run a scene."""
    step = None if METHODS[method].has_error_control else 0.5
    try:
        choose(model, RunOptions(t_span=(0.0, 1.0), method=method, step=step))
    except ModelError:
        return False
    return True


def follow(model: Model, span: float, **options: Any) -> Trajectory:
    """Run a model from t = 0 to its end.

    Raises
    ------
    SimulationError
        If it does not reach its end within `LONGEST`.
    """
    trajectory = ended(model, span, **options)
    if trajectory.status is not None and not trajectory.status.is_finished:
        raise SimulationError(str(trajectory.status))
    return trajectory


def ended(model: Model, span: float, **options: Any) -> Trajectory:
    """Run a model from t = 0 and return the trajectory, complete or not."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SimulationWarning)  # the status contains it
        return integrate(model, (0.0, span), most_seconds=LONGEST, progress=False, **options)


def stepped_run(model: Model, count: int, step: float, method: str, samples: int) -> Trajectory:
    """Run a model for `count` steps of equal size, and keep its state at about `samples` of them."""
    return follow(model, count * step, method=method, step=step, output_step=count // samples * step)
