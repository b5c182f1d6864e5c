"""Loads between frames as changes of low rank of the sweeps of generalised-alpha, against the dense matrix."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from kanefe.equations.model import Model
from kanefe.equations.routes import directions_of_loads
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.methods.generalised_alpha import CompiledAlpha
from kanefe.integrate.methods.kernel_stepper import KernelStepper
from kanefe.integrate.methods.table import METHODS
from kanefe.integrate.run import integrate
from kanefe.integrate.stepper import StepControl
from kanefe.kernels.steppers.generalised_alpha_systems import solve_newton
from kanefe.kernels.steppers.step_commands import VECTOR
from scenes import lattice_body

H = 0.01
G = 9.81


def stepper(model: Model, is_dense: bool, step: float | None = H) -> KernelStepper:
    """Return generalised-alpha with the matrix of all unknowns, or as the scene asks for."""
    makes = METHODS["generalised-alpha"].stepper
    assert isinstance(makes, CompiledAlpha)
    kernels = makes.with_jacobian(0) if is_dense else makes.kernels_for(model)
    control = StepControl(1e-6, 1e-9, step)
    return KernelStepper(Dynamics(model), 0.0, 1.0, control, name="generalised-alpha", kernels=kernels)


def step_once(run: KernelStepper) -> None:
    run.integrate_through(np.array([1.0]), np.empty((1, len(run.state()))), 1)


def unloaded(seed: int) -> Model:
    """Return a random tree with a flexible body, at rest without gravity, and springs and bushings without force.

    Without forces and speeds the matrix of all unknowns has no geometric and no gyroscopic terms.
    """
    rng, scene = np.random.default_rng(seed), kf.System()
    joints = (kf.Revolute("y"), kf.Prismatic((0.6, 0.0, 0.8)), kf.Spherical(), kf.Free(), kf.Universal("x", "y"))
    forces = kf.CoordinateForce(stiffness=1e3, damping=2.0)
    beam = scene.add_flexible_body("beam", lattice_body(1), joint=kf.Revolute("x", forces=forces))
    bodies, places = [], []
    for i in range(8):
        carrier = int(rng.integers(-1, len(bodies)))
        at = rng.uniform(-1.0, 1.0, 3)
        inertia, com = rng.uniform(0.9, 1.1, 3), rng.uniform(-0.3, 0.3, 3)
        parent = bodies[carrier] if carrier >= 0 else None
        joint = joints[int(rng.integers(len(joints)))] if i else kf.Free()
        bodies.append(scene.add_rigid_body(f"b{i}", 1.0, inertia, com=com, joint=joint, parent=parent, at=at))
        places.append(at + (places[carrier] if carrier >= 0 else 0.0))
    a, b, c = rng.choice(8, 3, replace=False)
    scene.add_spring("spring", bodies[a], bodies[b], stiffness=10.0 ** rng.uniform(2, 7), damping=50.0)
    scene.add_spring("to the tip", beam.interface("tip"), bodies[c], stiffness=1e5)
    there, stiffness = scene.ground.frame(at=places[c]), 10.0 ** rng.uniform(0, 6, 6)
    scene.add_bushing("bushing", there, bodies[c], stiffness=stiffness, damping=rng.uniform(0, 9, 6))
    return scene.freeze()


def of_sweep(run: KernelStepper, x: np.ndarray) -> np.ndarray:
    """Return ``(M + s C + r K)^-1 M x`` at the state of a run, at which no force acts."""
    model, shares = run.dynamics.model, (float(run.step.share_damping), float(run.step.share_stiffness))
    n, m = model.coordinate_count, model.free_count
    vectors = np.zeros((VECTOR.stiffness_direction + 1, len(x)))
    vectors[VECTOR.at] = run.vectors[VECTOR.state]
    vectors[VECTOR.damping_direction], vectors[VECTOR.stiffness_direction] = -shares[0] * x, -shares[1] * x
    model.route.sweep_implicitly(0.0, vectors, *shares)
    found = x.copy()
    found[n : n + m] += vectors[VECTOR.slope, n : n + m]
    return found


@pytest.mark.parametrize("seed", range(10))
def test_a_change_of_low_rank_solves_the_dense_system(seed: int) -> None:
    model = unloaded(seed)
    few, dense = stepper(model, False), stepper(model, True)
    assert few.step.most_directions == 18
    step_once(few)
    step_once(dense)
    assert few.step.rank == 8  # one of each spring, and six of the bushing
    n, m = model.coordinate_count, model.free_count
    x = np.zeros(few.vectors.shape[1])
    x[n : n + m] = np.random.default_rng(seed).normal(size=m)
    expected, found = x.copy(), of_sweep(few, x)
    solve_newton(dense.step, expected)
    solve_newton(few.step, found)
    size = abs(expected).max()
    assert abs(expected - x).max() > 1e-3 * size  # the loads count
    # round-off of systems whose stiffest direction has up to 1e3 times the inertia
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-11 * size)


def test_states_of_loads_are_solved_for_as_in_the_dense_system() -> None:
    """A block in its state of rest, with friction: the solution for any residual of accelerations and anchors."""
    scene = kf.System(gravity=(0.0, 0.0, -G))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    rest, normal = -G * 1e-5, kf.KelvinVoigt(1e5, damping=60.0)
    for i in range(4):
        block = scene.add_rigid_body(f"block {i}", 1.0, 0.01, joint=kf.Translation(position=(i, 0.0, rest)))
        if i == 0:
            scene.add_contact("feet", [block], floor, normal=normal, friction=kf.Coulomb(0.3))
    model = scene.freeze()
    few, dense = stepper(model, False, 1e-3), stepper(model, True, 1e-3)
    assert few.step.most_directions > 0
    step_once(few)
    step_once(dense)
    n, m, end = model.coordinate_count, model.free_count, model.coordinate_count + model.free_count + model.state_count
    x = np.zeros(few.vectors.shape[1])
    x[n:end] = np.random.default_rng(0).normal(size=end - n)
    expected, found = x.copy(), x.copy()  # a sweep knows of nothing that is stiff
    solve_newton(dense.step, expected)
    solve_newton(few.step, found)
    assert abs(expected - x)[n + m :].max() > 1e-3
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-11 * abs(expected).max())


def chain(count: int, springs: int) -> Model:
    """Return a hanging chain with springs over two joints each."""
    scene, bodies = kf.System(gravity=(0, 0, -G)), [None]
    for i in range(count):
        where = {"parent": bodies[-1], "at": (0, 0, -0.1)} if i else {}
        joint = kf.Revolute("xy"[i % 2], position=0.1)
        bodies.append(scene.add_rigid_body(f"b{i}", 0.1, (1e-4, 2e-4, 1e-4), com=(0, 0, -0.05), joint=joint, **where))
    for i in range(springs):
        first = 1 + i * (count - 2) // springs
        scene.add_spring(f"s{i}", bodies[first], bodies[first + 2], stiffness=1e4, damping=1.0)
    return scene.freeze()


def test_a_step_of_a_chain_with_springs_solves_for_them_whatever_its_length() -> None:
    """The work of an evaluation is of the length, that of the system of the springs alone."""
    counts = []
    for count in (20, 100):
        run = stepper(chain(count, 2), False, 1e-3)
        run.integrate_through(np.array([1.0]), np.empty((1, len(run.state()))), 50)
        counts.append((run.step.rank, run.statistics["jacobians"]))
        assert run.statistics["evaluations"] <= 3 * 50
    assert counts[0] == counts[1] == (2, 1)  # along each spring; at the start there is no tension


def test_few_directions_lead_where_the_dense_matrix_does() -> None:
    model = chain(20, 3)
    found = []
    for is_dense in (False, True):
        run, states = stepper(model, is_dense, 1e-3), np.empty((1, model.coordinate_count + model.free_count + 2))
        run.integrate_through(np.array([0.3]), states, 1000)
        found.append(states[0, : model.coordinate_count].copy())
    # both iterate to a thousandth of 1e-7 in each of 300 steps
    np.testing.assert_allclose(found[0], found[1], rtol=0, atol=1e-8)


def test_what_has_no_few_directions_takes_the_matrix_of_all_unknowns() -> None:
    assert directions_of_loads(chain(20, 3)) == 18
    assert directions_of_loads(chain(20, 4)) == 0  # 24 directions, more than speeds


def test_free_steps_take_few_directions_too() -> None:
    model = chain(20, 3)
    exact = integrate(model, (0.0, 0.2), method="radau5", rtol=1e-9, output_step=0.2).coordinates[-1]
    errors = []
    for rtol in (1e-4, 1e-6):
        run = integrate(model, (0.0, 0.2), method="generalised-alpha", rtol=rtol, output_step=0.2)
        errors.append(abs(run.coordinates[-1] - exact).max())
    assert errors[1] < 0.1 * errors[0]
    assert errors[1] < 1e-4
