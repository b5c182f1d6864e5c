"""Motions of joints that compiled code knows: steady ones, tables, and functions that numba has compiled."""

from __future__ import annotations

import math

import numpy as np
import pytest

import kanefe as kf
import kanefe.order_n.route
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.run import integrate
from kanefe.kernels.compiler._numba import IS_COMPILED
from pickled_scenes import acceleration, angle, rate

TIMES = np.linspace(0.0, 1.0, 6)


def compiled_motion() -> kf.Motion:
    return kf.Motion(angle, rate, acceleration).compiled()


@pytest.mark.skipif(not IS_COMPILED, reason="kernels are run as Python")
def test_the_functions_of_a_motion_can_be_compiled() -> None:
    motion = kf.Motion(angle, rate, acceleration, span=(0.0, 2.0)).compiled()
    assert motion.is_compiled
    assert motion.span == (0.0, 2.0)
    assert Dynamics(driven(motion, motion).freeze()).is_autonomous
    assert [f(0.7) for f in (motion.position, motion.velocity, motion.acceleration)] == pytest.approx(
        [angle(0.7), rate(0.7), acceleration(0.7)], rel=1e-15
    )


def in_python(motion: kf.Motion) -> kf.Motion:
    """The same motion, as compiled code cannot know it."""
    return kf.Motion(motion.position, motion.velocity, motion.acceleration, motion.span)


def driven(hub: kf.Motion, arm: kf.Motion, axis: str = "z") -> kf.System:
    """A hub and the arm on it, both driven, and a pendulum on the arm."""
    scene = kf.System(gravity=(0.0, -9.81, 0.0))
    wheel = scene.add_rigid_body("hub", 1.0, 0.1, joint=kf.Revolute("z", motion=hub))
    lever = scene.add_rigid_body(
        "arm", 1.0, 0.1, com=(0.5, 0.0, 0.0), at=(0.3, 0.0, 0.0), parent=wheel, joint=kf.Revolute("z", motion=arm)
    )
    joint = kf.Revolute(axis, position=0.3)
    scene.add_rigid_body("bob", 1.0, 0.1, com=(0.5, 0.0, 0.0), at=(1.0, 0.0, 0.0), parent=lever, joint=joint)
    return scene


@pytest.mark.parametrize("axis", ["z", "y"])  # a plane scene and one of space have kernels of their own
@pytest.mark.parametrize("method", ["dopri5", "extrapolation"])
def test_a_run_in_compiled_code_is_the_one_with_motions_in_python(axis: str, method: str) -> None:
    tables = kf.Motion.table(TIMES, np.cos(TIMES)), kf.Motion.steady(2.0, start=0.1)
    for hub, arm in (tables, (compiled_motion(), tables[0])):
        compiled = driven(hub, arm, axis)
        python = driven(in_python(hub), in_python(arm), axis)
        assert Dynamics(compiled.freeze()).is_autonomous
        assert not Dynamics(python.freeze()).is_autonomous
        ends = [scene.simulate((0.0, 1.0), method=method, step=0.02) for scene in (compiled, python)]
        # rounding of 50 steps
        states = [np.hstack((run.joint_coordinates("bob"), run.joint_speeds("bob"))) for run in ends]
        np.testing.assert_allclose(*states, rtol=1e-11, atol=1e-11)
        np.testing.assert_allclose(*(run.energy.balance_error for run in ends), rtol=0, atol=1e-11)


def test_a_run_with_compiled_motions_does_not_come_back_to_python(monkeypatch: pytest.MonkeyPatch) -> None:
    model = driven(compiled_motion(), kf.Motion.steady(2.0)).freeze()
    assert kanefe.order_n.route.OrderN(model).is_autonomous
    asked: list[float] = []
    at = kf.Motion.at

    def counted(self: kf.Motion, name: str, t: float, body: str) -> float:
        asked.append(t)
        return at(self, name, t, body)

    monkeypatch.setattr(kf.Motion, "at", counted)
    looks = []
    for rtol in (1e-4, 1e-10):  # what is looked at before a run does not depend on its steps
        asked.clear()
        integrate(model, (0.0, 1.0), method="dop853", rtol=rtol, output_step=1.0)
        looks.append(len(asked))
    assert looks[0] == looks[1]


def twitching(motion: kf.Motion) -> kf.System:
    scene = kf.System()
    hub = scene.add_rigid_body("hub", 1.0, 0.1, joint=kf.Revolute("z", motion=motion))
    joint = kf.Revolute("z", forces=kf.CoordinateForce(damping=0.1))
    scene.add_rigid_body("bob", 1.0, 0.1, com=(0.5, 0.0, 0.0), at=(1.0, 0.0, 0.0), parent=hub, joint=joint)
    return scene


@pytest.mark.parametrize("method", ["dopri5", "dop853"])
def test_a_step_does_not_lead_over_what_a_table_does(method: str) -> None:
    """A hub at rest for 10 s, but for a twitch of 20 ms, which the damper of a pendulum on it turns into heat."""
    times = np.linspace(0.0, 10.0, 1001)
    motion = kf.Motion.table(times, np.where(np.abs(times - 4.37) < 1e-3, 0.01, 0.0))
    assert not Dynamics(twitching(motion).freeze()).calls_functions
    runs = [
        twitching(motion).simulate((0.0, 10.0), method=method, rtol=rtol, output_step=10.0) for rtol in (1e-6, 1e-10)
    ]
    heat, exact = (run.energy.dissipated[-1] for run in runs)
    assert exact > 1e-4
    assert heat == pytest.approx(exact, rel=1e-5)


@pytest.mark.parametrize("options", [{"method": "dopri5"}, {"method": "rk4", "step": 0.01}])
def test_a_compiled_motion_that_turns_nan_is_named(options: dict) -> None:
    scene = twitching(kf.Motion(lambda t: 0.0 if t < 0.5 else math.nan, lambda t: 0.0, lambda t: 0.0).compiled())
    with pytest.warns(
        kf.SimulationWarning, match="motion of body 'hub' must give finite numbers; its position at t = 0.5"
    ):
        assert scene.simulate((0.0, 1.0), output_step=0.1, **options).times[-1] == pytest.approx(0.5, abs=0.02)


def test_fixed_steps_past_the_end_of_a_table_are_named() -> None:
    scene = twitching(kf.Motion.table(TIMES, TIMES))
    never = kf.Event("never", lambda t, state: 1.0, terminal=True)
    with pytest.warns(kf.SimulationWarning, match="motion of body 'hub' is given from 0 to 1 s .* Remedy: a longer"):
        scene.simulate((0.0, 2.0), method="rk4", step=0.01, events=[never])


def test_functions_that_numba_compiled_before_are_known_too() -> None:
    numba = pytest.importorskip("numba")
    motion = kf.Motion(numba.njit(angle), numba.njit(rate), numba.njit(acceleration))
    assert Dynamics(twitching(motion).freeze()).is_autonomous


@pytest.mark.skipif(not IS_COMPILED, reason="kernels are run as Python")
def test_a_motion_that_cannot_be_compiled_is_refused() -> None:
    words = {"slow": 0.1}
    with pytest.raises(kf.ModelError, match=r"velocity of a Motion cannot be compiled: .* Remedy: use numbers, math"):
        kf.Motion(lambda t: 0.1 * t, lambda t: words.get("slow", t), lambda t: 0.0).compiled()
