"""Stiffness and damping of flexible bodies, and of springs, dampers and stops in joints."""

from __future__ import annotations

import numpy as np

from kanefe.frames import Matrix, Vector
from kanefe.tree.model_data import ModelData
from kanefe.tree.scene_state import SceneState


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


def joint_tangents(state: SceneState) -> tuple[Vector, Vector]:
    """Return stiffness and damping along the free speeds by the springs, dampers and stops of joints at a state."""
    model = state.model
    k, c = np.zeros(model.free_count), np.zeros(model.free_count)
    for body in model.bodies:
        if not body.has_coordinate_forces:
            continue
        at = body.joint_coordinates(state.time, state.q)
        for x, where, force in zip(at, body.speeds, body.joint.coordinate_forces, strict=True):
            if force is not None and where < model.free_count:
                k[where], c[where] = force.slopes(float(x), float(state.full[where]))
    return k, c
