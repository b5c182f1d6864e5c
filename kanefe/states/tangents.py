"""Stiffness and damping of a scene at a state: of stops in joints, and of loads between markers."""

from __future__ import annotations

import numpy as np

from kanefe.frames import Matrix
from kanefe.states.interactions import add_load_slopes
from kanefe.states.state import State
from kanefe.tree.tangents import joint_tangents


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
