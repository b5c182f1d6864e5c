"""The model and state of a linear analysis, checked."""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol, runtime_checkable

import numpy as np

from kanefe.equations.given_state import Start, given_state, knows_states, slack_time, time_of
from kanefe.equations.model import Model
from kanefe.errors import ModelError
from kanefe.frames import Vector
from kanefe.kernels.compiler.compiled_functions import foreseen
from kanefe.kernels.compiler.signatures import COMPLEX
from kanefe.kernels.evaluation.evaluation import evaluate
from kanefe.loads.base import Load
from kanefe.loads.coordinate_friction import CoordinateFriction
from kanefe.tree.scales import scene_weight

MOST_WEIGHTS = 10.0
"""Largest force of a contact that acts at a distance at the start of a search for an equilibrium, in multiples of the
weight of the scene."""

HALVINGS = 30
"""Largest number of halvings of the distance over which it acts."""


@runtime_checkable
class Freezable(Protocol):
    """An object that can be frozen to a model: a `kanefe.System`."""

    def freeze(self, t: float = 0.0, start: Start = None) -> Model:
        """Return the model with its start at a time, s."""
        ...


def model_of(scene: object, what: str, t: float = 0.0) -> Model:
    """Return the model of a scene, or a model itself; errors name the analysis.

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
    with foreseen(lambda: [evaluate.unit(COMPLEX)]):  # what is missing is built together
        model.route.check_dense(what)
    _check_states(model, what)
    if model.free_count == 0:
        raise ModelError(f"{what}: nothing in the scene can move. Remedy: a joint that is free, or a flexible body")
    return model


def _check_states(model: Model, what: str) -> None:
    """Raise a ModelError for loads whose internal states move, or change step by step, without a form at rest."""
    if model.granular is not None:
        raise ModelError(
            f"{what} is not supported for granular contacts, here {model.granular.name!r}. Remedy: add_contact for the "
            "loaded ones, or a damped run"
        )
    if model.states_move:
        scene = model.route.state(model.slack_time, model.initial_state)
        names = [
            repr(load.name)
            for i, load in enumerate(model.loads)
            if load.has_rates and i not in model.rigid_contacts and load.resting(scene.load_ends(i)) is None
        ]
        if names:
            raise ModelError(
                f"{what}: the load {', '.join(names)} has internal states with rates, and their small motions are "
                "not supported. Remedy: leave it out, or frequencies from a run"
            )


def check_no_rigid_contacts(model: Model, what: str) -> None:
    """Raise a ModelError for a rigid contact in an analysis that raises loads or follows a motion."""
    if model.rigid_contacts:
        raise ModelError(
            f"{what} is not supported with rigid contacts, here {model.rigid_contact(0).title}: the closed points "
            "may change. Remedy: a compliant contact, kanefe.HuntCrossley(...), or a loop joint in its place; "
            "equilibrium and linearise take them"
        )


def rubbing(model: Model) -> Load | None:
    """Return a load with friction, whose rests depend on how they were reached; None if there is none."""
    for load in model.loads:
        if isinstance(load, CoordinateFriction) or (load.may_part and getattr(load, "friction", None) is not None):
            return load
    return None


def at_rest(model: Model, t: float, y: Vector, softness: float = 0.0) -> Model:
    """Return a model with the loads in their form about a rest y (q, u, z): sticking contacts are held by springs.

    `softness` (m): distance over which contacts act from afar; reduced if their force would be many times the weight of
    the scene.
    """
    if all(type(load).resting is Load.resting for load in model.loads):
        return model
    scene, z = model.route.state(t, y), model.parts(y)[2]

    def resting(i: int, softness: float) -> Load:
        return model.loads[i].resting(scene.load_ends(i), softness) or model.loads[i]

    loads = [resting(i, softness) for i in range(len(model.loads))]
    if all(load is before for load, before in zip(loads, model.loads, strict=True)):
        return model
    found = replace(model, loads=tuple(loads), initial_states=z)
    if softness <= 0.0 or (most := MOST_WEIGHTS * scene_weight(model)) <= 0.0:
        return found
    for _ in range(HALVINGS):
        wrenches = found.route.wrenches_of_loads(t, y)
        strong = [i for i, load in enumerate(loads) if load.may_part and np.abs(wrenches[i][:, :3]).max() > most]
        if not strong:
            break
        softness *= 0.5
        for i in strong:
            loads[i] = resting(i, softness)
        found = replace(model, loads=tuple(loads), initial_states=z)
    return found


def rested_states(model: Model, t: float, y: Vector) -> Vector:
    """Return the internal states of all loads at the rest y of a model from `at_rest`."""
    scene, z = model.route.state(t, y), model.parts(y)[2].copy()
    for i, load in enumerate(model.loads if len(z) else ()):
        z[model.load_states[i]] = load.rested(scene.load_ends(i), z[model.load_states[i]])
    return z


def model_in_state(scene: object, t: float | None, start: Start, what: str) -> tuple[Model, float, Vector, Vector]:
    """Return the model from `at_rest` with the internal states of a state, and time, q and u: see `started_model`."""
    model, time, y = started_model(scene, t, start, what)
    q, u, _ = model.parts(y)
    return at_rest(model, time, y), time, q, u


def started_model(scene: object, t: float | None, start: Start, what: str) -> tuple[Model, float, Vector]:
    """Return a model that starts with the internal states of a state, and time and state (q, u, z).

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
        If the time or the state is not valid for the model, or loops are open.
    """
    at = time_of(start) if t is None else t
    model = model_of(scene, what, slack_time(start, at))
    time, y = given_state(model, at, start, what)
    if model.rigid_contacts and not (start is not None and knows_states(model, start)):
        y = model.literal.touched(time, y, 0.0, np.inf, 0.0)
    z = model.parts(y)[2]
    if not np.array_equal(z, model.initial_states):
        model = replace(model, initial_states=z)
    return model, time, y
