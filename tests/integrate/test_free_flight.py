"""Invariants of motion: energy and momenta of soft bodies in large motion, undamped, damped, with gravity and loads."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import kanefe as kf
from bent_bodies import bent
from kanefe.equations.model import Model
from kanefe.integrate.run import integrate
from kanefe.integrate.trajectory import Trajectory
from kanefe.kane.energy import elastic_energy, gravity_energy, kinetic_energy, momenta
from kanefe.scene.scene import RigidBody
from kanefe.states.state import State
from scenes import lattice_body, random_inertia, random_state

SPAN = 0.35
CB = kf.CraigBampton(modes=2)


def scene_of(
    body: kf.FlexibleBody,
    slopes: str = "rotation-vector",
    gravity: tuple[float, float, float] = (0, 0, 0),
    tip: bool = True,
) -> kf.System:
    """Return a free body, held at G or floating, with a rigid body on a hinge at its tip."""
    scene = kf.System(gravity=gravity, slopes=slopes)
    arm = scene.add_flexible_body("arm", body, joint=kf.Free())
    if tip:
        inertia = random_inertia(np.random.default_rng(0), 0.01)
        scene.add_rigid_body(
            "tip", 0.6, inertia, parent=arm.interface("tip"), joint=kf.Revolute((1, 2, 3)), com=(0.1, 0.05, -0.1)
        )
    return scene


def planar_scene() -> kf.System:
    scene = kf.System()
    arm = scene.add_flexible_body("arm", lattice_body(1, planar=True), joint=kf.Planar())
    scene.add_rigid_body("tip", 0.6, 0.02, parent=arm.interface("tip"), joint=kf.Revolute("z"), com=(0.1, 0.05, 0.0))
    return scene


SCENES: dict[str, Callable[[], kf.System]] = {
    "clamped in G": lambda: scene_of(lattice_body(1, reduction=CB)),
    "clamped in G, Tait-Bryan slopes": lambda: scene_of(lattice_body(1, reduction=CB), "tait-bryan"),
    "floating": lambda: scene_of(lattice_body(2, {"tip": "rigid"}, reduction=kf.CraigBampton(modes=3))),
    "floating, both ends": lambda: scene_of(
        lattice_body(2, {"tip": "rigid", "root": "rigid"}, reduction=kf.CraigBampton(modes=1))
    ),
    "floating, alone": lambda: scene_of(lattice_body(3, {}, reduction=kf.CraigBampton(modes=6)), tip=False),
    "unreduced": lambda: scene_of(lattice_body(4, interior=1)),
    "planar, unreduced": planar_scene,
    "stiffened": lambda: scene_of(bent(lattice_body(1, reduction=CB), strength=0.1)),
    "stiffened, floating": lambda: scene_of(
        bent(lattice_body(2, {"tip": "rigid"}, reduction=kf.CraigBampton(modes=3)), strength=0.1)
    ),
}


def excited(model: Model, seed: int = 1) -> Model:
    """Return the model started far from rest: nodes displaced by a tenth of the length, tumbling at some rad/s."""
    q, u = random_state(model, seed, amplitude=0.1, speed=0.5)
    joint = model.bodies[0].speeds
    u[joint] *= 4.0
    return replace(model, initial_coordinates=q, initial_speeds=u)


def invariants(model: Model, run: Trajectory) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return total energy less work plus dissipation (T,), linear (T, 3) and angular momentum (T, 3)."""
    energy, linear, angular = [], [], []
    for i, t in enumerate(run.times):
        q, u = run.coordinates[i], run.speeds[i]
        total = (
            kinetic_energy(State(model, t, q, u))
            + elastic_energy(State(model, t, q))
            + gravity_energy(State(model, t, q))
        )
        energy.append(total + run.dissipated[i] - run.work[i])
        p, h = momenta(State(model, t, q, u))
        linear.append(p)
        angular.append(h)
    return np.array(energy), np.array(linear), np.array(angular)


def drift(values: np.ndarray) -> float:
    """Return the largest change since the start, relative to the largest value."""
    return float(abs(values - values[0]).max() / abs(values).max())


