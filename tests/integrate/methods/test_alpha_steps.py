"""Generalised-alpha and HHT in compiled code: amplification, contacts with friction, loops, counts, what is told."""

from __future__ import annotations

import re
import warnings
from typing import Any

import numpy as np
import pytest

import kanefe as kf
from kanefe.equations.model import Model
from kanefe.integrate.methods.generalised_alpha import SPECTRAL_RADIUS
from kanefe.integrate.methods.generalised_alpha_formula import GeneralisedAlpha
from kanefe.integrate.run import integrate
from kanefe.integrate.step_times import StepTimes
from loaded_scenes import everything
from loop_scenes import four_bar

FORMULAS = {"generalised-alpha": GeneralisedAlpha(SPECTRAL_RADIUS), "hht": GeneralisedAlpha(SPECTRAL_RADIUS, True)}
G = 9.81


def oscillator(stiffness: float, is_along_joint: bool) -> Model:
    """Return a kilogram on a spring along its joint, or between frames, which no sweep knows as stiff; x = 1 m."""
    scene = kf.System()
    forces = kf.CoordinateForce(stiffness=stiffness) if is_along_joint else None
    mass = scene.add_rigid_body("mass", 1.0, 0.1, joint=kf.Prismatic("x", position=1.0, forces=forces))
    if not is_along_joint:
        scene.add_bushing("spring", scene.ground, mass, stiffness=(stiffness, 0, 0, 0, 0, 0))
    return scene.freeze()


def amplification(formula: GeneralisedAlpha, square: float) -> np.ndarray:
    """Return the matrix of a step of (q, h u, h^2 a) of ``du = -omega^2 q``, with the square of h omega."""
    a_m, a_f, gamma, beta = formula.alpha_m, formula.alpha_f, formula.gamma, formula.beta
    after = np.array([[1, 0, -beta], [0, 1, -gamma], [(1 - a_f) * square, 0, 1 - a_m]])
    before = np.array([[1, 1, 0.5 - beta], [0, 1, 1 - gamma], [-a_f * square, 0, -a_m]])
    return np.linalg.solve(after, before)


@pytest.mark.parametrize("name", FORMULAS)
@pytest.mark.parametrize("is_along_joint", [True, False], ids=["sweeps", "Jacobian"])
@pytest.mark.parametrize("omega_h", [0.1, 1.0, 10.0, 1000.0])
def test_a_vibration_keeps_what_the_amplification_matrix_says(name: str, is_along_joint: bool, omega_h: float) -> None:
    h, steps, square = 0.01, 30, omega_h**2
    model = oscillator(square / h**2, is_along_joint)
    found = integrate(model, (0.0, steps * h), method=name, step=h, output_step=h).coordinates[:, 0]
    # a begins earlier than the true acceleration, by what the step resolves of the jerk: that of a ten thousandth of it
    formula = FORMULAS[name]
    resolved = 0.5e-4 * square**2 / (1.0 + formula.beta * formula.ratio * square)
    y = np.array([1.0, 0.0, -square + (formula.alpha_m - formula.alpha_f) * resolved])
    for i in range(1, steps + 1):
        y = amplification(formula, square) @ y
        assert found[i] == pytest.approx(y[0], abs=1e-8)  # round-off of places, times the stiffness
    # of an unresolved mode a step keeps the share that the spectral radius says
    radius = max(abs(np.linalg.eigvals(amplification(formula, 1e12))))
    assert radius == pytest.approx(SPECTRAL_RADIUS, abs=1e-3)  # a double root, found to the root of round-off


@pytest.mark.parametrize("name", FORMULAS)
def test_small_steps_lead_where_radau_does(name: str) -> None:
    """Springs, bushings, dampers, modes, driven joints and controls: order 2 towards the other method."""
    exact = integrate(everything(0), (0.0, 0.1), method="radau5", rtol=1e-10, output_step=0.1)
    errors = []
    for h in (1e-3, 5e-4):
        run = integrate(everything(0), (0.0, 0.1), method=name, step=h, output_step=0.1)
        errors.append(abs(run.coordinates[-1] - exact.coordinates[-1]).max())
    assert errors[1] < 1e-4
    assert 3.0 < errors[0] / errors[1] < 5.0


def pushed(**options: Any) -> kf.Result:
    """Return a block of a kilogram on a plane with mu = 0.3 that is pushed by 2 N/s t."""
    scene = kf.System(gravity=(0.0, 0.0, -G))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    block = scene.add_rigid_body("block", 1.0, 0.01, joint=kf.Translation(position=(0.0, 0.0, -G * 1e-5)))
    scene.add_contact("feet", [block], floor, normal=kf.KelvinVoigt(1e5, damping=60.0), friction=kf.Coulomb(0.3))
    scene.add_force(block, lambda t: (2.0 * t, 0.0, 0.0))
    return scene.simulate((0.0, 2.0), **options)


