"""The error of forces that a result tells: as large as it is, and with a word where it is more than rtol promises."""

from __future__ import annotations

import math
import warnings
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kanefe as kf
from kanefe.integrate.methods.elastic_speeds import elastic_speeds
from kanefe.tree.scales import coordinate_moves
from kanefe_fem import Material, Rectangle, beam_body, straight_beam

RATE, RADIUS, ROD = 40.0, 0.1, 0.35

TURN = 2.0 * math.pi / RATE


@cache
def rod() -> kf.FlexibleBody:
    """Return a steel rod with the static shapes of inertial loads, of which the fastest is one of 60 kHz."""
    loads = ("tip", "angular acceleration", "centrifugal")
    beam = straight_beam(ROD, Rectangle(0.03, 0.01), Material(E=210e9, nu=0.3, rho=7850.0), elements=4)
    interfaces, damping = {"root": "clamped", "tip": "rigid"}, kf.ModalDamping(0.05)
    return beam_body(beam, interfaces, kf.CraigBampton(modes=4, loads=loads), damping=damping)


@cache
def swing() -> kf.Motion:
    """Return a swing to and fro that begins as smoothly as it goes on, so that hardly anything vibrates."""
    w = 0.5 * RATE
    return kf.Motion(
        lambda t: 2.5 * math.sin(w * t) ** 4,
        lambda t: 10.0 * w * math.sin(w * t) ** 3 * math.cos(w * t),
        lambda t: 10.0 * w**2 * math.sin(w * t) ** 2 * (3.0 - 4.0 * math.sin(w * t) ** 2),
    ).compiled()


def slider_crank(pull: Any = None) -> kf.System:
    """Return a crank that drives a slider by a flexible rod, from its dead centre."""
    scene = kf.System()
    crank = scene.add_rigid_body("crank", 0.5, 1e-3, joint=kf.Revolute("z", motion=swing()))
    bar = scene.add_flexible_body("rod", rod(), parent=crank, at=(RADIUS, 0, 0), joint=kf.Revolute("z"))
    slider = scene.add_rigid_body("slider", 2.0, joint=kf.Prismatic("x", position=RADIUS + ROD))
    scene.add_loop_joint("pin", kf.Revolute("z"), bar.interface("tip"), slider)
    if pull is not None:
        scene.add_force(slider, pull)
    return scene


def run(**options: object) -> kf.Result:
    return slider_crank().simulate((0.0, 2.0 * TURN), output_step=TURN / 100, **options)  # type: ignore[arg-type]


@cache
def right_force() -> np.ndarray:
    return run(method="radau5", rtol=1e-10).loop_force("pin")[:, :3]


def estimated(result: kf.Result) -> float:
    errors = {one[:3]: one for one in result.force_errors()}
    return errors["loop_force", "pin", "force"].error


@pytest.fixture
def unsettled(monkeypatch: pytest.MonkeyPatch) -> None:
    """Have stiff modes left in outputs as they are: what then is wrong with forces is many times rtol."""
    monkeypatch.setattr("kanefe.integrate.methods.kernel_memory.elastic_speeds", lambda model: np.zeros(0, dtype=int))


@pytest.mark.usefixtures("unsettled")
def test_the_estimate_is_as_large_as_the_error() -> None:
    """A tenth of the times is looked at, none of which need have the largest error: a tenth of it may be found."""
    rtol = 1e-6
    found = run(method="extrapolation", rtol=rtol)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", kf.AccuracyWarning)
        right = np.linalg.norm(found.loop_force("pin")[:, :3] - right_force(), axis=1).max()
        assert right > 300.0 * rtol * np.linalg.norm(right_force(), axis=1).max()
        assert 0.1 * right < estimated(found) < 3.0 * right


@pytest.mark.usefixtures("unsettled")
def test_forces_beyond_what_the_tolerance_promises_come_with_a_word() -> None:
    found = run(method="extrapolation", rtol=1e-6)
    with pytest.warns(kf.AccuracyWarning, match=r"'pin' has an error of about .* N, .*promises 0.0001. .*'radau5'"):
        found.loop_force("pin")
    assert "forces  error about" in str(found)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found.loop_force("pin")  # once is enough


def test_forces_as_good_as_promised_come_without_one() -> None:
    found = run(method="radau5", rtol=1e-6)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found.loop_force("pin")
    error, largest, _ = found.statistics["force_error"][3:]
    assert 0.0 < error < 1e-4 * largest


def test_the_error_is_kept_with_a_saved_result(tmp_path: Path) -> None:
    found = run(method="radau5", rtol=1e-6)
    found.save(tmp_path / "run.h5")  # which reads all forces
    read = kf.load_result(tmp_path / "run.h5")
    assert read.statistics["force_error"] == found.statistics["force_error"]
    with pytest.raises(kf.ModelError, match="no model to run again"):
        read.force_errors()


def test_what_has_no_estimate_says_why() -> None:
    """When it is asked for, and in what is printed once a force was read: there is no silence about errors."""
    far = slider_crank().simulate((0.0, 2.0 * TURN), output_step=0.4 * TURN, method="radau5")
    with pytest.raises(kf.ModelError, match="outputs are too far apart"):
        far.force_errors()
    far.loop_force("pin")
    assert "the errors of forces are not estimated: its outputs are too far apart" in str(far)
    called = slider_crank(lambda t: (1.0, 0.0, 0.0)).simulate(
        (0.0, 0.2 * TURN), output_step=0.01 * TURN, method="radau5", rtol=1e-4
    )
    called.loop_force("pin")
    assert "not estimated unasked: functions in Python would be called again" in str(called)


def test_fixed_steps_have_an_estimate() -> None:
    """A tenth of the times is looked at, as above; the largest error is at the start, which is among them."""
    found = run(method="radau5", step=TURN / 100)
    right = np.linalg.norm(found.loop_force("pin")[:, :3] - right_force(), axis=1).max()
    assert 0.1 * right < estimated(found) < 3.0 * right
    assert "forces  error" in str(found)


def test_a_run_of_which_no_part_goes_again_is_read_without_an_estimate(monkeypatch: pytest.MonkeyPatch) -> None:
    found = run(method="extrapolation", rtol=1e-6)
    monkeypatch.setattr("kanefe.results.force_errors.KernelStepper.integrate_through", lambda *_: 0)
    assert np.isfinite(found.loop_force("pin")).all()
    with pytest.raises(kf.ModelError, match="no part of the run could be run again"):
        found.force_errors()


@pytest.mark.parametrize("output", [3, 70, 131])
def test_an_error_between_the_parts_at_even_distances_is_seen(output: int) -> None:
    """At the start, and in the middle between two parts; of the fastest mode, at one time."""
    found = run(method="radau5", rtol=1e-6)
    model = found.run.model
    fastest = next(at for _, at, speed in coordinate_moves(model) if speed == elastic_speeds(model)[-1])
    found.run.states = found.run.states.copy()
    found.run.states[output, fastest] += 1e-9 * ROD  # of which its frequency makes 0.2 % of the largest force
    error = found.force_errors()[0]
    assert error.share > 1e-3  # without it: below 1e-4, see above


def test_parts_that_take_too_many_steps_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    found = run(method="radau5", rtol=1e-6)
    assert "error of about" in str(found.force_errors()[0])
    monkeypatch.setattr("kanefe.results.force_errors.MOST_STEPS", 0.0)
    monkeypatch.setattr("kanefe.results.force_errors.FEWEST_STEPS", 12)
    assert "error of at least" in str(found.force_errors()[0])
    found.loop_force("pin")
    assert "forces  error at least" in str(found)
