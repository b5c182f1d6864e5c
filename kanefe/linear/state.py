"""What a linear analysis is of: a model and a state of it, checked at the door."""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol, runtime_checkable

import numpy as np

from kanefe.equations.model import Model
from kanefe.errors import ModelError
from kanefe.frames import Vector, numbers
from kanefe.kane.constraints import constraint_rates, constraint_residuals, held_rows
from kanefe.kane.state import State
from kanefe.kernels.tolerances import LARGEST_OPENING


@runtime_checkable
class Freezable(Protocol):
    """What can be frozen to a model: a `kanefe.System`."""

    def freeze(self, start: float = 0.0) -> Model:
        """Return the model at a time of the start, s."""
        ...


def model_of(scene: object, what: str, t: float = 0.0) -> Model:
    """Return the model of a scene, or a model itself; a ModelError names the analysis that it is for.

    Parameters
    ----------
    scene : System or Model
    what : str
        The analysis, for messages.
    t : float
        Time at which driven joints of a scene start, s.

    Raises
    ------
    ModelError
        If it is neither, if it has unreduced bodies, or if nothing in it can move.
    """
    model = scene.freeze(t) if isinstance(scene, Freezable) else scene
    if not isinstance(model, Model):
        raise ModelError(f"{what} needs a System or a Model, not {scene!r}. Remedy: the scene, or scene.freeze()")
    model.route.check_dense(what)
    if model.states_move:
        names = ", ".join(repr(load.name) for load in model.loads if load.has_rates)
        raise ModelError(
            f"{what}: the load {names} has internal states that move, and small motions of those are not offered. "
            "Remedy: leave it out, or frequencies from a run"
        )
    if model.free_count == 0:
        raise ModelError(f"{what}: nothing in the scene can move. Remedy: a joint that is free, or a flexible body")
    return model


def model_in_state(model: Model, t: object, y: object, what: str) -> tuple[Model, float, Vector, Vector]:
    """Return a model that starts with the internal states of y, time, q and u; Euler parameters of unit length.

    Raises
    ------
    ModelError
        If the time or the state is not finite, the state has another shape, or loops are open in it.
    """
    time = numbers(t)
    if time.shape != () or not np.isfinite(time):
        raise ModelError(f"t of {what} must be a finite time in s, not {t!r}")
    state = model.initial_state if y is None else numbers(y).astype(float)
    names = model.state_names
    if state.shape != (len(names),):
        raise ModelError(
            f"the state of {what} has shape {state.shape}, and this model has {len(names)} entries: "
            f"{', '.join(names[:4])}{' ...' if len(names) > 4 else ''}. Remedy: model.initial_state, or "
            "the coordinates and speeds of a result"
        )
    if not np.all(np.isfinite(state)):
        worst = int(np.flatnonzero(~np.isfinite(state))[0])
        raise ModelError(f"the state of {what} is not finite: {names[worst]} is {state[worst]}")
    q, u, z = model.parts(state)
    if not np.array_equal(z, model.initial_states):
        model = replace(model, initial_states=z)
    rotations = [(body.coordinates, body.joint.rotation_at) for body in model.bodies]
    if not all(np.any(q[at[first : first + 4]]) for at, first in rotations if first is not None):
        raise ModelError(f"the state of {what} has Euler parameters of no length. Remedy: (1, 0, 0, 0)")
    q = model.advance(q, np.zeros(model.free_count))  # of unit length
    _check_closed(model, float(time), q, u, what)
    return model, float(time), q, u


def _check_closed(model: Model, t: float, q: Vector, u: Vector, what: str) -> None:
    if not model.constraints:
        return
    state = State(model, t, q, u)
    full = state.full
    opened, rates = constraint_residuals(state), constraint_rates(state)
    slipping = rates.J @ full[: rates.J.shape[1]]
    sizes = np.abs(rates.J) @ np.abs(full[: rates.J.shape[1]])
    labels = [f"{constraint.title} ({row.label})" for constraint, row in held_rows(state)]
    # the projection of a run leaves 1e-12, its dense output between steps up to the tolerance of the run
    bad = (np.abs(opened) > 1e3 * LARGEST_OPENING) | (np.abs(slipping) > 1e-4 * np.maximum(sizes, 1e-3))
    if bad.any():
        worst = int(np.flatnonzero(bad)[0])
        raise ModelError(
            f"the state of {what} leaves {labels[worst]} open: by {opened[worst]:.3g} m or rad, at a rate of "
            f"{slipping[worst]:.3g}. Remedy: model.initial_state, a state of a run, or kanefe.equilibrium"
        )
