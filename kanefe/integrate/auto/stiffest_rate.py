"""The fastest natural frequency or decay of a scene as it starts."""

from __future__ import annotations

import numpy as np

from kanefe.equations.model import Model
from kanefe.frames import Matrix
from kanefe.kane.assemble import accelerations, mass_at_start
from kanefe.kane.state import State
from kanefe.kane.tangents import constant_tangents, current_tangents
from kanefe.storage.scipy_later import scipy


def stiffest_rate(model: Model, start: float) -> float:
    """Return the highest natural frequency or decay rate of the scene as it starts, in rad/s; zero without elasticity.

    Of K and C of flexible bodies and springs with the mass of the whole scene: a body on a hinge, or a light
    one on a stiff spring, vibrates faster than its own modes say.
    """
    state = State(model, start, model.initial_coordinates, model.initial_speeds)
    return highest_rate(model, start, *current_tangents(state, *constant_tangents(model)))


def highest_rate(model: Model, start: float, K: Matrix, C: Matrix) -> float:
    """Return the same for given matrices over the free speeds, with the mass of the scene as it starts."""
    if not (np.any(K) or np.any(C)):
        return 0.0
    M, n = mass_at_start(model, start), model.free_count
    try:
        squares, rates = (
            scipy.linalg.eigh(X, M, eigvals_only=True, subset_by_index=(n - 1, n - 1))[0] if np.any(X) else 0.0
            for X in (K, C)
        )
    except np.linalg.LinAlgError:
        accelerations(State(model, start, model.initial_coordinates, model.initial_speeds))  # names what has no inertia
        raise
    return float(max(np.sqrt(max(squares, 0.0)), rates))
