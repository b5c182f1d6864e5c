"""Loads that are too large to compute with: products of their forces are beyond the largest number."""

from __future__ import annotations

import numpy as np

from kanefe.equations.model import Model
from kanefe.errors import SimulationError
from kanefe.linear.small_motions import SmallMotions
from kanefe.tree.load_names import named_loads
from kanefe.tree.scene_state import SceneState

LARGEST = 1e120
"""Force, moment or acceleration above which its square, with a stiffness or an inertia of 1e60 on it, overflows, in N,
N m, m/s2 or rad/s2."""


def check_loads(model: Model, state: SceneState) -> None:
    """Raise a SimulationError that names a load whose value at a state is above `LARGEST`.

    What a load has nothing to tell of, or knows only from its start on, is no number.
    """
    for name, load in named_loads(model).items():
        value = np.asarray(load.value(state.time, state), dtype=float)
        if np.any(np.abs(value) > LARGEST):
            raise _too_large(f"the load {name!r} is {np.nanmax(np.abs(value)):.3g}", state.time)
    y, t = np.concatenate((state.q, state.u, state.z)), state.time
    for number, wrenches in model.route.wrenches_of_loads(t, y).items() if model.loads else ():
        if np.any(np.abs(wrenches) > LARGEST):
            raise _too_large(f"the load {model.loads[number].name!r} is {np.nanmax(np.abs(wrenches)):.3g} N", t)


def check_accelerations(small: SmallMotions) -> None:
    """Raise a SimulationError if the accelerations of a state, or loads that leave none, are above `LARGEST`."""
    du = small.du
    if not np.all(np.abs(du) <= LARGEST):
        check_loads(small.model, small.here)
        if np.any(np.abs(du) > LARGEST):  # what is no number, such as gas without a volume, ends a step there
            raise _too_large(f"an acceleration is {np.nanmax(np.abs(du)):.3g}", small.t)


def _too_large(what: str, t: float) -> SimulationError:
    return SimulationError(
        f"no equilibrium of the scene was found: at t = {t:.6g} s {what}, and numbers above {LARGEST:g} cannot be "
        "computed with. Remedy: check its value, or loads that do not grow without bound along the search"
    )
