"""Every joint: its partial velocities and remainders against finite differences of its pose (Eq. 13-16)."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import kanefe as kf
from kanefe.errors import ModelError
from kanefe.frames import axial
from kanefe.joints import Joint
from kanefe.joints.given_pose import driven
from scenes import derivatives

ANGLES = np.linspace(0.0, 2 * np.pi, 40, endpoint=False)
REACH = 2.0 + np.cos(3 * ANGLES)
KNOT = np.column_stack((REACH * np.cos(2 * ANGLES), REACH * np.sin(2 * ANGLES), np.sin(3 * ANGLES)))

TIMES = np.linspace(-1.0, 1.0, 41)
TUMBLING = kf.PoseTable(
    TIMES,
    np.column_stack((np.sin(TIMES), TIMES**2, np.cos(2 * TIMES))),
    [kf.euler_angles("XYZ", (t, 0.5 * t**2, 0.3 - t)) for t in TIMES],
)

JOINTS: list[Joint] = [
    kf.Fixed(),
    kf.Revolute("x"),
    kf.Revolute((1.0, -2.0, 0.5), position=0.4, speed=-1.0),
    kf.Prismatic("y"),
    kf.Prismatic((0.0, 3.0, 4.0), position=0.2, speed=0.3),
    kf.Planar(position=(0.1, -0.2), angle=0.5, velocity=(0.3, 0.2), rate=-0.7),
    kf.Cylindrical((1.0, 1.0, 0.0), position=(0.3, -0.4), speed=(1.0, 2.0)),
    kf.Screw("x", lead=0.02, position=0.5, speed=3.0),
    kf.Spherical(orientation=(1, -1, 0.5, 2), angular_velocity=(0.1, -0.5, 2.0)),
    kf.Universal("x", "y", position=(0.2, -0.6), speed=(1.0, 2.0)),
    kf.Universal((1.0, 1.0, 0.0), "z"),
    kf.Translation(position=(0.1, 0.2, -0.3), velocity=(1.0, 0.0, 2.0)),
    kf.PointOnCurve(KNOT, closed=True, position=0.3, speed=-1.0),
    kf.PointOnCurve(KNOT, closed=True, turns=True, position=2.1, speed=1.0),
    kf.PointOnCurve(KNOT, closed=True, turns=True, up=(0.3, 0.1, 1.0), position=1.3),
    kf.Free(position=(1, 2, 3), orientation=(2, 1, 0, -1), velocity=(1, 0, 2), angular_velocity=(0.1, -0.5, 2.0)),
    driven(kf.Free(motion=TUMBLING)),
]


@pytest.mark.parametrize("joint", JOINTS, ids=repr)
def test_velocity_and_acceleration_match_the_pose(joint: Joint) -> None:
    rng = np.random.default_rng(0)
    n = len(joint.speed_names)
    q = joint.advance(joint.initial_coordinates(), rng.standard_normal(n))
    u, du = rng.standard_normal(n), rng.standard_normal(n)

    def moved(t: float) -> np.ndarray:
        return joint.advance(q, u * t + 0.5 * du * t * t)

    V, W = joint.partial_velocities(q)
    Z, Y = joint.remainders(q, u)
    dp, ddp = derivatives(lambda t: joint.pose(moved(t))[0])
    dA, _ = derivatives(lambda t: joint.pose(moved(t))[1])
    # order-8 differences, steps of 0.02: round-off 1e-15 / 0.02, and 1e-15 / 0.02^2 in second derivatives
    assert V @ u == pytest.approx(dp, abs=1e-11)
    assert V @ du + Z == pytest.approx(ddp, abs=1e-10)
    assert W @ u == pytest.approx(-0.5 * axial(dA @ joint.pose(q)[1].T), abs=1e-10)
    # angular acceleration from the angular velocity along the same motion; u(t) = u + du t to second order
    alpha, _ = derivatives(lambda t: joint.partial_velocities(moved(t))[1] @ (u + du * t))
    assert W @ du + Y == pytest.approx(alpha, abs=1e-10)


@pytest.mark.parametrize("joint", JOINTS, ids=repr)
def test_coordinate_rates_are_the_rate_of_advance(joint: Joint) -> None:
    rng = np.random.default_rng(1)
    q, u = joint.initial_coordinates(), rng.standard_normal(len(joint.speed_names))
    rate, _ = derivatives(lambda t: joint.advance(q, u * t))
    assert joint.coordinate_rates(q, u) == pytest.approx(rate, abs=1e-12)


@pytest.mark.parametrize("joint", JOINTS, ids=repr)
def test_names_match_sizes(joint: Joint) -> None:
    assert len(joint.coordinate_names) == len(joint.initial_coordinates())
    assert len(joint.speed_names) == len(joint.initial_speeds())


def test_free_joint_keeps_unit_parameters() -> None:
    joint = kf.Free(orientation=(3, 0, 0, 4))
    q = joint.initial_coordinates()
    assert np.linalg.norm(q[3:]) == 1.0
    for _ in range(1000):
        q = joint.advance(q, np.full(6, 0.1))
    assert np.linalg.norm(q[3:]) == pytest.approx(1.0, abs=1e-15)  # renormalised at each step: no drift


def test_steady_motion() -> None:
    motion = kf.Motion.steady(3.0, start=1.0)
    assert (motion.position(2.0), motion.velocity(2.0), motion.acceleration(2.0)) == (7.0, 3.0, 0.0)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: kf.Revolute("w"), "axis of a revolute joint: 'w' is not x, y, z or three numbers"),
        (
            lambda: kf.Revolute((0, 0, 0)),
            "axis of a revolute joint must be three finite numbers with a length above zero",
        ),
        (lambda: kf.Prismatic((1, 0)), "axis of a prismatic joint must be three finite numbers"),
        (lambda: kf.Revolute("z", forces=1.0), "forces of a revolute joint must be a CoordinateForce, not"),
        (lambda: kf.Revolute("z", motion=np.sin), "motion of a revolute joint must be a Motion, not"),
        (lambda: kf.Revolute("z", position=np.nan), "position of a revolute joint must be one finite number"),
        (lambda: kf.Prismatic("z", speed=np.inf), "speed of a prismatic joint must be one finite number"),
        (lambda: kf.Revolute("z", speed=1.0, motion=kf.Motion.steady(1.0)), "Remedy: leave out position and speed"),
        (
            lambda: kf.Revolute("z", motion=kf.Motion(0.0, 1.0, 0.0)),
            "position of a Motion must be a function",
        ),
        (
            lambda: kf.Revolute("z", motion=kf.Motion(lambda t: t, lambda t: np.nan, lambda t: 0.0)),
            r"velocity at t = 0\.0 s must be one finite number",
        ),
        (
            lambda: kf.Revolute("z", motion=kf.Motion(lambda t: (t, t), lambda t: 1.0, lambda t: 0.0)),
            r"position at t = 0\.0 s must be one finite number",
        ),
        (lambda: kf.Free(orientation=(0, 0, 0, 0)), r"must be a rotation, not \(0, 0, 0, 0\)"),
        (lambda: kf.Free(velocity=(1, 2)), "velocity of a free joint must be 3 finite numbers"),
        (lambda: kf.Free(position=(1, 2, np.nan)), "position of a free joint must be 3 finite numbers"),
        (lambda: kf.Planar(position=(1, 2, 3)), "position of a planar joint must be 2 finite numbers"),
        (lambda: kf.Planar(rate=np.nan), "rate of a planar joint must be one finite number"),
    ],
)
def test_bad_input_is_named(make: Any, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        make()


@pytest.mark.parametrize(
    ("motion", "message"),
    [
        (
            kf.Motion(lambda t: 3.0 * t, lambda t: 5.0, lambda t: 0.0),
            "the velocity of a Motion is 5, but its position changes at 3 a",
        ),
        (
            kf.Motion(lambda t: np.sin(9 * t), lambda t: 9 * np.cos(9 * t), lambda t: 81 * np.sin(9 * t)),
            "the acceleration of a Motion is .* Remedy: give the time derivative of the velocity",
        ),
    ],
)
def test_a_motion_whose_rate_contradicts_it_is_refused(motion: kf.Motion, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        kf.Revolute("z", motion=motion)


def test_fast_large_and_slow_motions_pass_the_check() -> None:
    for a, w in ((1e-6, 6e3), (1e4, 1e-3), (1.0, 6e3), (1e6, 1.0)):
        motion = kf.Motion(
            lambda t, a=a, w=w: a * np.sin(w * t),
            lambda t, a=a, w=w: a * w * np.cos(w * t),
            lambda t, a=a, w=w: -a * w * w * np.sin(w * t),
        )
        assert kf.Revolute("z", motion=motion).motion is motion
