"""Rolling without slipping, against closed forms."""

import numpy as np
import pytest

import kanefe as kf
from kanefe.equations.model import Model
from kanefe.frames import euler_parameters, rotation_matrix
from scenes import random_inertia

RADIUS, MASS = 0.3, 2.0


@pytest.fixture(autouse=True)
def _literal(monkeypatch):
    """Runs take the literal route: that the compiled one gives the same is for its own tests."""
    monkeypatch.setattr(Model, "route", Model.literal)


def test_a_ball_rolls_down_a_slope():
    """A homogeneous ball gains 5/7 g sin; the plane is turned, not gravity."""
    slope = 0.4
    scene = kf.System(gravity=(0, 0, -9.81))
    plane = scene.ground.frame(orientation=(np.cos(slope / 2), 0, np.sin(slope / 2), 0))
    start = RADIUS * plane.axes[:, 2]
    ball = scene.add_rigid_body("ball", MASS, 0.4 * MASS * RADIUS**2, joint=kf.Free(position=start))
    scene.add_rolling_ball("roll", ball, RADIUS, plane)
    result = scene.simulate((0.0, 1.0), rtol=1e-9, output_step=0.25)
    travel = (result.position("ball") - start) @ plane.axes
    expected = 0.5 * 5 / 7 * 9.81 * np.sin(slope) * result.times**2
    np.testing.assert_allclose(travel, np.column_stack((expected, 0 * expected, 0 * expected)), atol=1e-9)
    # normal force m g cos, friction 2/7 m g sin up the slope
    force = [
        rotation_matrix(e) @ f for e, f in zip(result.rotation("ball"), result.loop_force("roll")[:, :3], strict=True)
    ]
    wanted = MASS * 9.81 * np.array((-2 / 7 * np.sin(slope), 0, np.cos(slope)))
    np.testing.assert_allclose(np.array(force) @ plane.axes, np.tile(wanted, (5, 1)), atol=1e-7)


def test_a_ball_on_a_turntable_runs_in_circles():
    """On a plane that turns at W a rolling homogeneous ball moves on a circle at 2/7 W."""
    rate = 3.0
    scene = kf.System(gravity=(0, 0, -9.81))
    table = scene.add_rigid_body("table", 1.0, 1.0, joint=kf.Revolute("z", motion=kf.Motion.steady(rate)))
    start, speed = np.array((0.5, 0.0, RADIUS)), np.array((0.0, 0.4, 0.0))
    # the contact moves with the table: v = W x r + R w x n
    spin = np.cross((0, 0, 1), (speed - np.cross((0, 0, rate), start))) / RADIUS
    ball = scene.add_rigid_body(
        "ball", MASS, 0.4 * MASS * RADIUS**2, joint=kf.Free(position=start, velocity=speed, angular_velocity=spin)
    )
    scene.add_rolling_ball("roll", ball, RADIUS, table)
    result = scene.simulate((0.0, 2.0), rtol=1e-9, output_step=0.1)
    turn = 2 / 7 * rate * result.times
    radius = 0.4 / (2 / 7 * rate)
    expected = np.column_stack((0.5 + radius * (np.cos(turn) - 1), radius * np.sin(turn), RADIUS + 0 * turn))
    np.testing.assert_allclose(result.position("ball"), expected, atol=1e-8)


def test_a_disc_rolls_on_a_circle_at_a_steady_lean():
    """Steady precession of a thin disc: lean, rates and radius of the path obey the closed form.

    With the axle `lean` above the ground, precession P and total rate n about the axle: the hub runs on a circle of
    radius -n R / P, and moments about the centre, P c (J n - I P s) = m R (c P^2 radius - s g), give n.
    """
    lean, precession = 0.3, 2.5
    across, along = 0.25 * MASS * RADIUS**2, 0.5 * MASS * RADIUS**2  # I and J
    sine, cosine = np.sin(lean), np.cos(lean)
    n = sine * (across * precession**2 * cosine - MASS * 9.81 * RADIUS)
    n /= (along + MASS * RADIUS**2) * precession * cosine
    axle = np.array((cosine, 0.0, sine))
    w = n * axle + precession * (np.array((0, 0, 1)) - sine * axle)
    down = np.array((sine, 0.0, -cosine))
    velocity = -np.cross(w, RADIUS * down)
    # the circle about N's z axis: velocity = P x r
    place = np.array((velocity[1] / precession, -velocity[0] / precession, RADIUS * cosine))
    turn = euler_parameters((0, 1, 0), np.pi / 2 - lean)  # z of the disc along the axle
    A = rotation_matrix(turn)
    np.testing.assert_allclose(A[:, 2], axle, atol=1e-15)
    scene = kf.System(gravity=(0, 0, -9.81))
    disc = scene.add_rigid_body(
        "disc",
        MASS,
        (across, across, along),
        joint=kf.Free(position=place, orientation=turn, velocity=velocity, angular_velocity=A.T @ w),
    )
    scene.add_rolling_wheel("roll", disc, RADIUS)
    model = scene.freeze()
    np.testing.assert_allclose(model.initial_speeds, np.concatenate((velocity, A.T @ w)), atol=1e-12)
    result = scene.simulate((0.0, 2.0), rtol=1e-9, output_step=0.1)
    hub = result.position("disc")
    angle = precession * result.times
    radius = place[0]
    expected = np.column_stack((radius * np.cos(angle), radius * np.sin(angle), place[2] + 0 * angle))
    np.testing.assert_allclose(hub, expected, atol=1e-7)


@pytest.mark.parametrize("seed", range(2))
def test_rolling_keeps_energy(seed):
    """An eccentric, unequal wheel and ball that tumble on a plane: contact forces do no work."""
    rng = np.random.default_rng(seed)
    scene = kf.System(gravity=(0, 0, -9.81))
    inertia = random_inertia(rng, 0.02)
    joint = kf.Free(position=(0, 0, 0.5), orientation=(1, 0.6, 0.1, 0), angular_velocity=(1.0, 2.0, -9.0))
    body = scene.add_rigid_body("body", MASS, inertia, com=(0.02, 0.03, -0.01), joint=joint)
    add = scene.add_rolling_ball if seed else scene.add_rolling_wheel
    add("roll", body, RADIUS)
    result = scene.simulate((0.0, 1.0), rtol=1e-9, output_step=0.1)
    assert np.ptp(result.energy.kinetic) > 1e-2
    assert abs(result.energy.balance_error).max() < 1e-7 * result.energy.kinetic.max()
