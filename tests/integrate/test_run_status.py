"""How runs end: finished, stopped by a limit, failed with a name, a time and a remedy; never a hang and never NaN."""

from __future__ import annotations

import itertools
import re
import time
import warnings
from collections.abc import Callable, Mapping
from dataclasses import FrozenInstanceError
from typing import Any

import numpy as np
import pytest

import kanefe as kf
from kanefe.checks.robustness.runs import ended, suits
from kanefe.integrate.auto.choice import Choice
from kanefe.integrate.clock import Clock
from kanefe.integrate.methods.table import METHODS, own_methods
from kanefe.integrate.options import RunOptions
from kanefe.integrate.run import integrate
from kanefe.integrate.state_rows import StateRows
from kanefe.integrate.status import RunStatus, summary
from kanefe.integrate.stepper import StepFailure
from kanefe.kernels.compiler._numba import IS_COMPILED, seconds_compiling
from kanefe.kernels.compiler.filling import filler
from loop_scenes import four_bar
from robustness.steps import stiff_spring
from run_scenes import ADAPTIVE, double_pendulum
from steel_beams import steel_beam


def straight_line(rate: float = 1.0) -> kf.System:
    scene = kf.System()
    scene.add_point("point", 1.0, joint=kf.Prismatic("x", speed=rate))
    return scene


class ScriptedStepper:
    """A method of which a test decides what each step does: its coordinate is the time."""

    name = "scripted"
    bent = unanswered = ()
    hardest = None

    def __init__(self, step: float, fails: Mapping[int, Exception] | None = None, bad: int = -1) -> None:
        self.t = self.t_old = 0.0
        self._step, self._fails, self._bad, self._count = step, fails or {}, bad, 0
        self.calls: list[int] = []

    @property
    def step_count(self) -> int:
        return self._count

    @property
    def statistics(self) -> dict[str, int | float]:
        return {"steps": self._count, "rejected": 0, "evaluations": 4 * self._count}

    def step_again(self, t: float) -> bool:
        return False

    def integrate_through(self, times: np.ndarray, states: np.ndarray, most_steps: int) -> int:
        self.calls.append(most_steps)
        passed = 0
        while passed < len(times) and most_steps > 0:
            if self._count in self._fails:
                raise self._fails[self._count]
            self.t_old, self.t = self.t, self.t + self._step
            self._count += 1
            most_steps -= 1
            while passed < len(times) and times[passed] <= self.t:
                states[passed] = self._at(float(times[passed]))
                passed += 1
        return passed

    def _at(self, t: float) -> np.ndarray:
        return np.array([t if self._count != self._bad else np.nan, 1.0, 0.0, 0.0])

    def state(self) -> np.ndarray:
        return self._at(self.t)

    def states(self, times: np.ndarray) -> np.ndarray:
        return np.array([self._at(float(t)) for t in times])

    def restart(self, t: float, y: np.ndarray) -> None:
        self.t = self.t_old = t

    def snapshot(self) -> dict[str, np.ndarray]:
        return {"t": np.array(self.t)}

    def resume(self, snapshot: Mapping[str, np.ndarray]) -> None:
        self.t = self.t_old = float(snapshot["t"])


def scripted(monkeypatch: pytest.MonkeyPatch, stepper: ScriptedStepper, **options: Any) -> kf.Result:
    choice = Choice("scripted", "for the test", lambda dynamics: stepper, {})
    monkeypatch.setattr("kanefe.integrate.set_up.choose", lambda *arguments: choice)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", kf.SimulationWarning)
        return straight_line().simulate((0.0, 1.0), **options)


