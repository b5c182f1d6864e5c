"""Linearly implicit evaluations and extrapolation where loops are closed."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import null_space

from kanefe.checks.verification.loops import parallelograms
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.run import integrate
from kanefe.kernels.constraints.tolerances import NEAR_SINGULAR
from kanefe.kernels.steppers.step_commands import VECTOR
from kanefe.literal.loop_closure import project_speeds
from kanefe.states.constraints import constraint_rates
from kanefe.states.state import State
from kanefe.tree.tangents import constant_tangents
from loop_scenes import four_bar, sprung_loop
from order_n_rates import order_n


@pytest.mark.parametrize("seed", range(3))
def test_a_sweep_solves_the_dense_equations_with_loops(seed: int) -> None:
    """``(M + s C + r K) z = F + C a + K b + J^T lambda`` and ``J z + remainder = 0``, by the null space of J."""
    model, rng = sprung_loop(seed), np.random.default_rng(seed)
    n, m, q = model.coordinate_count, model.free_count, model.initial_coordinates
    u = project_speeds(model, 0.0, q, rng.normal(size=m))
    share_damping, share_stiffness = 0.013, 0.0031
    vectors = np.zeros((VECTOR.stiffness_direction + 1, n + m + 2))
    vectors[VECTOR.at, : n + m] = np.concatenate((q, u))
    vectors[VECTOR.damping_direction : VECTOR.stiffness_direction + 1, n : n + m] = rng.normal(size=(2, m))
    directions = (
        vectors[VECTOR.damping_direction, n : n + m].copy(),
        vectors[VECTOR.stiffness_direction, n : n + m].copy(),
    )
    order_n(model).sweep(0.0, vectors, share_damping, share_stiffness)
    K, C = constant_tangents(model)
    M = model.mass_matrix(0.0, np.concatenate((q, u))) + share_damping * C + share_stiffness * K
    F = model.forces(0.0, np.concatenate((q, u))) + C @ directions[0] + K @ directions[1]
    rows = constraint_rates(State(model, 0.0, q, u))
    driven = rows.J[:, m : m + model.driven_count] @ model.driven_speeds(0.0)[1]
    held = np.linalg.lstsq(rows.J[:, :m], -(rows.remainder + driven), rcond=None)[0]
    free = null_space(rows.J[:, :m])
    expected = held + free @ np.linalg.solve(free.T @ M @ free, free.T @ (F - M @ held))
    np.testing.assert_allclose(vectors[VECTOR.slope, n : n + m], expected, rtol=0, atol=1e-9 * abs(expected).max())


def test_extrapolation_keeps_its_order_with_loops() -> None:
    """Six columns: order 6; halved steps leave a 64th of the error, or a 30th where they are still long."""
    model = four_bar(speed=3.0).freeze()
    exact = integrate(model, (0.0, 1.0), method="dop853", rtol=1e-12, output_step=1.0).coordinates[-1]
    errors = [
        abs(integrate(model, (0.0, 1.0), method="extrapolation", step=h, output_step=1.0).coordinates[-1] - exact).max()
        for h in (0.1, 0.05)
    ]
    assert errors[0] < 1e-4
    assert errors[1] < errors[0] / 30.0


@pytest.mark.parametrize("seed", range(2))
def test_extrapolation_runs_mechanisms_of_flexible_bodies(seed: int) -> None:
    model = sprung_loop(seed)
    exact = integrate(model, (0.0, 0.3), method="dop853", rtol=1e-11, output_step=0.1)
    run = integrate(model, (0.0, 0.3), method="extrapolation", rtol=1e-7, output_step=0.1)
    # some tens of steps
    np.testing.assert_allclose(run.coordinates, exact.coordinates, rtol=0, atol=1e-5)


def test_near_a_singular_position_the_nearest_closed_state_is_taken() -> None:
    """Without shares of C and K the evaluation is that of the explicit methods, also where the loops are open a bit."""
    model = parallelograms(2)
    dynamics = Dynamics(model)
    y = dynamics.initial_state(0.0)
    angle = 0.5 * np.pi + 0.05
    y[: model.coordinate_count] = angle, angle, angle, -angle, -angle
    open_y = dynamics.projected(0.0, y) + 1e-6 * np.sin(np.arange(len(y)))
    vectors = np.zeros((VECTOR.stiffness_direction + 1, len(y)))
    vectors[VECTOR.at] = open_y
    dynamics.implicit_rate(0.0, vectors, 0.0, 0.0)
    assert 0.0 < dynamics.weakest < NEAR_SINGULAR
    expected = dynamics.rate(0.0, open_y)
    np.testing.assert_array_equal(vectors[VECTOR.at], open_y)
    speeds = slice(model.coordinate_count, None)
    np.testing.assert_allclose(vectors[VECTOR.slope, speeds], expected[speeds], rtol=0, atol=1e-9 * abs(expected).max())


def test_fixed_steps_of_generalised_alpha_take_two_sweeps_with_loops(monkeypatch: pytest.MonkeyPatch) -> None:
    """At most; no factorisation; three evaluations begin the run; and the compiled route closes the loops."""
    literal: list[object] = []
    monkeypatch.setattr("kanefe.literal.loop_closure.project", lambda *given: literal.append(given))
    model = sprung_loop(0)
    run = integrate(model, (0.0, 0.1), method="generalised-alpha", step=5e-4)
    counts = [run.statistics[name] for name in ("steps", "evaluations", "factorisations", "jacobians")]
    assert counts[1] <= 403  # less where one sweep is enough
    assert (counts[0], *counts[2:]) == (200, 0, 0)
    assert not literal
    exact = integrate(model, (0.0, 0.1), method="dop853", rtol=1e-10).coordinates[-1]
    finer = integrate(model, (0.0, 0.1), method="generalised-alpha", step=2.5e-4).coordinates[-1]
    errors = [abs(found - exact).max() for found in (run.coordinates[-1], finer)]
    assert errors[1] < 0.3 * errors[0]  # of order 2: a quarter
