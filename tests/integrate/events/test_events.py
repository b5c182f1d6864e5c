"""Events: when they happen, in which direction, what they do, and that none is lost or found twice."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import kanefe as kf
from kanefe.integrate.methods.table import METHODS, own_methods
from kanefe.tree.scene_state import SceneState
from loop_scenes import four_bar
from run_scenes import bounced, falling_ball, floor, height_of_ball
from scenes import lattice_body

G = 9.81


def spinner(rate: float = 1.0) -> kf.System:
    """A wheel that turns at a constant rate: its angle is rate times t, whatever the method and the step."""
    scene = kf.System()
    scene.add_rigid_body("wheel", 1.0, 0.5, joint=kf.Revolute("z", speed=rate))
    return scene


def angle(state: SceneState) -> float:
    return float(state.joint_coordinates("wheel")[0])


def options_of(method: str) -> dict[str, Any]:
    return {"method": method} if METHODS[method].has_error_control else {"method": method, "step": 0.01}


WAYS = [
    *((name, {}) for name in own_methods() if METHODS[name].has_error_control),
    *((name, {"step": 0.01}) for name in own_methods() if METHODS[name].has_fixed_steps),
]


@pytest.mark.parametrize(("method", "options"), WAYS)
def test_a_bouncing_ball_bounces_when_it_should(method: str, options: dict[str, float]) -> None:
    result = falling_ball().simulate((0.0, 3.0), method=method, events=[floor(0.8)], **options)
    assert result.status.is_finished
    first = np.sqrt(2.0 / G)
    flights = 2.0 * first * 0.8 ** np.arange(1, 7)
    expected = first + np.concatenate(([0.0], np.cumsum(flights)))
    expected = expected[expected < 3.0]
    # a parabola: all methods and their dense output are exact but for round-off, which every bounce hands on
    np.testing.assert_allclose(result.events["floor"], expected, rtol=0, atol=1e-11)
    # each bounce takes 1 - 0.8^2 of the energy, which counts as dissipated
    taken = 0.1 * G * (1.0 - 0.64 ** len(expected))
    assert result.energy.dissipated[-1] == pytest.approx(taken, rel=1e-10)
    assert abs(result.energy.balance_error).max() < 1e-10
    assert result.position("ball")[:, 2].min() > -1e-12


@pytest.mark.parametrize("direction", [0, -1, 1])
@pytest.mark.parametrize("rtol", [1e-4, 1e-5, 1e-7, 1e-8, 1e-9])
def test_an_action_at_a_stop_that_only_counts(direction: int, rtol: float) -> None:
    """The place that is found lies before the root as often as behind it: that is no second event, and no storm."""
    scene = kf.System(gravity=(0, 0, -G))
    stop = kf.CoordinateForce(limits=(0.0, None), limit_stiffness=1e5, limit_damping=10.0)
    scene.add_point("ball", 1.0, joint=kf.Prismatic("z", position=1.0, forces=stop))
    seen: list[float] = []
    hit = kf.Event("hit", lambda t, state: state.position("ball")[2], direction, action=lambda t, state: seen.append(t))
    result = scene.simulate((0.0, 3.0), rtol=rtol, events=[hit])
    assert result.status.is_finished
    assert len(seen) == len(result.events["hit"]) == (4 if direction else 8)


@pytest.mark.parametrize(("direction", "expected"), [(0, [0.5, 1.5, 2.5, 3.5]), (1, [1.5, 3.5]), (-1, [0.5, 2.5])])
def test_only_the_wanted_direction_counts(direction: int, expected: list[float]) -> None:
    event = kf.Event("quarter", lambda t, state: np.cos(np.pi * angle(state)), direction=direction)
    found = spinner().simulate((0.0, 4.0), events=event).events["quarter"]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-11)  # 1e-13 of the span, and round-off of the cosine


def test_round_off_about_a_zero_is_no_way_back_through_it() -> None:
    """Where an event acts a step ends: the other way through its zero was told beside it, of ten times six."""

    def noisy(t: float, state: SceneState) -> float:
        return float(np.cos(np.pi * angle(state)) + 1e-10 * np.sin(1e15 * t))

    falls = kf.Event("falls", noisy, direction=-1, action=lambda t, state: None)
    events = [falls, kf.Event("rises", noisy, direction=1)]
    found = spinner().simulate((0.0, 20.0), method="rk4", step=0.01, events=events).events
    for name, first in (("falls", 0.5), ("rises", 1.5)):
        np.testing.assert_allclose(found[name], np.arange(first, 20.0, 2.0), rtol=0, atol=1e-9)


@pytest.mark.parametrize("width", [0.3, 3e-2, 1e-3])
def test_two_roots_within_one_step_are_both_found(width: float) -> None:
    """The wheel has nothing to resolve: steps grow tenfold up to the whole span."""
    event = kf.Event("dip", lambda t, state: (angle(state) - 40.0) ** 2 - width**2)
    result = spinner().simulate((0.0, 100.0), events=event, method="dop853")
    assert result.statistics["steps"] < 12
    np.testing.assert_allclose(result.events["dip"], [40.0 - width, 40.0 + width], rtol=0, atol=1e-9)


def test_what_touches_zero_without_passing_it_is_no_pair_of_roots() -> None:
    event = kf.Event("near", lambda t, state: (angle(state) - 40.0) ** 2 + 1e-3)
    assert len(spinner().simulate((0.0, 100.0), events=event).events["near"]) == 0


def test_a_function_that_is_zero_at_the_start_is_no_event_there() -> None:
    event = kf.Event("level", lambda t, state: float(np.sin(angle(state))))
    found = spinner().simulate((0.0, 7.0), events=event).events["level"]
    np.testing.assert_allclose(found, [np.pi, 2.0 * np.pi], rtol=0, atol=1e-11)


@pytest.mark.parametrize("method", own_methods())
def test_a_terminal_event_ends_the_run_where_it_happens(method: str) -> None:
    landing = kf.Event("floor", height_of_ball, terminal=True)
    result = falling_ball().simulate((0.0, 3.0), events=[landing], output_times=[0.1, 0.2, 2.0], **options_of(method))
    landing = np.sqrt(2.0 / G)
    assert result.status.kind == "stopped"
    assert str(result.status) == "the run was stopped at t = 0.451524 s: by the event 'floor'"
    assert result.times == pytest.approx([0.1, 0.2, landing], abs=1e-12)
    assert result.position("ball")[-1, 2] == pytest.approx(0.0, abs=1e-11)
    result.raise_for_status()  # as was wanted: no failure


def test_outputs_before_and_after_an_action_are_those_of_their_own_branch() -> None:
    def turned(t: float, state: SceneState) -> np.ndarray:
        y = state.vector
        y[1] = -2.0
        return y

    event = kf.Event("turn", lambda t, state: angle(state) - 1.0, direction=1, action=turned)
    result = spinner().simulate((0.0, 2.0), events=[event], output_step=0.125)
    t = result.times
    expected = np.where(t <= 1.0, t, 1.0 - 2.0 * (t - 1.0))
    np.testing.assert_allclose(result.joint_coordinates("wheel")[:, 0], expected, rtol=0, atol=1e-12)


def test_an_action_without_a_state_restarts_where_a_load_is_switched() -> None:
    """A torque that is switched off at an angle: constant acceleration, then constant rate, exact to round-off."""
    switch = {"torque": 1.0}

    def off(t: float, state: SceneState) -> None:
        switch["torque"] = 0.0

    scene = kf.System()
    wheel = scene.add_rigid_body("wheel", 1.0, 0.5, joint=kf.Revolute("z"))
    scene.add_torque(wheel, lambda t: (0.0, 0.0, switch["torque"]))
    event = kf.Event("off", lambda t, state: angle(state) - 1.0, action=off)
    result = scene.simulate((0.0, 2.0), events=[event], method="dop853")
    assert result.events["off"] == pytest.approx([1.0], abs=1e-11)  # theta = t^2 with 2 rad/s2
    assert result.joint_coordinates("wheel")[-1, 0] == pytest.approx(1.0 + 2.0 * 1.0, abs=1e-10)
    assert result.statistics["rejected"] == 0


def test_events_of_one_moment_are_all_told_and_all_act() -> None:
    calls = []

    def note(name: str) -> Any:
        return lambda t, state: calls.append((name, t))

    events = [
        kf.Event("a", lambda t, state: angle(state) - 1.0, action=note("a")),
        kf.Event("b", lambda t, state: t - 1.0, action=note("b")),
        kf.Event("c", lambda t, state: angle(state) - 1.5),
    ]
    result = spinner().simulate((0.0, 2.0), events=events)
    assert [name for name, _ in calls] == ["a", "b"]
    assert {name: times.round(9).tolist() for name, times in result.events.items()} == {
        "a": [1.0],
        "b": [1.0],
        "c": [1.5],
    }


def test_very_short_flights_after_a_bounce_are_not_missed() -> None:
    """The step after a bounce is longer than the flights: the ball must not fall through the floor."""
    terminal = kf.Event("below", lambda t, state: state.position("ball")[2] + 1e-6, terminal=True)
    with pytest.warns(
        kf.SimulationWarning,
        match="'floor' acted .* infinitely many events in a finite time. Remedy: let its action bring",
    ):
        result = falling_ball().simulate((0.0, 3.0), events=[floor(0.3), terminal])
    assert len(result.events["below"]) == 0
    last = np.sqrt(2.0 / G) * (1.0 + 2.0 * 0.3 / 0.7)  # where the flights end up
    assert result.status.time == pytest.approx(last, abs=1e-6)
    assert result.times[-1] == result.status.time


@pytest.mark.parametrize("restitution", [1e-3, 0.1, 0.5, 0.9])
def test_a_storm_of_events_is_a_failure_with_a_name(restitution: float) -> None:
    """A motor drives a wheel on against an edge that throws it back each time with a thousandth, or nearly all."""
    event = kf.Event("edge", lambda t, state: angle(state) - 1.0, direction=1, action=bounced(restitution))
    scene = kf.System()
    wheel = scene.add_rigid_body("wheel", 1.0, 0.5, joint=kf.Revolute("z"))
    scene.add_torque(wheel, lambda t: (0.0, 0.0, 1.0))
    with pytest.warns(kf.SimulationWarning, match="'edge' acted .* infinitely many events"):
        result = scene.simulate((0.0, 50.0), events=[event])
    assert result.status.kind == "failed"
    assert len(result.events["edge"]) < 300


@pytest.mark.parametrize("method", [name for name in own_methods() if METHODS[name].has_error_control])
def test_an_impact_on_a_mechanism_keeps_its_loops_closed(method: str) -> None:
    """Only the crank is told its new speed; the others follow."""
    scene = four_bar(speed=2.0)

    def stopped(t: float, state: SceneState) -> np.ndarray:
        y = state.vector
        n = len(y) // 2
        y[n] *= -0.5
        return y

    event = kf.Event("stop", lambda t, state: state.joint_coordinates("crank")[0] - 1.5, action=stopped)
    result = scene.simulate((0.0, 1.0), events=[event], method=method)
    assert len(result.events["stop"]) >= 1
    run = result.run
    assert run is not None
    from kanefe.literal.loop_closure import project_speeds

    for t, q, u in zip(result.times[::50], run.trajectory.coordinates[::50], run.trajectory.speeds[::50], strict=True):
        np.testing.assert_allclose(project_speeds(run.model, t, q, u), u, rtol=0, atol=1e-9)


def test_events_see_flexible_bodies_and_unreduced_ones() -> None:
    for reduction in (kf.CraigBampton(modes=2), None):
        scene = kf.System(gravity=(0.0, 0.0, -2.0))
        scene.add_flexible_body("arm", lattice_body(1, reduction=reduction), joint=kf.Revolute("y"))
        event = kf.Event("down", lambda t, state: state.position("arm", "tip")[2] + 0.3, terminal=True)
        result = scene.simulate((0.0, 3.0), events=[event], rtol=1e-5)
        assert result.status.kind == "stopped"
        # the step lands on the event by dense output: its own tolerance, and that of the elastic modes
        assert result.position("arm", "tip")[-1, 2] == pytest.approx(-0.3, abs=1e-6)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: kf.Event("", lambda t, s: t), "the name of an event must be a text"),
        (lambda: kf.Event("a", 3.0), r"event 'a' needs a function f\(t, state\) -> number"),
        (lambda: kf.Event("a", lambda t, s: t, direction=2), "direction of event 'a' must be -1, 0 or 1, not 2"),
        (lambda: kf.Event("a", lambda t, s: t, action=1), "action of event 'a' must be a function"),
        (lambda: kf.Event("a", lambda t, s: t, terminal=True, action=lambda t, s: None), "'a' ends the run"),
    ],
)
def test_bad_events_are_named(make: Any, message: str) -> None:
    with pytest.raises(kf.ModelError, match=message):
        make()


def test_bad_lists_of_events_are_named() -> None:
    twice = [kf.Event("a", lambda t, s: t - 0.5), kf.Event("a", lambda t, s: t - 0.6)]
    with pytest.raises(kf.ModelError, match="two events are called 'a'"):
        spinner().simulate((0.0, 1.0), events=twice)
    with pytest.raises(kf.ModelError, match=r"events must be a list of kanefe\.Event or of names .* not of function"):
        spinner().simulate((0.0, 1.0), events=[lambda t, s: t])


def test_what_functions_and_actions_give_is_checked_and_named() -> None:
    with pytest.raises(kf.ModelError, match=r"event 'a' must give one finite number; at t = 0 s it gave nan"):
        spinner().simulate((0.0, 1.0), events=kf.Event("a", lambda t, s: np.nan))
    short = kf.Event("a", lambda t, s: t - 0.5, action=lambda t, s: np.zeros(3))
    with pytest.warns(
        kf.SimulationWarning, match=r"action of event 'a' must return 2 finite numbers.* gave shape \(3,\)"
    ):
        result = spinner().simulate((0.0, 1.0), events=short)
    assert result.status.kind == "failed"


def test_no_event_costs_no_evaluation_of_a_state(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("kanefe.order_n.route.OrderN.state", lambda *a: pytest.fail("a state was made"))
    assert spinner().simulate((0.0, 1.0)).status.is_finished


def test_events_do_not_change_the_run_that_they_watch() -> None:
    plain = falling_ball().simulate((0.0, 1.0), method="dop853")
    watched = falling_ball().simulate((0.0, 1.0), method="dop853", events=kf.Event("floor", height_of_ball))
    np.testing.assert_array_equal(plain.position("ball"), watched.position("ball"))
    assert plain.statistics["steps"] == watched.statistics["steps"]
