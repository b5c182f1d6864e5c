"""What a linear analysis is of: a model and a state of it, checked at the door."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Protocol, runtime_checkable

import numpy as np

from kanefe.equations.given_state import Start, given_state, knows_states, slack_time, time_of
from kanefe.equations.model import Model
from kanefe.equations.routes import functions_of_route
from kanefe.errors import ModelError
from kanefe.frames import Vector
from kanefe.kane.route import touched_at_start
from kanefe.kernels.compiler._numba import IS_COMPILED
from kanefe.kernels.compiler.compiled_functions import expect
from kanefe.loads.action import End
from kanefe.loads.base import Load
from kanefe.tree.scales import scene_weight

MOST_WEIGHTS = 10.0
"""Largest force of a contact that acts at a distance at the start of a search for an equilibrium, in multiples of the
weight of the scene."""

HALVINGS = 30
"""Number of halvings of the distance over which it acts."""


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
    if IS_COMPILED and "route" not in vars(model):
        expect(functions_of_route(model, has_jacobian=True))  # in one go, not each when it is first called
    model.route.check_dense(what)
    _check_states(model, what)
    if model.free_count == 0:
        raise ModelError(f"{what}: nothing in the scene can move. Remedy: a joint that is free, or a flexible body")
    return model


def _check_states(model: Model, what: str) -> None:
    """Raise a ModelError that names loads whose internal states move, or change in steps, without a form at rest."""
    if model.granular is not None:
        raise ModelError(
            f"{what} is not supported with many rigid contacts among each other, here {model.granular.name!r}, which "
            "runs step over. Remedy: add_contact for those that carry, or a damped run"
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
                f"{what}: the load {', '.join(names)} has internal states that move, and small motions of those are "
                "not supported. Remedy: leave it out, or frequencies from a run"
            )


def check_no_rigid_contacts(model: Model, what: str) -> None:
    """Raise a ModelError that names a rigid contact in an analysis that raises loads or follows a motion."""
    if model.rigid_contacts:
        raise ModelError(
            f"{what} is not supported with rigid contacts, here {model.rigid_contact(0).title}: what touches may "
            "change on the way. Remedy: a compliant contact, kanefe.HuntCrossley(...), or a loop joint in its place; "
            "equilibrium and linearise take them"
        )


def at_rest(model: Model, t: float, y: Vector, softness: float = 0.0) -> Model:
    """Return a model whose loads act as they do about a state y (q, u, z) at rest: contacts that stick hang on springs.

    `softness` (m): over what distance contacts act from afar, or less where they would push by many times the weight of
    the scene, away from what they are to hold.
    """
    if not any(_rests_otherwise(load) for load in model.loads):
        return model
    scene = model.route.state(t, y)
    most = MOST_WEIGHTS * scene_weight(model)
    loads = tuple(
        _resting(load, t, scene.load_ends(i), scene.load_states(i), softness, most)
        for i, load in enumerate(model.loads)
    )
    if all(load is before for load, before in zip(loads, model.loads, strict=True)):
        return model
    return replace(model, loads=loads, initial_states=model.parts(y)[2])


def _rests_otherwise(load: Load) -> bool:
    """Return whether a load may act in another form at rest."""
    return type(load).resting is not Load.resting


def _resting(load: Load, t: float, ends: Sequence[End], z: Vector, softness: float, most: float) -> Load:
    """Return a load as it acts about a rest, so soft that none of its forces is above `most` (N) there."""
    found = load.resting(ends, softness)
    if found is None:
        return load
    if load.may_part and most > 0.0 and softness > 0.0:
        for _ in range(HALVINGS):
            if np.abs(found.action(t, ends, z).wrenches[:, :3]).max() <= most:
                break
            softness *= 0.5
            found = load.resting(ends, softness) or found
    return found


def rested_states(model: Model, t: float, y: Vector) -> Vector:
    """Return the internal states of all loads where a state y of a model that is `at_rest` has come to rest."""
    scene, z = model.route.state(t, y), model.parts(y)[2].copy()
    for i, load in enumerate(model.loads if len(z) else ()):
        z[model.load_states[i]] = load.rested(scene.load_ends(i), z[model.load_states[i]])
    return z


def model_in_state(scene: object, t: float | None, start: Start, what: str) -> tuple[Model, float, Vector, Vector]:
    """Return a model that is `at_rest` with the internal states of a state, time, q and u: see `started_model`."""
    model, time, y = started_model(scene, t, start, what)
    q, u, _ = model.parts(y)
    return at_rest(model, time, y), time, q, u


def started_model(scene: object, t: float | None, start: Start, what: str) -> tuple[Model, float, Vector]:
    """Return a model that starts with the internal states of a state, time, and that state (q, u, z).

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
    if model.rigid_contacts and not (start is not None and knows_states(model, start)):
        y = touched_at_start(model, time, y)
    z = model.parts(y)[2]
    if not np.array_equal(z, model.initial_states):
        model = replace(model, initial_states=z)
    return model, time, y
