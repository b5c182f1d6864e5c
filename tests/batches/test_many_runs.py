"""Many runs at once: each is that of `simulate` alone, whatever the number of threads and turns; bad input."""

from __future__ import annotations

import warnings
from collections.abc import Callable

import numpy as np
import pytest

import kanefe as kf
from kanefe.batches import lanes as lanes_module
from kanefe.batches.many_runs import simulate_many
from loop_scenes import four_bar
from run_scenes import double_pendulum, falling_ball, floor, soft_arm, tumbling

SAME = 1e-13
"""Largest difference of states, relative to the largest: the arithmetic is the same, and only loops close otherwise."""


def damped_arm() -> kf.System:
    """Return two links on stiff damped joints, for which an implicit method looks at the start."""
    scene = kf.System(gravity=(0.0, -9.81, 0.0))
    stiff = kf.CoordinateForce(stiffness=4e3, damping=40.0)
    upper = scene.add_rigid_body("upper", 2.0, 0.2, com=(0.5, 0, 0), joint=kf.Revolute("z", forces=stiff))
    scene.add_rigid_body("lower", 1.0, 0.1, com=(0.5, 0, 0), parent=upper, at=(1, 0, 0), joint=kf.Revolute("z"))
    return scene


SCENES: dict[str, tuple[Callable[[], kf.System], dict[str, object]]] = {
    "pendulum, chosen": (double_pendulum, {}),
    "pendulum, order 5": (double_pendulum, {"method": "dopri5", "rtol": 1e-7}),
    "fixed steps": (double_pendulum, {"method": "rk4", "step": 0.01}),
    "free body": (tumbling, {"rtol": 1e-8}),
    "implicit": (damped_arm, {"method": "radau5", "rtol": 1e-6}),
    "generalised-alpha": (damped_arm, {"method": "generalised-alpha", "step": 0.005}),
    "flexible": (soft_arm, {}),
    "contact of an event": (falling_ball, {"events": floor(0.8)}),
}


def starts_of(scene: kf.System, count: int) -> np.ndarray:
    """Return starts beside that of a scene; rotations are made of unit length by the run."""
    first = scene.freeze().initial_state
    return first + 0.05 * np.random.default_rng(3).uniform(-1.0, 1.0, (count, len(first)))


def states(result: kf.Result) -> np.ndarray:
    assert result.run is not None
    return result.run.states


def check_same(found: tuple[kf.Result, ...], alone: list[kf.Result]) -> None:
    assert len(found) == len(alone)
    for many, one in zip(found, alone, strict=True):
        assert str(many.status) == str(one.status)
        assert np.array_equal(many.times, one.times)
        assert np.abs(states(many) - states(one)).max() <= SAME * np.abs(states(one)).max()
        for name in ("method", "steps", "rejected", "evaluations"):
            assert many.statistics[name] == one.statistics[name], name
        assert {k: v.tolist() for k, v in many.events.items()} == {k: v.tolist() for k, v in one.events.items()}


@pytest.mark.parametrize("kind", SCENES)
def test_each_run_is_that_of_simulate_alone(kind: str) -> None:
    make, options = SCENES[kind]
    scene = make()
    starts = starts_of(scene, 5)
    alone = [scene.simulate((0.0, 0.4), start=start, **options) for start in starts]
    check_same(simulate_many(scene, (0.0, 0.4), starts, threads=2, **options), alone)


def test_loops_and_turns(monkeypatch: pytest.MonkeyPatch) -> None:
    """Starts of loops are closed, and runs are the same if their lanes take many short turns."""
    scene = four_bar()
    run = scene.simulate((0.0, 0.3), rtol=1e-8)
    starts = [run.at(t) for t in run.times[[0, 200, 400]]]
    alone = [scene.simulate((0.0, 0.3), start=start, rtol=1e-6) for start in starts]
    monkeypatch.setattr(lanes_module, "TURN", 3)
    check_same(simulate_many(scene, (0.0, 0.3), starts, threads=1, rtol=1e-6), alone)


def test_runs_of_one_scene_are_one_call(monkeypatch: pytest.MonkeyPatch) -> None:
    """All starts but the first are run in one call of compiled code, and none of them alone."""
    from kanefe.batches import many_runs

    alone: list[object] = []
    run = many_runs.run
    monkeypatch.setattr(many_runs, "run", lambda model, options: alone.append(model) or run(model, options))
    calls: list[int] = []
    call = lanes_module._Turns._call
    monkeypatch.setattr(
        lanes_module._Turns, "_call", lambda self, lanes, left: calls.append(len(left)) or call(self, lanes, left)
    )
    scene = double_pendulum()
    simulate_many(scene, (0.0, 0.2), starts_of(scene, 7), threads=1)
    assert len(alone) == 1
    assert calls == [6]


