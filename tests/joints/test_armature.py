"""Inertia of rotors behind gears, along single coordinates: closed forms, energies, momenta and driving forces."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from kanefe.errors import ModelError

GRAVITY, MASS, ARM, INERTIA, ROTOR = 9.81, 2.0, 0.3, 0.05, 0.4


def pendulum(**joint: object) -> kf.System:
    scene = kf.System(gravity=(0, 0, -GRAVITY))
    hinge = kf.Revolute("y", forces=kf.CoordinateForce(armature=ROTOR), **joint)
    scene.add_rigid_body("arm", MASS, INERTIA, com=(0, 0, -ARM), joint=hinge)
    return scene


def test_a_rotor_slows_a_pendulum_down() -> None:
    modes = kf.linearise(pendulum()).modes()
    inertia = INERTIA + MASS * ARM**2 + ROTOR
    wanted = np.sqrt(MASS * GRAVITY * ARM / inertia) / (2.0 * np.pi)
    assert modes.frequencies == pytest.approx([wanted], rel=1e-10)


def test_a_drive_turns_the_rotor_too() -> None:
    motion = kf.Motion(lambda t: 1.5 * t**2, lambda t: 3.0 * t, lambda t: 3.0)
    result = pendulum(motion=motion).simulate((0.0, 1.0), output_step=0.25)
    angle = 1.5 * result.times**2
    weight = MASS * GRAVITY * ARM * np.sin(angle)
    wanted = 3.0 * (INERTIA + MASS * ARM**2 + ROTOR) + weight
    assert result.driving_force("arm") == pytest.approx(wanted, rel=1e-12)
    assert abs(result.energy.balance_error).max() < 1e-6


def test_a_rotor_has_neither_weight_nor_momentum() -> None:
    """Two bodies on a slide that nothing holds: the armature acts on their distance alone."""
    scene = kf.System(gravity=(0, 0, 0))
    base = scene.add_rigid_body("base", 3.0, 0.1, joint=kf.Prismatic("x", speed=0.5))
    slide = kf.Prismatic("x", speed=2.0, forces=kf.CoordinateForce(stiffness=50.0, armature=ROTOR))
    scene.add_rigid_body("cart", MASS, 0.1, parent=base, joint=slide)
    result = scene.simulate((0.0, 2.0), rtol=1e-10)
    linear = 3.0 * result.joint_speeds("base")[:, 0] + MASS * result.joint_speeds("base")[:, 0]
    linear += MASS * result.joint_speeds("cart")[:, 0]
    assert linear == pytest.approx(3.0 * 0.5 + MASS * 2.5, rel=1e-9)
    # the reduced mass of the two and the armature swing on the spring
    rate = np.sqrt(50.0 / (ROTOR + 3.0 * MASS / (3.0 + MASS)))
    assert result.joint_coordinates("cart")[:, 0] == pytest.approx(2.0 / rate * np.sin(rate * result.times), abs=1e-8)
    kinetic = 0.5 * ROTOR * result.joint_speeds("cart")[0, 0] ** 2 + 0.5 * 3.0 * 0.5**2 + 0.5 * MASS * 2.5**2
    assert result.energy.kinetic[0] == pytest.approx(kinetic, rel=1e-14)


@pytest.mark.parametrize("method", ["dop853", "radau5", "generalised-alpha", "extrapolation"])
def test_methods_agree_on_what_a_rotor_does(method: str) -> None:
    """With a massless link between: only the armature gives it inertia."""
    step = {"step": 2e-4} if method == "generalised-alpha" else {"rtol": 1e-9}
    ends = []
    for options in (step | {"method": method}, {"method": "dop853", "rtol": 1e-11}):
        scene = kf.System(gravity=(0, 0, -GRAVITY))
        geared = {"forces": kf.CoordinateForce(stiffness=40.0, damping=0.1, armature=0.02)}
        link = scene.add_frame("link", joint=kf.Revolute("y", **geared))
        spun = kf.Revolute((1, 0.2, 0), position=0.4, forces=kf.CoordinateForce(armature=0.1))
        scene.add_rigid_body("arm", 1.0, 0.02, com=(0, 0, -0.2), parent=link, at=(0.1, 0, -0.3), joint=spun)
        result = scene.simulate((0.0, 0.5), **options)
        ends.append(np.concatenate([result.joint_coordinates(name)[-1] for name in ("link", "arm")]))
    # second order with 2500 steps; the others by their tolerance
    assert ends[0] == pytest.approx(ends[1], abs=1e-5 if method == "generalised-alpha" else 1e-7)


def test_a_frame_at_the_end_moves_by_its_rotor_alone() -> None:
    scene = kf.System(gravity=(0, 0, -GRAVITY))
    wheel = scene.add_frame("wheel", joint=kf.Revolute("x", forces=kf.CoordinateForce(armature=0.5)))
    scene.add_motor(wheel, 2.0)
    assert scene.simulate((0.0, 1.0)).joint_coordinates("wheel")[-1, 0] == pytest.approx(2.0, rel=1e-6)


def test_the_reaction_of_a_joint_leaves_out_what_its_rotor_takes() -> None:
    scene = pendulum(position=np.pi / 2)
    result = scene.simulate((0.0, 0.1))
    rate = -MASS * GRAVITY * ARM / (INERTIA + MASS * ARM**2 + ROTOR)
    moment = result.joint_reaction("arm")[0]
    assert abs(moment[4]) == pytest.approx(abs(ROTOR * rate), rel=1e-12)


def balls() -> tuple[kf.System, kf.Frame]:
    """Return two bodies on balls with rotors, the second one on the first."""
    scene = kf.System(gravity=(0, 0, -GRAVITY))
    ball = kf.Spherical(orientation=kf.rotation_about("x", 0.4), angular_velocity=(1.0, -2.0, 3.0), armature=ROTOR)
    inner = scene.add_rigid_body("inner", MASS, (0.02, 0.03, 0.04), com=(0.1, 0, -ARM), joint=ball)
    place = {"parent": inner, "at": (0, 0, -0.5), "joint": kf.Spherical(armature=0.1)}
    return scene, scene.add_rigid_body("outer", 1.0, (0.01, 0.02, 0.02), com=(0, 0.1, 0), **place)


def test_balls_with_rotors_keep_their_energy() -> None:
    scene, _ = balls()
    assert abs(scene.simulate((0.0, 0.5), rtol=1e-10).energy.balance_error).max() < 1e-8


def test_a_loop_over_balls_with_rotors_has_the_rates_of_the_literal_route() -> None:
    scene, outer = balls()
    scene.add_distance("rod", outer.frame((0.2, 0, 0)), scene.ground.frame((0.5, 0, 0)), 0.7)
    model = scene.freeze()
    y = np.concatenate((model.initial_state, np.zeros(2)))
    found, literal = model.route.evaluate(0.0, y).rates, model.literal.evaluate(0.0, y).rates
    np.testing.assert_allclose(found, literal, rtol=0, atol=1e-11 * abs(literal).max())


def test_a_free_body_with_an_armature_falls_more_slowly() -> None:
    scene = kf.System(gravity=(0, 0, -GRAVITY))
    scene.add_rigid_body("body", MASS, 0.1, joint=kf.Free(angular_velocity=(0.0, 0.0, 2.0), armature=ROTOR))
    result = scene.simulate((0.0, 1.0))
    assert result.position("body")[-1, 2] == pytest.approx(-0.5 * GRAVITY * MASS / (MASS + ROTOR), rel=1e-9)
    assert result.energy.kinetic[0] == pytest.approx(0.5 * (0.1 + ROTOR) * 4.0, rel=1e-14)
    assert abs(result.energy.balance_error).max() < 1e-8


def test_refusals() -> None:
    with pytest.raises(ModelError, match="armature of a joint coordinate must be finite and >= 0"):
        kf.CoordinateForce(armature=-1.0)
    for joint in (kf.Spherical, kf.Free):
        with pytest.raises(ModelError, match=r"armature of a .* joint must be >= 0"):
            joint(armature=-0.1)
        with pytest.raises(ModelError, match=r"armature of a .* joint"):
            joint(armature=np.nan)
        with pytest.raises(ModelError, match=r"armature .* moment that drives it.*Remedy"):
            joint(motion=kf.PoseTable(np.arange(4.0), orientations=np.tile((1.0, 0, 0, 0), (4, 1))), armature=0.1)
    scene = kf.System()
    carrier = scene.add_rigid_body("carrier", 1.0, 0.1, joint=kf.Prismatic("x"))
    with pytest.raises(ModelError, match=r"seen from the ground.*'carrier'.*Remedy"):
        scene.add_rigid_body("rider", 1.0, 0.1, parent=carrier, joint=kf.Free(armature=0.1))
    with pytest.raises(ModelError, match="start or forces of its own"):
        scene.add_loop_joint("ball", kf.Spherical(armature=0.1), scene.ground, carrier)
