"""What method="auto" takes of the methods for stiff scenes: where vibrations are followed, and where stepped over."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

import kanefe as kf
from kanefe.integrate.auto.choice import choose, method_names
from kanefe.integrate.auto.cost import ERROR_OF_RADAU, LEAST_OF_RADAU, SEEN_BY_RADAU, steps_of_radau
from kanefe.integrate.auto.explicit_rates import rate_of_functions
from kanefe.integrate.auto.suited_method import candidates
from kanefe.integrate.auto.vibrations import CALM, LEAST_DAMPING, MOST_RADIANS, Vibrations, least_damping
from kanefe.integrate.breakpoints import SAMPLES
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.methods.radau5 import of_order_three
from kanefe.integrate.options import RunOptions
from kanefe.integrate.run import integrate
from kanefe.kernels.steppers.extrapolation_dense import LARGEST_COLUMNS
from kanefe.tree.scene_state import SceneState
from kanefe_fem.beams.body import beam_body, straight_beam
from kanefe_fem.beams.sections import Rectangle
from kanefe_fem.materials.isotropic import Material
from steel_beams import steel_bar

SLOWEST = 92.8
"""Frequency in Hz of the bar clamped at its root: 1.875^2 / (2 pi L^2) sqrt(E I / (rho A)), of 0.3 m by 1 cm."""


def bar(gravity: float, damping: float = 0.01) -> kf.Model:
    """Return a bar on a hinge, straight at the start: gravity is what bends it."""
    options = {"reduction": kf.CraigBampton(modes=10), "damping": kf.ModalDamping(damping) if damping else None}
    return steel_bar(0.02, 0.01, gravity=gravity, **options).freeze()


@pytest.mark.parametrize(
    ("gravity", "periods", "rtol", "name", "reason"),
    [
        (9.81, 100.0, 1e-4, "extrapolation", "stiff over"),
        # g / w^2 of some 3e-5 m, a ten-thousandth of the length
        (9.81, 100.0, 1e-6, "radau5", "and vibrate by more than rtol=1e-06 at the start"),
        (0.0981, 100.0, 1e-6, "radau5", "and forces are more exact by its steps"),
        (0.0, 100.0, 2e-7, "radau5", "and forces are more exact by its steps"),
        (0.0, 100.0, 5e-8, "radau5", "and rtol=5e-08 resolves their vibrations"),
        (0.0, 20.0, 1e-6, "radau5", "and the slowest, of 92.8 Hz, is followed"),
        (0.0, 20.0, 1e-4, "extrapolation", "stiff over"),
    ],
)
def test_vibrations_that_the_tolerance_asks_for_are_followed(
    gravity: float, periods: float, rtol: float, name: str, reason: str
) -> None:
    model, options = bar(gravity), RunOptions(t_span=(0.0, periods / SLOWEST), rtol=rtol)
    choice = choose(model, options)
    assert choice.name == name
    assert name in method_names(model, options)  # of which the machine code is made before anything is evaluated
    assert reason in choice.reason


@pytest.mark.parametrize("rtol", [1e-3, 1e-6])
def test_at_tight_tolerances_forces_decide_where_they_cost_no_more(
    monkeypatch: pytest.MonkeyPatch, rtol: float
) -> None:
    model, options = bar(0.0), RunOptions(t_span=(0.0, 100.0 / SLOWEST), rtol=rtol)
    name = "radau5" if rtol < 1e-4 else "extrapolation"
    choice = choose(model, options)
    assert choice.name == name
    assert ("forces" in (choice.left_out or {}).get("extrapolation", "")) == (name == "radau5")
    monkeypatch.setattr("kanefe.integrate.auto.suited_method.EVALUATIONS_INSTEAD", 0.0)  # as with many speeds
    assert choose(model, options).name == "extrapolation"


SPAN = 100.0 / SLOWEST
MIDDLE = 0.5 * SPAN


@pytest.mark.parametrize(
    ("torque", "reason"),
    [
        (lambda t: 5.0 if t > MIDDLE else 0.0, "once a function of the time changes"),
        (lambda t: 5.0 * (1.0 + math.tanh((t - MIDDLE) * 20.0 / SPAN)), "forces are more exact"),  # in ten periods
        (lambda t: 0.01 if t > MIDDLE else 0.0, "forces are more exact"),
        (lambda t: 5.0 if t < 2.0 * SPAN else 0.0, "at the start"),
    ],
)
def test_vibrations_that_a_jump_begins_are_followed(torque: Callable[[float], float], reason: str) -> None:
    scene = steel_bar(0.02, 0.01, gravity=0.0, reduction=kf.CraigBampton(modes=10), damping=kf.ModalDamping(0.01))
    scene.add_torque(scene.body("bar"), lambda t: (0.0, torque(t), 0.0))
    choice = choose(scene.freeze(), RunOptions(t_span=(0.0, SPAN), rtol=1e-6))
    assert choice.name == "radau5"
    assert reason in choice.reason
    if told := choice.reason.partition("once a function of the time changes, at ")[2]:
        assert abs(float(told.split()[0]) - MIDDLE) < 1.1 * SPAN / SAMPLES


def test_functions_are_looked_at_once_for_the_choice_and_the_run() -> None:
    asked: list[float] = []

    def torque(t: float) -> tuple[float, float, float]:
        asked.append(t)
        return 0.0, 5.0 if t > MIDDLE else 0.0, 0.0

    scene = steel_bar(0.02, 0.01, gravity=0.0, reduction=kf.CraigBampton(modes=10), damping=kf.ModalDamping(0.01))
    scene.add_torque(scene.body("bar"), torque)
    counts = scene.simulate((0.0, SPAN), rtol=1e-6).statistics
    # of the choice, of the rates at outputs, and of a bisection to the last digit
    assert len(asked) < SAMPLES + counts["evaluations"] + 110


@pytest.mark.parametrize(
    ("ratio", "begins", "haste"), [(0.0, 1, 1.0), (1e-4, 1, 1.0), (0.01, 1, 50.0), (0.01, 4, 1.0), (0.01, 400, 1.0)]
)
def test_steps_of_radau_are_those_of_a_vibration_that_fades(ratio: float, begins: int, haste: float) -> None:
    frequency, size, rtol, atol = 500.0, 1e-3, 1e-8, 1e-9
    ones = np.ones(1)
    found = Vibrations(frequency * ones, ratio * ones, size * ones, np.eye(1), ones, haste * ones, begins * ones)
    error = haste * size / (of_order_three(rtol) * (haste * size + atol / rtol))
    times = np.linspace(0.0, 10.0 / begins, 100_001)
    left = error * np.exp(-ratio * frequency * times)
    pace = np.where(left > SEEN_BY_RADAU, frequency * (ERROR_OF_RADAU * left) ** 0.25, 0.0)
    steps = begins * float(np.sum(pace[1:] + pace[:-1]) * times[1] / 2.0)
    # of the trapezoidal rule, mostly where the vibration ends
    assert steps_of_radau(10.0, rtol, atol, found) == pytest.approx(max(steps, LEAST_OF_RADAU), rel=1e-3)


def _swung_bar() -> kf.System:
    return steel_bar(0.02, 0.01, reduction=kf.CraigBampton(modes=10))


def _two_links() -> kf.System:
    """Return an arm of two undamped beams, whose motor stops at 0.1 s."""
    aluminium = Material(E=70e9, nu=0.33, rho=2700.0)
    model = straight_beam(1.0, Rectangle(0.01, 0.04), aluminium, elements=6)
    link = beam_body(model, {"root": "clamped", "tip": "rigid"}, reduction=kf.CraigBampton(modes=4))
    scene = kf.System()
    hub = scene.add_rigid_body("hub", 1.0, 0.01, joint=kf.Revolute("z"))
    upper = scene.add_flexible_body("upper", link, parent=hub)
    elbow = scene.add_rigid_body("elbow", 0.5, 1e-3, parent=upper.interface("tip"), joint=kf.Revolute("z"))
    scene.add_flexible_body("lower", link, parent=elbow)
    scene.add_torque(hub, lambda t: 5.0 if t < 0.1 else 0.0)
    return scene


@pytest.mark.parametrize(
    ("make", "rtol", "name"),
    [(_swung_bar, 1e-5, "radau5"), (_two_links, 1e-5, "radau5"), (_two_links, 1e-9, "dop853")],
)
def test_what_follows_vibrations_is_that_with_less_evaluations(
    make: Callable[[], kf.System], rtol: float, name: str
) -> None:
    asked = {
        method: make().simulate((0.0, 0.4), method=method, rtol=rtol).statistics
        for method in ("auto", "radau5", "dop853")
    }
    assert asked["auto"]["method"].startswith(name)
    # samples of the choice, and trials
    assert asked["auto"]["evaluations"] < 1.25 * min(asked[method]["evaluations"] for method in ("radau5", "dop853"))


@pytest.mark.parametrize("damping", [0.0, 0.01])
def test_vibrations_for_ever_are_told_with_the_remedy(damping: float) -> None:
    choice = choose(bar(9.81, damping), RunOptions(t_span=(0.0, 100.0 / SLOWEST), rtol=1e-6))
    assert ("no damping of 'bar': with kf.ModalDamping" in choice.reason) == (damping == 0.0)


# Stability functions of T_jj of the extrapolated implicit Euler method, from (1 - z / n)^-n by Aitken and Neville
# (Hairer & Wanner 1996, IV.9)
def stability(z: np.ndarray) -> list[np.ndarray]:
    rows: list[list[np.ndarray]] = []
    for n in range(1, LARGEST_COLUMNS + 1):
        row = [(1.0 - z / n) ** -n]
        for k in range(1, n):
            row.append(row[-1] + (row[-1] - rows[-1][k - 1]) / (n / (n - k) - 1.0))
        rows.append(row)
    return [row[-1] for row in rows]


def test_the_extrapolation_is_stable_where_it_is_taken() -> None:
    radians = np.logspace(-1, 3, 4000)

    def growth(damping: float, of: np.ndarray) -> float:
        return max(float(abs(R).max()) for R in stability(of * (-damping + 1j * np.sqrt(1.0 - damping**2))))

    assert growth(LEAST_DAMPING, radians) < 1.0
    assert growth(0.0, radians) > 1.01  # the reason for all this
    for columns, R in enumerate(stability(1j * radians), start=1):
        # a quarter below what is asked for
        assert abs(R[radians > 0.8 * CALM * columns / LARGEST_COLUMNS]).max() < 1.0
    followed = np.logspace(-2, np.log10(MOST_RADIANS), 1000)
    allowed = least_damping(followed)
    damped = followed * (-allowed + 1j * np.sqrt(1.0 - allowed**2))
    assert max(float(abs(R).max()) for R in stability(damped)) < 1.0
    grown = followed[-100:] * (-0.5 * allowed[-100:] + 1j)
    assert max(float(abs(R).max()) for R in stability(grown)) > 1.0  # half of it would not do


@pytest.mark.parametrize(("rtol", "name"), [(1e-3, "extrapolation"), (1e-6, "dop853")])
def test_what_samples_follow_needs_less_damping(rtol: float, name: str) -> None:
    """A bar damped by 0.2 %, moved at 4 kHz, 0.15 and 0.3 radians of its slowest; the faster are damped by 5 %."""
    damping = kf.ModalDamping([0.002, 0.002, 0.05])
    scene = steel_bar(reduction=kf.CraigBampton(modes=10), damping=damping)
    scene.add_controller(
        "hold",
        lambda t, reads, memory: 1.0 - 20.0 * reads[0] - 0.5 * reads[1],
        every=2.5e-4,
        reads=("joint_coordinates bar", "joint_speeds bar"),
        drives="motor bar",
    )
    result = scene.simulate((0.0, 0.5), rtol=rtol, output_step=1e-3)
    assert result.statistics["method"] == name
    fine = scene.simulate((0.0, 0.5), rtol=1e-9, output_step=1e-3, method="dop853")
    # five hundred runs from sample to sample, each with errors of rtol of the bar's way
    assert abs(result.joint_coordinates("bar") - fine.joint_coordinates("bar")).max() < 500 * rtol * 0.1


@pytest.mark.parametrize(
    ("gravity", "periods", "rtol", "name", "then"),
    [
        (9.81, 100.0, 1e-3, "extrapolation", True),  # bent by a ten-thousandth of the length, unseen
        (9.81, 100.0, 1e-6, "radau5", False),
        (0.0, 10.0, 1e-3, "radau5", False),
    ],
)
def test_what_is_not_damped_is_stepped_over_or_followed(
    gravity: float, periods: float, rtol: float, name: str, then: bool
) -> None:
    found = candidates(bar(gravity, damping=0.0), 0.0, periods / SLOWEST, rtol, 0.1 * rtol).choose()
    assert found.name == name
    assert bool(found.then) == then
    # the slowest is sideways, where the bar is clamped and twice as thick
    assert not then or found.least * 2.0 * np.pi * 2.0 * SLOWEST == pytest.approx(CALM, rel=0.01)


@pytest.mark.parametrize("kind", ["modal_coordinates", "modal_speeds"])
def test_an_undamped_vibration_neither_grows_nor_is_lost(kind: str) -> None:
    body = steel_bar(0.02, 0.01, reduction=kf.CraigBampton(modes=4)).freeze().bodies[0].flexible.body
    first = 0.01 * np.eye(body.free_count)[0] * np.sqrt(body.mass)
    scene = kf.System()
    slowest = np.sqrt(body.stiffness[0, 0])
    scene.add_flexible_body(
        "bar", body, joint=kf.Fixed(), **{kind: first * (slowest if kind == "modal_speeds" else 1.0)}
    )
    periods, rtol = 300, 1e-3
    result = scene.simulate((0.0, periods * 2.0 * np.pi / slowest), rtol=rtol, output_step=1.0)
    energy = result.energy.total
    assert energy.max() <= energy[0] * (1.0 + 100.0 * rtol)
    # some parts of rtol are lost in a period; by the steps that step over vibrations all of it
    assert energy[-1] > energy[0] * (1.0 - rtol * periods)
    assert result.statistics["energy_balance"][1] == pytest.approx(1.0 - energy[-1] / energy[0], rel=1e-6)


def test_a_small_vibration_that_begins_in_the_run_is_kept_within_the_tolerance() -> None:
    body = steel_bar(0.02, 0.01, reduction=kf.CraigBampton(modes=4)).freeze().bodies[0].flexible.body
    slowest, k = np.sqrt(body.stiffness[0, 0]), body.free_count
    scene = kf.System()
    scene.add_flexible_body("bar", body, joint=kf.Fixed())
    moving = 1e-3 * np.sqrt(body.mass) * slowest * np.eye(2 * k)[k]
    periods, rtol = 300, 1e-4
    span = periods * 2.0 * np.pi / slowest
    strike = kf.Event("strike", lambda t, state: t - 0.1 * span, action=lambda t, state: state.vector + moving)
    result = scene.simulate((0.0, span), rtol=rtol, output_step=0.05 * span, events=strike)
    assert result.statistics["method"] == "extrapolation, then radau5"
    # what is lost of the millimetre, beside the tolerance for the bar of 0.3 m
    assert 1e-3 * (1.0 - np.sqrt(result.energy.total[-1] / (0.5 * moving @ moving))) < 10.0 * rtol * 0.3


def test_a_vibration_that_begins_in_the_run_is_followed_from_there_on() -> None:
    model = steel_bar(0.02, 0.01, gravity=0.0, reduction=kf.CraigBampton(modes=2)).freeze()
    span = 10.0

    def strike(t: float, state: SceneState) -> np.ndarray:
        struck = state.vector.copy()
        struck[model.coordinate_count + 1] += 1.0
        return struck

    event = kf.Event("strike", lambda t, state: t - 9.95, action=strike)
    run = integrate(model, (0.0, span), rtol=1e-3, events=event, output_step=1.0)
    assert run.statistics["method"].startswith("extrapolation, then ")
    q, u = run.coordinates[-1], run.speeds[-1]
    after = model.route.energy(span, np.concatenate((q, u))).total
    assert after == pytest.approx(run.work[-1], rel=0.05)  # some periods, of which each may lose rtol


def test_both_methods_go_on_from_a_snapshot_to_the_bit() -> None:
    model = steel_bar(0.02, 0.01, gravity=0.0, reduction=kf.CraigBampton(modes=2)).freeze()
    choice = choose(model, RunOptions(t_span=(0.0, 10.0), rtol=1e-3))
    first, second = choice.make(Dynamics(model)), choice.make(Dynamics(model))
    times = np.array([0.02, 0.03])
    struck = first.state()
    struck[model.coordinate_count + 1] += 1.0
    first.restart(0.01, struck)
    found, again = np.empty((2, 2, len(struck)))
    assert first.integrate_through(times[:1], found, 1000) == 1
    assert first.name.startswith("extrapolation, then ")
    second.resume(first.snapshot())
    assert second.name == first.name
    assert first.integrate_through(times[1:], found[1:], 1000) == second.integrate_through(times[1:], again[1:], 1000)
    np.testing.assert_array_equal(found[1], again[1])
    assert first.statistics == second.statistics


def test_damping_by_functions_is_measured() -> None:
    scene = kf.System()
    wheel = scene.add_rigid_body("wheel", 1.0, 0.1, joint=kf.Revolute("z"))
    scene.add_motor(wheel, lambda t, state: -500.0 * state.joint_speeds("wheel")[0])
    model = scene.freeze()
    dynamics = Dynamics(model)
    # 500 N m s over 0.1 kg m2
    assert rate_of_functions(dynamics, 0.0) == pytest.approx(5000.0, rel=1e-6)
    assert dynamics.evaluations < 20
    assert choose(model, RunOptions(t_span=(0.0, 1.0))).name == "radau5"


def test_bodies_bent_by_many_times_their_length_are_told() -> None:
    body = steel_bar(0.02, 0.01, reduction=kf.CraigBampton(modes=4)).freeze().bodies[0].flexible.body
    scene = kf.System()
    scene.add_flexible_body("bar", body, joint=kf.Fixed(), modal_speeds=1e4 * np.eye(body.free_count)[0])
    with pytest.warns(kf.SimulationWarning, match=r"bent beyond its valid range, 'bar' by [0-9.e+]+ rad at node \d+"):
        result = scene.simulate((0.0, 0.01), rtol=1e-6)
    assert result.statistics["bending"][1] > 0.2
