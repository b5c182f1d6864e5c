"""Functions of the user that are noisy, remember, jump or give no number once are named, with the remedy."""

from __future__ import annotations

import math

import numpy as np
import pytest

import kanefe as kf


def pushed(function) -> kf.System:
    scene = kf.System(gravity=(0, 0, -9.81))
    rod = scene.add_rigid_body("rod", 1.0, 1 / 12, com=(0.5, 0, 0), joint=kf.Revolute("y"))
    scene.add_motor(rod, function)
    return scene


def test_noise_is_refused_before_the_run() -> None:
    rng = np.random.default_rng(0)
    with pytest.raises(kf.ModelError, match=r"motor of 'rod' gave .* and then .* noisy .* Remedy: add_controller"):
        pushed(lambda t, state: 1e-6 * rng.standard_normal()).simulate((0.0, 1.0))


def test_a_memory_that_every_call_changes_is_refused() -> None:
    total = [0.0]

    def integral(t: float) -> float:
        total[0] += 0.001
        return total[0]

    with pytest.raises(kf.ModelError, match=r"keeps a state of its own"):
        pushed(integral).simulate((0.0, 1.0))


def test_a_memory_that_the_run_changes_is_told_after_it() -> None:
    latched = []

    def latch(t: float, state: kf.SceneState) -> float:
        if state.joint_coordinates("rod")[0] > 0.3:
            latched.append(t)
        return 1.0 if latched else 0.0

    with pytest.warns(kf.SimulationWarning, match=r"gave 0 before the run and 1 after it.*Remedy: add_controller"):
        pushed(latch).simulate((0.0, 0.6))


def test_a_switch_that_chatters_is_named() -> None:
    def sign(t: float, state: kf.SceneState) -> float:
        return -50.0 * float(np.sign(state.joint_speeds("rod")[0]))

    result = pushed(sign).simulate((0.0, 1.0), most_seconds=0.5)
    assert "the motor of 'rod' jumps by 1e+02" in result.status.reason
    assert "kf.Event" in result.status.remedy


def test_a_number_that_is_missing_once_is_told() -> None:
    calls = [0]

    def once(t: float, state: kf.SceneState) -> float:
        calls[0] += 1
        return math.nan if calls[0] == 100 else 0.1

    with pytest.warns(kf.SimulationWarning, match=r"must give one finite number; at t = .* it gave nan; .*1 times"):
        result = pushed(once).simulate((0.0, 1.0))
    assert result.status.kind == "finished"


def test_a_function_of_time_and_state_passes_without_a_word(recwarn: pytest.WarningsRecorder) -> None:
    result = pushed(lambda t, state: math.sin(t) - 0.1 * state.joint_speeds("rod")[0]).simulate((0.0, 1.0))
    assert result.status.is_finished
    assert not recwarn.list
