"""The linearly implicit sweep and the extrapolation method over it."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pytest

import kanefe as kf
from kanefe.equations.model import Model
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.methods.extrapolation import METHOD
from kanefe.integrate.run import integrate
from kanefe.integrate.stepper import StepControl
from kanefe.kernels.steppers.step_commands import VECTOR
from kanefe.order_n.planar_route import PlanarRoute
from kanefe.tree.tangents import constant_tangents
from order_n_rates import order_n
from run_scenes import check_snapshot
from scenes import chain_scene, floating_scene, random_state
from steel_beams import BAR_LENGTH, STEEL, steel_bar


def sprung_chain(is_planar: bool) -> Model:
    """Return a chain of three links with springs and dampers in its joints."""
    scene, parent = kf.System(gravity=(0, 0, -9.81)), None
    for i, axis in enumerate(("y", "y", "y") if is_planar else ("y", "z", "x")):
        forces = kf.CoordinateForce(stiffness=10.0**i, damping=0.3 * i)
        joint = kf.Revolute(axis, position=0.2 + 0.1 * i, speed=0.5, forces=forces)
        link = scene.add_rigid_body(
            f"link {i}",
            1.0,
            (0.1, 0.2, 0.3),
            com=(0.3, 0, 0.1),
            joint=joint,
            parent=parent,
            at=(0, 0, 0) if parent is None else (0.6, 0, 0),
        )
        parent = link
    slide = kf.Prismatic("x", position=0.1, speed=0.2, forces=kf.CoordinateForce(stiffness=40.0, damping=2.0))
    scene.add_rigid_body("slide", 0.5, 0.1, com=(0, 0, 0.1), joint=slide, parent=parent)
    return scene.freeze()


def check(model: Model, y: np.ndarray) -> None:
    """Compare a sweep with the dense equations of the literal route."""
    n, m = model.coordinate_count, model.free_count
    share_damping, share_stiffness = 0.013, 0.0031
    rng = np.random.default_rng(3)
    vectors = np.zeros((VECTOR.stiffness_direction + 1, n + m + 2))
    vectors[VECTOR.at, : n + m] = y
    vectors[VECTOR.damping_direction : VECTOR.stiffness_direction + 1, n : n + m] = rng.normal(size=(2, m))
    directions = (
        vectors[VECTOR.damping_direction, n : n + m].copy(),
        vectors[VECTOR.stiffness_direction, n : n + m].copy(),
    )
    order_n(model).sweep(0.0, vectors, share_damping, share_stiffness)
    K, C = constant_tangents(model)
    M, F = model.mass_matrix(0.0, y), model.forces(0.0, y)
    expected = np.linalg.solve(M + share_damping * C + share_stiffness * K, F + C @ directions[0] + K @ directions[1])
    np.testing.assert_allclose(vectors[VECTOR.slope, n : n + m], expected, rtol=0, atol=1e-9 * abs(expected).max())


@pytest.mark.parametrize("is_planar", [True, False])
def test_a_sweep_solves_the_dense_equations_of_springs_in_joints(is_planar: bool) -> None:
    model = sprung_chain(is_planar)
    assert isinstance(model.route, PlanarRoute) == is_planar
    check(model, model.initial_state)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("make", [chain_scene, floating_scene])
def test_a_sweep_solves_the_dense_equations_of_flexible_bodies(make: Callable[..., kf.System], seed: int) -> None:
    model = make(seed, reduction=kf.CraigBampton(modes=3), damping=kf.ModalDamping(0.05)).freeze()
    check(model, np.concatenate(random_state(model, seed)))


class Found(NamedTuple):
    """What a run stored, and its statistics."""

    stored: np.ndarray
    statistics: dict[str, int | float]


def run(model: Model, span: float, outputs: int, *, rtol: float = 1e-6, step: float | None = None) -> Found:
    """Run a scene by extrapolation."""
    stepper = METHOD.make(Dynamics(model), 0.0, span, StepControl(rtol, 0.1 * rtol, step))
    times = np.linspace(0.0, span, outputs + 1)[1:]
    stored = np.empty((outputs, len(stepper.state())))
    assert stepper.integrate_through(times, stored, 10**6) == outputs
    return Found(stored, stepper.statistics)


def test_modes_of_100_kilohertz_do_not_hold_the_step_down() -> None:
    model = steel_bar().freeze()
    found = run(model, 1.0, 4, rtol=1e-5)
    # an explicit method would take 1 s * 2 pi * 1e5 Hz / 2 = 3e5 steps; here the swing alone sets the step
    assert found.statistics["evaluations"] < 2000
    pendulum = kf.System(gravity=(0.0, 0.0, -9.81))
    m = STEEL.rho * BAR_LENGTH * 0.01 * 0.02
    inertia = m * (0.3**2 + 0.02**2) / 12
    pendulum.add_rigid_body("bar", m, inertia, com=(0.15, 0, 0), joint=kf.Revolute("y"))
    stiff = pendulum.simulate((0.0, 1.0), rtol=1e-10, output_step=0.25, method="dop853").joint_coordinates("bar")[1:, 0]
    # the bar bends by less than 1e-5 of its length, which shifts its swing over a second by some 1e-4
    np.testing.assert_allclose(found.stored[:, 0], stiff, atol=5e-4)


def test_fixed_steps_are_of_order_six_and_cost_one_sweep_a_substep() -> None:
    model = sprung_chain(is_planar=False)
    exact = integrate(model, (0.0, 0.4), rtol=1e-12, method="dop853", output_step=0.4).coordinates[-1]
    errors = []
    for step in (0.02, 0.01):
        found = run(model, 0.4, 1, step=step)
        assert found.statistics["evaluations"] == (1 + 2 + 3 + 4 + 5 + 6) * round(0.4 / step)
        errors.append(abs(found.stored[-1, : model.coordinate_count] - exact).max())
    assert 30.0 < errors[0] / errors[1] < 200.0  # 2^6: more than order 4, less than 8


def test_states_between_the_steps_are_as_good_as_at_their_ends() -> None:
    model = sprung_chain(is_planar=False)
    exact = integrate(model, (0.0, 1.0), rtol=1e-12, method="dop853", output_step=0.02).coordinates[1:]
    found = run(model, 1.0, 50, rtol=1e-8)
    assert found.statistics["steps"] < 40  # of 50 states, most lie within a step
    errors = abs(found.stored[:, : model.coordinate_count] - exact)
    assert errors.max() < 3e-7


def test_a_run_goes_on_from_a_snapshot_to_the_bit() -> None:
    model = steel_bar().freeze()
    check_snapshot(lambda: METHOD.make(Dynamics(model), 0.0, 1.0, StepControl(1e-6, 1e-7, None)), 1.0, 3)


def test_the_rebound_of_an_impact_comes_nearer_to_its_share_as_the_tolerance_falls():
    """By `Restitution` a ball leaves with e of its speed; a step over the whole impact does not see its kinks."""
    e, errors = 0.7, []
    for rtol in (1e-5, 1e-8):
        scene = kf.System()
        wall = scene.add_surface("wall", scene.ground, kf.shapes.Plane("z"))
        ball = scene.add_rigid_body("ball", 1.0, 0.01, joint=kf.Free(position=(0, 0, 0.3), velocity=(0, 0, -2.0)))
        skin = scene.add_surface("skin", ball, kf.shapes.Sphere(0.1))
        scene.add_contact("c", skin, wall, normal=kf.Restitution(1e6, e))
        result = scene.simulate((0.0, 0.15), method="extrapolation", rtol=rtol, output_step=0.15)
        errors.append(abs(result.velocity("ball")[-1, 2] / 2.0 - e))
    assert errors[1] < 1e-6  # a hundred times rtol: what some ten steps within the impact miss
    assert errors[1] < 0.1 * errors[0]
