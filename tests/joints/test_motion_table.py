"""Motions from tables: exact where a cubic is, continuous up to the acceleration, an error outside."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import kanefe as kf
from kanefe.errors import ModelError

TIMES = np.array([0.0, 0.3, 0.5, 0.9, 1.4, 2.0])


def test_a_cubic_is_reproduced() -> None:
    motion = kf.Motion.table(TIMES, 2 * TIMES**3 - TIMES**2 + 1)
    for t in np.linspace(0.0, 2.0, 7):
        assert motion.position(t) == pytest.approx(2 * t**3 - t**2 + 1, abs=1e-13)
        assert motion.velocity(t) == pytest.approx(6 * t**2 - 2 * t, abs=1e-12)
        assert motion.acceleration(t) == pytest.approx(12 * t - 2, abs=1e-11)


def test_the_acceleration_is_continuous() -> None:
    motion = kf.Motion.table(TIMES, np.sin(3 * TIMES))
    for t in TIMES[1:-1]:
        # the third derivative of the spline is some 100 rad/s3
        assert motion.acceleration(t - 1e-9) == pytest.approx(motion.acceleration(t + 1e-9), abs=1e-6)


def test_a_driven_joint_follows_its_table() -> None:
    J = 0.7
    scene = kf.System()
    scene.add_rigid_body("wheel", 1.0, J, joint=kf.Revolute("z", motion=kf.Motion.table(TIMES, TIMES**3)))
    result = scene.simulate((0.0, 2.0), output_step=0.1)  # to the last point of the table
    assert result.joint_coordinates("wheel")[:, 0] == pytest.approx(result.times**3, abs=1e-12)
    assert result.driving_force("wheel") == pytest.approx(6 * J * result.times, abs=1e-11)
    assert abs(result.energy.balance_error).max() < 1e-9


def test_outside_its_table_a_motion_is_not_known() -> None:
    scene = kf.System()
    scene.add_rigid_body("wheel", 1.0, 0.1, joint=kf.Revolute("z", motion=kf.Motion.table(TIMES, TIMES)))
    scene.add_rigid_body("free", 1.0, 0.1, joint=kf.Revolute("z", speed=1.0))
    named = r"motion of body 'wheel' is given from 0 to 2 s and was asked for at t = .* Remedy: a longer"
    with pytest.raises(ModelError, match=named):
        scene.simulate((-0.1, 1.0))
    with pytest.raises(ModelError, match=named):
        scene.simulate((0.0, 2.5))
    never = kf.Event("never", lambda t, state: 1.0, terminal=True)
    with pytest.warns(kf.SimulationWarning, match=named):
        assert scene.simulate((0.0, 2.5), events=[never]).times[-1] == pytest.approx(2.0, abs=1e-6)


def test_a_table_may_start_late() -> None:
    scene = kf.System()
    base = scene.add_rigid_body("wheel", 1.0, 0.1, joint=kf.Revolute("z", motion=kf.Motion.table(TIMES + 5, TIMES**2)))
    end = scene.ground.frame(at=(1.0, 0.0, 0.0))
    scene.add_spring("s", base.frame(at=(0.5, 0.0, 0.0)), end, stiffness=3.0)
    result = scene.simulate((5.5, 6.0), output_step=0.25)
    angle = result.joint_coordinates("wheel")[:, 0]
    assert angle == pytest.approx((result.times - 5) ** 2, abs=1e-12)
    # the spring is slack where the run starts, not where a motion that begins later is at zero
    assert result.energy.elastic[0] < 1e-30  # round-off of a length, squared
    assert result.energy.elastic[-1] > 1e-4


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: kf.Motion(np.sin), "velocity and acceleration is missing. Remedy: .* Motion.table"),
        (lambda: kf.Motion(np.sin, np.cos), "needs position, velocity and acceleration; acceleration is missing"),
        (lambda: kf.Motion.table([0, 1, 2], [0, 1, 2]), r"has 3 points, a spline needs 4\. Remedy: more points"),
        (
            lambda: kf.Motion.table([0, 1, 1, 2], [0, 1, 2, 3]),
            "times .* must increase, but 1 s is followed by 1 s. Remedy: sort the points and leave out doubled",
        ),
        (
            lambda: kf.Motion.table([0, 1, 2, 3], [0, 1, 2]),
            r"as many finite positions as times; shapes \(4,\) and \(3,",
        ),
        (lambda: kf.Motion.table([0, 1, 2, np.nan], [0, 1, 2, 3]), "or a number is not finite"),
        (lambda: kf.Motion.table("often", [1, 2]), "as many finite positions as times"),
    ],
)
def test_bad_tables_are_named(make: Any, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        make()
