"""Rigid contacts in order n against the literal route, which is independent of it."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from kanefe.equations.model import Model
from kanefe.kane.assemble import accelerations, held_solver
from kanefe.kane.constraints import held_rows
from kanefe.kane.rigid_contacts.contact_forces import check_determined
from kanefe.kane.route import powers, state_rates
from kanefe.order_n.route import OrderN
from rigid_scenes import rigid_scene, rigid_state

T = 0.2


def literal_rates(model: Model, y: np.ndarray) -> tuple[np.ndarray, float] | None:
    """Return dy/dt and powers, and how far rows are from dependent; None where the forces are not determined."""
    state = model.literal.view(T, y)
    try:
        check_determined(state)
    except kf.SimulationError:
        return None
    weakest = 1.0
    if held_rows(state):
        solver = held_solver(state)
        if solver.rank < solver.row_count:
            return None
        values = np.linalg.svd(solver.scaled_rows)[1]
        weakest = float(values[-1] / values[0]) ** 2
    du = accelerations(state)
    rates = model.coordinate_rates(state.q, state.u), du, state_rates(state), powers(state, du)
    return np.concatenate(rates), weakest


@pytest.mark.parametrize("seed", range(40))
def test_random_scenes_accelerate_as_by_the_literal_route(seed):
    model = rigid_scene(seed)
    assert isinstance(model.route, OrderN)
    for number in range(3):
        y = rigid_state(model, 10 * seed + number)
        found = literal_rates(model, y)
        if found is None:
            continue
        rates, weakest = found
        own, _ = model.route.held_rates(T, np.append(y, (0.0, 0.0)))
        # round-off of the two ways through some hundred operations, over what rows lack to depend on each other
        np.testing.assert_allclose(own, rates, rtol=0.0, atol=1e-12 / weakest * np.abs(rates).max())
