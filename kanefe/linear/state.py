"""What a linear analysis is of: a model and a state of it, checked at the door."""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol, runtime_checkable

import numpy as np

from kanefe.equations.given_state import Start, given_state, slack_time, time_of
from kanefe.equations.model import Model
from kanefe.errors import ModelError
from kanefe.frames import Vector


@runtime_checkable
class Freezable(Protocol):
    """What can be frozen to a model: a `kanefe.System`."""

    def freeze(self, t: float = 0.0, start: Start = None) -> Model:
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


def model_in_state(scene: object, t: float | None, start: Start, what: str) -> tuple[Model, float, Vector, Vector]:
    """Return a model that starts with the internal states of a state, time, q and u.

    Parameters
    ----------
    scene : System or Model
    t : float, optional
        s; default: that of the state, or zero.
    start : AtOneTime or array_like, optional
        See `kanefe.equations.given_state`; default: the start of the scene.
    what : str
        The analysis, for messages.

    Raises
    ------
    ModelError
        If the time or the state make no sense for the model, or loops are open.
    """
    at = time_of(start) if t is None else t
    model = model_of(scene, what, slack_time(start, at))
    time, y = given_state(model, at, start, what)
    q, u, z = model.parts(y)
    if not np.array_equal(z, model.initial_states):
        model = replace(model, initial_states=z)
    return model, time, q, u