def tight(model: Model, **options: Any) -> Trajectory:
    return integrate(model, (0.0, SPAN), rtol=1e-12, method="dop853", output_step=SPAN / 6, **options)


@pytest.mark.parametrize("scene", SCENES)
def test_free_flight_keeps_energy_and_momenta(scene: str) -> None:
    model = excited(SCENES[scene]().freeze())
    run = tight(model)
    # the scene is strained and turned enough for every nonlinear term to matter
    assert elastic_energy(State(model, 0.0, run.coordinates[0])) > 0.02 * kinetic_energy(
        State(model, 0.0, run.coordinates[0], run.speeds[0])
    )
    energy, linear, angular = invariants(model, run)
    # relative tolerance of a step 1e-12, some hundred steps
    assert drift(energy) < 1e-10
    assert drift(linear) < 1e-10
    assert drift(angular) < 1e-10


def test_drift_falls_with_the_tolerance() -> None:
    model = excited(SCENES["clamped in G"]().freeze())
    drifts = []
    for rtol in (1e-4, 1e-6, 1e-8, 1e-10):
        run = integrate(model, (0.0, SPAN), rtol=rtol, method="dop853", output_step=SPAN / 6)
        drifts.append([drift(x) for x in invariants(model, run)])
    # a ten-thousandth of the tolerance takes at least a factor 1000 off every invariant: no error of the equations
    # hides; of 25 steps a single one may be off by more than its estimate says
    ratios = np.array(drifts[:-2]) / np.array(drifts[2:])
    assert np.all(ratios > 1000.0)


def test_a_wrong_angular_velocity_of_the_interface_would_show() -> None:
    # With slopes read as a rotation, but their rates taken for the angular velocity, energy is lost at second order:
    # the tangent map is needed. (Guards the test above against slopes too small to matter.)
    model = excited(SCENES["clamped in G"]().freeze())
    naive = replace(
        model,
        slopes=replace(model.slopes, tangent=lambda theta: np.eye(3), remainder=lambda theta, dtheta: np.zeros(3)),
    )
    assert drift(invariants(naive, tight(naive))[0]) > 1e-4


@pytest.mark.parametrize("slopes", ["rotation-vector", "tait-bryan"])
def test_gravity_gives_what_the_potential_loses(slopes: str) -> None:
    gravity = np.array([1.0, -3.0, -9.0])
    model = excited(scene_of(lattice_body(1, reduction=CB), slopes, tuple(gravity)).freeze())
    run = tight(model)
    energy, linear, _ = invariants(model, run)
    mass = model.bodies[0].flexible.body.mass + model.bodies[1].rigid.mass
    kinetic = 0.5 * np.sum(linear**2, axis=1).max() / mass  # the sum with the potential may be nothing by chance
    assert abs(energy - energy[0]).max() < 1e-10 * kinetic
    fall = linear - linear[0] - mass * run.times[:, None] * gravity
    assert abs(fall).max() < 1e-9 * abs(linear).max()


@pytest.mark.parametrize(
    "damping", [kf.ModalDamping(0.05), kf.RayleighDamping(mass=2.0, stiffness=0.003)], ids=["modal", "rayleigh"]
)
@pytest.mark.parametrize("interfaces", [None, {"tip": "rigid"}], ids=["clamped in G", "floating"])
def test_damping_takes_energy_and_leaves_momenta(damping: Any, interfaces: Any) -> None:
    body = lattice_body(1, interfaces, reduction=kf.CraigBampton(modes=3), damping=damping)
    model = excited(scene_of(body).freeze())
    run = tight(model)
    energy, linear, angular = invariants(model, run)
    assert np.all(np.diff(run.dissipated) > 0)
    assert run.dissipated[-1] > 0.02 * energy[0]  # a good part of it
    assert drift(energy) < 1e-10
    assert drift(linear) < 1e-10
    assert drift(angular) < 1e-10


