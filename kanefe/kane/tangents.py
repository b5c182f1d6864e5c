"""Stiffness of flexible bodies, and what changes with the state: of friction and stops in joints, between markers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kanefe.frames import Matrix, Vector
from kanefe.kane.interactions import add_interaction_slopes
from kanefe.kane.kinematics import FrameMotion
from kanefe.tree.model_data import ModelData


def elastic_stiffness(model: ModelData) -> Matrix:
    """Return K of the flexible bodies over the free speeds, (free, free)."""
    K = np.zeros((model.free_count, model.free_count))
    for body in model.bodies:
        if body.flexible:
            k, at = body.flexible.body.free_count, body.flexible.speeds
            K[at, at] = body.flexible.body.stiffness[:k, :k]
    return K


def current_tangents(
    model: ModelData, motions: Sequence[FrameMotion], t: float, q: Vector, u: Vector, K: Matrix, C: Matrix
) -> tuple[Matrix, Matrix]:
    """Return K and C over the free speeds with what the state adds to constant ones; the same if nothing does.

    Parameters
    ----------
    model : ModelData
    motions : sequence of FrameMotion
        The outward sweep.
    t : float
        s.
    q, u : ndarray
        Coordinates, and all speeds.
    K, C : ndarray, shape (free, free)
        Of flexible bodies and of the springs and dampers of joints.
    """
    if not model.has_varying_tangents:
        return K, C
    K, C = K.copy(), C.copy()
    for body in model.bodies:
        if not body.has_coordinate_forces:
            continue
        at = body.joint_coordinates(t, q)
        for x, where, force in zip(at, body.speeds, body.joint.coordinate_forces, strict=True):
            if force is not None and where < len(K):
                k, c = force.slopes(float(x), float(u[where]))
                K[where, where] += k - force.stiffness
                C[where, where] += c - force.damping
    add_interaction_slopes(model, motions, t, q, u, K, C)
    return K, C
