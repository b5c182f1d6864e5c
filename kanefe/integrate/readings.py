"""What a controller or an output reads of a state, one number at a time."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from kanefe.equations.model import Model
from kanefe.frames import Vector, euler_parameters_from_matrix, rotation_vector
from kanefe.tree.reading_terms import terms_of
from kanefe.tree.scene_state import SceneState

if TYPE_CHECKING:
    from kanefe.loads.controller import Reading

Read = Callable[[float, Vector, Callable[[], SceneState]], float]


def reader(model: Model, reading: Reading) -> Read:
    """Return what reads one number of a state."""
    i, terms = reading.component, terms_of(model, reading)
    if terms is not None and len(terms) == 1 and terms[0][1] == 1.0:
        at = terms[0][0]
        return lambda t, y, state: float(y[at])
    if reading.what not in _VECTORS:
        return lambda t, y, state: reading.of(state())
    vector = partial(_VECTORS[reading.what], model, reading)

    def read(t: float, y: Vector, state: Callable[[], SceneState]) -> float:
        value = vector(t, y, state())
        if reading.is_own:
            value = state().rotation(reading.body, reading.interface).T @ value
        return float(value[i])

    return read


def _position(model: Model, reading: Reading, t: float, y: Vector, state: SceneState) -> Vector:
    return state.position(reading.body, reading.interface)


def _rotation(model: Model, reading: Reading, t: float, y: Vector, state: SceneState) -> Vector:
    return rotation_vector(euler_parameters_from_matrix(state.rotation(reading.body, reading.interface)))


def _velocity(model: Model, reading: Reading, t: float, y: Vector, state: SceneState) -> Vector:
    return state.velocity(reading.body, reading.interface)


def _angular_velocity(model: Model, reading: Reading, t: float, y: Vector, state: SceneState) -> Vector:
    A = state.rotation(reading.body, reading.interface)
    return np.asarray(A @ state.angular_velocity(reading.body, reading.interface))


def _acceleration(model: Model, reading: Reading, t: float, y: Vector, state: SceneState) -> Vector:
    return _accelerations(model, reading, t, y)[0]


def _angular_acceleration(model: Model, reading: Reading, t: float, y: Vector, state: SceneState) -> Vector:
    return _accelerations(model, reading, t, y)[1]


def _accelerations(model: Model, reading: Reading, t: float, y: Vector) -> tuple[Vector, Vector]:
    """Return the accelerations of a frame in N, with the drives as they were before the sample."""
    route, du = model.route, model.parts(model.route.evaluate(t, y).rates)[1]
    view, du = route.acting(t, y, du)
    rates = np.concatenate((du, view.driven_rates))
    frame = None
    if reading.interface:
        frame = view.model.flexible_terms(reading.body).body.interface(reading.interface)
    F = view.motion(model.index(reading.body), frame)
    return F.A_NF @ (F.V @ rates + F.Z), F.A_NF @ (F.W @ rates + F.Y)


_VECTORS: dict[str, Callable[..., Vector]] = {
    "position": _position,
    "rotation": _rotation,
    "velocity": _velocity,
    "angular_velocity": _angular_velocity,
    "acceleration": _acceleration,
    "angular_acceleration": _angular_acceleration,
}