@pytest.mark.parametrize("method", ADAPTIVE)
def test_a_run_to_the_end_says_so(method: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        result = straight_line().simulate((0.0, 2.0), method=method)
    assert result.status.is_finished
    assert str(result.status) == "the run finished at t = 2 s"
    assert result.events == {}
    result.raise_for_status()


def test_a_failure_names_the_worst_component_when_and_what_to_try(monkeypatch: pytest.MonkeyPatch) -> None:
    stepper = ScriptedStepper(0.1, {5: StepFailure("no step is small enough", "loosen rtol", 1)})
    result = scripted(monkeypatch, stepper, output_step=0.2)
    assert str(result.status) == (
        "the run failed at t = 0.5 s: no step is small enough; the worst is 'point: rate [m/s]'. Remedy: loosen rtol"
    )
    # what was passed within the chunk that failed, and the place where it did
    assert result.times == pytest.approx([0.0, 0.2, 0.4, 0.5], abs=1e-15)
    assert result.position("point")[:, 0] == pytest.approx([0.0, 0.2, 0.4, 0.5], abs=1e-15)
    with pytest.raises(kf.SimulationError, match="no step is small enough"):
        result.raise_for_status()


def test_the_modes_of_a_flexible_body_are_named() -> None:
    from scenes import lattice_body

    scene = kf.System()
    arm = scene.add_flexible_body("arm", lattice_body(1, reduction=kf.CraigBampton(modes=2)), joint=kf.Revolute("y"))
    tip = scene.add_rigid_body("tip", 0.5, 0.02, parent=arm.interface("tip"))
    scene.add_force(tip, lambda t: (0.0, 0.0, 0.0 if t < 0.05 else np.sign(np.sin(1e15 * t)) * 1e9))
    with pytest.warns(kf.SimulationWarning, match=r"at t = 0\.05 s: .*; the worst is 'arm: .*\[.*\]'|'arm: (d?)eta \d"):
        result = scene.simulate((0.0, 0.1), method="dop853", rtol=1e-4)
    assert np.all(np.isfinite(result.modal_coordinates("arm")))


@pytest.mark.parametrize("method", ["dopri5", "dop853"])
def test_what_moves_is_named_and_not_the_work_that_follows_it(method: str) -> None:
    """The speed of the wheel grows like a logarithm, the work of its torque faster."""
    scene = kf.System()
    wheel = scene.add_rigid_body("wheel", 1.0, 0.5, joint=kf.Revolute("z"))
    scene.add_torque(wheel, lambda t: (0.0, 0.0, 1.0 / (0.5 - t) if t < 0.5 else 1e300))
    with pytest.warns(kf.SimulationWarning, match="the worst is 'wheel: (rate|angle)"):
        assert scene.simulate((0.0, 1.0), method=method).status.time == pytest.approx(0.5, abs=1e-9)


def test_an_error_of_the_equations_is_a_status_too(monkeypatch: pytest.MonkeyPatch) -> None:
    error = kf.SimulationError("spring 's' has no length at t = 0.32 s. Remedy: keep its ends apart")
    result = scripted(monkeypatch, ScriptedStepper(0.1, {3: error}))
    assert str(result.status) == f"the run failed at t = 0.3 s: {error}"
    singular = np.linalg.LinAlgError("Singular matrix")
    assert "Singular matrix. Remedy: " in str(scripted(monkeypatch, ScriptedStepper(0.1, {3: singular})).status)


def test_states_that_are_not_finite_end_a_run_before_they_are_stored(monkeypatch: pytest.MonkeyPatch) -> None:
    result = scripted(
        monkeypatch, ScriptedStepper(0.125, bad=7), output_step=0.125, events=kf.Event("e", lambda t, s: t - 9)
    )
    assert result.status.kind == "failed"
    assert "grown without bound; the worst is 'point: distance [m]'. Remedy:" in str(result.status)
    assert np.all(np.isfinite(result.position("point")))
    assert len(result.times) == 7


# steps of 10 s and of 0.1 s: the equations overflow in the first step; the loop is torn apart after some
@pytest.mark.parametrize("method", [name for name in METHODS if METHODS[name].has_fixed_steps])
@pytest.mark.parametrize(("scene", "step"), [(double_pendulum, 10.0), (four_bar, 0.1)])
def test_a_fixed_step_that_is_too_long_is_told_with_what_there_is(
    method: str, scene: Callable[[], kf.System], step: float
) -> None:
    model = scene().freeze()
    if not suits(method, model):
        pytest.skip("it does not run this scene")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", kf.SimulationWarning)
        trajectory = integrate(model, (0.0, 50 * step), method=method, step=step, output_step=step)
    assert trajectory.status is not None
    assert trajectory.status.is_finished or trajectory.status.remedy
    assert np.all(np.isfinite(trajectory.coordinates))
    assert np.all(np.isfinite(trajectory.speeds))


@pytest.mark.parametrize("size", [1e-13, 0.0])
def test_steps_that_do_not_get_on_are_a_failure_and_no_hang(monkeypatch: pytest.MonkeyPatch, size: float) -> None:
    stepper = ScriptedStepper(size)
    result = scripted(monkeypatch, stepper)
    assert "steps have become smaller than 1e-12 of the span. Remedy: check loads" in str(result.status)
    assert stepper.statistics["steps"] < 200


def test_a_run_that_would_take_days_is_warned_of(monkeypatch: pytest.MonkeyPatch) -> None:
    choice = Choice("scripted", "for the test", lambda dynamics: ScriptedStepper(2.0**-7), {})
    monkeypatch.setattr("kanefe.integrate.set_up.choose", lambda *arguments: choice)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        straight_line().simulate((0.0, 1.0))
    monkeypatch.setattr("kanefe.integrate.pace.PATIENCE", 0.0)
    monkeypatch.setattr("kanefe.integrate.pace.LONGEST", 0.0)
    expected = (
        r"steps of scripted are 0\.0078 s long: at this pace the run takes .* min more\. Remedy: check loads"
        r".* another method, such as 'radau5' or 'dop853'"
    )
    with pytest.warns(kf.SimulationWarning, match=expected) as told:
        assert straight_line().simulate((0.0, 1.0)).status.is_finished
    assert len(told) == 1
    assert told[0].filename == __file__


def test_full_systems_are_told_after_the_first_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    """A method that is asked for tells what its full systems cost; one that solves none says nothing."""
    monkeypatch.setattr("kanefe.integrate.pace.MOST_SPEEDS", 1)
    monkeypatch.setattr("kanefe.integrate.pace.LONG", 0.0)
    expected = (
        r"radau5 solves full systems of 2 unknowns, .* cube .*: a step takes .* s, and at t = .* s the run takes .* "
        r"min more with steps of .* s\. Remedy: method='auto', or 'dop853' or 'generalised-alpha', if that needs none"
    )
    with pytest.warns(kf.SimulationWarning, match=expected) as told:
        assert double_pendulum().simulate((0.0, 0.5), method="radau5").status.is_finished
    assert len(told) == 1
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        double_pendulum().simulate((0.0, 0.5), method="dop853")


def test_a_long_run_without_reduction_says_what_would_be_short(monkeypatch: pytest.MonkeyPatch) -> None:
    body = kf.flexible_body(steel_beam(60), {"root": "clamped"})
    assert "not reduced" in str(body)
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    scene.add_flexible_body("arm", body, joint=kf.Revolute("y"))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene.simulate((0.0, 1e-3))
    monkeypatch.setattr("kanefe.integrate.pace.SOON", 0.0)
    monkeypatch.setattr("kanefe.integrate.pace.WAIT", 0.0)
    words = r"'arm' moves with all 360 degrees of freedom .* ms a step: the run takes .* more\. Remedy: reduction="
    with pytest.warns(kf.SimulationWarning, match=words) as told:
        assert scene.simulate((0.0, 1e-3)).status.is_finished
    assert len(told) == 1


def test_time_of_compiling_is_no_pace(monkeypatch: pytest.MonkeyPatch) -> None:
    choice = Choice("scripted", "for the test", lambda dynamics: ScriptedStepper(2.0**-7), {})
    monkeypatch.setattr("kanefe.integrate.set_up.choose", lambda *arguments: choice)
    monkeypatch.setattr("kanefe.integrate.pace.PATIENCE", 0.0)
    monkeypatch.setattr("kanefe.integrate.pace.LONGEST", 0.0)
    compiled = itertools.count(step=1000)  # each look at it a thousand seconds later
    monkeypatch.setattr("kanefe.integrate.pace.seconds_compiling", lambda: next(compiled))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        straight_line().simulate((0.0, 1.0))


def test_a_chunk_is_limited_and_one_step_long_where_events_are_watched(monkeypatch: pytest.MonkeyPatch) -> None:
    stepper = ScriptedStepper(1e-5)
    scripted(monkeypatch, stepper, output_step=1.0)
    assert max(stepper.calls) <= 2000
    assert len(stepper.calls) < 200
    stepper = ScriptedStepper(0.1)
    scripted(monkeypatch, stepper, events=kf.Event("half", lambda t, state: t - 0.5))
    assert set(stepper.calls) == {1}


@pytest.mark.parametrize("method", ADAPTIVE)
def test_the_limit_of_steps_is_kept_and_told(method: str) -> None:
    result = double_pendulum().simulate((0.0, 10.0), method=method, most_steps=7)
    assert result.status.kind == "stopped"
    assert result.statistics["steps"] == 7
    assert "by the limit of 7 steps. Remedy: a larger limit, or continue" in str(result.status)
    assert result.times[-1] == result.status.time
    whole = double_pendulum().simulate((0.0, 10.0), method=method)
    assert len(result.times) > 1
    np.testing.assert_array_equal(result.position("second")[:-1], whole.position("second")[: len(result.times) - 1])


def test_the_limit_of_time_stops_a_run() -> None:
    result = double_pendulum().simulate((0.0, 1e6), method="dop853", rtol=1e-12, output_step=1e6, most_seconds=0.0)
    assert "by the limit of 0 seconds" in str(result.status)
    assert str(result.status).endswith("or another method, such as 'radau5' or 'generalised-alpha'")


def test_the_limit_of_time_ends_the_search_for_an_event() -> None:
    """A function that jumps is halved some 40 times, here at 0.05 s each; the run then ends before that step."""
    slow: list[float] = []

    def jumps(t: float, state: object) -> float:
        if t >= 0.3 or slow:
            slow.append(t)
            time.sleep(0.05)
        return 1.0 if t < 0.3 else -1.0

    scene, event = double_pendulum(), kf.Event("jump", jumps)
    result = scene.simulate((0.0, 1.0), method="dop853", events=event, output_step=0.1, most_seconds=0.6)
    assert "by the limit of 0.6 seconds" in str(result.status)
    assert len(slow) < 25
    assert 0.0 < result.status.time < 0.3
    assert result.times[-1] == result.status.time
    assert len(result.events["jump"]) == 0


def test_output_times_are_those_asked_for() -> None:
    wanted = [0.1, 0.25, 0.7]
    for method in own_methods():
        options: dict[str, Any] = {} if METHODS[method].has_error_control else {"step": 0.03}
        result = straight_line(2.0).simulate((0.0, 1.0), method=method, output_times=wanted, **options)
        assert result.times.tolist() == wanted
        assert result.position("point")[:, 0] == pytest.approx([0.2, 0.5, 1.4], abs=1e-12)
        assert result.status.time == 1.0  # run to its end all the same


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"output_times": [0.0, 1.0], "output_step": 0.1}, "output_step and output_times were both given"),
        ({"output_times": []}, "one or more finite times"),
        ({"output_times": [[0.0, 1.0]]}, r"shape \(1, 2\) was given"),
        ({"output_times": ["soon"]}, "output_times must be times in s"),
        ({"output_times": [0.0, np.nan]}, "one or more finite times"),
        ({"output_times": [0.5, 0.5]}, "must ascend, each time once"),
        ({"output_times": [0.0, 2.0]}, "reach from 0 to 2 s, the run from 0 to 1 s"),
        ({"most_steps": 0}, "most_steps must be a whole number above zero, not 0"),
        ({"most_steps": 1.5}, "most_steps must be a whole number"),
        ({"most_seconds": -1.0}, "must be zero s or more, not -1.0"),
        ({"most_seconds": "long"}, "must be zero s or more, not 'long'"),
    ],
)
def test_bad_limits_and_outputs_are_named(options: dict[str, Any], message: str) -> None:
    with pytest.raises(kf.ModelError, match=message):
        integrate(straight_line().freeze(), (0.0, 1.0), **options)


