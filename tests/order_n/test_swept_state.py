"""What functions of the user see in order n equals the literal route in random scenes, and is swept once."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings

import kanefe as kf
from kanefe.order_n.swept_state import MotionsKernel
from kanefe.states.state import State
from random_scenes import Recipe, random_model, recipes
from scenes import random_state

POINT = (0.1, -0.2, 0.3)


@settings(max_examples=25, derandomize=True, deadline=None, database=None)
@given(recipes(bodies=12, elastic=0.4, between=4))
def test_motions_equal_those_of_the_literal_route(recipe: Recipe) -> None:
    model = random_model(recipe)
    q, u = random_state(model, recipe.seed)
    y = np.concatenate((q, u, model.initial_states))
    swept, literal = model.route.state(0.3, y), State(model, 0.3, q, u)
    # round-off of sums over a chain of a dozen bodies of about a metre at some rad/s
    close = {"rtol": 1e-12, "atol": 1e-11}
    for body in model.bodies:
        interfaces = [] if body.flexible is None else [frame.name for frame in body.flexible.body.interfaces]
        for interface in ("", *interfaces):
            where = body.name, interface
            for point in ((), (POINT,)):
                np.testing.assert_allclose(swept.position(*where, *point), literal.position(*where, *point), **close)
                np.testing.assert_allclose(swept.velocity(*where, *point), literal.velocity(*where, *point), **close)
            np.testing.assert_allclose(swept.rotation(*where), literal.rotation(*where), **close)
            np.testing.assert_allclose(swept.angular_velocity(*where), literal.angular_velocity(*where), **close)
    for number in range(len(model.loads)):
        for ours, theirs in zip(swept.load_ends(number), literal.load_ends(number), strict=True):
            for a, b in zip(ours, theirs, strict=True):
                np.testing.assert_allclose(a, b, **close)


def test_functions_share_one_sweep(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    parent = scene.ground
    for i in range(5):
        parent = scene.add_rigid_body(f"link {i}", 1.0, 0.1, parent=parent, at=(0.3, 0, 0), joint=kf.Revolute("y"))
        scene.add_motor(parent, lambda t, state, name=f"link {i}": 0.1 * state.position(name)[2])
        scene.add_motor(parent, lambda t, state, name=f"link {i}": -0.1 * state.velocity(name)[2])
    model = scene.freeze()
    swept: list[float] = []
    rows = MotionsKernel.rows

    def counted(kernel: MotionsKernel, t: float, y: np.ndarray) -> np.ndarray:
        swept.append(t)
        return rows(kernel, t, y)

    monkeypatch.setattr(MotionsKernel, "rows", counted)
    model.rhs(0.0, model.initial_state)
    assert len(swept) == 1


def test_what_a_function_writes_to_is_its_own() -> None:
    scene = kf.System()
    body = scene.add_rigid_body("body", 1.0, 0.1, joint=kf.Prismatic("x", position=0.2))

    def careless(t: float, state: kf.SceneState) -> float:
        position = state.position("body")
        position += 1.0
        state.rotation("body")[:] = 0.0
        return float(state.position("body")[0])

    scene.add_motor(body, careless)
    model = scene.freeze()
    np.testing.assert_allclose(model.rhs(0.0, model.initial_state)[1], 0.2, rtol=1e-15)
