"""Generalised-alpha and HHT with fixed steps: order from the first step on, damping of what a step does not resolve."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import kanefe as kf
from kanefe.equations.model import Model
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.methods.generalised_alpha import SPECTRAL_RADIUS
from kanefe.integrate.methods.kernel_stepper import KernelStepper
from kanefe.integrate.methods.table import METHODS
from kanefe.integrate.run import integrate
from kanefe.integrate.stepper import StepControl
from kanefe.integrate.trajectory import Trajectory
from kanefe.kane.assemble import accelerations
from kanefe.states.state import State
from loop_scenes import four_bar
from run_scenes import check_snapshot, thrown_pendulum

NAMES = ["generalised-alpha", "hht"]


def stepper(model: Model, name: str, span: float, step: float | None) -> KernelStepper:
    made = METHODS[name].make(Dynamics(model), 0.0, span, StepControl(1e-6, 1e-9, step))
    assert isinstance(made, KernelStepper)
    return made


def errors(model: Model, name: str, span: float, step: float) -> np.ndarray:
    """Return the largest errors of q, u and du over the steps of a run."""
    steps = round(span / step)
    exact = integrate(model, (0.0, span), rtol=1e-12, method="dop853", output_step=step)
    run, found = stepper(model, name, span, step), np.zeros(3)
    for i in range(1, steps + 1):
        run.integrate_through(np.array([span]), np.empty((1, len(run.state()))), 1)
        q, u = exact.coordinates[i], exact.speeds[i]
        du = accelerations(State(model, run.t, q, u))
        y = run.state()
        parts = y[: len(q)] - q, y[len(q) : len(q) + len(u)] - u, run.step.at_start[len(q) : len(q) + len(u)] - du
        found = np.maximum(found, [abs(part).max() for part in parts])
    return found


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("make", [thrown_pendulum, lambda: four_bar().freeze()], ids=["tree", "loop"])
def test_coordinates_speeds_and_accelerations_are_of_order_two_from_the_first_step_on(
    name: str, make: Callable[[], Model]
) -> None:
    model = make()
    coarse, fine = errors(model, name, 0.2, 0.01), errors(model, name, 0.2, 0.005)
    assert np.all((coarse / fine > 3.5) & (coarse / fine < 6.0))


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("make", [thrown_pendulum, lambda: four_bar().freeze()], ids=["tree", "loop"])
def test_the_first_step_is_as_good_as_the_others(name: str, make: Callable[[], Model]) -> None:
    model = make()
    coarse, fine = errors(model, name, 0.002, 0.002)[1], errors(model, name, 0.001, 0.001)[1]
    # the error of the speeds is of third order; where it begins with the true acceleration, of second: 4
    assert coarse / fine == pytest.approx(8.0, rel=0.1)


@pytest.mark.parametrize("name", NAMES)
def test_what_a_step_does_not_resolve_is_damped(name: str) -> None:
    """A mass on a spring of 1600 Hz with steps of 10 ms: each keeps the share that the spectral radius says."""
    scene = kf.System()
    hinge = kf.Prismatic("x", position=1e-3, forces=kf.CoordinateForce(stiffness=1e8))
    scene.add_rigid_body("mass", 1.0, 0.1, joint=hinge)
    run = stepper(scene.freeze(), name, 1.0, 0.01)
    run.integrate_through(np.array([1.0]), np.empty((1, len(run.state()))), 40)
    assert abs(run.state()[0]) < 1e-3 * 40 * SPECTRAL_RADIUS**40 * 10  # a double root: n r^n


@pytest.mark.parametrize("name", NAMES)
def test_fixed_steps_are_taken_whatever_is_stored(name: str) -> None:
    runs = [pendulum_run(name, output_step=output_step) for output_step in (0.1, 0.013)]
    assert [run.statistics["steps"] for run in runs] == [20, 20]
    np.testing.assert_array_equal(runs[0].coordinates[-1], runs[1].coordinates[-1])
    exact = integrate(thrown_pendulum(), (0.0, 0.2), rtol=1e-12, method="dop853", output_step=0.013)
    off = abs(runs[1].coordinates - exact.coordinates).max(axis=1)
    assert off.max() < 1.5 * off[-1]  # between the steps as good as at their ends


def pendulum_run(name: str, output_step: float) -> Trajectory:
    return integrate(thrown_pendulum(), (0.0, 0.2), method=name, step=0.01, output_step=output_step)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("step", [None, 0.01])
def test_a_run_goes_on_from_a_snapshot_to_the_bit(name: str, step: float | None) -> None:
    check_snapshot(lambda: stepper(thrown_pendulum(), name, 0.5, step), 0.5, 7)


@pytest.mark.parametrize("name", NAMES)
def test_a_step_far_too_large_is_a_failure_with_advice(name: str) -> None:
    scene = kf.System()
    scene.add_rigid_body("top", 1.0, (1.0, 2.0, 3.0), joint=kf.Free(angular_velocity=(30.0, 20.0, 10.0)))
    with pytest.warns(kf.SimulationWarning, match="with steps of 1 s.*a smaller step"):
        result = scene.simulate((0.0, 10.0), method=name, step=1.0)
    assert result.status.kind == "failed"