def test_seconds_are_told_by_part() -> None:
    event = kf.Event("e", lambda t, state: t - 0.5)
    found = double_pendulum().simulate((0.0, 1.0), events=event).statistics
    assert set(found["seconds_by_part"]) - {"compiling"} == {"set-up", "steps", "events"}
    assert found["seconds"] == pytest.approx(sum(found["seconds_by_part"].values()))


def test_what_is_compiled_within_a_part_is_a_part_by_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    compiled = iter([0.0, 0.0, 3.0, 7.0])
    monkeypatch.setattr("kanefe.integrate.clock.seconds_compiling", lambda: next(compiled))
    clock = Clock()
    with clock.part("set-up"):
        pass
    assert list(clock.seconds) == ["set-up"]
    with clock.part("steps"):
        pass
    assert clock.seconds["compiling"] == 4.0
    assert clock.seconds["steps"] == pytest.approx(-4.0, abs=0.1)


@pytest.mark.skipif(not IS_COMPILED, reason="kernels are run as Python")
def test_compiling_is_noticed() -> None:
    before = seconds_compiling()
    assert filler(((compiled_function(), 0, 0, False),)) is not None
    assert seconds_compiling() > before


def compiled_function() -> Any:
    import numba

    return numba.njit(lambda t: 2.0 * t)


