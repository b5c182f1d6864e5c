"""Contacts at rest: balance under own weight, small motions about it, and runs that begin there."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from kanefe import shapes
from kanefe.checks.verification.turning import ball_on
from kanefe_fem.beams.body import straight_beam
from kanefe_fem.beams.sections import Rectangle
from kanefe_fem.materials.isotropic import Material

MASS, G, STIFFNESS, LAMBDA = 2.0, 9.81, 1e5, 0.3
ROUGH = kf.Coulomb(0.5)


def box_on_plane(tilt: float = 0.0, height: float = 0.1, friction: kf.Coulomb = ROUGH) -> kf.System:
    scene = kf.System(gravity=(0, 0, -G))
    slope = scene.add_surface("slope", scene.ground, shapes.Plane("z"), orientation=kf.rotation_about("y", tilt))
    box = scene.add_rigid_body("box", MASS, (0.1, 0.1, 0.1), joint=kf.Free(position=(0, 0, height)))
    skin = scene.add_surface("skin", box, shapes.Box((0.4, 0.3, 0.2)))
    scene.add_contact("c", skin, slope, normal=kf.HuntCrossley(STIFFNESS, LAMBDA), friction=friction)
    return scene


@pytest.mark.parametrize("height", [0.1, 0.15, 0.0999])
@pytest.mark.parametrize("static", [None, 0.6])
def test_a_box_comes_to_rest_on_a_floor_that_it_need_not_touch_at_first(height, static):
    found = kf.equilibrium(box_on_plane(height=height, friction=kf.Coulomb(0.5, static=static)))
    assert found.position("box")[2] == pytest.approx(0.1 - MASS * G / STIFFNESS, abs=1e-12)
    assert found.load("c")[2] == pytest.approx(MASS * G, rel=1e-9)
    assert found.load("c")[4] == pytest.approx(0.0, abs=1e-9)


def test_friction_holds_on_a_slope_what_it_has_to_and_no_more():
    tilt = 0.1
    found = kf.equilibrium(box_on_plane(tilt))
    force, normal, tangential = found.load("c")[:3], *found.load("c")[3:5]
    np.testing.assert_allclose(force, (0, 0, MASS * G), atol=1e-8)
    assert normal == pytest.approx(MASS * G * np.cos(tilt), rel=1e-9)
    assert tangential == pytest.approx(MASS * G * np.sin(tilt), rel=1e-9)


def test_a_slope_beyond_the_cone_has_no_balance():
    with pytest.raises(kf.SimulationError, match="no equilibrium of the scene was found"):
        kf.equilibrium(box_on_plane(tilt=0.6))


def test_small_motions_about_a_rest_are_those_of_springs():
    """Heave of the box on its four corners: k / m, and damping lambda N."""
    modes = kf.equilibrium(box_on_plane()).linearise().modes()
    omega = np.sqrt(STIFFNESS / MASS)
    damping = LAMBDA * MASS * G / (2.0 * np.sqrt(STIFFNESS * MASS))
    heave = int(np.argmin(abs(2 * np.pi * modes.frequencies - omega * np.sqrt(1 - damping**2))))
    assert 2 * np.pi * modes.frequencies[heave] == pytest.approx(omega * np.sqrt(1 - damping**2), rel=1e-8)
    assert modes.damping_ratios[heave] == pytest.approx(damping, rel=1e-6)


@pytest.mark.parametrize("tilt", [0.0, 0.1])
def test_a_run_from_a_rest_stays_and_creeps_by_nothing(tilt):
    scene = box_on_plane(tilt)
    found = kf.equilibrium(scene)
    result = scene.copy().simulate((0.0, 20.0), start=found, rtol=1e-6, output_step=1.0)
    assert abs(result.position("box") - found.position("box")).max() < 1e-12
    assert result.contact("c").slip[-1] == 0.0
    assert set(result.contact("c").status) == {"sticks"}


def test_routes_agree_about_a_rest():
    model = kf.equilibrium(box_on_plane(0.1)).model
    rng = np.random.default_rng(1)
    q, _, z = model.parts(model.initial_state.copy())
    y = np.concatenate((q + 1e-5 * rng.standard_normal(7), 1e-3 * rng.standard_normal(6), z, (0.0, 0.0)))
    np.testing.assert_allclose(
        model.route.evaluate(0.0, y).rates, model.literal.evaluate(0.0, y).rates, rtol=1e-9, atol=1e-9
    )


def test_what_is_put_exactly_on_each_other_settles():
    """Five boards touch at depth zero: their touches end steps, and make no storm of events."""
    scene = kf.System(gravity=(0, 0, -G))
    below = scene.add_surface("floor", scene.ground, shapes.Plane("z"))
    feet = shapes.Points([(x, y, -0.1) for x in (-0.1, 0.1) for y in (-0.1, 0.1)])
    for i in range(5):
        board = scene.add_rigid_body(f"board {i}", 1.0, 0.01, joint=kf.Free(position=(0, 0, 0.1 + 0.2 * i)))
        skin = scene.add_surface(f"feet {i}", board, feet)
        scene.add_contact(f"c{i}", skin, below, normal=kf.HuntCrossley(1e6, damping=5.0), friction=ROUGH)
        below = scene.add_surface(f"top {i}", board, shapes.Plane("z"), at=(0, 0, 0.1))
    result = scene.simulate((0.0, 2.0), rtol=1e-5)
    result.raise_for_status()
    sunk = sum((5 - i) * G / 1e6 for i in range(5))
    assert result.position("board 4")[-1, 2] == pytest.approx(0.9 - sunk, abs=1e-6)


@pytest.mark.parametrize("raised", [0.0, 1e-3, 0.3])
def test_a_flexible_arm_comes_to_rest_on_a_thin_stop_and_does_not_fall_through(raised):
    # its highest modes are 1e6 times stiffer than gravity along the hinge, which pulls the arm on and does not hold it
    beam = straight_beam(1.0, Rectangle(0.04, 0.04), Material(E=70e9, nu=0.33, rho=2700.0), elements=6)
    body = kf.flexible_body(beam, {"root": "clamped"}, reduction=kf.CraigBampton(8))
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    hinged = scene.add_flexible_body("arm", body, joint=kf.Revolute("y", position=-raised))
    stop = scene.add_surface("stop", scene.ground, kf.shapes.Box((0.1, 0.1, 0.01)), at=(1.0, 0.0, -0.005))
    scene.add_contact("end", hinged.node(6), stop, normal=kf.KelvinVoigt(1e5, damping=100.0))
    found = kf.equilibrium(scene)
    # moments about the hinge: the stop carries half the weight
    assert found.contact("end").normal == pytest.approx(0.5 * body.mass * 9.81, rel=1e-3)
    assert "end" in found.contact_report()


def test_a_ball_rests_on_a_slope_by_its_rolling_resistance():
    """Friction holds its weight, and a moment below 0.01 m times the normal force keeps it from rolling."""
    scene = ball_on(np.arctan(0.05), kf.Coulomb(0.4, rolling=0.01))
    held = kf.equilibrium(scene)
    assert held.load("c")[4] == pytest.approx(9.81 * np.sin(np.arctan(0.05)), rel=1e-9)
    result = scene.copy().simulate((0.0, 20.0), start=held, rtol=1e-6, output_step=1.0)
    assert abs(result.position("ball") - held.position("ball")).max() < 1e-12


def test_a_ball_that_spins_and_rolls_loses_what_its_couples_take():
    """The energy balance knows the springs of their anchors, and what slips."""
    friction = kf.Coulomb(0.4, torsional=0.01, rolling=0.005)
    start = {"velocity": (1.0, 0.0, 0.0), "angular_velocity": (0.0, 10.0, 20.0)}
    result = ball_on(0.0, friction, 1e6, **start).simulate((0.0, 4.0), rtol=1e-9)
    assert abs(result.velocity("ball")[-1]).max() < 1e-6
    assert abs(result.angular_velocity("ball")[-1]).max() < 1e-3  # it rings on the springs that hold it
    lost = 0.5 * 1.0 + 0.5 * 4e-3 * (10.0**2 + 20.0**2)
    assert result.contact("c").work[-1] == pytest.approx(lost, rel=1e-4)  # the rest rings away
    assert abs(result.energy.balance_error).max() < 1e-7 * lost


def test_twists_about_a_rest_are_those_of_springs():
    """Small spins of a ball that lies hang on its patch: k rho^2 over its inertia."""
    friction = kf.Coulomb(0.4, torsional=0.05, rolling=0.01, damping=20.0)
    frequencies = kf.equilibrium(ball_on(0.0, friction, 1e4)).linearise().modes().frequencies
    omega, damping = np.sqrt(1e4 * 0.05**2 / 4e-3), 20.0 * 0.05**2 / 4e-3
    wanted = np.sqrt(omega**2 - 0.25 * damping**2) / (2 * np.pi)
    assert np.abs(frequencies / wanted - 1.0).min() < 1e-7


def test_bristles_rest_and_swing_on_their_stiffness():
    """About a rest bristles are a spring of sigma0 N, which holds the weight of a block on a slope."""
    tilt, friction = 0.1, kf.LuGre(1e4, 30.0, 0.0, coulomb=0.4, static=0.5, stribeck_speed=1e-3)
    scene = kf.System(gravity=(G * np.sin(tilt), 0, -G * np.cos(tilt)))
    floor = scene.add_surface("floor", scene.ground, shapes.Plane("z"))
    block = scene.add_point("block", 1.0, joint=kf.Translation(position=(0, 0, 0)))
    scene.add_contact("c", block, floor, normal=kf.HuntCrossley(STIFFNESS, LAMBDA), friction=friction)
    held = kf.equilibrium(scene)
    assert held.load("c")[4] == pytest.approx(G * np.sin(tilt), rel=1e-9)
    modes = held.linearise().modes()
    normal = G * np.cos(tilt)
    wanted = np.sqrt(1e4 * normal - (0.5 * 30.0 * normal) ** 2) / (2 * np.pi)
    assert np.abs(modes.frequencies / wanted - 1.0).min() < 1e-6
    result = scene.copy().simulate((0.0, 2.0), start=held, rtol=1e-8)
    assert abs(result.position("block")[:, 0] - held.position("block")[0]).max() < 1e-9
    assert abs(result.energy.balance_error).max() < 1e-9