SLIPS = 0.3 * G / 2.0


@pytest.mark.parametrize("name", FORMULAS)
def test_a_block_sticks_and_then_slides(name: str) -> None:
    step = 1e-3
    result = pushed(method=name, step=step)
    t, x = result.times, result.position("block")[:, 0]
    assert result.events["feet slip"] == pytest.approx([SLIPS], abs=step)
    # the anchor's spring yields in proportion to the push; then this is above friction by 2 N/s (t - t_0)
    i = int(np.searchsorted(t, SLIPS)) - 1
    rate, after = x[i] / t[i], np.maximum(t - SLIPS, 0.0)
    assert 0.0 < rate * SLIPS < 1e-4
    expected = rate * t + after**3 / 3.0
    assert x == pytest.approx(expected, abs=1e-6)  # vibrations on the anchor are of that size
    # no step is cut, and the matrix is made where friction begins to slip
    assert result.statistics["steps"] == 2000
    assert result.statistics["factorisations"] < 10
    assert result.statistics["evaluations"] < 3 * 2000
    assert abs(result.energy.balance_error).max() < 1e-5


@pytest.mark.parametrize("name", FORMULAS)
def test_loops_stay_closed(name: str) -> None:
    run = integrate(four_bar().freeze(), (0.0, 2.0), method=name, step=1e-3, output_step=0.1)
    model = four_bar().freeze()
    assert run.statistics["factorisations"] == 0  # sweeps alone
    for t, q, u in zip(run.times, run.coordinates, run.speeds, strict=True):
        closed = model.route.projected(t, np.concatenate((q, u, np.zeros(2))))
        assert abs(closed[: len(q)] - q).max() < 1e-12  # that of closing loops, not of the step
    # a fourth of the error at half the step: no drift that grows with their number
    exact = integrate(model, (0.0, 2.0), method="dop853", rtol=1e-11, output_step=2.0).coordinates[-1]
    fine = integrate(model, (0.0, 2.0), method=name, step=5e-4, output_step=2.0).coordinates[-1]
    assert abs(run.coordinates[-1] - exact).max() > 3.5 * abs(fine - exact).max()


@pytest.mark.parametrize("name", FORMULAS)
def test_a_wheel_on_a_journal_bearing_stops_when_the_textbook_says(name: str) -> None:
    """Internal states that follow the load of the joint are solved for with the accelerations."""
    scene = kf.System(gravity=(0, 0, -G))
    friction = kf.JointFriction(0.1, 0.01)
    scene.add_rigid_body("wheel", 2.0, 0.02, joint=kf.Revolute("y", speed=10.0, friction=friction))
    result = scene.simulate((0.0, 11.0), method=name, step=2e-3)
    stops = 10.0 * 0.02 / (0.1 * 2.0 * G * 0.01)
    assert result.events["wheel stick"][-1] == pytest.approx(stops, abs=2e-3)  # within a step
    assert result.energy.dissipated[-1] == pytest.approx(0.5 * 0.02 * 100.0, rel=1e-4)


class Filter(kf.Load):
    """A state that follows the speed of its end in the time TAU, s."""

    def __init__(self, end: kf.Frame) -> None:
        self.name, self.ends = "filter", (end,)

    @property
    def initial_states(self) -> np.ndarray:
        return np.zeros(1)

    def action(self, t: float, ends: Any, states: np.ndarray) -> kf.Action:
        return kf.Action(np.zeros((1, 6)), rates=(ends[0].v[:1] - states) / TAU)


TAU = 0.05


@pytest.mark.parametrize("name", FORMULAS)
def test_internal_states_are_of_order_two(name: str) -> None:
    errors = []
    for step in (0.01, 0.005):
        scene = kf.System()
        scene.add(Filter(scene.add_point("point", 1.0, joint=kf.Prismatic("x", speed=1.0))))
        run = integrate(scene.freeze(), (0.0, 0.1), method=name, step=step, output_step=0.1)
        errors.append(abs(run.internal[-1, 0] - (1.0 - np.exp(-0.1 / TAU))))
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.3)  # 2 of Euler's method
    assert errors[1] < 2e-3


@pytest.mark.parametrize("count", [5, 80])
def test_a_step_of_a_chain_costs_as_many_sweeps_whatever_its_length(count: int) -> None:
    scene, parent = kf.System(gravity=(0, 0, -G)), None
    for i in range(count):
        where = {"parent": parent, "at": (0, 0, -0.1)} if parent is not None else {}
        joint = kf.Revolute("xy"[i % 2], position=0.1)
        parent = scene.add_rigid_body(f"b{i}", 0.1, (1e-4, 2e-4, 1e-4), com=(0, 0, -0.05), joint=joint, **where)
    counts = scene.simulate((0.0, 0.1), method="generalised-alpha", step=1e-3).statistics
    assert counts["evaluations"] <= 2.5 * counts["steps"]
    assert counts["factorisations"] == counts["jacobians"] == 0