@pytest.mark.parametrize("method", own_methods())
def test_every_result_tells_what_it_cost(method: str) -> None:
    options: dict[str, Any] = {} if METHODS[method].has_error_control else {"step": 0.03}
    told = straight_line().simulate((0.0, 1.0), method=method, **options).statistics
    counts = [told[name] for name in ("steps", "rejected", "evaluations", "factorisations", "jacobians")]
    assert all(isinstance(count, int) for count in counts)
    assert told["steps"] > 0
    assert told["evaluations"] >= told["steps"]
    assert told["method"] == method
    assert told["reason"] == "asked for"


def test_a_result_tells_itself_in_a_few_lines() -> None:
    events = [kf.Event("half", lambda t, state: t - 0.5), kf.Event("never", lambda t, state: t - 9.0)]
    result = straight_line().simulate((0.0, 2.0), method="rk4", step=0.125, events=events)
    status, method, route, counts, seconds, balance, happened = str(result).splitlines()
    assert status == "the run finished at t = 2 s"
    assert method == "  method  rk4 (asked for), step 0.125"
    assert route == "  route   order n, in the plane (rigid bodies that all move in one plane)"
    assert counts == f"  counts  16 steps, {result.statistics['evaluations']} evaluations"
    assert re.fullmatch(r"  time    .* s.*; 99\.9 % of the steps within .* us, all within .* us", seconds)
    assert balance.startswith("  energy  balance ")
    assert happened == "  events  half 1, never 0"


