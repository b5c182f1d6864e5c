"""Constraints that are switched on and off in a run: what holds, what it takes, and what is refused."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import kanefe as kf
from kanefe.constraints.rows import DirectionRow, PointRow
from kanefe.equations.model import Model
from kanefe.states.state import State
from kanefe.tree.model_data import QUADRATURES
from kanefe.tree.scene_state import SceneState
from random_loops import LoopScene, closed_state
from random_scenes import Recipe, recipes
from steel_beams import steel_beam

G, RADIUS = 9.81, 0.1


def landing(height: float = 0.5) -> tuple[kf.System, kf.Event]:
    """Return a full ball at 3 m/s above a rough floor, and the event at which it lands and rolls from then on."""
    scene = kf.System(gravity=(0, 0, -G))
    joint = kf.Free(position=(0, 0, height), velocity=(3, 0, 0))
    ball = scene.add_rigid_body("ball", 2.0, 0.4 * 2.0 * RADIUS**2, joint=joint)
    scene.add_rolling_ball("floor", ball, RADIUS, starts_on=False)

    def land(t: float, state: SceneState) -> np.ndarray:
        return state.switched(on="floor")

    return scene, kf.Event("lands", lambda t, state: state.position("ball")[2] - RADIUS, -1, action=land)


@pytest.mark.parametrize(
    "options", [{}, {"method": "vern9"}, {"method": "radau5"}, {"method": "generalised-alpha"}], ids=str
)
@pytest.mark.parametrize("is_literal", [False, True], ids=["compiled", "literal"])
def test_a_ball_that_lands_rolls_on(monkeypatch: Any, is_literal: bool, options: dict[str, str]) -> None:
    """Angular momentum about the contact stays: v = 5/7 v0, and the rest of the energy is dissipated."""
    if is_literal:
        if options.get("method") == "radau5":
            pytest.skip("radau5 needs sweeps")
        monkeypatch.setattr(Model, "route", Model.literal)
    scene, lands = landing()
    result = scene.simulate((0.0, 1.0), events=[lands], output_step=0.05, **options)
    assert result.status.is_finished
    assert result.events["lands"] == pytest.approx([np.sqrt(2.0 * (0.5 - RADIUS) / G)], abs=1e-9)
    rolls = result.times > result.events["lands"][0]
    np.testing.assert_allclose(result.velocity("ball")[rolls] - (15.0 / 7.0, 0.0, 0.0), 0.0, atol=1e-7)
    np.testing.assert_allclose(result.position("ball")[rolls, 2], RADIUS, atol=1e-10)
    taken = 0.5 * 2.0 * 9.0 * 2.0 / 7.0 + 2.0 * G * (0.5 - RADIUS)
    assert result.energy.dissipated[-1] == pytest.approx(taken, rel=1e-7)
    forces = result.loop_force("floor")
    np.testing.assert_allclose(forces[~rolls], 0.0, atol=0)
    np.testing.assert_allclose(np.linalg.norm(forces[rolls, :3], axis=1), 2.0 * G, rtol=1e-6)


def test_a_hook_lets_go_and_catches_again() -> None:
    """A cart on a spring comes back to rest where the hook held it, after one period."""
    scene = kf.System()
    spring = kf.CoordinateForce(stiffness=100.0, rest=0.2)
    cart = scene.add_rigid_body("cart", 1.0, joint=kf.Prismatic("x", forces=spring))
    scene.add_loop_joint("hook", kf.Fixed, scene.ground, cart, starts_on=True)
    events = [
        kf.Event("lets go", lambda t, state: t - 0.1, action=lambda t, state: state.switched(off="hook")),
        kf.Event(
            "is back",
            lambda t, state: state.joint_speeds("cart")[0],
            1,
            action=lambda t, state: state.switched(on=["hook"]),
        ),
    ]
    result = scene.simulate((0.0, 1.0), events=events, output_step=0.01)
    period = 2.0 * np.pi / 10.0
    assert result.events["is back"] == pytest.approx([0.1 + period], abs=1e-6)
    swings = (result.times > 0.1) & (result.times < 0.1 + period)
    wanted = 0.2 * (1.0 - np.cos(10.0 * (result.times[swings] - 0.1)))
    np.testing.assert_allclose(result.position("cart")[swings, 0], wanted, atol=1e-5)
    np.testing.assert_allclose(result.position("cart")[~swings, 0], 0.0, atol=1e-6)


def some_switched(recipe: Recipe, loops: int, flags: int) -> list[Model | None]:
    """Return a random scene with loops, some of them off, and the same without those; None as `LoopScene.frozen`."""
    models = []
    for is_cut in (False, True):
        made = LoopScene(recipe, loops)
        scene = made.scene
        constraints = [replace(c, starts_on=bool(flags >> i & 1)) for i, c in enumerate(scene._constraints)]
        scene._constraints = [replace(c, starts_on=None) for c in constraints if c.starts_on] if is_cut else constraints
        models.append(made.frozen())
    return models


@settings(max_examples=12, deadline=None)
@given(recipes(bodies=6, loads=1), st.integers(2, 4), st.integers(0, 15))
def test_what_is_off_is_not_there(recipe: Recipe, loops: int, flags: int) -> None:
    """On both routes, of random scenes: the same accelerations as without what is switched off."""
    switched, cut = some_switched(recipe, loops, flags)
    closed = None if cut is None else closed_state(cut, 3)
    if switched is None or cut is None or closed is None:
        return
    y = np.concatenate((*closed, switched.initial_states, np.zeros(QUADRATURES)))
    plain = np.concatenate((*closed, cut.initial_states, np.zeros(QUADRATURES)))
    n = switched.coordinate_count + switched.free_count
    for route, other in ((switched.route, cut.route), (switched.literal, cut.literal)):
        found, wanted = route.evaluate(0.0, y), other.evaluate(0.0, plain)  # later, drives may be out of reach
        # rows that are left out change the order of sums in eigenvalues and pivots alone
        scale = np.abs(wanted.rates[:n]).max(initial=1.0)
        np.testing.assert_allclose(
            found.rates[:n], wanted.rates[:n], rtol=0, atol=1e-9 * scale / min(1.0, wanted.weakest)
        )


def test_what_is_off_costs_nothing(monkeypatch: Any) -> None:
    """The literal route asks no row of it anything; of the compiled one see test_skips."""
    scene, _ = landing()
    scene.add_loop_joint("idle", kf.Fixed, scene.ground, scene.add_rigid_body("block", 1.0, 1.0), starts_on=False)

    def refuse(*arguments: Any) -> None:
        raise AssertionError("a row of a constraint that is off was evaluated")

    for kind in (PointRow, DirectionRow):
        for question in ("residual", "terms"):
            monkeypatch.setattr(kind, question, refuse)
    model = scene.freeze()
    model.literal.evaluate(0.0, np.concatenate((model.initial_state, np.zeros(QUADRATURES))))
    assert model.constraint_report().rows == 0
    with pytest.raises(AssertionError, match="that is off"):
        model.literal.evaluate(0.0, np.concatenate((model.initial_state[:-1], np.ones(1 + QUADRATURES))))


def test_one_that_is_open_is_not_switched_on() -> None:
    scene, lands = landing()
    early = replace(lands, function=lambda t, state: t - 0.01, direction=0)
    with pytest.warns(kf.SimulationWarning, match="is switched on where it is not closed"):
        result = scene.simulate((0.0, 1.0), events=[early])
    assert result.status.kind == "failed"
    assert result.status.time == pytest.approx(0.01)
    text = str(result.status)
    assert "rolling ball 'floor' between" in text
    assert "stays open by 0.4 m (contact)" in text
    assert "Remedy: an event whose function is its gap" in text
    assert result.times[-1] == pytest.approx(0.01)


def test_small_motions_of_what_holds() -> None:
    """A pendulum of two links whose lower joint is locked or not, at rest: its frequencies say which."""
    scene = kf.System(gravity=(0, 0, -G))
    upper = scene.add_rigid_body("upper", 1.0, joint=kf.Revolute("y"), com=(0, 0, -1.0))
    lower = scene.add_rigid_body("lower", 1.0, parent=upper, at=(0, 0, -1), joint=kf.Revolute("y"), com=(0, 0, -1.0))
    scene.add_gear("lock", {lower: 1.0}, 0.0, starts_on=True)
    model = scene.freeze()
    locked = kf.equilibrium(model).linearise().modes().frequencies
    assert 2.0 * np.pi * locked == pytest.approx([np.sqrt(3.0 * G / 5.0)], rel=1e-9)
    y = State(model, 0.0, model.initial_coordinates, model.initial_speeds, model.initial_states).switched(off="lock")
    for found in (kf.equilibrium(model, start=y).linearise(), kf.linearise(model, start=y)):
        free = 2.0 * np.pi * found.modes().frequencies
        assert free == pytest.approx(np.sqrt((2.0 - np.sqrt(2.0), 2.0 + np.sqrt(2.0))) * np.sqrt(G), rel=1e-9)


def test_a_rope_breaks_beside_an_unreduced_body() -> None:
    """Its states reach the sparse route: the weight falls freely from then on."""
    scene = kf.System(gravity=(0, 0, -G))
    scene.add_flexible_body("arm", kf.flexible_body(steel_beam(12), {"root": "clamped"}, reduction=None))
    weight = scene.add_point("weight", 1.0, joint=kf.Prismatic("z"))
    scene.add_point("other", 1.0, joint=kf.Prismatic("x"))
    scene.add_force(weight, lambda t: (0.0, 0.0, -100.0 * t))
    hook = scene.ground.frame(at=(0, 0, 1))
    scene.add(kf.Rope("rope", (hook, weight), axial_stiffness=1e6, damping=1e3, preload=G, breaking_load=G + 20.0))
    result = scene.simulate((0.0, 0.3), output_times=[0.28, 0.3])
    breaks = result.events["rope breaks"][0]
    assert breaks == pytest.approx(0.2, abs=2e-3)
    v0, v1 = (-G * (t - breaks) - 50.0 * (t * t - breaks**2) for t in (0.28, 0.3))
    fall = np.diff(result.velocity("weight")[:, 2])[0]
    assert fall == pytest.approx(v1 - v0, rel=1e-4)


@pytest.mark.parametrize(
    ("break_it", "words"),
    [
        (
            lambda s, b: s.add_rolling_ball("x", b, 0.1, starts_on=1),
            "starts_on of rolling ball 'x' must be True, False",
        ),
        (lambda s, b: s.add_gear("x", {b: 1.0}, starts_on="no"), "starts_on of gear 'x' must be"),
    ],
)
def test_the_door(break_it: Any, words: str) -> None:
    scene = kf.System()
    body = scene.add_rigid_body("body", 1.0, joint=kf.Prismatic("x"))
    with pytest.raises(kf.ModelError, match=words):
        break_it(scene, body)


def test_what_cannot_be_switched() -> None:
    scene, _ = landing()
    block = scene.add_rigid_body("block", 1.0, 1.0)
    scene.add_loop_joint("weld", kf.Fixed, scene.ground, block)
    model = scene.freeze()
    state = model.route.state(0.0, model.initial_state)
    assert state.is_on("weld")
    assert not state.is_on("floor")
    with pytest.raises(kf.ModelError, match=r"fixed loop joint 'weld' between .* always holds. Remedy: starts_on="):
        state.switched(off="weld")
    with pytest.raises(kf.ModelError, match=r"no constraint called 'flor'. It has: floor, weld"):
        state.switched(on="flor")


def test_not_beside_unreduced_bodies() -> None:
    scene, _ = landing()
    scene.add_flexible_body("arm", kf.flexible_body(steel_beam(60), {"root": "clamped"}, reduction=None))
    with pytest.raises(
        kf.ModelError, match=r"'floor' between .* not supported beside the unreduced body 'arm'. Remedy: "
    ):
        scene.freeze()
