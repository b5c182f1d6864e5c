"""The start of a frozen scene: loops closed, and loads between frames in their initial state; or a given state."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from kanefe.equations.body_relaxations import body_relaxations, with_relaxed_bodies
from kanefe.equations.contact_masses import with_contact_masses
from kanefe.equations.given_state import Start, given_state, knows_states
from kanefe.equations.joint_frictions import with_joint_frictions
from kanefe.equations.joint_stops import joint_stops
from kanefe.equations.model import Model
from kanefe.equations.routes import starting_route
from kanefe.frames import Vector
from kanefe.loads.base import Load
from kanefe.tree.model_data import ModelData


def scene_model(data: ModelData, loads: Sequence[Load], t: float) -> Model:
    """Return the model of a frozen scene with the start that was given in it, and its loads between frames.

    To close loops, joints whose start is not given move first, then all joints, then also elastic coordinates, each
    only if the loops do not close otherwise; likewise speeds: see `kanefe.literal.consistent_start`. Springs without a
    rest length are slack at that start, at time t (s), also if a run starts from another state (`model_at_start`).
    Dry friction in joints is a separate load, and so are stops with a restitution: see
    `kanefe.equations.joint_frictions` and `joint_stops`; and the arms of viscoelastic bodies: `body_relaxations`.

    Raises
    ------
    ModelError
        If a loop cannot be closed (the message names it and its remaining opening) or no speeds keep it closed, or a
        load has no valid initial state.
    """
    model = replace(Model.of(data.with_loads(())), slack_time=t)
    if model.constraints:
        q, u, _ = model.parts(starting_route(model).start(t))
        model = replace(model, initial_coordinates=q, initial_speeds=u)
    loads = (*loads, *joint_stops(model.with_loads(loads)))
    loads = (*loads, *body_relaxations(model.with_loads(loads)))
    loads = with_contact_masses(model, loads)
    if loads:
        model = model.with_loads(starting_route(model).started(t, loads))
    return with_joint_frictions(model, t)


def model_at_start(model: Model, t: float, start: Start = None) -> Model:
    """Return the model of a scene at its start at time t (s): that of the scene, or a given one.

    A start given in the scene that loops have moved is told by a `StartWarning`.

    Raises
    ------
    ModelError
        If the given state is not valid.
    """
    if start is None:
        if model.constraints:
            from kanefe.equations.start_report import warn_of_mended

            warn_of_mended(model, t)
        q, u, z = model.parts(model.initial_state)
        return model.with_start(q, u, _anchored(model, t, q, u, z))
    _, y = given_state(model, t, start, "the run")
    q, u, z = model.parts(starting_route(model).projected(t, y))
    if not knows_states(model, start):
        z = _anchored(model, t, q, u, z)
        if any(load.kind == "relaxation" for load in model.loads):
            z = with_relaxed_bodies(model, starting_route(model).state(t, np.concatenate((q, u, z))), z)
    return model.with_start(q, u, z)


def _anchored(model: Model, t: float, q: Vector, u: Vector, z: Vector) -> Vector:
    """Return internal states in which friction holds bodies at rest, or slips: see `anchored_start` beside this."""
    if model.has_unreduced or not any(load.kind in {"friction", "contact"} for load in model.loads):
        return z
    from kanefe.equations.anchored_start import with_balanced_anchors

    return with_balanced_anchors(model, t, q, u, z)
