"""A run that a sampled controller shakes to pieces names the controller."""

import warnings

import numpy as np
import pytest

import kanefe as kf
from kanefe.integrate.run_checks.drive_growth import DriveGrowth
from kanefe.kernels.steppers.sampling import LIMITS


def arm(gain: float) -> kf.System:
    """Return an arm of 0.1 kg m2 whose speed a sampled controller brakes: from sample to sample by 1 - gain."""
    scene = kf.System()
    body = scene.add_rigid_body("arm", 1.0, (0.1, 0.1, 0.1), joint=kf.Revolute("z", speed=0.1))
    scene.add_motor(body, 0.0)
    scene.add_controller(
        "brake",
        lambda t, reads, memory: -gain * 0.1 / 0.01 * reads[0],
        every=0.01,
        reads=("joint_speeds arm",),
        drives=("motor arm",),
    )
    return scene


NAMED = r"controller 'brake' now changes 'motor arm.*' by .* times as much as at the start.*may be unstable"
POLES = r"its fastest pole is \|z\| = 2\.9 over 0\.01 s, at 50 Hz"
REMEDY = r"Remedy: smaller gains or a shorter every= of controller 'brake' \(now 0\.01 s\)"


def test_a_run_of_an_unstable_loop_says_so_early_and_ends_where_drives_have_grown_a_millionfold() -> None:
    with pytest.warns(kf.SimulationWarning, match=f"{NAMED}.*{POLES}.*{REMEDY}") as told:
        result = arm(3.9).simulate((0.0, 20.0))  # 1 - 3.9
    assert [str(one.message)[:8] for one in told] == ["at t = 0", "the run "]
    assert result.status.kind == "failed"
    assert result.times[-1] < 1.0
    with pytest.raises(kf.SimulationError, match=f"drives have grown a millionfold; {NAMED}.*{POLES}.*{REMEDY}"):
        result.status.raise_if_failed()


def test_growth_is_that_of_the_last_change_over_the_largest_of_the_first_ones() -> None:
    growth = DriveGrowth(2)
    growth.take(np.column_stack((np.ones(20), (-2.0) ** np.arange(20))))  # changes of 3 times 1, 2, 4, ..., 2^18
    assert growth.grown(10.0) == (1, 2.0 ** (19 - LIMITS.few_samples), 3.0 * 2.0**18)


def test_drives_that_grow_otherwise_are_not_taken_for_a_loop() -> None:
    """A start at rest, a jump and a target that goes on by the third power of time: changes grow by any factor."""
    for target in (lambda t: 1.0 if t > 0.5 else 1e-9 * t, lambda t: t**3):
        scene = kf.System()
        scene.add_rigid_body("arm", 1.0, (0.1, 0.1, 0.1), joint=kf.Revolute("z"))
        scene.add_controller(
            "follow",
            lambda t, r, m, target=target: 20.0 * (target(t) - r[0]) - 2.0 * r[1],
            every=0.01,
            reads=("joint_coordinates arm", "joint_speeds arm"),
            drives="motor arm",
        )
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            assert scene.simulate((0.0, 3.0)).status.is_finished


def test_a_limit_and_a_warning_of_slow_steps_name_it_too(monkeypatch: pytest.MonkeyPatch) -> None:
    result = arm(3.9).simulate((0.0, 20.0), most_steps=14)
    assert result.status.kind == "stopped"
    with pytest.raises(AssertionError, match=f"{NAMED}.*{REMEDY}"):
        raise AssertionError(str(result.status))
    monkeypatch.setattr("kanefe.integrate.pace.PATIENCE", 0.0)
    monkeypatch.setattr("kanefe.integrate.pace.LONGEST", -1.0)
    with pytest.warns(kf.SimulationWarning, match="check loads and controllers for noise"):
        arm(0.5).simulate((0.0, 0.1))


def test_a_stable_loop_is_not_named() -> None:
    status = arm(0.5).simulate((0.0, 20.0), most_steps=60).status
    assert status.kind == "stopped"
    assert "controller" not in str(status)
