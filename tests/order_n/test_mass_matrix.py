"""The mass matrix by one sweep is that of dense partial velocities, and takes no dense work in a chain of loops."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from exact_lines import random_beam
from kanefe.equations.model import Model
from kanefe.kane import assemble
from kanefe.states.state import State
from loop_scenes import four_bars
from order_n_rates import T, order_n
from random_loops import LoopScene
from random_scenes import Recipe, random_model
from scenes import random_state

SEEDS = range(12)


def check(model: Model, seed: int) -> None:
    """Compare in a random state, relative to the inertias along both speeds of each entry."""
    q, u = random_state(model, seed)
    found = order_n(model).mass_matrix(T, np.concatenate((q, u, model.initial_states)))
    literal = assemble.mass_matrix(State(model, T, q, u))
    sizes = np.sqrt(np.abs(np.diag(literal)))
    # round-off of the sums over the tree: a thousand additions at most
    np.testing.assert_array_less(np.abs(found - literal), 1e-12 * np.outer(sizes, sizes) + 1e-300)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("slopes", ["rotation-vector", "tait-bryan"])
def test_random_trees(seed: int, slopes: str) -> None:
    check(random_model(Recipe(seed, bodies=12, elastic=0.5, loads=3, between=2, slopes=slopes)), seed)


@pytest.mark.parametrize("seed", SEEDS)
def test_random_loops(seed: int) -> None:
    check(LoopScene(Recipe(seed, bodies=10, elastic=0.4), loops=3).scene.freeze(), seed)


@pytest.mark.parametrize("basis", ["splines", "mixed"])
def test_bodies_that_bend_far_carry_others(basis: str) -> None:
    scene = kf.System()
    strip = random_beam(1, "shear-deformable", basis)
    root = scene.add_rigid_body("root", 2.0, (0.1, 0.2, 0.25), joint=kf.Free())
    whip = scene.add_flexible_body("whip", strip, parent=root, joint=kf.Spherical())
    for number, place in enumerate(("middle", "tip")):
        joint = kf.Revolute((0.0, 0.6, 0.8))
        scene.add_rigid_body(f"bob {number}", 1.0, (0.1, 0.1, 0.2), parent=whip.interface(place), joint=joint)
    check(scene.freeze(), 3)


@pytest.mark.parametrize("layout", ["apart", "in a row", "one on the other"])
def test_linearisations_of_loops_have_no_dense_mass_matrix(layout: str, monkeypatch: pytest.MonkeyPatch) -> None:
    found = kf.equilibrium(four_bars(6, layout))
    calls, plain = [], assemble.rigid_masses
    monkeypatch.setattr(assemble, "rigid_masses", lambda *given: calls.append(1) or plain(*given))
    found.linearise()
    assert not calls
