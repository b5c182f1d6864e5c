"""A run that a sampled controller shakes to pieces names the controller."""

import warnings

import pytest

import kanefe as kf


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


NAMED = r"controller 'brake' has come to change 'motor arm.*' by .* times as much as at the start.*may be unstable"
REMEDY = r"Remedy: smaller gains or a shorter every= of controller 'brake' \(now 0\.01 s\)"


def test_a_run_that_an_unstable_loop_ends_names_the_controller() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        result = arm(3.9).simulate((0.0, 20.0))  # eigenvalue -2.9
    assert result.status.kind == "failed"
    with pytest.raises(kf.SimulationError, match=f"{NAMED}.*{REMEDY}"):
        result.status.raise_if_failed()


def test_a_limit_and_a_warning_of_slow_steps_name_it_too(monkeypatch: pytest.MonkeyPatch) -> None:
    result = arm(3.9).simulate((0.0, 20.0), most_steps=60)
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