def tops(*rates: float) -> kf.System:
    """Return free tops, whose gyroscopic terms a sweep leaves to the iteration."""
    scene = kf.System()
    for i, rate in enumerate(rates):
        spin = kf.Free(angular_velocity=(0.3 * rate, 0.2 * rate, rate))
        scene.add_rigid_body(f"top {i}", 1.0, (1.0, 2.0, 2.9), joint=spin)
    return scene


def test_steps_left_before_convergence_are_told_and_the_run_goes_on() -> None:
    scene = tops(40.0, 36.0, 32.0, 28.0)  # more slow directions than are mixed
    with pytest.warns(kf.SimulationWarning, match=r"left before it had converged in \d+ of 20 steps of 0.05 s"):
        result = scene.simulate((0.0, 1.0), method="generalised-alpha", step=0.05)
    assert result.status.is_finished
    count, first, last, largest = result.statistics["unconverged"]
    assert 0 < count <= 20
    assert 0.0 < first <= last <= 1.0
    assert 0.0 < largest < 1e-3
    assert f"{count:.0f} steps, from t = {first:.6g} s" in str(result)
    assert result.statistics["evaluations"] <= 21 * 20 + 3  # of a step no more than so many


def test_a_step_too_long_for_a_contact_is_named_with_time_and_remedy() -> None:
    scene = kf.System(gravity=(0, 0, -G))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    ball = scene.add_rigid_body("ball", 1.0, 0.01, joint=kf.Translation(position=(0, 0, 0.3)))
    scene.add_contact("pad", [ball], floor, normal=kf.KelvinVoigt(1e6, damping=60.0))
    period = 2.0 * np.pi * 1e-3
    with pytest.warns(kf.SimulationWarning, match=rf"contact 'pad' .* period of {period:.2g} s.*Remedy.*0.0006 s"):
        result = scene.simulate((0.0, 1.0), method="generalised-alpha", step=0.01)
    assert re.search(r"at t = 0.2\d* s", str(result.status))
    assert result.times[-1] == result.status.time  # what there is up to there is kept
    fine = scene.simulate((0.0, 1.0), method="generalised-alpha", step=period / 20.0)
    assert fine.status.is_finished


@pytest.mark.parametrize(("share", "is_told"), [(0.3, True), (0.2, False)])
def test_steps_of_which_a_bounce_has_less_than_two_are_told(share: float, is_told: bool) -> None:
    scene = kf.System(gravity=(0, 0, -G))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    ball = scene.add_rigid_body("ball", 1.0, 0.01, joint=kf.Translation(position=(0, 0, 0.3)))
    scene.add_contact("pad", [ball], floor, normal=kf.KelvinVoigt(1e4, damping=0.0))
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        scene.simulate((0.0, 0.5), method="generalised-alpha", step=share * 2.0 * np.pi * 1e-2)
    texts = [str(one.message) for one in told]
    assert any(re.search(r"touches at t = 0\.2\d+ s: on contact 'pad'.*Remedy", text) for text in texts) == is_told


def test_fixed_steps_tell_their_wall_time() -> None:
    run = integrate(four_bar().freeze(), (0.0, 0.1), method="generalised-alpha", step=1e-3)
    most, longest = run.statistics["step_seconds"]
    assert 0.0 < most <= longest < run.statistics["seconds"]
    assert "step_seconds" not in integrate(four_bar().freeze(), (0.0, 0.1), method="dop853").statistics


def test_the_quantile_is_that_of_the_lengths() -> None:
    times, lengths = StepTimes(), np.random.default_rng(0).lognormal(np.log(1e-5), 1.0, 20_000)
    assert times.told == []
    for length in lengths:
        times.add(length)
    most, longest = times.told
    # classes of 1.044, and nanoseconds
    assert 1.0 <= most / np.quantile(lengths, 0.999) < 1.05
    assert longest == pytest.approx(lengths.max(), abs=1e-9)


def test_a_simulation_takes_the_steps_of_a_run() -> None:
    run = integrate(tops(2.0).freeze(), (0.0, 0.5), method="generalised-alpha", step=5e-3)
    sim = tops(2.0).start(method="generalised-alpha", step=5e-3, every=5e-3)
    for _ in range(100):
        sim.step(5e-3)
    q = run.coordinates[-1]
    assert sim.stepper.state()[: len(q)] == pytest.approx(q, abs=1e-12)  # steps rounded in another way
    assert sim.statistics["steps"] == 100
    most, longest = sim.statistics["step_seconds"]
    assert 0.0 < most <= longest
