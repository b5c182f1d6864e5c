"""A state computes its motions, matrices, forces and energies once, however many ask."""

import numpy as np
import pytest

import kanefe.states.state as state_module
from kanefe.kane.assemble import accelerations, mass_matrix
from kanefe.kane.energy import (
    dissipated_power,
    elastic_energy,
    gravity_energy,
    kinetic_energy,
    load_power,
    momenta,
)
from kanefe.states.state import State
from random_scenes import Recipe, random_model


@pytest.fixture
def sweeps(monkeypatch):
    """Count outward sweeps."""
    made = []
    sweep = state_module.sweep_outward

    def counted(*arguments):
        made.append(arguments[1])
        return sweep(*arguments)

    monkeypatch.setattr(state_module, "sweep_outward", counted)
    return made


def scene():
    model = random_model(Recipe(seed=3, bodies=6, elastic=0.4, loads=4, between=3))
    rng = np.random.default_rng(1)
    return model, State(model, 0.3, model.initial_coordinates, rng.normal(size=model.free_count))


def test_one_sweep_for_all_energies_of_a_state(sweeps):
    _, state = scene()
    sweeps.clear()  # that of the start
    for energy in (kinetic_energy, elastic_energy, gravity_energy, dissipated_power, load_power, momenta):
        energy(state)
    assert len(sweeps) == 1


def test_one_sweep_for_what_equations_and_users_ask_of_a_state(sweeps):
    model, state = scene()
    sweeps.clear()
    mass_matrix(state)
    accelerations(state)
    state.position(model.bodies[-1].name)
    kinetic_energy(state)
    assert len(sweeps) == 1


def test_one_sweep_for_an_energy_of_the_literal_route(sweeps):
    model, state = scene()
    sweeps.clear()
    model.literal.energy(0.3, np.concatenate((state.q, state.u, state.z, np.zeros(2))))
    assert len(sweeps) == 1


def test_functions_of_a_state_are_computed_once():
    _, state = scene()
    assert mass_matrix(state) is mass_matrix(state)
