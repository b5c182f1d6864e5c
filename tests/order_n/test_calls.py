"""Calls of kernels whose arrays stay where they are: nothing of one call is seen in another."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import kanefe as kf
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.methods.table import METHODS
from kanefe.integrate.stepper import StepControl, Stepper
from kanefe.order_n.compiled_run import CompiledRun
from run_scenes import double_pendulum, thrown_pendulum


def pendulum(motor: Any, axis: str = "z") -> kf.System:
    scene = kf.System(gravity=(0.0, -9.81, 0.0))
    arm = scene.add_rigid_body("arm", 1.0, 0.1, com=(0.5, 0, 0), joint=kf.Revolute("z"))
    rod = scene.add_rigid_body("rod", 1.0, 0.1, com=(0.5, 0, 0), parent=arm, at=(1, 0, 0), joint=kf.Revolute(axis))
    scene.add_motor(rod, motor)
    return scene


@pytest.mark.parametrize("axis", ["z", "y"])
def test_a_load_may_ask_for_the_rates_of_its_own_model(axis: str) -> None:
    plain, y = pendulum(0.25, axis).freeze(), np.array([0.3, -0.2, 1.0, 0.5])
    times, seen = [], []

    def motor(t: float, state: Any) -> float:
        times.append(t)
        if times == [0.5, 0.0]:  # a second call, and not one within
            seen.append(model.rhs(0.1, -y))
            seen.append(state.position("rod"))
        return 0.25

    model = pendulum(motor, axis).freeze()
    model.rhs(0.5, 0.5 * y)
    np.testing.assert_array_equal(model.rhs(0.0, y), plain.rhs(0.0, y))
    np.testing.assert_array_equal(seen[0], plain.rhs(0.0, -y))
    np.testing.assert_array_equal(seen[1], plain.route.state(0.0, y).position("rod"))


def test_what_a_function_keeps_of_a_state_stays() -> None:
    kept: list[tuple[np.ndarray, ...]] = []

    def motor(t: float, state: Any) -> float:
        kept.append((state.q, state.u, state.frames[1].p_NoFo_N))
        return 0.0

    model = pendulum(motor).freeze()
    y = np.array([0.3, -0.2, 1.0, 0.5])
    first, second = model.rhs(0.0, y), model.rhs(0.0, 2.0 * y)
    assert not np.array_equal(first, second)
    np.testing.assert_array_equal(np.concatenate(kept[0][:2]), y)
    np.testing.assert_array_equal(kept[0][2], model.route.state(0.0, y).frames[1].p_NoFo_N)


@pytest.mark.parametrize("make", [lambda: double_pendulum().freeze(), thrown_pendulum])
def test_runs_that_share_a_route_do_not_meet(make: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    made = []
    begin = CompiledRun.__init__
    monkeypatch.setattr(CompiledRun, "__init__", lambda self, *given: (made.append(self), begin(self, *given))[1])

    def stepper(model: Any, start: float) -> Stepper:
        return METHODS["dop853"].make(Dynamics(model), start, start + 1.0, StepControl(1e-8, 1e-10, None))

    def states(run: Stepper, time: float) -> np.ndarray:
        found = np.empty((1, len(run.state())))
        assert run.integrate_through(np.array([time]), found, 10**6) == 1
        return found

    model = make()
    first, second = stepper(model, 0.0), stepper(model, 0.25)
    mixed = [states(run, run.t + 0.2) for _ in range(3) for run in (first, second)]
    assert len(made) == 2  # each was prepared once
    apart = []
    for start in (0.0, 0.25):
        run = stepper(make(), start)
        apart.append([states(run, run.t + 0.2) for _ in range(3)])
    np.testing.assert_array_equal(mixed[::2], apart[0])
    np.testing.assert_array_equal(mixed[1::2], apart[1])
