"""What came of a run of a long case, and which methods such cases may ask for."""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.checks.robustness.runs import controlled_methods, follow, stepped_methods
from kanefe.equations.model import Model
from kanefe.errors import ModelError, SimulationError
from kanefe.integrate.methods.table import METHODS
from kanefe.integrate.trajectory import Trajectory


def implicit_methods() -> tuple[str, ...]:
    """Return the methods that choose their steps and are not held down by stiff modes."""
    return tuple(name for name in controlled_methods() if not METHODS[name].is_explicit)


def check_long_method(name: str) -> None:
    """Raise a ModelError if no method of this name takes steps of a given size."""
    if name not in stepped_methods():
        raise ModelError(f"{name!r} is no method with fixed steps. Remedy: one of {', '.join(stepped_methods())}")


def failure_of(model: Model, span: float, **options: Any) -> str:
    """Return why a run could not be finished; "" if it was."""
    try:
        follow(model, span, **options)
    except SimulationError as problem:
        return str(problem)
    return ""


def is_reported(trajectory: Trajectory) -> bool:
    """Tell whether a run came to its end, or says why it did not and what to try."""
    status = trajectory.status
    return status is None or status.is_finished or bool(status.reason and status.remedy)


def all_finite(trajectory: Trajectory) -> bool:
    """Tell whether every number of a trajectory is finite."""
    arrays = (trajectory.coordinates, trajectory.speeds, trajectory.dissipated, trajectory.work)
    return all(bool(np.all(np.isfinite(x))) for x in arrays)
