"""What loads do on their ends is compiled in equilibria: no contact is detected in Python at each state of a search."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from kanefe.contact import contact_evaluation
from kanefe.linear.imbalance import force_sizes
from kanefe.linear.small_motions import SmallMotions
from kanefe.literal.route import LiteralRoute
from order_n_rates import T, order_n
from random_scenes import Recipe, random_model
from scenes import random_state


def plate(corners: int) -> kf.System:
    """Return a plate on a plane, on as many points along each side."""
    scene = kf.System(gravity=(0, 0, -9.81))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane())
    side = np.linspace(-0.5, 0.5, corners)
    body = scene.add_rigid_body("plate", 10.0, (1, 1, 2), joint=kf.Free())
    feet = [body.frame(at=(x, y, 0.0)) for x in side for y in side]
    scene.add_contact("feet", feet, floor, normal=kf.HuntCrossley(1e6, 0.2), friction=kf.Coulomb(0.5))
    return scene


@pytest.mark.parametrize("seed", range(8))
def test_wrenches_are_those_of_the_literal_route(seed: int) -> None:
    model = random_model(Recipe(seed, bodies=8, elastic=0.4, between=5))
    q, u = random_state(model, seed)
    y = np.concatenate((q, u, model.initial_states))
    found, literal = (route.wrenches_of_loads(T, y) for route in (order_n(model), LiteralRoute(model)))
    assert found.keys() == literal.keys()
    for number, wrenches in literal.items():
        size = 1.0 + np.abs(wrenches).max()
        np.testing.assert_allclose(found[number], wrenches, rtol=0, atol=1e-12 * size)


def test_wrenches_of_contacts_are_those_of_the_literal_route() -> None:
    model = plate(3).freeze()
    y = model.initial_state.copy()
    y[2] = -1e-3  # pressed in
    found, literal = (route.wrenches_of_loads(0.0, y)[0] for route in (order_n(model), LiteralRoute(model)))
    assert abs(literal).max() > 1.0
    np.testing.assert_allclose(found, literal, rtol=0, atol=1e-12 * abs(literal).max())


def test_sizes_bound_the_forces_of_contacts() -> None:
    model = plate(3).freeze()
    q = model.initial_coordinates.copy()
    q[2] = -1e-3
    small = SmallMotions(model, 0.0, q, np.zeros(6))
    sizes, forces = force_sizes(small.here), model.forces(0.0, np.concatenate((q, np.zeros(6), model.initial_states)))
    assert np.all(sizes >= np.abs(forces) * (1.0 - 1e-12))
    assert sizes[:3] == pytest.approx(sizes[2], rel=1e-9)  # a force of any direction
    # each foot counts with its arm, though their moments cancel
    arms = np.hypot(*np.meshgrid((-0.5, 0.0, 0.5), (-0.5, 0.0, 0.5)))
    assert sizes[3] == pytest.approx((sizes[2] - 10.0 * 9.81) * arms.mean(), rel=1e-6)


def test_detections_in_python_do_not_grow_with_states(monkeypatch: pytest.MonkeyPatch) -> None:
    model = plate(2).freeze()
    calls, plain = [], contact_evaluation.InPython.__init__
    monkeypatch.setattr(
        contact_evaluation.InPython, "__init__", lambda self, *given: calls.append(1) or plain(self, *given)
    )
    for depth in np.linspace(0.0, 1e-3, 20):
        q = model.initial_coordinates.copy()
        q[2] = -depth
        force_sizes(SmallMotions(model, 0.0, q, np.zeros(6)).here)
    assert not calls