def test_a_run_that_fails_is_named_and_others_go_on() -> None:
    scene = double_pendulum()
    starts = starts_of(scene, 5)
    starts[0, 2:] = 1e160  # centrifugal forces are beyond all numbers
    starts[3, 2:] = 1e90  # no step is small enough for it
    with pytest.warns(kf.SimulationWarning) as told:
        found = simulate_many(scene, (0.0, 0.2), starts, threads=1, rtol=1e-6)
    last = str(told[-1].message)
    assert last.startswith("2 of 5 runs failed: run 0: the run failed at t = 0 s: the equations of motion have no")
    assert "; run 3: the run failed at t = " in last
    assert [result.status.kind == "failed" for result in found] == [True, False, False, True, False]
    assert np.array_equal(states(found[0])[0, :4], starts[0])
    assert "could not begin" in str(found[0])
    check_same(found[4:], [scene.simulate((0.0, 0.2), start=starts[4], rtol=1e-6)])


def test_scenes_that_are_alike() -> None:
    """A scene for each run, with other masses; and functions of the user in Python."""

    def pendulum(mass: float, is_pushed: bool = False) -> kf.System:
        scene = kf.System(gravity=(0.0, -9.81, 0.0))
        rod = scene.add_rigid_body("rod", mass, 0.1, com=(0.5, 0, 0), joint=kf.Revolute("z"))
        if is_pushed:
            scene.add_force(rod, lambda t: (0.0, np.sin(t), 0.0))
        return scene

    for is_pushed in (False, True):
        alone = [pendulum(mass, is_pushed).simulate((0.0, 0.3)) for mass in (1.0, 2.0, 3.0)]
        check_same(simulate_many([pendulum(mass, is_pushed) for mass in (1.0, 2.0, 3.0)], (0.0, 0.3)), alone)


def test_no_warning_is_made_of_quiet_runs() -> None:
    scene = double_pendulum()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        simulate_many(scene, (0.0, 0.2), starts_of(scene, 3))


BAD: dict[str, tuple[dict[str, object], str]] = {
    "no starts": ({}, "needs starts="),
    "no start": ({"starts": []}, "has no run"),
    "wrong shape": ({"starts": [[0.0] * 4, [0.0] * 3]}, "run 1: start of the run has shape"),
    "not finite": ({"starts": [[0.0] * 4, [0.0] * 4, [0.0, np.nan, 0.0, 0.0]]}, "run 2: start of the run is not f"),
    "one state": ({"starts": [0.0, 0.0, 0.0, 0.0]}, "run 0: start of the run must be a state"),
    "a generator": ({"starts": (x for x in [[0.0] * 4])}, "starts= of simulate_many must be"),
    "a checkpoint": ({"starts": [[0.0] * 4], "checkpoint": "x"}, "take no checkpoint="),
    "no threads": ({"starts": [[0.0] * 4], "threads": 0}, "threads must be one or more"),
    "a method": ({"starts": [[0.0] * 4], "method": "euler"}, "there is no method"),
    "a keyword": ({"starts": [[0.0] * 4], "start": [0.0] * 4}, "takes no start="),
}


@pytest.mark.parametrize("kind", BAD)
def test_bad_input_is_refused(kind: str) -> None:
    given, text = BAD[kind]
    with pytest.raises(kf.ModelError, match=text):
        simulate_many(double_pendulum(), (0.0, 0.1), **given)


def test_scenes_that_differ_are_refused() -> None:
    with pytest.raises(kf.ModelError, match="the scene of run 1 has 13 coordinates and speeds, that of run 0 has 4"):
        simulate_many([double_pendulum(), tumbling()], (0.0, 0.1))
    with pytest.raises(kf.ModelError, match=r"the scene of run 1 has 'upper: angle .*' where that of run 0 has"):
        simulate_many([double_pendulum(), damped_arm()], (0.0, 0.1))
    with pytest.raises(kf.ModelError, match="starts= has 1 states, and there are 2 scenes"):
        simulate_many([double_pendulum(), double_pendulum()], (0.0, 0.1), [[0.0] * 4])
    with pytest.raises(kf.ModelError, match="scenes= of simulate_many must be"):
        simulate_many([1.0], (0.0, 0.1))  # type: ignore[list-item]
