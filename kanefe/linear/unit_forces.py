"""Generalised forces of unit loads at a state; accelerations are linear in them."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from kanefe.bodies.flexible import InterfaceFrame
from kanefe.frames import Matrix, Vector
from kanefe.loads.functions import Constant
from kanefe.loads.valued_load import ValuedLoad
from kanefe.states.interactions import generalised_force
from kanefe.states.kinematics import elastic_partial_rates, elastic_state
from kanefe.states.state import State
from kanefe.tree.load_names import scene_loads
from kanefe.tree.model_data import ModelData

if TYPE_CHECKING:
    from kanefe.tree.load_names import SceneLoad

SPACE = 3


def load_values(state: State) -> Vector:
    """Return the values of functions of the user that depend on the state, in the order of `load_columns`."""
    parts = [np.atleast_1d(load.value(state.t, state)) for load in scene_loads(state.model) if _looks(load)]
    for i, load in enumerate(state.model.loads):
        if load.input_count:
            parts.append(load.inputs(state.t, state.load_ends(i), state.load_states(i)))
    return np.concatenate([np.zeros(0), *parts])


def load_columns(state: State) -> Matrix:
    """Return the generalised forces (free, k) of unit values, in the order of `load_values`."""
    n = state.model.free_count
    columns = [np.zeros((n, 0))]
    columns += [scene_load_columns(state, load) for load in scene_loads(state.model) if _looks(load)]
    for i, load in enumerate(state.model.loads):
        if load.input_count:
            units = load.input_wrenches(state.t, state.load_ends(i))
            columns.append(np.column_stack([generalised_force(state, load.ends, unit)[:n] for unit in units]))
    return np.column_stack(columns)


def _looks(load: ValuedLoad) -> bool:
    return load.takes_state and not load.is_constant


def scene_load_columns(state: State, load: SceneLoad) -> Matrix:
    """Return the generalised forces (free, values) of unit values of a load of the scene."""
    model, n = state.model, state.model.free_count
    number, interface = carrier(model, load)
    body, G = model.bodies[number], state.motions[number]
    for motor in body.joint_loads:
        if motor is load:
            column = np.zeros((n, 1))
            column[body.speeds[motor.coordinate]] = 1.0
            return column
    for force, _ in body.loads:
        if force is load:
            frame = state.motion(number, interface)
            wrenches = [replace(force, **_unit(axis)).wrench(0.0, frame) for axis in np.eye(SPACE)]
            return np.column_stack([(frame.V.T @ f + frame.W.T @ m)[:n] for f, m in wrenches])
    field = next(one for one in body.field_loads if one is load)
    eta, _ = elastic_state(body.flexible, state.q, state.full, False)  # type: ignore[arg-type]  # on flexible bodies
    rates = elastic_partial_rates(body.flexible, G.V.shape[1])  # type: ignore[arg-type]
    units = [1.0] if field.is_pressure else list(np.eye(SPACE))
    parts = [replace(field, **_unit(unit)).forces(0.0, G.A_NF, eta) for unit in units]
    return np.column_stack([(G.V.T @ f + G.W.T @ m + rates.T @ e)[:n] for f, m, e in parts])


def carrier(model: ModelData, load: SceneLoad) -> tuple[int, InterfaceFrame | None]:
    """Return the body of a load, and the interface it acts on."""
    for number, body in enumerate(model.bodies):
        for other, interface in body.loads:
            if other is load:
                return number, interface
        if any(other is load for other in (*body.joint_loads, *body.field_loads)):
            return number, None
    raise TypeError("the load belongs to another model")


def _unit(value: object) -> dict[str, Any]:
    """Return the fields of a load with this constant value."""
    return {"function": Constant(value), "takes_state": False}
