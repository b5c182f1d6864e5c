"""Solvers of other packages as methods: they agree with kanefe's own, and are driven by the same loop."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
import pytest

import kanefe as kf
from kanefe.errors import MissingDependency, ModelError, SimulationWarning
from kanefe.integrate.methods.table import METHODS
from kanefe.integrate.run import integrate
from kanefe.literal.loop_closure import project_positions
from loop_scenes import four_bar
from run_scenes import PLUGGED, SCENES, double_pendulum, falling_ball, floor, soft_arm

ALL_SCENES = {**SCENES, "four-bar": four_bar}


def test_there_are_four_of_them() -> None:
    assert {name for name, method in METHODS.items() if method.is_plugged} == {
        "scipy-bdf",
        "scipy-radau",
        "scipy-lsoda",
        "sundials-cvode",
    }


@pytest.mark.parametrize("scene", ALL_SCENES)
@pytest.mark.parametrize("method", PLUGGED)
def test_it_agrees_with_dop853(method: str, scene: str) -> None:
    model = ALL_SCENES[scene]().freeze()
    options: dict[str, Any] = {"output_step": 0.07}  # between the steps: the dense output too
    exact = integrate(model, (0.0, 0.7), method="dop853", rtol=1e-10, **options)
    run = integrate(model, (0.0, 0.7), method=method, rtol=1e-6, **options)
    assert run.status is not None
    assert run.status.is_finished
    # some hundred steps of a multistep method, each with an error of a tolerance
    assert run.coordinates == pytest.approx(exact.coordinates, abs=1e-4)
    assert run.work == pytest.approx(exact.work, abs=1e-3)
    assert 10 < run.statistics["steps"] < 1000
    assert run.statistics["evaluations"] > run.statistics["steps"]


@pytest.mark.parametrize("method", PLUGGED)
def test_its_steps_do_not_depend_on_how_many_states_are_stored(method: str) -> None:
    model = double_pendulum().freeze()
    few, many = (integrate(model, (0.0, 1.0), method=method, rtol=1e-6, output_step=h) for h in (0.5, 0.01))
    assert few.statistics == many.statistics | {name: few.statistics[name] for name in ("seconds", "seconds_by_part")}
    np.testing.assert_array_equal(few.coordinates, many.coordinates[::50])


@pytest.mark.parametrize("method", PLUGGED)
def test_loops_that_drift_do_not_have_it_begin_anew_at_every_step(method: str) -> None:
    model = four_bar().freeze()
    run = integrate(model, (0.0, 1.0), method=method, rtol=1e-6, output_step=0.5)
    # begun anew at each it would be of order 1, with thousands of steps
    assert run.statistics["steps"] < 300
    for t, q in zip(run.times, run.coordinates, strict=True):
        assert q == pytest.approx(project_positions(model, t, q), abs=1e-10)


@pytest.mark.parametrize("method", PLUGGED)
def test_events_stop_it_and_it_goes_on_behind(method: str) -> None:
    result = falling_ball().simulate((0.0, 1.0), method=method, events=floor(0.5), rtol=1e-8)
    fall = np.sqrt(2.0 / 9.81)
    assert result.events["floor"] == pytest.approx([fall, 2.0 * fall], abs=1e-7)


@pytest.mark.parametrize("method", PLUGGED)
def test_a_load_that_turns_nan_is_named(method: str) -> None:
    scene = kf.System()
    wheel = scene.add_rigid_body("wheel", 1.0, 0.5, joint=kf.Revolute("z"))
    scene.add_torque(wheel, lambda t: 1.0 if t < 0.5 else np.nan)
    with pytest.warns(SimulationWarning, match=r"on 'wheel' must give .* at t = 0\.[5-9]\d* s it gave .*nan"):
        result = scene.simulate((0.0, 1.0), method=method)
    assert result.status.kind == "failed"
    assert 0.499 < result.times[-1] <= 0.5  # up to where the equations have an answer there are smaller steps


@pytest.mark.parametrize("method", PLUGGED)
def test_a_scene_that_is_driven_all_through_needs_no_integration(method: str) -> None:
    scene = kf.System()
    scene.add_rigid_body("rotor", 1.0, 0.2, joint=kf.Revolute("z", motion=kf.Motion.steady(5.0)))
    result = scene.simulate((0.0, 1.0), method=method, output_step=0.25)
    assert result.joint_coordinates("rotor")[:, 0] == pytest.approx([0, 1.25, 2.5, 3.75, 5.0], abs=1e-14)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"checkpoint": "run.npz"}, "have no checkpoints. Remedy: method='radau5'"),
        ({"step": 0.1}, "step has no meaning for .*, which chooses its own"),
        ({"rtol": 1e-14}, "rtol=1e-14 is below the round-off"),
    ],
)
@pytest.mark.parametrize("method", [name for name, method in METHODS.items() if method.is_plugged])
def test_what_it_cannot_do_is_refused(
    method: str, options: dict[str, Any], message: str, tmp_path: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ModelError, match=message):
        integrate(double_pendulum().freeze(), (0.0, 1.0), method=method, **options)
    assert not list(tmp_path.iterdir())


def test_a_missing_package_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, "kanefe.integrate.methods._sundials", raising=False)
    monkeypatch.setitem(sys.modules, "sksundae.cvode", None)
    with pytest.raises(MissingDependency, match=r"pip install 'kanefe\[sundials\]'"):
        integrate(double_pendulum().freeze(), (0.0, 1.0), method="sundials-cvode")


@pytest.mark.parametrize("method", [p for p in PLUGGED if "lsoda" not in p.values[0]])
def test_implicit_ones_get_the_jacobian(method: str) -> None:
    run = integrate(soft_arm().freeze(), (0.0, 0.2), method=method, rtol=1e-4, output_step=0.2)
    assert 0 < run.statistics["jacobians"] < run.statistics["steps"]
