"""Results by name: positions, joints, modes, energies, forces."""

import time
from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp

import kanefe as kf
from kanefe.frames import rotation_matrix
from kanefe.results.quantities import QUANTITIES
from result_scenes import at_rest, beam_arm, pendulum, robot, turntable


def matrices(result: kf.Result, *frame: str) -> np.ndarray:
    return np.array([rotation_matrix(e) for e in result.rotation(*frame)])


def test_a_rigid_pendulum_is_where_its_angle_says():
    result = pendulum()
    angle = result.joint_coordinates("rod")[:, 0]
    assert result.times.shape == (51,)
    assert result.bodies == ("rod",)
    np.testing.assert_allclose(result.position("rod"), 0.0, atol=1e-15)
    zero = np.zeros_like(angle)
    expected = np.column_stack((np.cos(angle / 2), zero, zero, np.sin(angle / 2)))
    np.testing.assert_allclose(result.rotation("rod"), expected, atol=1e-12)
    rate = result.joint_speeds("rod")[:, 0]
    np.testing.assert_allclose(result.angular_velocity("rod")[:, 2], rate, rtol=1e-12)


def test_the_reaction_of_a_pendulum_is_the_force_its_centre_needs():
    result = pendulum()
    angle, rate = result.joint_coordinates("rod")[:, 0], result.joint_speeds("rod")[:, 0]
    alpha = -9.81 * 0.5 * np.cos(angle) * 2.0 / (2 / 12 + 2.0 * 0.25)
    np.testing.assert_allclose(result.angular_acceleration("rod")[:, 2], alpha, rtol=1e-12, atol=1e-12)
    expected = np.column_stack(
        (
            2.0 * (-0.5 * rate**2 + 9.81 * np.sin(angle)),
            2.0 * (0.5 * alpha + 9.81 * np.cos(angle)),
            0 * angle,
        )
    )
    np.testing.assert_allclose(result.joint_reaction("rod")[:, :3], expected, atol=1e-10)
    np.testing.assert_allclose(result.joint_reaction("rod")[:, 3:], 0.0, atol=1e-10)


def test_energy_of_a_pendulum():
    result = pendulum()
    energy = result.energy
    height = 0.5 * np.sin(result.joint_coordinates("rod")[:, 0])
    np.testing.assert_allclose(energy.gravity, 2.0 * 9.81 * height, atol=1e-12)
    np.testing.assert_allclose(energy.total, energy.kinetic + energy.elastic + energy.gravity)
    assert not energy.work.any()
    assert not energy.dissipated.any()
    # rtol 1e-10 over 1 s of motion with some 10 J
    assert abs(energy.balance_error).max() < 1e-8


def test_euler_parameters_do_not_jump():
    scene = kf.System()
    scene.add_rigid_body("top", mass=1.0, inertia=1.0, joint=kf.Revolute("z", speed=20.0))
    e = scene.simulate((0.0, 2.0), rtol=1e-8).rotation("top")
    # 20 rad/s turns through 0.08 rad between outputs, so that e moves by 0.04; a flip would be a step of 2
    assert np.linalg.norm(np.diff(e, axis=0), axis=1).max() < 0.05
    assert e[:, 0].min() < -0.9  # six turns pass through -1


def test_a_driven_joint_is_reported_from_its_motion():
    result = turntable()
    t = result.times
    np.testing.assert_allclose(result.joint_coordinates("table")[:, 0], np.sin(3 * t), atol=1e-15)
    np.testing.assert_allclose(result.joint_speeds("table")[:, 0], 3 * np.cos(3 * t), atol=1e-15)
    inertia = 0.4 + 0.1 + 2.0 * 0.25
    np.testing.assert_allclose(result.driving_force("table"), -9 * inertia * np.sin(3 * t), atol=1e-12)
    np.testing.assert_allclose(result.joint_reaction("table")[:, 5], result.driving_force("table"), atol=1e-12)
    # work of the drive against the kinetic energy it makes: the quadrature of the run, at rtol 1e-10
    np.testing.assert_allclose(result.energy.work, 0.5 * inertia * 9 * (np.cos(3 * t) ** 2 - 1), atol=1e-8)
    angular = result.momentum.angular[:, 2]
    np.testing.assert_allclose(angular, inertia * 3 * np.cos(3 * t), atol=1e-12)
    speed = 1.5 * np.cos(3 * t)
    np.testing.assert_allclose(np.linalg.norm(result.velocity("load"), axis=1), abs(speed), atol=1e-12)


