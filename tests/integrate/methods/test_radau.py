"""Radau IIA of order 5: order, stiff scenes in few steps, dense output, exact Jacobian, and its linear systems."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import kanefe as kf
from benchmarks.force_errors import drawn
from kanefe.errors import SimulationWarning
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.methods.radau5 import METHOD, radau_iia
from kanefe.integrate.run import integrate
from kanefe.integrate.stepper import StepControl
from kanefe.kernels.algebra.lu import factorise, factorise_from_last, solve, solve_from_last
from kanefe.kernels.steppers import radau_systems
from kanefe.tree.model_data import QUADRATURES
from loop_scenes import four_bar
from run_scenes import SCENES, soft_arm, tumbling
from scenes import lattice_body
from steel_beams import steel_bar


def reference(make: Callable[[], kf.System], times: np.ndarray) -> np.ndarray:
    return integrate(make().freeze(), (0.0, 1.0), rtol=1e-13, method="dop853", output_times=times).coordinates


def errors_of_steps(make: Callable[[], kf.System], times: np.ndarray, steps: list[float]) -> np.ndarray:
    exact, model = reference(make, times), make().freeze()
    runs = [integrate(model, (0.0, 1.0), method="radau5", step=step, output_times=times) for step in steps]
    return np.array([abs(run.coordinates - exact).max() for run in runs])


@pytest.mark.parametrize("scene", ["tumbling", "soft arm"])
def test_halving_the_step_divides_the_error_by_two_to_the_fifth(scene: str) -> None:
    steps = [1 / 8, 1 / 16, 1 / 32]
    errors = errors_of_steps(SCENES[scene], np.array([1.0]), steps)
    # a body that turns by 3 rad, and modes that are still felt: ratios of 22 and 30 at steps of 1/8 and less
    assert np.log2(errors[:-1] / errors[1:]) == pytest.approx([5.0, 5.0], abs=0.6)
    assert errors[-1] < 1e-8


def test_dense_output_is_of_order_four_within_a_step() -> None:
    # a third into each step of every size; the polynomial of order 3 there has an error of h^4, the steps one of h^5
    times = np.array([0.25 + 1 / 96, 0.5 + 1 / 96])
    errors = errors_of_steps(tumbling, times, [1 / 32])
    finer = errors_of_steps(tumbling, 0.25 * np.array([1, 2]) + 1 / 192, [1 / 64])
    assert np.log2(errors[0] / finer[0]) == pytest.approx(4.0, abs=0.3)
    run = integrate(tumbling().freeze(), (0.0, 1.0), method="radau5", step=1 / 32, output_times=times)
    assert np.linalg.norm(run.coordinates[:, 3:7], axis=1) == pytest.approx([1.0, 1.0], abs=1e-15)
    assert errors[0] < 1e-5


@pytest.mark.parametrize("scene", SCENES)
def test_the_error_follows_the_tolerance(scene: str) -> None:
    times = np.linspace(0.0, 1.0, 8)
    exact, model = reference(SCENES[scene], times), SCENES[scene]().freeze()
    tolerances = np.array([1e-4, 1e-6, 1e-8])
    runs = [integrate(model, (0.0, 1.0), method="radau5", rtol=r, output_times=times) for r in tolerances]
    errors = np.array([abs(run.coordinates - exact).max() for run in runs])
    # neither larger nor much smaller: what a step may have is that of an estimate of order 3, not of the step itself;
    # of the soft arm, whose modes are followed as their forces ask for, some thousandths
    assert np.all((0.001 * tolerances < errors) & (errors < 10.0 * tolerances))
    # steps as rtol^(2/3 / 4), errors as h^5: a hundredth of rtol is 1 / 46 of the error
    assert np.all((0.001 * errors[:-1] < errors[1:]) & (errors[1:] < 0.1 * errors[:-1]))


def test_damped_modes_of_100_kilohertz_are_stepped_over() -> None:
    model = steel_bar(damping=kf.ModalDamping(0.01)).freeze()
    run = integrate(model, (0.0, 0.5), rtol=1e-3, method="radau5", output_step=0.05)
    # an explicit method would need 0.5 s * 2 pi * 1e5 Hz / 2 = 160,000 steps
    assert run.statistics["steps"] < 200
    assert run.statistics["evaluations"] < 1200
    assert run.statistics["jacobians"] < 10
    exact = integrate(model, (0.0, 0.5), rtol=1e-7, method="extrapolation", output_step=0.05)
    # rtol of an angle of 3 rad; 5e-4 is measured
    assert run.coordinates[:, 0] == pytest.approx(exact.coordinates[:, 0], abs=2e-3)


def test_matrices_are_kept() -> None:
    counts = integrate(soft_arm().freeze(), (0.0, 1.0), rtol=3e-8, method="radau5", output_step=0.5).statistics
    assert counts["jacobians"] <= 0.1 * counts["steps"]
    assert counts["jacobians"] < counts["factorisations"] < 0.6 * counts["steps"]
    # three a Newton iteration, and one at the start of the step
    assert counts["evaluations"] < 9 * (counts["steps"] + counts["rejected"])


def test_a_fixed_step_that_is_too_long_for_the_iteration_is_said() -> None:
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    scene.add_rigid_body("rod", 1.0, 0.01, com=(0, 0, -0.1), joint=kf.Revolute("y", speed=100.0))
    with pytest.warns(SimulationWarning, match=r"Newton iteration of radau5 does not converge with steps of 2 s"):
        run = integrate(scene.freeze(), (0.0, 4.0), method="radau5", step=2.0)
    assert run.status is not None
    assert run.status.remedy == "a smaller step, or rtol instead"


def test_loops_stay_closed() -> None:
    model = four_bar().freeze()
    run = integrate(model, (0.0, 1.0), rtol=1e-7, method="radau5", output_step=0.1)
    exact = integrate(model, (0.0, 1.0), rtol=1e-11, method="dop853", output_step=0.1)
    assert run.coordinates == pytest.approx(exact.coordinates, abs=1e-7)


def flexible_body_in_flight() -> tuple[kf.Model, np.ndarray]:
    """Return a scene with a rotation, modes and damping, and a state of it."""
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    scene.add_flexible_body(
        "arm",
        lattice_body(1, reduction=kf.CraigBampton(modes=1), damping=kf.ModalDamping(0.1)),
        joint=kf.Free(angular_velocity=(0.3, -2.0, 1.0), velocity=(1.0, 0.5, 0.2)),
    )
    model = scene.freeze()
    rng = np.random.default_rng(1)
    q = model.advance(model.initial_coordinates, 0.1 * rng.standard_normal(model.free_count))
    u = model.initial_speeds + 0.1 * rng.standard_normal(model.free_count)
    return model, np.concatenate((q, u, np.zeros(QUADRATURES)))


def test_systems_of_the_size_of_the_speeds_solve_those_of_the_state() -> None:
    model, y = flexible_body_in_flight()
    dynamics, control = Dynamics(model), StepControl(1e-6, 1e-9, None)
    stepper = METHOD.make(dynamics, 0.0, 1.0, control)
    step, m, h = stepper.step, model.free_count, 0.4
    step.state[:], step.h = y, h
    step.jacobian[:, : 2 * m] = dynamics.tangent_derivatives(0.0, y)
    J = dynamics.jacobian(0.0, y)
    assert radau_systems.factorise_systems(step)
    r = np.random.default_rng(3).standard_normal((2, len(y)))
    gamma, alpha, beta = step.gamma / h, step.alpha / h, step.beta / h
    expected = np.linalg.solve(gamma * np.eye(len(y)) - J, r[0])
    a = r[0].copy()
    radau_systems.solve_real(step, a)
    # condition numbers of 1e4, times round-off
    assert a == pytest.approx(expected, abs=1e-12 * np.abs(expected).max())
    expected = np.linalg.solve((alpha + 1j * beta) * np.eye(len(y)) - J, r[0] + 1j * r[1])
    a, b = r.copy()
    radau_systems.solve_complex(step, a, b)
    assert a + 1j * b == pytest.approx(expected, abs=1e-12 * np.abs(expected).max())


def test_derivatives_along_tangents_are_those_of_moves_on_the_group() -> None:
    model, y = flexible_body_in_flight()
    n, m = model.coordinate_count, model.free_count
    q, u = y[:n], y[n : n + m]
    dynamics = Dynamics(model)
    found = dynamics.tangent_derivatives(0.0, y)
    assert found.shape == (m + QUADRATURES, 2 * m)
    h = 1e-5
    for i, unit in enumerate(np.eye(m)):
        sides = [(model.advance(q, side * h * unit), u, q, u + side * h * unit) for side in (1.0, -1.0)]
        rates = [
            [dynamics.rate(0.0, np.concatenate((*pair, np.zeros(QUADRATURES))))[n:] for pair in (side[:2], side[2:])]
            for side in sides
        ]
        for column, (ahead, behind) in zip((i, m + i), zip(*rates, strict=True), strict=True):
            # central differences: h^2 of truncation, 1e-16 / h of cancellation, times rates of some 1e3
            assert found[:, column] == pytest.approx((ahead - behind) / (2 * h), rel=1e-7, abs=1e-5)


def test_what_a_function_of_the_state_adds_is_in_the_jacobian() -> None:
    def rod(motor: object) -> Dynamics:
        scene = kf.System()
        body = scene.add_rigid_body("rod", 1.0, 0.1, com=(0.5, 0, 0), joint=kf.Spherical(angular_velocity=(1, 2, 3)))
        scene.add_torque(body, motor, follows=True)
        return Dynamics(scene.freeze())

    free = rod((0.0, 0.0, 0.0))
    damped = rod(lambda t, state: -0.3 * np.asarray(state.angular_velocity("rod")))
    y = np.concatenate((free.model.initial_state, np.zeros(QUADRATURES)))
    change = damped.jacobian(0.0, y) - free.jacobian(0.0, y)
    # the torque -0.3 w about the fixed point: -0.3 of the inverse inertia there
    inertia = np.diag([0.1, 0.1 + 0.25, 0.1 + 0.25])
    assert change[4:7, 4:7] == pytest.approx(-0.3 * np.linalg.inv(inertia), abs=1e-8)
    change[4:7, 4:7] = 0.0
    assert change[:-QUADRATURES] == pytest.approx(np.zeros((7, len(y))), abs=1e-8)  # the quadratures have its power too
    J = free.jacobian(0.0, y)
    assert J[:-QUADRATURES, :-QUADRATURES] == pytest.approx(free.model.jacobian(0.0, y[:-QUADRATURES]), abs=1e-14)


def test_the_coefficients_are_those_of_radau_iia() -> None:
    of, r = radau_iia(), np.sqrt(6.0)
    T, inverse = (np.reshape(of[name].numbers, (3, 3)) for name in ("T", "T_inverse"))
    gamma, alpha, beta = (of[name] for name in ("gamma", "alpha", "beta"))
    # Butcher's matrix (Hairer & Wanner 1996, table 5.6), and its inverse in the blocks of the transformation
    A = np.array(
        [
            [(88 - 7 * r) / 360, (296 - 169 * r) / 1800, (-2 + 3 * r) / 225],
            [(296 + 169 * r) / 1800, (88 + 7 * r) / 360, (-2 - 3 * r) / 225],
            [(16 - r) / 36, (16 + r) / 36, 1 / 9],
        ]
    )
    assert of["nodes"] == pytest.approx(A.sum(axis=1), abs=1e-14)
    blocks = np.array([[gamma, 0, 0], [0, alpha, -beta], [0, beta, alpha]])
    assert inverse @ np.linalg.inv(A) @ T == pytest.approx(blocks, abs=1e-12)
    # the error vanishes for polynomials up to degree 3: changes Z = c^k, with the rate of the start, (1, 0, 0)
    c = of["nodes"]
    for k, rate in ((1, 1.0), (2, 0.0), (3, 0.0)):
        assert of["weights"] @ c**k + rate == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("kind", [float, complex])
def test_factors_solve(kind: type) -> None:
    rng = np.random.default_rng(2)
    A = rng.standard_normal((7, 7)).astype(kind)
    if kind is complex:
        A += 1j * rng.standard_normal((7, 7))
    A[0, 0] = 0.0  # rows must be exchanged
    x = rng.standard_normal(7).astype(kind)
    factors, pivots, b = A.copy(), np.empty(7), A @ x
    assert factorise(factors, pivots)
    solve(factors, pivots, b)
    assert b == pytest.approx(x, abs=1e-13)
    A[:, 3] = 0.0
    assert not factorise(A, pivots)


@pytest.mark.parametrize("kind", [float, complex])
def test_factors_from_the_last_solve_and_stay_sparse(kind: type) -> None:
    """What depends on nothing but itself and the border gains no entries, however large those of the border are."""
    rng, border, size = np.random.default_rng(3), 3, 10
    A = np.diag(rng.uniform(1.0, 2.0, size)).astype(kind)
    A[:border] += 1e3 * rng.standard_normal((border, size))
    A[:, :border] += rng.standard_normal((size, border))
    A[6:8, 6:8] = [[0.0, 2.0], [1.0, 0.5]]  # a pair whose rows must be exchanged
    A[0, 0] = 0.0
    if kind is complex:
        A *= np.exp(1j * rng.uniform(0.0, 6.0, A.shape))
    x = rng.standard_normal(size).astype(kind)
    factors, pivots, b = A.copy(), np.empty(size), A @ x
    assert factorise_from_last(factors, pivots, border)
    sparse = factors[border:, border:]
    assert np.count_nonzero(sparse) <= size - border + 2
    solve_from_last(factors, pivots, b)
    # round-off of products as large as 1e3 times some tens
    assert b == pytest.approx(x, abs=1e-10)
    for number in (1, 5):
        singular = A.copy()
        singular[:, number] = 0.0
        assert not factorise_from_last(singular, pivots, border)
        assert np.all((pivots >= 0) & (pivots < size))  # `solve_from_last` stays within its memory


def test_a_step_for_which_the_iteration_diverged_is_not_tried_at_once_again() -> None:
    """In a loop in space, where errors would allow steps for which it diverges: two tries failed for each step."""
    scene, seconds, _ = drawn(11)
    found = scene.simulate((0.0, 0.25 * seconds), method="radau5", rtol=1e-4).statistics
    assert found["rejected"] < found["steps"]
