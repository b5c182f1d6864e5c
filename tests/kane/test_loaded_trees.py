"""Joint forces, drives of single coordinates, springs, bushings and controlled loads: balances on any state."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import kanefe as kf
from kanefe.equations.model import Model
from kanefe.kane.assemble import accelerations
from kanefe.kane.coupling import accelerations_and_coupling_forces, recovered_forces
from kanefe.kane.energy import dissipated_power, drive_power, load_power
from kanefe.kane.reactions import joint_reactions
from kanefe.states.state import State
from loaded_scenes import T, add_connections, add_controls, all_momenta, along, everything, total_energy, tree
from scenes import random_state


def joints_only(seed: int) -> Model:
    return tree(seed)[0].freeze()


def connected(seed: int) -> Model:
    scene, bodies = tree(seed, joint_forces=False)
    add_connections(scene, bodies, seed, ground=True)
    return scene.freeze()


def controlled(seed: int) -> Model:
    scene, bodies = tree(seed, joint_forces=False)
    add_controls(scene, bodies)
    return scene.freeze()


MODELS: dict[str, Callable[[int], Model]] = {
    "joint forces": joints_only,
    "connected": connected,
    "controlled": controlled,
    "everything": everything,
}


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_energy_changes_by_the_powers(model: Callable[[int], Model], seed: int) -> None:
    frozen = model(seed)
    q, u = random_state(frozen, seed, amplitude=0.05)
    du = accelerations(State(frozen, T, q, u))
    state = State(frozen, T, q, u)
    powers = [load_power(state), drive_power(state, du), -dissipated_power(state)]
    assert frozen.has_power
    # order-8 differences of energies of some 10 J at a step of 3e-4: round-off 1e-15 * 10 / 3e-4
    assert along(frozen, T, q, u)(total_energy) == pytest.approx(sum(powers), abs=1e-9 * (1 + max(map(abs, powers))))


@pytest.mark.parametrize("seed", range(3))
def test_forces_inside_a_scene_keep_its_momenta(seed: int) -> None:
    scene, bodies = tree(seed, gravity=False)
    add_connections(scene, bodies, seed, ground=False)
    model = scene.freeze()
    q, u = random_state(model, seed, amplitude=0.05)
    # the hub is free: whatever is driven, pulled or held between the bodies, nothing acts from outside
    assert along(model, T, q, u)(all_momenta) == pytest.approx(np.zeros(6), abs=2e-9)
    assert abs(all_momenta(model, T, q, u)).max() > 0.1


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_joints_carry_nothing_along_free_coordinates_but_their_forces(model: Callable[[int], Model], seed: int) -> None:
    # the reactions come from the balance of the bodies, which knows no partial velocities
    frozen = model(seed)
    q, u = random_state(frozen, seed, amplitude=0.05)
    du = accelerations(State(frozen, T, q, u))
    driving, _ = recovered_forces(State(frozen, T, q, u), du)
    full = frozen.all_speeds(T, u)
    state = State(frozen, T, q, u)
    turned = frozen.armatures * np.concatenate((du, state.driven_rates))  # what rotors take before the joint feels it
    for body, reaction in zip(frozen.bodies, joint_reactions(State(frozen, T, q, u), du), strict=True):
        at = body.joint_coordinates(T, q)
        V, W = body.joint.partial_velocities(at)
        _, A_FM = body.joint.pose(at)
        expected = np.zeros(len(body.speeds))
        for i, (speed, force) in enumerate(zip(body.speeds, body.joint.coordinate_forces, strict=True)):
            expected[i] += force.force(at[i], full[speed]) - turned[speed] if force else 0.0
            expected[i] += driving[speed - frozen.free_count] if speed >= frozen.free_count else 0.0
            expected[i] += sum(m.value(T, state) for m in body.joint_loads if m.coordinate == i)
        found = (A_FM.T @ V).T @ reaction[:3] + (A_FM.T @ W).T @ reaction[3:]
        assert found == pytest.approx(expected, abs=1e-10 * (1 + abs(reaction).max()))


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_coupling_forces_are_the_same_both_ways(model: Callable[[int], Model]) -> None:
    frozen = model(1)
    q, u = random_state(frozen, 1, amplitude=0.05)
    du, F_u = accelerations_and_coupling_forces(State(frozen, T, q, u))
    eliminated = accelerations(State(frozen, T, q, u))
    _, recovered = recovered_forces(State(frozen, T, q, u), eliminated)
    # two factorisations of matrices with condition numbers up to some 1e4
    assert du == pytest.approx(eliminated, abs=1e-11 * abs(du).max())
    assert F_u == pytest.approx(recovered, abs=1e-11 * abs(F_u).max())


@pytest.mark.parametrize("seed", range(2))
def test_a_run_of_everything_balances(seed: int) -> None:
    scene, bodies = tree(seed)
    add_connections(scene, bodies, seed, ground=True)
    add_controls(scene, bodies)
    result = scene.simulate((0.0, 0.2), rtol=1e-8, method="dop853", output_step=0.02)
    moved = abs(result.energy.work).max() + abs(result.energy.dissipated).max()
    assert moved > 0.01
    # kinks of friction-free springs and stops cost the error control some digits of its 1e-8 a step
    assert abs(result.energy.balance_error).max() < 1e-5


def test_single_coordinates_follow_their_motions() -> None:
    scene, _ = tree(0)
    result = scene.simulate((0.0, 0.3), rtol=1e-6, output_step=0.1)
    model = scene.freeze()
    for name, coordinate in (("sleeve", 1), ("cardan", 0), ("plate", 2)):
        motion = model.bodies[model.index(name)].joint.motions[coordinate]
        expected = [motion.position(t) for t in result.times]
        assert result.joint_coordinates(name)[:, coordinate] == pytest.approx(expected, abs=1e-15)
        rates = [motion.velocity(t) for t in result.times]
        assert result.joint_speeds(name)[:, coordinate] == pytest.approx(rates, abs=1e-15)
        assert result.driving_force(name).shape == result.times.shape
    assert "sleeve: angle [rad]" not in model.coordinate_names()
    assert "sleeve: distance [m]" in model.coordinate_names()
    assert result.units("driving_force", "sleeve") == "N m"


def test_a_joint_driven_along_two_coordinates_tells_both_forces(tmp_path) -> None:
    m, J = 2.0, 0.3
    scene = kf.System()
    slide = kf.Motion(lambda t: t**3, lambda t: 3 * t**2, lambda t: 6 * t)
    turn = kf.Motion(lambda t: t**2, lambda t: 2 * t, lambda t: 2.0)
    scene.add_rigid_body("sleeve", m, J, joint=kf.Cylindrical("z", motion=(slide, turn)))
    result = scene.simulate((0.0, 1.0), output_step=0.25)
    expected = np.column_stack((6 * m * result.times, 2 * J * np.ones(5)))
    assert result.driving_force("sleeve") == pytest.approx(expected, abs=1e-12)
    assert result.units("driving_force", "sleeve") == "N, N m"
    result.save(tmp_path / "run.h5")
    loaded = kf.load_result(tmp_path / "run.h5")
    assert loaded.driving_force("sleeve") == pytest.approx(expected, abs=1e-12)
    assert loaded.units("driving_force", "sleeve") == "N, N m"
    result.plot("driving_force", path=tmp_path / "drive.png")