def test_of_many_events_those_are_listed_that_happen_often() -> None:
    run = straight_line().simulate((0.0, 0.5))
    times = np.arange(1.0, 4.0)
    events = {f"e{i}": times[: i % 3] for i in range(12)}
    shown = summary(run.status, run.statistics, events).splitlines()[-1]
    assert shown == "  events  e1 1, e2 2, e4 1, e5 2, e7 1, e8 2, e10 1, e11 2 and others, 12 in all"


def test_a_partial_result_is_saved_and_loaded_with_its_status_and_events(tmp_path) -> None:
    event = kf.Event("half", lambda t, state: t - 0.5)
    end = kf.Event("end", lambda t, state: t - 0.75, terminal=True)
    result = double_pendulum().simulate((0.0, 1.0), events=[event, end])
    result.save(tmp_path / "run.h5")
    loaded = kf.load_result(tmp_path / "run.h5")
    assert loaded.status == result.status
    assert loaded.times[-1] == loaded.status.time == pytest.approx(0.75, abs=1e-12)
    assert {name: times.tolist() for name, times in loaded.events.items()} == {
        name: times.tolist() for name, times in result.events.items()
    }
    np.testing.assert_array_equal(loaded.position("second"), result.position("second"))
    assert loaded.statistics == result.statistics


