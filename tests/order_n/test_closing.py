"""Loops closed in order n: the coordinates and speeds of the literal route, and what is left to that route."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

import kanefe as kf
from kanefe.equations.model import Model
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.run import integrate
from kanefe.kane import assemble
from kanefe.kane.assemble import held_accelerations
from kanefe.kernels.constraints.tolerances import CLOSING, NEAR_SINGULAR
from kanefe.literal import loop_closure as assembly
from kanefe.literal.loop_closure import project_positions, project_speeds
from kanefe.states.constraints import constraint_rates
from kanefe.states.state import State
from kanefe.tree.tangents import constant_tangents
from loop_scenes import four_bar, parallelogram, sprung_loop
from random_loops import LoopScene, closed_state
from random_scenes import Recipe, recipes

CHECKS = [HealthCheck.too_slow, HealthCheck.filter_too_much]


def closed(model: Model, t: float, q: np.ndarray, u: np.ndarray, share: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    y = model.route.projected(t, np.concatenate((q, u)), share=share)
    return y[: len(q)], y[len(q) :]


def slips(model: Model, t: float, q: np.ndarray, u: np.ndarray) -> float:
    """Return the largest rate at which a loop opens, of the largest speed, in scenes of some metres."""
    state = State(model, t, q, u)
    full, J = state.full, constraint_rates(state).J
    return float(abs(J @ full[: J.shape[1]]).max()) / (1.0 + float(abs(u).max()))


def opened(model: Model, q: np.ndarray, u: np.ndarray, seed: int, size: float) -> tuple[np.ndarray, np.ndarray]:
    """Return a state beside a closed one, by as much as a step of an integrator may leave it open."""
    rng = np.random.default_rng(seed)
    count = model.free_count
    return model.advance(q, size * rng.standard_normal(count)), u + size * rng.standard_normal(count)


def has_inertia(model: Model, q: np.ndarray, u: np.ndarray) -> bool:
    """Tell whether M is positive: of random bodies that bend far to second order it need not be."""
    return bool(np.linalg.eigvalsh(model.mass_matrix(0.0, np.concatenate((q, u))))[0] > 0.0)


def is_closed_as_literally(recipe: Recipe, loops: int, size: float) -> bool:
    """Compare both routes; tell whether there was anything to compare."""
    model = LoopScene(recipe, loops).frozen()
    state = closed_state(model, recipe.seed) if model is not None and model.constraints else None
    if model is None or state is None or not model.free_count:
        return False
    weakest = held_accelerations(State(model, 0.0, *state))[2]
    if weakest < NEAR_SINGULAR or not has_inertia(model, *state):
        return False
    q, u = opened(model, *state, recipe.seed, size)
    expected = project_positions(model, 0.0, q)
    q_closed, u_closed = closed(model, 0.0, q, u)
    # both close the loops with answers of places that are `size` apart or less: they differ by what those miss
    apart = max(100.0 * size**2, 1e-12) / weakest
    np.testing.assert_allclose(q_closed, expected, rtol=0, atol=apart)
    np.testing.assert_allclose(
        u_closed, project_speeds(model, 0.0, q_closed, u), rtol=0, atol=apart * max(1e-3, abs(u).max())
    )
    assert assembly.openings(model, 0.0, q_closed).worst <= CLOSING.tolerance
    assert slips(model, 0.0, q_closed, u_closed) < 1e-11 / weakest
    return True


@settings(max_examples=30, derandomize=True, deadline=None, database=None, suppress_health_check=CHECKS)
@given(recipes(bodies=8, loads=0), st.integers(1, 3), st.sampled_from((1e-8, 1e-5)))
def test_rigid_loops(recipe: Recipe, loops: int, size: float) -> None:
    assume(is_closed_as_literally(recipe, loops, size))


@settings(max_examples=20, derandomize=True, deadline=None, database=None, suppress_health_check=CHECKS)
@given(recipes(bodies=8, loads=0, elastic=0.4), st.integers(1, 2))
def test_loops_with_flexible_bodies(recipe: Recipe, loops: int) -> None:
    assume(is_closed_as_literally(recipe, loops, 1e-6))


def test_rows_that_seem_not_to_depend_on_each_other_move_nothing() -> None:
    """Those of this loop do where it is closed; beside that, a step that heeds them all goes beyond the nearest."""
    assert is_closed_as_literally(Recipe(seed=3, bodies=3, elastic=0.4), 1, 1e-6)


@pytest.mark.parametrize("seed", range(3))
def test_the_metric_may_have_the_stiffness_of_modes_and_joints(seed: int) -> None:
    model, share = sprung_loop(seed), 1e-4
    K = share * constant_tangents(model)[0]
    q, u = opened(model, model.initial_coordinates, model.initial_speeds, seed, 1e-5)
    expected = project_positions(model, 0.0, q, K)
    q_closed, u_closed = closed(model, 0.0, q, u, share)
    # second order in what was open
    np.testing.assert_allclose(q_closed, expected, rtol=0, atol=1e-8)
    np.testing.assert_allclose(u_closed, project_speeds(model, 0.0, q_closed, u, K), rtol=0, atol=1e-8)
    plain = closed(model, 0.0, q, u)[0]
    assert abs(plain - expected).max() > 1e-6  # M alone moves the modes


def test_a_closed_state_stays_where_it_is() -> None:
    model = four_bar().freeze()
    q, u = closed(model, 0.0, *opened(model, model.initial_coordinates, model.initial_speeds, 0, 1e-4))
    again = closed(model, 0.0, q, u)
    np.testing.assert_array_equal(again[0], q)
    np.testing.assert_allclose(again[1], u, rtol=1e-15)


def test_speeds_of_contacts_stay_where_they_are_open_by_round_off() -> None:
    """A box slides: its lower corners are held; speeds that lift it by less than round-off are left, others are not."""
    scene = kf.System(gravity=(0, 0, -9.81))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    start = kf.Free(position=(0, 0, 0.1), velocity=(2.5, 0, 0))
    corners = kf.shapes.Points([(x, y, -0.1) for x in (-0.1, 0.1) for y in (-0.1, 0.1)])
    skin = scene.add_surface("skin", scene.add_rigid_body("box", 1.0, 0.01, joint=start), corners)
    scene.add_contact("c", skin, floor, normal=kf.Rigid(), friction=kf.Coulomb(0.2))
    found = scene.simulate((0.0, 0.01), output_step=0.01).run
    model, run = found.model, found.trajectory
    y = np.concatenate((run.coordinates[-1], run.speeds[-1], run.internal[-1]))
    lifted = model.coordinate_count + 2
    for speed, is_left in ((1e-16, True), (1e-12, False)):
        y[lifted] = speed
        assert (model.route.projected(0.0, y)[lifted] == speed) == is_left


def test_loops_that_are_far_open_are_closed_too() -> None:
    model = four_bar().freeze()
    q, u = opened(model, model.initial_coordinates, model.initial_speeds, 3, 0.3)
    assert assembly.openings(model, 0.0, q).worst > 0.1
    q_closed, u_closed = closed(model, 0.0, q, u)
    assert assembly.openings(model, 0.0, q_closed).worst <= CLOSING.tolerance
    assert slips(model, 0.0, q_closed, u_closed) < 1e-14


def test_loops_out_of_reach_are_named_by_the_literal_route() -> None:
    model = four_bar(rocker=0.9, motion=kf.Motion.steady(2.0, 0.6)).freeze()
    q, u = model.initial_coordinates, model.initial_speeds
    with pytest.raises(kf.SimulationError, match="the mechanism cannot continue: revolute loop joint 'pin'"):
        Dynamics(model).projected(1.2, np.concatenate((q, u, np.zeros(2))))


def test_what_has_no_inertia_of_its_own_is_left_to_the_literal_route() -> None:
    scene = kf.System()
    crank = scene.add_rigid_body("crank", 1, 0.1, com=(0.1, 0, 0), joint=kf.Revolute("z", position=0.5, speed=1.0))
    rod = scene.add_rigid_body("rod", 0.0, 0.0, parent=crank, at=(0.2, 0, 0), joint=kf.Revolute("z"))
    slider = scene.add_rigid_body("slider", 0.0, at=(0.7, 0, 0), joint=kf.Prismatic("x"))
    scene.add_loop_joint("pin", kf.Revolute("z"), rod.frame(at=(0.5, 0, 0)), slider)
    model = scene.freeze()
    q, u = opened(model, model.initial_coordinates, model.initial_speeds, 0, 1e-6)
    y = Dynamics(model).projected(0.0, np.concatenate((q, u, np.zeros(2))))
    assert assembly.openings(model, 0.0, y[: len(q)]).worst <= CLOSING.tolerance


@pytest.mark.parametrize("make", [lambda: four_bar(speed=6.0), parallelogram], ids=["crank-rocker", "parallelogram"])
def test_a_run_never_leaves_the_compiled_route(make: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    # the parallelogram passes singular positions, at which the rates are those of the nearest closed state
    def refuse(*_: Any) -> Any:
        raise AssertionError("the literal route was taken")

    model = make().freeze()  # whose start the literal route closes
    for name in ("project_positions", "project_speeds", "project"):
        monkeypatch.setattr(assembly, name, refuse)
    for name in ("accelerations", "held_accelerations"):
        monkeypatch.setattr(assemble, name, refuse)
    run = integrate(model, (0.0, 3.0), rtol=1e-7, method="dop853", output_step=0.5, progress=False)
    for t, q, u in zip(run.times, run.coordinates, run.speeds, strict=True):
        assert assembly.openings(model, float(t), q).worst <= CLOSING.tolerance
        assert slips(model, float(t), q, u) < 1e-11
