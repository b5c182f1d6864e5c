"""Rates of what the linearly implicit sweep does not know: damping and stiffness of the user's functions, measured."""

from __future__ import annotations

import numpy as np

from kanefe.equations.model import Model
from kanefe.integrate.dynamics import DIFFERENCE, Dynamics
from kanefe.loads.controller import Held
from kanefe.storage.scipy_later import scipy
from kanefe.tree.scales import coordinate_moves, state_scales

ROUNDS = 4
"""Largest number of iterations for the largest rate: functions that act along few coordinates need two."""


def look_at_state(model: Model) -> bool:
    """Return whether functions of the user on single bodies and joints depend on the state.

    What a sampled controller holds does not: within a step it is constant.
    """
    return any(
        load.takes_state and not isinstance(load.function, Held)
        for body in model.bodies
        for load in (*(load for load, _ in body.loads), *body.joint_loads, *body.field_loads)
    )


def rate_of_functions(dynamics: Dynamics, t: float) -> float:
    """Return the largest decay rate or frequency in rad/s that such functions bring at the start (s), by a few calls.

    By power iterations on differences of the rates, those of speeds and those of deflections, less what elastic bodies,
    springs and dampers in joints have in them.
    """
    model = dynamics.model
    if not look_at_state(model):
        return 0.0
    n, m, y = model.coordinate_count, model.free_count, dynamics.initial_state(t)
    state = model.literal.view(t, y)
    K, C = model.literal.tangents(state)
    factors = scipy.linalg.lu_factor(model.route.mass_matrix(t, y)[:m, :m])
    straight = np.array([(at, speed) for turns, at, speed in coordinate_moves(model) if not turns], dtype=int)
    straight = straight.reshape(-1, 2)
    scales, rng = state_scales(model), np.random.default_rng(0)

    def size(places: np.ndarray, speeds: np.ndarray, known: np.ndarray) -> float:
        """Return the size of the largest eigenvalue of the derivatives by some components of the state."""
        x, found = np.zeros(m), 0.0
        x[speeds] = rng.standard_normal(len(speeds)) * scales[places]
        for _ in range(ROUNDS if len(speeds) else 0):
            direction = np.zeros(len(y))
            direction[places] = x[speeds]
            reach = DIFFERENCE / np.abs(direction / scales).max()
            ahead, behind = dynamics.rate(t, y + reach * direction), dynamics.rate(t, y - reach * direction)
            x_before, x = x, np.zeros(m)
            change = (ahead - behind)[n : n + m] / (2.0 * reach)
            change += scipy.linalg.lu_solve(factors, known @ x_before)
            x[speeds] = change[speeds]
            found = float(np.linalg.norm(x) / np.linalg.norm(x_before))
            if not 0.0 < found < np.inf:
                break
        return found

    everything = np.arange(m)
    of_damping, of_stiffness = size(n + everything, everything, C), size(straight[:, 0], straight[:, 1], K)
    return max(of_damping, float(np.sqrt(of_stiffness)))
