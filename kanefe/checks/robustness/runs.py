"""Runs of the stress cases: which methods there are, and a run with any of them."""

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
"""Time after which a run counts as hanging, s."""


def controlled_methods(model: Model | None = None) -> tuple[str, ...]:
    """Return the methods that choose their steps; those that suit a scene."""
    names = tuple(name for name in own_methods() if METHODS[name].has_error_control)
    return names if model is None else tuple(name for name in names if suits(name, model))


def stepped_methods() -> tuple[str, ...]:
    """Return the methods that can take steps of a given size."""
    return tuple(name for name in own_methods() if METHODS[name].has_fixed_steps)


def is_accurate(method: str) -> bool:
    """Return whether a method is of higher order than 2."""
    return METHODS[method].order > 2


def tolerance(method: str, accurate: float, low_order: float) -> float:
    """Return rtol of a run: one for methods of higher order, if they can keep it, and one for those of order 2."""
    return max(accurate if is_accurate(method) else low_order, METHODS[method].least_rtol)


def long_methods(wanted: str | None) -> tuple[str, ...]:
    """Return the methods of long runs: the one wanted, or those that keep energy."""
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
        If it does not come to its end, also if that takes longer than `LONGEST`.
    """
    trajectory = ended(model, span, **options)
    if trajectory.status is not None and not trajectory.status.is_finished:
        raise SimulationError(str(trajectory.status))
    return trajectory


def ended(model: Model, span: float, **options: Any) -> Trajectory:
    """Run a model from t = 0, and return what there is however it ends."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SimulationWarning)  # the status says it
        return integrate(model, (0.0, span), most_seconds=LONGEST, progress=False, **options)


def stepped_run(model: Model, count: int, step: float, method: str, samples: int) -> Trajectory:
    """Run a model for so many steps of one size, and keep its state at some of them."""
    return follow(model, count * step, method=method, step=step, output_step=count // samples * step)
