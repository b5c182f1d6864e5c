"""The start of a frozen scene: loops closed, and loads between frames in their initial state; or a given state."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from kanefe.equations.contact_masses import with_contact_masses
from kanefe.equations.given_state import Start, given_state, knows_states, slack_time
from kanefe.equations.joint_frictions import with_joint_frictions
from kanefe.equations.joint_stops import joint_stops
from kanefe.equations.model import Model
from kanefe.equations.routes import starting_route
from kanefe.frames import Vector
from kanefe.loads.base import Load
from kanefe.tree.model_data import ModelData


def model_at_start(data: ModelData, loads: Sequence[Load], t: float, start: Start = None) -> Model:
    """Return the model of a frozen scene with a consistent start at time t (s), and its loads between frames.

    To close loops, joints whose start is not given move first, then all joints, then also elastic coordinates, each
    only if the loops do not close otherwise; likewise speeds: see `kanefe.kane.consistent_start`. A given start that
    moves is told by a `StartWarning`. Springs without a rest length are slack at that start, also if the model then
    starts from another state.
    Dry friction in joints is a separate load, and so are stops with a restitution: see
    `kanefe.equations.joint_frictions` and `joint_stops`.

    Raises
    ------
    ModelError
        If a loop cannot be closed (the message names it and its remaining opening) or no speeds keep it closed, a load
        has no valid initial state, or the given state is not valid.
    """
    slack = slack_time(start, t)
    model = replace(Model.of(data.with_loads(())), slack_time=slack)
    if model.constraints:
        q, u, _ = model.parts(starting_route(model).start(slack))
        if not (np.array_equal(q, model.initial_coordinates) and np.array_equal(u, model.initial_speeds)):
            model = replace(model, initial_coordinates=q, initial_speeds=u)
            if start is None:
                _warn_of_mended(model, slack)
    loads = (*loads, *joint_stops(model.with_loads(loads)))
    loads = with_contact_masses(model, loads)
    if loads:
        model = model.with_loads(starting_route(model).started(slack, loads))
    model = with_joint_frictions(model, slack)
    if start is None:
        parts = model.initial_coordinates, model.initial_speeds, model.initial_states
        return replace(model, initial_states=_anchored(model, slack, *parts))
    _, y = given_state(model, t, start, "the run")
    q, u, z = model.parts(starting_route(model).projected(t, y))
    if not knows_states(model, start):
        z = _anchored(model, t, q, u, z)
    return replace(model, initial_coordinates=q, initial_speeds=u, initial_states=z)


def _warn_of_mended(model: Model, t: float) -> None:
    from kanefe.kane.start_report import warn_of_mended

    warn_of_mended(model, t)


def _anchored(model: Model, t: float, q: Vector, u: Vector, z: Vector) -> Vector:
    """Return internal states in which friction holds bodies at rest, or slips: see `kanefe.kane.anchored_start`."""
    if model.has_unreduced or not any(load.kind in {"friction", "contact"} for load in model.loads):
        return z
    from kanefe.kane.anchored_start import with_balanced_anchors

    return with_balanced_anchors(model, t, q, u, z)