def test_velocity_and_acceleration_are_the_rates_of_position():
    result = robot()
    t = result.times
    for frame in (("tip",), ("arm", "tip")):
        # central differences over 0.01 s of motion at up to some 10 Hz, read in the middle of the run
        x, v, a = result.position(*frame), result.velocity(*frame), result.acceleration(*frame)
        steps = (t[2:] - t[:-2])[:, None]
        np.testing.assert_allclose((x[2:] - x[:-2]) / steps, v[1:-1], atol=0.05 * abs(v).max())
        slow = slice(5, -5)
        integral = v[0] + np.cumsum(0.5 * (a[1:] + a[:-1]) * np.diff(t)[:, None], axis=0)
        np.testing.assert_allclose(integral[slow], v[1:][slow], atol=0.05 * abs(v).max())


def test_a_body_on_an_interface_moves_with_it():
    result = robot()
    np.testing.assert_allclose(result.position("arm", interface="tip"), result.position("tip"), atol=1e-14)
    np.testing.assert_allclose(matrices(result, "arm", "tip"), matrices(result, "tip"), atol=1e-13)


def test_nodes_move_with_modes_and_mesh_frame():
    result = robot()
    displacements = result.nodal_displacements("arm")
    assert displacements.shape == (41, 7, 3)
    np.testing.assert_allclose(displacements[:, 0], 0.0, atol=1e-15)
    np.testing.assert_allclose(displacements[:, -1], result.deflection("arm", "tip")[:, :3], atol=1e-14)
    np.testing.assert_allclose(result.nodal_positions("arm")[:, -1], result.position("arm", "tip"), atol=1e-14)
    np.testing.assert_allclose(result.nodal_positions("arm", frames=7), result.nodal_positions("arm")[7], atol=1e-15)
    chosen = result.nodal_displacements("arm", frames=slice(0, None, 10), nodes=[2, 4])
    np.testing.assert_allclose(chosen, displacements[::10, [2, 4]], atol=1e-15)


def test_a_table_too_large_asks_for_a_choice(monkeypatch):
    monkeypatch.setattr("kanefe.results.reader.LARGEST_TABLE", 1000)
    with pytest.raises(kf.ModelError, match=r"'arm'.*frames="):
        robot().nodal_displacements("arm")
    assert robot().nodal_displacements("arm", frames=[0, 1]).shape == (2, 7, 3)


def test_energy_of_a_flexible_scene_balances():
    energy = robot().energy
    exchanged = max(abs(energy.work).max(), energy.dissipated.max(), energy.elastic.max())
    assert energy.elastic.max() > 1e-3 * exchanged
    assert energy.dissipated[-1] > 0
    assert np.all(np.diff(energy.dissipated) >= 0)
    # second-order steps with rtol 1e-5: measured 4e-4 of the energy exchanged
    assert abs(energy.balance_error).max() < 2e-3 * exchanged


def test_the_root_force_is_the_reaction_of_the_joint_there():
    result = robot()
    force, reaction = result.coupling_force("arm", "root"), result.joint_reaction("arm")
    # the root is at G's origin; two routes to one wrench, round-off of sums of some 10 N
    np.testing.assert_allclose(force, reaction, atol=1e-10 * abs(reaction).max())


def test_the_force_of_a_carried_body_is_what_its_joint_takes_from_it():
    result = robot()
    on_arm, on_tip = result.coupling_force("arm", "tip"), result.joint_reaction("tip")
    turn = np.einsum("tji,tjk->tik", matrices(result, "arm"), matrices(result, "tip"))
    np.testing.assert_allclose(on_arm[:, :3], -np.einsum("tij,tj->ti", turn, on_tip[:, :3]), atol=1e-10)
    np.testing.assert_allclose(on_arm[:, 3:], -np.einsum("tij,tj->ti", turn, on_tip[:, 3:]), atol=1e-10)
    # Newton for the carried body alone, from the motion as it is reported
    w, alpha, c = result.angular_velocity("tip"), result.angular_acceleration("tip"), np.array([0.02, 0, 0])
    turning = np.cross(alpha, c) + np.cross(w, np.cross(w, c))
    a_com = result.acceleration("tip") + np.einsum("tij,tj->ti", matrices(result, "tip"), turning)
    needed = 0.2 * (a_com - np.array([0, 0, -9.81]))
    np.testing.assert_allclose(-np.einsum("tij,tj->ti", matrices(result, "arm"), on_arm[:, :3]), needed, atol=1e-10)


def test_an_arm_at_rest_is_held_by_its_weight():
    result = at_rest()
    mass = 1200.0 * 0.02 * 0.04
    force = result.coupling_force("arm", "root")
    weight = mass * 9.81
    # equilibrium to round-off of the stiffest mode (its K is 1e8 above the softest); second-order shift of the sagging
    # mass has no part in the moment about y beyond x displacements, which linear modes do not have
    np.testing.assert_allclose(force[:, 2], weight, rtol=1e-7)
    np.testing.assert_allclose(force[:, 4], -weight * 0.5, rtol=1e-6)
    np.testing.assert_allclose(np.delete(force, (2, 4), axis=1), 0.0, atol=1e-6 * weight)
    EI = 2e9 * 0.02 * 0.04**3 / 12
    # Timoshenko's shear adds 0.3 % to Euler-Bernoulli's sag; the span is uniform and the tip is a node
    np.testing.assert_allclose(-result.deflection("arm", "tip")[:, 2], weight / (8 * EI), rtol=5e-3)


