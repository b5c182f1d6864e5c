"""Stiffness of flexible bodies, and what changes with the state: of stops in joints, between markers."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kanefe.frames import Matrix, Vector
from kanefe.kane.interactions import add_load_slopes
from kanefe.tree.model_data import ModelData

if TYPE_CHECKING:
    from kanefe.kane.state import State


def elastic_stiffness(model: ModelData) -> Matrix:
    """Return K of the flexible bodies over the free speeds, (free, free)."""
    K = np.zeros((model.free_count, model.free_count))
    for body in model.bodies:
        if body.flexible:
            k, at = body.flexible.body.free_count, body.flexible.speeds
            K[at, at] = body.flexible.body.stiffness[:k, :k]
    return K


def constant_tangents(model: ModelData) -> tuple[Matrix, Matrix]:
    """Return K and C of flexible bodies and of springs and dampers in joints over the free speeds, (free, free)."""
    K = elastic_stiffness(model)
    C = np.zeros_like(K)
    for body in model.bodies:
        for where, force in zip(body.speeds, body.joint.coordinate_forces, strict=True):
            if force is not None and where < model.free_count:
                K[where, where], C[where, where] = force.stiffness, force.damping
        if body.flexible:
            k, at = body.flexible.body.free_count, body.flexible.speeds
            if body.flexible.damping is not None:
                C[at, at] = body.flexible.damping[:k]
    return K, C


def joint_tangents(state: State) -> tuple[Vector, Vector]:
    """Return stiffness and damping along the free speeds by the springs, dampers and stops of joints at a state."""
    model = state.model
    k, c = np.zeros(model.free_count), np.zeros(model.free_count)
    for body in model.bodies:
        if not body.has_coordinate_forces:
            continue
        at = body.joint_coordinates(state.t, state.q)
        for x, where, force in zip(at, body.speeds, body.joint.coordinate_forces, strict=True):
            if force is not None and where < model.free_count:
                k[where], c[where] = force.slopes(float(x), float(state.full[where]))
    return k, c


def current_tangents(state: State, K: Matrix, C: Matrix) -> tuple[Matrix, Matrix]:
    """Return K and C over the free speeds with what the state adds to constant ones; the same if nothing does.

    Parameters
    ----------
    state : State
    K, C : ndarray, shape (free, free)
        Of flexible bodies and of the springs and dampers of joints.
    """
    model = state.model
    if not model.has_varying_tangents:
        return K, C
    K, C = K.copy(), C.copy()
    for body in model.bodies:
        for where, force in zip(body.speeds, body.joint.coordinate_forces, strict=True):
            if force is not None and where < len(K):
                K[where, where] -= force.stiffness
                C[where, where] -= force.damping
    for X, along in zip((K, C), joint_tangents(state), strict=True):
        X[np.diag_indices(len(X))] += along
    add_load_slopes(state, K, C)
    return K, C
