"""What a frozen model offers to those with an integrator or controller of their own."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import kanefe as kf
from kanefe.equations.model import Model
from kanefe.errors import ModelError
from kanefe.frames import euler_parameters_from_matrix
from loaded_scenes import STEP, T, add_connections, everything, tree
from order_n_rates import order_n
from random_scenes import Recipe, random_model
from scenes import derivatives, lattice_body, path, random_state


@pytest.fixture(scope="module")
def model() -> Model:
    return everything(1)


@pytest.fixture(scope="module")
def y(model: Model) -> np.ndarray:
    return np.concatenate(random_state(model, 4, amplitude=0.05))


def along(model: Model, t: float, y: np.ndarray) -> Callable[[Callable[[float, np.ndarray], Any]], np.ndarray]:
    """Return what differentiates ``quantity(t, y)`` by time along the motion that `rhs` tells."""
    n = model.coordinate_count
    q, u, du = y[:n], y[n:], model.rhs(t, y)[n:]
    moved = path(model, q, u, du)

    def rate(quantity: Callable[[float, np.ndarray], Any]) -> np.ndarray:
        at = lambda s: np.asarray(quantity(t + s, np.concatenate((moved(s), u + s * du))))  # noqa: E731
        return derivatives(at, STEP)[0]

    return rate


def test_states_are_named_in_their_order() -> None:
    scene = kf.System()
    table = kf.Motion(lambda t: t, lambda t: 1.0, lambda t: 0.0)
    sleeve = scene.add_rigid_body("sleeve", 1.0, 0.1, joint=kf.Cylindrical("x", motion=(None, table)))
    body = lattice_body(1, reduction=kf.CraigBampton(modes=1))
    arm = scene.add_flexible_body("arm", body, parent=sleeve, joint=kf.Revolute("y"))
    scene.add_rigid_body("ball", 1.0, 0.1, parent=arm.interface("tip"), joint=kf.Spherical())
    model = scene.freeze()
    names = model.state_names
    k = body.free_count
    assert names[:2] == ("sleeve: distance [m]", "arm: angle [rad]")
    assert names[2 : 2 + k] == tuple(f"arm: eta {i}" for i in range(k))
    assert [name.split(":")[0] for name in names[2 + k : 6 + k]] == ["ball"] * 4
    assert names[6 + k : 8 + k] == ("sleeve: rate [m/s]", "arm: rate [rad/s]")
    assert names[8 + k : 8 + 2 * k] == tuple(f"arm: deta {i}" for i in range(k))
    assert len(names) == len(model.initial_state) == len(model.rhs(0.0, model.initial_state))


def test_names_tell_which_entry_is_which(model: Model) -> None:
    names = list(model.state_names)
    assert len(set(names)) == len(names)
    y = model.initial_state
    y[names.index("nut: angle [rad]")] = 0.7
    y[names.index("nut: rate [rad/s]")] = -0.4
    rates = model.rhs(0.0, y)
    assert rates[names.index("nut: angle [rad]")] == -0.4
    moved, still = (model.kinematics("nut", 0.0, state) for state in (y, model.initial_state))
    relative = still.rotation.T @ moved.rotation
    expected = np.array([np.cos(0.35), 0.0, 0.0, np.sin(0.35)])  # the nut turns about z
    np.testing.assert_allclose(euler_parameters_from_matrix(relative), expected, atol=1e-14)


def test_other_integrators_reach_the_end_of_a_run() -> None:
    scene, bodies = tree(3)
    add_connections(scene, bodies, 3, ground=True)
    result = scene.simulate((0.0, 0.2), rtol=1e-9, atol=1e-11, method="dop853", output_step=0.1)
    model = scene.freeze()
    run = solve_ivp(model.rhs, (0.0, 0.2), model.initial_state, method="LSODA", rtol=1e-9, atol=1e-11)
    assert run.success
    end = model.kinematics("nut", 0.2, run.y[:, -1])
    # two methods with errors of 1e-9 a step, over some hundreds of steps
    np.testing.assert_allclose(end.position, result.position("nut")[-1], atol=1e-6)
    implicit = solve_ivp(
        model.rhs, (0.0, 0.2), model.initial_state, method="Radau", jac=model.jacobian, rtol=1e-6, atol=1e-8
    )
    assert implicit.success
    np.testing.assert_allclose(implicit.y[:, -1], run.y[:, -1], atol=1e-4)


def test_mass_matrix_and_forces_give_the_accelerations(model: Model, y: np.ndarray) -> None:
    du = model.rhs(T, y)[model.coordinate_count :]
    forces = model.forces(T, y)
    M = model.mass_matrix(T, y)
    np.testing.assert_allclose(M @ du, forces, rtol=0, atol=1e-11 * abs(forces).max())
    np.testing.assert_allclose(M, M.T, rtol=0, atol=1e-14 * abs(M).max())
    assert np.linalg.eigvalsh(M)[0] > 0.0


def test_the_mass_matrix_is_that_of_the_kinetic_energy() -> None:
    model = random_model(Recipe(5, bodies=6, elastic=0.5, is_autonomous=True))
    q, u = random_state(model, 5)
    y = np.concatenate((q, u))
    kinetic = model.energy(0.0, y).kinetic
    assert kinetic == pytest.approx(0.5 * u @ model.mass_matrix(0.0, y) @ u, rel=1e-12)


def test_energy_changes_by_the_powers_of_the_order_n_route(model: Model, y: np.ndarray) -> None:
    dissipated, work = order_n(model).held_rates(T, np.concatenate((y, np.zeros(2))))[0][-2:]
    rate = along(model, T, y)(lambda t, state: model.energy(t, state).total)
    # order-8 differences of energies of some 10 J at a step of 3e-4
    assert rate == pytest.approx(work - dissipated, abs=1e-9 * (1 + abs(work) + abs(dissipated)))
    parts = model.energy(T, y)
    assert parts.total == parts.kinetic + parts.elastic + parts.gravity


PLACES = [("hub", ""), ("cardan", ""), ("arm", ""), ("arm", "tip"), ("nut", "")]


@pytest.mark.parametrize(("body", "interface"), PLACES)
def test_kinematics_are_the_rates_of_places(model: Model, y: np.ndarray, body: str, interface: str) -> None:
    found = model.kinematics(body, T, y, interface)
    rate = along(model, T, y)
    velocity = rate(lambda t, state: model.kinematics(body, t, state, interface).position)
    np.testing.assert_allclose(found.rotation @ found.velocity, velocity, atol=1e-9)
    turning = found.rotation.T @ rate(lambda t, state: model.kinematics(body, t, state, interface).rotation)
    spin = np.array([turning[2, 1], turning[0, 2], turning[1, 0]])
    np.testing.assert_allclose(found.angular_velocity, spin, atol=1e-9)


@pytest.mark.parametrize(("body", "interface"), PLACES)
def test_partial_velocities_are_slopes_by_the_speeds(model: Model, y: np.ndarray, body: str, interface: str) -> None:
    found = model.kinematics(body, T, y, interface)
    n = model.coordinate_count
    for i in range(model.free_count):
        moved = y.copy()
        moved[n + i] += 1.0
        other = model.kinematics(body, T, moved, interface)
        np.testing.assert_allclose(other.velocity - found.velocity, found.partial_velocities[:, i], atol=1e-12)
        slope = other.angular_velocity - found.angular_velocity
        np.testing.assert_allclose(slope, found.partial_angular_velocities[:, i], atol=1e-12)


def test_threads_share_a_model() -> None:
    model = everything(2)
    states = [np.concatenate(random_state(model, seed, amplitude=0.05)) for seed in range(40)]

    def evaluate(i: int) -> tuple[np.ndarray, np.ndarray]:
        return model.rhs(0.01 * i, states[i]), model.jacobian(0.01 * i, states[i])

    with ThreadPoolExecutor(4) as pool:  # the model is fresh: its tables are made by one of the threads
        together = list(pool.map(evaluate, range(len(states))))
    for i, (rates, J) in enumerate(together):
        alone = evaluate(i)
        np.testing.assert_array_equal(rates, alone[0])
        np.testing.assert_array_equal(J, alone[1])


def test_a_call_leaves_nothing_behind(model: Model, y: np.ndarray) -> None:
    kept = y.copy()
    first = model.rhs(T, y)
    model.rhs(0.9, np.concatenate(random_state(model, 8)))
    model.jacobian(0.3, model.initial_state)
    np.testing.assert_array_equal(model.rhs(T, y), first)
    np.testing.assert_array_equal(y, kept)
    first[:] = np.nan  # the result is the caller's
    assert np.isfinite(model.rhs(T, y)).all()


CALLS: dict[str, Callable[[Model, np.ndarray], Any]] = {
    "rhs": lambda model, y: model.rhs(0.0, y),
    "jacobian": lambda model, y: model.jacobian(0.0, y),
    "mass_matrix": lambda model, y: model.mass_matrix(0.0, y),
    "forces": lambda model, y: model.forces(0.0, y),
    "energy": lambda model, y: model.energy(0.0, y),
    "kinematics": lambda model, y: model.kinematics("hub", 0.0, y),
}


@pytest.mark.parametrize("call", CALLS.values(), ids=CALLS)
def test_states_of_another_shape_are_refused(model: Model, call: Callable[[Model, np.ndarray], Any]) -> None:
    n, m = model.coordinate_count, model.free_count
    for shape in ((n + m - 1,), (n + m + 2,), (n + m, 1), ()):
        with pytest.raises(ModelError, match=f"has {n} coordinates and {m} speeds, not shape"):
            call(model, np.zeros(shape))


def test_unknown_frames_are_refused(model: Model, y: np.ndarray) -> None:
    with pytest.raises(ModelError, match=r"no body called .hubb.\. It has: hub, sleeve"):
        model.kinematics("hubb", 0.0, y)
    with pytest.raises(ModelError, match="rigid"):
        model.kinematics("hub", 0.0, y, "tip")
    with pytest.raises(ModelError, match="tip"):
        model.kinematics("arm", 0.0, y, "top")


def test_lists_and_whole_numbers_are_states() -> None:
    scene = kf.System(gravity=(0, -9.81, 0))
    scene.add_rigid_body("bob", 1.0, 0.1, com=(1, 0, 0), joint=kf.Revolute("z"))
    model = scene.freeze()
    expected = model.rhs(0.0, np.array([1.0, 2.0]))
    np.testing.assert_array_equal(model.rhs(0.0, np.array([1, 2])), expected)
    np.testing.assert_array_equal(model.rhs(0.0, [1, 2]), expected)  # type: ignore[arg-type]
    strided = np.array([1.0, 9.0, 2.0, 9.0])[::2]
    np.testing.assert_array_equal(model.rhs(0.0, strided), expected)
    np.testing.assert_array_equal(model.jacobian(0.0, strided), model.jacobian(0.0, np.array([1.0, 2.0])))


def test_a_frozen_model_cannot_be_changed(model: Model) -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        model.gravity = np.zeros(3)  # type: ignore[misc]
    for array in (model.gravity, model.initial_coordinates, model.initial_speeds):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0
    state = model.initial_state
    state[0] = 99.0  # a copy
    assert model.initial_state[0] != 99.0


def test_the_nodal_form_has_no_exact_jacobian() -> None:
    scene = kf.System()
    body = lattice_body(1, rotations=True, reduction=kf.CraigBampton(modes=1))
    scene.add_flexible_body("arm", body, joint=kf.Revolute("y"))
    model = scene.freeze()
    assert np.isfinite(model.rhs(0.0, model.initial_state)).all()
    with pytest.raises(ModelError, match="Remedy: finite differences of rhs"):
        model.jacobian(0.0, model.initial_state)


def test_reactions_and_driving_forces_are_those_of_the_result() -> None:
    scene = kf.System(gravity=(0.0, -9.81, 0.0))
    swing = kf.Motion(lambda t: np.sin(t), lambda t: np.cos(t), lambda t: -np.sin(t))
    crank = scene.add_rigid_body("crank", 1.0, 0.1, com=(0.2, 0, 0), joint=kf.Revolute("z", motion=swing))
    scene.add_rigid_body("rod", 2.0, 0.2, com=(0.3, 0, 0), joint=kf.Revolute("y"), parent=crank, at=(0.5, 0, 0))
    result = scene.simulate((0.0, 1.0), rtol=1e-9, output_step=0.5)
    model = scene.freeze()
    y = np.concatenate((result.joint_coordinates("rod")[-1], result.joint_speeds("rod")[-1]))
    # the same equations at the same state: round-off
    np.testing.assert_allclose(model.joint_reactions(1.0, y)["rod"], result.joint_reaction("rod")[-1], rtol=1e-12)
    np.testing.assert_allclose(model.driving_forces(1.0, y)["crank"], result.driving_force("crank")[-1], rtol=1e-12)
    assert set(model.driving_forces(1.0, y)) == {"crank"}


def test_derivatives_refuse_states_and_directions_of_another_shape() -> None:
    scene = kf.System(gravity=(0, 0, -9.81))
    scene.add_rigid_body("rod", 1.0, 1 / 12, com=(0.5, 0, 0), joint=kf.Revolute("y"))
    route = scene.freeze().route
    y = np.zeros(4)
    for state, along in ((y, np.eye(len(y) - 1)), (y, y), (y[:-2], np.eye(len(y) - 2)), (y, np.eye(len(y))[:, :-2])):
        with pytest.raises(ModelError, match=f"must have {len(y)} entries"):
            route.derivatives(0.0, state, along)
        with pytest.raises(ModelError, match="Remedy"):
            route.partial_derivatives(0.0, state, along)
    none = route.partial_derivatives(0.0, y, np.zeros((0, len(y))))
    assert none is not None
    assert none.shape == (0, len(y))
