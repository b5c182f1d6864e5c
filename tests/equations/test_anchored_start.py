"""Friction at the start of a run: it holds what can rest, and what cannot slips at once; defaults of its anchors."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import kanefe as kf
from kanefe.checks.verification.contact import INCLINE, INCLINE_SPEED, NORMAL, UP, coin, moving_incline
from kanefe.checks.verification.references import load_references
from kanefe.equations.anchored_start import _least

G = 9.81
LEAD, RADIUS = 0.05, 0.04
THRESHOLD = LEAD / (2.0 * math.pi * RADIUS)


def screw(above: float) -> kf.System:
    scene = kf.System(gravity=(0, 0, -G))
    joint = kf.Screw("z", lead=LEAD, friction=kf.JointFriction(THRESHOLD + above, RADIUS))
    scene.add_rigid_body("nut", 3.0, 0.01, joint=joint)
    return scene


def test_a_screw_above_its_threshold_holds_from_the_start() -> None:
    result = screw(0.002).simulate((0.0, 2.0))
    assert abs(result.joint_coordinates("nut")).max() < 1e-15
    assert set(result.load("friction of nut")[:, 2]) == {1.0}
    assert not any(len(times) for times in result.events.values())


def test_a_screw_below_it_slips_from_the_start_as_the_textbook_says() -> None:
    result = screw(-0.002).simulate((0.0, 2.0), rtol=1e-8)
    mu, rise = THRESHOLD - 0.002, LEAD / (2.0 * math.pi)
    # it is lowered against W r (mu - tan)/(1 + mu tan), where W = m (g + rise dw/dt)
    arm = RADIUS * (mu - THRESHOLD) / (1.0 + mu * THRESHOLD)
    rate = 3.0 * G * arm / (0.01 - 3.0 * rise * arm)
    assert result.joint_coordinates("nut")[-1, 0] == pytest.approx(0.5 * rate * 2.0**2, rel=1e-7)
    assert set(result.load("friction of nut")[:, 2]) == {0.0}


def box_on_slope(tilt: float, friction: kf.Coulomb) -> kf.System:
    scene = kf.System(gravity=(G * math.sin(tilt), 0, -G * math.cos(tilt)))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    start = kf.Free(position=(0, 0, 0.1 - 2.0 * G * math.cos(tilt) / 1e6))
    box = scene.add_rigid_body("box", 2.0, 0.02, joint=start)
    skin = scene.add_surface("skin", box, kf.shapes.Box((0.4, 0.3, 0.2)))
    scene.add_contact("c", skin, floor, normal=kf.HuntCrossley(1e6, 0.3), friction=friction)
    return scene


@pytest.mark.parametrize("friction", [kf.Coulomb(0.5), kf.Coulomb(0.4, static=0.5), kf.Coulomb((0.5, 0.3), along="x")])
def test_a_box_put_where_it_rests_stays_there(friction: kf.Coulomb) -> None:
    """Only its place is given, and not what its anchors hold: four corners share what keeps it."""
    scene = box_on_slope(0.1, friction)
    rest = kf.equilibrium(scene)
    placed = np.concatenate((rest.q, rest.u))
    result = scene.copy().simulate((0.0, 5.0), start=placed)
    assert abs(result.position("box") - rest.position("box")).max() < 1e-14
    assert result.contact("c").slip[-1] == 0.0
    tangential = np.linalg.norm(result.contact("c").tangential[0])
    assert tangential == pytest.approx(2.0 * G * math.sin(0.1), rel=1e-9)


@pytest.mark.parametrize("static", [None, 0.4])
def test_a_block_that_cannot_rest_slides_with_what_is_left(static: float | None) -> None:
    """From t = 0 with kinetic friction, along the slope and not as two coefficients of a start would have it."""
    tilt, mu = 0.5, 0.3
    scene = kf.System(gravity=(G * math.sin(tilt), 0, -G * math.cos(tilt)))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    start = kf.Free(position=(0, 0, -G * math.cos(tilt) / 1e6))
    block = scene.add_rigid_body("block", 1.0, 0.01, joint=start)
    law = kf.HuntCrossley(1e6, 0.3)
    scene.add_contact("c", block, floor, normal=law, friction=kf.Coulomb(mu, static=static))
    result = scene.simulate((0.0, 1.0), rtol=1e-8)
    wanted = 0.5 * G * (math.sin(tilt) - mu * math.cos(tilt)) * result.times**2
    np.testing.assert_allclose(result.position("block")[:, 0], wanted, rtol=0, atol=1e-9)


def test_what_spins_and_rolls_from_the_start_loses_what_friction_takes() -> None:
    """A ball on its patch: the moment mu rho N about the normal, from the first instant."""
    mu, rho, radius, mass = 0.4, 0.02, 0.1, 1.0
    scene = kf.System(gravity=(0, 0, -G))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    start = kf.Free(position=(0, 0, radius - mass * G / 1e6), angular_velocity=(0, 0, 20.0))
    ball = scene.add_rigid_body("ball", mass, 4e-3, joint=start)
    skin = scene.add_surface("skin", ball, kf.shapes.Sphere(radius))
    scene.add_contact("c", skin, floor, normal=kf.HuntCrossley(1e6, 0.3), friction=kf.Coulomb(mu, torsional=rho))
    result = scene.simulate((0.0, 0.5), rtol=1e-9)
    wanted = 20.0 - mu * rho * mass * G / 4e-3 * result.times
    np.testing.assert_allclose(result.angular_velocity("ball")[:, 2], wanted, rtol=0, atol=1e-8)


def test_a_coin_that_rolls_about_its_centre_goes_on() -> None:
    """Where it touches wanders over the coin: its slip stays zero, and its points there do not stay at rest."""
    for check in coin(load_references()["K21"]):
        assert check.passed, check.quantity


def test_the_rest_of_a_pendulum_on_a_journal_bearing() -> None:
    """Against pieces of the equation with rigid friction, mu r |F| with the force of its own acceleration."""
    mass, inertia, lever, mu, radius = 2.0, 0.02, 0.3, 0.3, 0.05

    def acceleration(angle: float, rate: float, way: float) -> float:
        found = 0.0
        for _ in range(60):  # a contraction by mu r / lever or so
            x = lever * (found * math.cos(angle) - rate**2 * math.sin(angle))
            z = lever * (found * math.sin(angle) + rate**2 * math.cos(angle)) + G
            moment = -mass * G * lever * math.sin(angle) - way * mu * radius * mass * math.hypot(x, z)
            found = moment / (inertia + mass * lever**2)
        return found

    def turns(t: float, y: np.ndarray) -> float:
        return float(y[1])

    turns.terminal = True  # type: ignore[attr-defined]
    t, angle, stops = 0.0, 1.0, []
    while lever * abs(math.sin(angle)) > mu * radius:
        way = -math.copysign(1.0, angle)
        turns.direction = -way  # type: ignore[attr-defined]
        rates = lambda t, y, way=way: (y[1], acceleration(y[0], y[1], way))  # noqa: E731
        run = solve_ivp(rates, (t, t + 9.0), (angle, 0.0), "DOP853", rtol=1e-11, atol=1e-13, events=turns)
        t, angle = float(run.t[-1]), float(run.y[0, -1])
        stops.append(t)
    scene = kf.System(gravity=(0, 0, -G))
    joint = kf.Revolute("y", position=1.0, friction=kf.JointFriction(mu, radius))
    scene.add_rigid_body("bob", mass, inertia, com=(0, 0, -lever), joint=joint)
    result = scene.simulate((0.0, t + 1.0))
    # ten times what an anchor yields by, 1e-7; of instants some of its own times, 3e-4 of the swing's
    assert result.joint_coordinates("bob")[-1, 0] == pytest.approx(angle, abs=2e-6)
    told = result.events["bob stick"]
    assert max(abs(told - stop).min() for stop in stops) < 2e-4


def test_what_sticks_on_a_shaken_slope_does_not_ring_loose() -> None:
    """Slips and sticks are those of a rigid block; at a tenth of critical damping there were four more, and a drift."""
    exact = load_references()["F01a"].values["res"]
    scene, top = moving_incline()
    start = kf.Free(position=-G * math.cos(INCLINE) / 1e7 * NORMAL, velocity=INCLINE_SPEED * UP)
    block = scene.add_rigid_body("block", 1.0, 0.01, joint=start)
    scene.add_contact("c", block, top, normal=kf.HuntCrossley(1e7, 0.3), friction=kf.Coulomb(0.3))
    result = scene.simulate((0.0, 3.0))
    told = np.sort(np.concatenate([result.events[f"c {what}"] for what in ("slip", "stick")]))
    # by T/k of 3e-7 m over its own speed, and ten times the tolerance
    np.testing.assert_allclose(told[told > 0.1], [time for _, time in exact["events"]], rtol=0, atol=1.5e-5)
    drift = (result.position("block")[-1] - result.position("deck")[-1]) @ UP - exact["slip_end"]
    assert abs(drift) < 1e-5


def test_what_an_action_kicks_slips_by_its_kinetic_coefficient() -> None:
    def kick(t: float, state: kf.SceneState) -> np.ndarray:
        y = state.vector
        y[1] = 2.0
        return y

    scene = kf.System()
    forces = kf.CoordinateForce(friction=2.0, static_friction=4.0)
    scene.add_rigid_body("block", 1.0, joint=kf.Prismatic("x", forces=forces))
    event = kf.Event("kick", lambda t, state: t - 0.5, action=kick)
    result = scene.simulate((0.0, 2.0), events=[event])
    # 2 m/s against 2 m/s2
    assert result.joint_coordinates("block")[-1, 0] == pytest.approx(1.0, rel=1e-6)
    assert result.events["block stick"][-1] == pytest.approx(1.5, abs=1e-3)


def test_stick_and_slip_is_followed_at_any_tolerance() -> None:
    """A mass that slips at 4 N and rubs with 2.5 N: where it slips is an event, and no kink within a step."""
    k, v, static, sliding = 100.0, 0.1, 4.0, 2.5
    w, D = math.sqrt(k), (static - sliding) / k
    period = 2.0 * D / v + 2.0 / w * (math.pi - math.atan(D * w / v))
    for rtol in (1e-4, 1e-6):
        scene = kf.System()
        base = scene.add_frame("base", joint=kf.Prismatic("x", motion=kf.Motion.steady(v)))
        forces = kf.CoordinateForce(friction=sliding, static_friction=static)
        mass = scene.add_rigid_body("mass", 1.0, parent=base, joint=kf.Prismatic("x", forces=forces))
        scene.add_spring("spring", scene.ground.frame(at=(-1, 0, 0)), mass, stiffness=k, rest_length=1.0)
        slip = scene.simulate((0.0, 4.0), rtol=rtol).events["mass slip"]
        assert slip == pytest.approx(static / k / v + period * np.arange(5), abs=100.0 * rtol)


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_what_friction_holds_is_the_least_within_its_limits(size: float) -> None:
    """By the conditions of a least within balls: no slope within one, and a slope straight outwards on its edge."""
    rng = np.random.default_rng(2)
    root = rng.standard_normal((6, 6))
    G, b = size * (root @ root.T + np.eye(6)), size * rng.standard_normal(6)
    parts = [slice(0, 2), slice(2, 4), slice(4, 6)]
    most = np.array((0.05, 10.0, 0.05))
    y = _least(G, b, parts, most, float(np.abs(b).max()))
    left = (b - G @ y) / size
    lengths = np.array([np.linalg.norm(y[part]) for part in parts])
    np.testing.assert_allclose(lengths[[0, 2]], most[[0, 2]], rtol=1e-12)
    assert lengths[1] < most[1]
    # to which sweeps settle, relative to the largest limit
    np.testing.assert_allclose(left[parts[1]], 0.0, atol=1e-8)
    for part in (parts[0], parts[2]):
        outwards = y[part] / np.linalg.norm(y[part])
        np.testing.assert_allclose(left[part], np.linalg.norm(left[part]) * outwards, atol=1e-8)