def test_an_interface_that_carries_nothing_has_no_force():
    assert not at_rest().coupling_force("arm", "tip").any()


def test_forces_are_computed_only_when_asked_for_and_kept(monkeypatch):
    body = beam_arm(elements=2)
    scene = kf.System(gravity=(0, 0, -9.81))
    scene.add_flexible_body("arm", body)
    result = scene.simulate((0.0, 1e-3), method="generalised-alpha", output_step=5e-4)

    def refuse(*_: object) -> None:
        raise RuntimeError("computed")

    with monkeypatch.context() as patch:
        patch.setattr("kanefe.results.literal_sweeps.LiteralForces", refuse)
        patch.setattr("kanefe.order_n.sweeps.CompiledForces", refuse)
        result.position("arm")
        result.acceleration("arm")
        assert result.energy.balance_error.shape == (3,)
        with pytest.raises(RuntimeError, match="computed"):
            result.coupling_force("arm", "root")
    first = result.coupling_force("arm", "root")
    monkeypatch.setattr("kanefe.order_n.force_kernel.ForceKernel.prepared", refuse)
    assert result.coupling_force("arm", "root") is first
    with pytest.raises(ValueError, match="read-only"):
        first[0] = 0.0


def test_positions_of_a_usual_run_take_well_below_a_second():
    scene = kf.System()
    rod = scene.add_rigid_body("a", mass=1.0, inertia=1.0, com=(0.5, 0, 0), joint=kf.Revolute("z", speed=1.0))
    scene.add_rigid_body("b", mass=1.0, inertia=1.0, parent=rod, at=(1, 0, 0), joint=kf.Revolute("z"))
    result = scene.simulate((0.0, 1.0))
    start = time.perf_counter()
    assert result.position("b").shape == (501, 3)
    assert time.perf_counter() - start < 1.0  # 0.1 s on one slow core


@pytest.mark.parametrize(
    ("call", "names"),
    [
        (lambda r: r.position("leg"), "'leg'.*hub, arm, tip"),
        (lambda r: r.coupling_force("arm", "end"), "'end'.*root, tip"),
        (lambda r: r.position("hub", "end"), "'hub' has no interface called 'end'.*none"),
        (lambda r: r.modal_coordinates("hub"), "'hub' is rigid.*Flexible are: arm"),
        (lambda r: r.nodal_positions("tip"), "'tip' is rigid"),
        (lambda r: r.driving_force("hub"), "'hub' is not driven.*none"),
        (lambda r: r.nodal_displacements("arm", frames=[400]), "0 to 40"),
        (lambda r: r.nodal_displacements("arm", frames=0.5), "searchsorted"),
        (lambda r: r.nodal_displacements("arm", nodes=[7]), "0 to 6"),
        (lambda r: r.units("colour"), "'colour'.*position"),
        (lambda r: r.read("colour"), "'colour'.*position"),
        (lambda r: r.read("coupling_force", "arm"), "needs an interface.*root, tip"),
    ],
)
def test_an_unknown_name_is_an_error_that_lists_those_there_are(call, names):
    with pytest.raises(kf.ModelError, match=names):
        call(robot())


def test_every_quantity_has_a_unit():
    result = robot()
    assert all(result.units(quantity) for quantity in QUANTITIES)
    assert result.units("coupling_force") == "N, N m"
    assert result.units("joint_coordinates", "hub") == "rad"
    assert result.units("joint_speeds", "hub") == "rad/s"
    assert turntable().units("driving_force", "table") == "N m"
    assert result.units("modal_coordinates", "arm") == "kg^1/2 m"
    scene = kf.System()
    scene.add_rigid_body("free", mass=1.0, inertia=1.0, joint=kf.Free())
    flight = scene.simulate((0.0, 0.1), output_step=0.1)
    assert flight.units("joint_coordinates", "free") == "m, 1"


def test_a_sparse_basis_moves_nodes_as_the_same_in_full():
    """Of components x to rz at each node, those that shift it."""
    scene = kf.System()
    scene.add_flexible_body("arm", beam_arm(), joint=kf.Fixed())
    full = kf.equilibrium(scene).body("arm")
    sparse, eta = replace(full, basis=sp.csr_matrix(full.basis)), np.linspace(-1.0, 1.0, full.basis.shape[1])
    nodes = np.array((6, 2, 3))
    for given in (eta, np.stack((eta, eta**2))):
        wanted = full.displacements(given, nodes)
        # sums in another order
        np.testing.assert_allclose(sparse.displacements(given, nodes), wanted, rtol=0, atol=1e-14 * abs(wanted).max())