def test_work_of_loads_and_drives_is_accounted_for() -> None:
    scene = kf.System(gravity=(0.0, -9.81, 0.0))
    motion = kf.Motion(lambda t: np.sin(3 * t), lambda t: 3 * np.cos(3 * t), lambda t: -9 * np.sin(3 * t))
    hub = scene.add_rigid_body("hub", 2.0, 0.1, joint=kf.Revolute("z", motion=motion))
    arm = scene.add_flexible_body(
        "arm", lattice_body(1, reduction=CB, damping=kf.ModalDamping(0.02)), parent=hub, joint=kf.Revolute("y")
    )
    tip = scene.add_rigid_body("tip", 0.3, 0.01, parent=arm.interface("tip"), joint=kf.Revolute("x"), com=(0, 0.1, 0))
    scene.add_torque(arm, lambda t: 2.0 * np.cos(5 * t))
    scene.add_torque(tip, lambda t: 0.1 * t)
    scene.add_force(tip, lambda t: (np.sin(4 * t), 1.0, -t), point=(0.1, 0.0, 0.2))
    scene.add_torque(arm.interface("tip"), (0.1, 0.2, -0.1), follows=True)
    scene.add_force(arm.node(3), (0.0, 0.0, 1.0), follows=True)
    model = scene.freeze()
    run = tight(model)
    energy, _, _ = invariants(model, run)
    assert abs(run.work).max() > 0.1
    # the balance starts at the energy of the start, the drive's part of it included; work is an integral of the same
    # tolerance. Energies are of the order of 10 J.
    scale = max(abs(run.work).max(), abs(energy).max())
    assert abs(energy - energy[0]).max() < 1e-10 * scale


def test_a_motor_inside_a_free_scene_does_work_but_changes_no_momentum() -> None:
    scene = scene_of(lattice_body(1, reduction=CB))
    scene.add_torque(RigidBody(scene, 1, "tip"), lambda t: 0.5 * np.cos(7 * t))
    model = excited(scene.freeze())
    run = tight(model)
    energy, linear, angular = invariants(model, run)
    assert abs(run.work).max() > 1e-2
    assert drift(energy) < 1e-10
    assert drift(linear) < 1e-10
    assert drift(angular) < 1e-10


def test_the_printed_damping_would_brake_free_flight() -> None:
    # the counterpart of the test above, on a rigid spin: see test_corrections for the forces themselves
    body = lattice_body(1, {}, reduction=kf.CraigBampton(modes=3), damping=kf.RayleighDamping(mass=2.0))
    scene = kf.System()
    scene.add_flexible_body("arm", body, joint=kf.Free(velocity=(1.0, 0.0, 0.0)))
    run = scene.simulate((0.0, 1.0), rtol=1e-10, output_step=0.5)
    # translation alone: nothing deforms, nothing is lost; C = a M on the absolute velocity would leave exp(-2) of it
    assert run.velocity("arm")[-1] == pytest.approx([1.0, 0.0, 0.0], abs=1e-9)
    assert run.energy.dissipated[-1] == pytest.approx(0.0, abs=1e-12)


def test_a_chain_of_every_rotating_joint_keeps_energy() -> None:
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    parent = None
    for i, joint in enumerate(
        (
            kf.Spherical(orientation=(1, 0.2, 0, 0), angular_velocity=(1, 2, 0)),
            kf.Universal("x", "y", speed=(1.0, -2.0)),
            kf.Cylindrical("y", speed=(0.3, 1.0)),
            kf.Screw((1, 0, 1), lead=0.1, speed=2.0),
        )
    ):
        parent = scene.add_rigid_body(
            f"link {i}", 1.0, (0.01, 0.02, 0.025), com=(0.2, 0.0, 0.05), parent=parent, joint=joint, at=(0.4, 0, 0)
        )
    energy = scene.simulate((0.0, 1.0), rtol=1e-10).energy
    # some 10 J flow; the integrator keeps 1e-10 a step over some hundred steps
    assert abs(energy.balance_error).max() < 1e-7
    assert np.ptp(energy.kinetic) > 1.0
