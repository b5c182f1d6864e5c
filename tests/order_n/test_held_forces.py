"""Forces that more than six fixed components of a body share are told of all states at once, as the oracle has them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import kanefe as kf
from kanefe.bodies.relaxation import Relaxation
from kanefe.equations.model import Model
from kanefe.literal.run_forces import LiteralForces
from kanefe.order_n import held_forces
from kanefe.order_n.held_forces import are_served
from kanefe.tree.neighbours import parts_of
from order_n_rates import order_n
from random_scenes import Recipe, random_model
from scenes import lattice_body, random_state

SEEDS = (14, 17, 18, 29, 38, 48)
"""Seeds of scenes that have such bodies."""


def states_of(model: Model, seed: int) -> tuple[np.ndarray, np.ndarray]:
    states = [np.concatenate((*random_state(model, seed + 100 * k), model.initial_states)) for k in range(3)]
    return np.linspace(0.1, 0.3, 3), np.array(states)


@pytest.mark.parametrize("seed", SEEDS)
def test_random_scenes(seed: int) -> None:
    model = random_model(Recipe(seed, bodies=8, elastic=0.6, loads=4, between=5))
    told, given = order_n(model).force_kernel.told, states_of(model, seed)
    forces = order_n(model).sweeps(*given).forces
    literal = LiteralForces.of_states(order_n(model), *given)
    shared = told.undetermined - told.by_reaction.keys()
    assert shared
    for number in shared:
        expected = literal.part(number)
        np.testing.assert_allclose(forces.part(number), expected, rtol=0, atol=1e-11 * (1.0 + np.abs(expected).max()))


def relaxing(body: kf.FlexibleBody) -> kf.FlexibleBody:
    """The body with two arms that pull on all of its coordinates."""
    k = body.free_count
    factors = np.sqrt(0.1 * np.diag(body.stiffness)[:k, None]) * np.random.default_rng(3).standard_normal((k, 2))
    return replace(body, relaxation=Relaxation(factors, np.array((0.02, 0.3))))


@pytest.mark.parametrize("slopes", ["rotation-vector", "tait-bryan"])
@pytest.mark.parametrize("hinged", [False, True])
def test_a_damped_body_that_is_held_at_both_ends_and_carries_another(
    hinged: bool, slopes: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = kf.System(gravity=(0.3, -0.2, -9.81), slopes=slopes)
    carrier = scene.add_rigid_body("carrier", 2.0, (0.1, 0.2, 0.25), joint=kf.Free())
    ends = {"root": "clamped", "tip": kf.Interface(fixed=("rx", "y", "z")) if hinged else "clamped"}
    reduction, damping = kf.CraigBampton(modes=3), kf.RayleighDamping(0.1, 0.001)
    body = relaxing(lattice_body(1, interfaces=ends, interior=1, reduction=reduction, damping=damping))
    held = scene.add_flexible_body("held", body, parent=carrier)
    bob = scene.add_rigid_body("bob", 1.0, 0.1, parent=held.interface("tip"), joint=kf.Revolute("y"))
    scene.add_spring("spring", held.node(3), scene.ground, stiffness=50.0, damping=2.0)
    scene.add_spring("other", held.interface("root"), bob.frame(at=(0.1, 0.2, 0.3)), stiffness=20.0)
    scene.add_force(held.interface("tip"), (1.0, 2.0, 3.0))
    model = scene.freeze()
    assert are_served(model, model.index("held"))
    times, states = states_of(model, 1)
    given = times, states + np.arange(states.shape[1]) * (np.arange(states.shape[1]) >= states.shape[1] - 2)
    expected = LiteralForces.of_states(order_n(model), *given)
    parts = [i for i, part in enumerate(parts_of(model)) if part.body == model.index("held")]
    wanted = [expected.part(i) for i in parts]
    monkeypatch.setattr(LiteralForces, "of_states", lambda *given: pytest.fail("state by state"))
    monkeypatch.setattr(held_forces, "AT_ONCE", 2)  # of three states
    forces = order_n(model).sweeps(*given).forces
    for number, own in zip(parts, wanted, strict=True):
        np.testing.assert_allclose(forces.part(number), own, rtol=0, atol=1e-11 * (1.0 + np.abs(own).max()))
