"""Bodies in a fluid, by both routes: mass matrices, energies and momenta of random trees."""

from __future__ import annotations

import numpy as np
import pytest

from kanefe.kane.assemble import mass_matrix
from kanefe.kane.energy import elastic_energy, gravity_energy, kinetic_energy, momenta
from kanefe.states.state import State
from order_n_rates import T, order_n
from random_scenes import Recipe, random_model
from scenes import random_state


@pytest.mark.parametrize("seed", range(6))
def test_mass_energies_and_momenta_are_those_of_the_literal_route(seed: int) -> None:
    model = random_model(Recipe(seed, bodies=6, elastic=0.8, has_fluid=True))
    assert order_n(model).flexible.bodies.size
    q, u = random_state(model, seed)
    y, state = np.concatenate((q, u, np.zeros(2))), State(model, T, q, u)
    found, expected = order_n(model).mass_matrix(T, y[:-2]), mass_matrix(state)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13 * abs(expected).max())
    balances = order_n(model).sweeps(np.array([T]), y[None]).balances[0]
    wanted = [kinetic_energy(state), elastic_energy(state), gravity_energy(state), *np.concatenate(momenta(state))]
    np.testing.assert_allclose(balances, wanted, rtol=0, atol=1e-13 * (1.0 + abs(np.array(wanted)).max()))