def test_options_are_checked_when_they_are_given_and_do_not_change() -> None:
    options = RunOptions(t_span=(0.0, 2.0), output_step=0.5, events=kf.Event("now", lambda t, state: t - 1.0))
    assert options.span == (0.0, 2.0)
    assert options.times.tolist() == [0.0, 0.5, 1.0, 1.5, 2.0]
    assert [event.name for event in options.watched] == ["now"]
    with pytest.raises(FrozenInstanceError):
        options.rtol = 1e-3  # type: ignore[misc]
    with pytest.raises(kf.ModelError, match="checkpoint_seconds"):
        RunOptions(t_span=(0.0, 1.0), checkpoint_seconds=-1.0)


def test_a_refused_option_leaves_the_scene_open() -> None:
    scene = double_pendulum()
    with pytest.raises(kf.ModelError, match="there is no method 'euler'"):
        scene.simulate((0.0, 1.0), method="euler")
    scene.add_point("more", 1.0, joint=kf.Prismatic("x"))


def test_states_that_overflow_between_two_steps_are_a_failure(monkeypatch: pytest.MonkeyPatch) -> None:
    """The states after all steps are finite, the energy dissipated within one is not."""
    count = StateRows.count_finite

    def overflowing(rows: StateRows) -> int:
        rows.states[20:, -2:] = np.inf
        return count(rows)

    monkeypatch.setattr(StateRows, "count_finite", overflowing)
    run = ended(stiff_spring(), 0.05, method="radau5", rtol=1e-3)
    assert run.status is not None
    assert run.status.kind == "failed"
    assert "rtol" in str(run.status)
    assert np.all(np.isfinite(run.dissipated))
    assert len(run.times) == 21  # with the end


@pytest.mark.parametrize(("share", "is_told"), [(1.9e-4, False), (2.1e-4, True), (9e-6, False)])
def test_more_than_fits_is_more_than_all_steps_may_leave(share: float, is_told: bool) -> None:
    """Of 100 steps at 1e-6 two times 1e-6 each; below, no method promises less."""
    statistics = {"method": "m", "reason": "r", "route": "o", "route_reason": "r", "rtol": 1e-6, "steps": 100}
    statistics |= {"seconds": 1.0, "seconds_by_part": {}, "energy_balance": [0.1, share]}
    text = summary(RunStatus("finished", 1.0), statistics, {})
    assert ("more than fits rtol 1e-06" in text) is is_told


def test_springs_of_rigid_bodies_are_no_elastic_modes() -> None:
    scene = kf.System()
    spring = kf.CoordinateForce(stiffness=1e10, damping=1e3)
    scene.add_rigid_body("rod", 1.0, joint=kf.Prismatic("z", position=1e-6, forces=spring))
    reason = scene.simulate((0.0, 1.0)).statistics["reason"]
    assert "springs and joints up to 1.59e+04 Hz are stiff" in reason
