"""A run tries other methods: what is better is taken, what disagrees is not, and the run is the same each time."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

import kanefe as kf
from benchmarks.drawn_scenes import drawn
from kanefe.equations.model import Model
from kanefe.integrate.auto.choice import choose
from kanefe.integrate.auto.trial_plan import SHARE, TrialPlan
from kanefe.integrate.auto.trials import Stretch, Trial, went_over
from kanefe.integrate.auto.tried_methods import TriedMethods
from kanefe.integrate.auto.work import WorkCounter
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.methods.table import METHODS, own_methods, row_for
from kanefe.integrate.options import RunOptions
from kanefe.integrate.set_up import set_up
from kanefe.integrate.stepper import StepControl, StepFailure

FLEXIBLE, SECONDS = 10, 1.0
"""Seed of a chain with an undamped beam, and how much of it is run, s."""

LONG = 3.0
"""Time of a run of rigid links in which trials pay, s."""


@pytest.fixture(scope="module")
def model() -> Model:
    return drawn(FLEXIBLE).scene.freeze()


def tried(model: Model, rtol: float) -> TriedMethods:
    stepper = set_up(model, RunOptions(t_span=(0.0, SECONDS), rtol=rtol)).stepper
    assert isinstance(stepper, TriedMethods)
    return stepper


def passed(stepper: TriedMethods, times: np.ndarray, chunks: Iterator[int]) -> np.ndarray:
    states, stored = np.empty((len(times), len(stepper.state()))), 0
    while stored < len(times):
        stored += stepper.integrate_through(times[stored:], states[stored:], next(chunks))
    return states


def ever(count: int) -> Iterator[int]:
    while True:
        yield count


def test_a_better_method_is_taken_and_as_accurate() -> None:
    scene = drawn(FLEXIBLE).scene
    run, alone, exact = (
        scene.copy().simulate((0.0, SECONDS), method=method, rtol=rtol, output_step=0.01)
        for method, rtol in (("auto", 1e-3), ("radau5", 1e-3), ("vern9", 1e-7))  # the last is off by 1e-12
    )
    assert run.statistics["method"] == "radau5, then extrapolation"
    assert run.statistics["evaluations"] < alone.statistics["evaluations"]
    assert "extrapolation from" in str(run)
    assert "taken" in str(run)
    last = f"link {len(scene.freeze().bodies) - 1}"
    size = drawn(FLEXIBLE).size
    assert np.abs(run.position(last) - exact.position(last)).max() < 10.0 * 1e-3 * size


def test_a_run_does_not_depend_on_how_it_is_cut(model: Model) -> None:
    times = np.linspace(0.01, SECONDS, 30)
    whole, cut = tried(model, 1e-5), tried(model, 1e-5)
    np.testing.assert_array_equal(passed(whole, times, ever(10**6)), passed(cut, times, ever(7)))
    assert whole.trials == cut.trials
    assert len(whole.trials) > 1
    assert whole.statistics == cut.statistics
    assert whole.name == cut.name


@pytest.mark.parametrize("steps", [2, 7])
def test_one_step_of_a_cut_costs_no_more_than_another(model: Model, steps: int) -> None:
    """The states within a step, which take dop853 evaluations, are wanted of calls for one step alone."""

    def evaluations(count: int) -> float:
        control = StepControl(1e-5, 1e-6, None)
        makes = [lambda on, name=name: row_for(model, name).make(on, 0.0, 0.1, control) for name in ("dop853", "vern9")]
        dynamics = Dynamics(model)
        run = TriedMethods(makes[0](dynamics), makes[1:], dynamics, (0.0, 0.1), 1e-5, WorkCounter(model, False))
        passed(run, np.array([0.1]), ever(count))
        assert run.trials
        return run.statistics["evaluations"]

    assert evaluations(steps) == evaluations(10**6) < evaluations(1)


@pytest.mark.parametrize("rtol", [1e-3, 1e-4, 1e-5, 1e-6])
def test_a_run_is_the_same_when_it_is_asked_for_again(rtol: float) -> None:
    """What the run before has made does not count."""
    scene = drawn(FLEXIBLE).scene.copy()
    first, second = (scene.simulate((0.0, SECONDS), rtol=rtol) for _ in range(2))
    assert first.statistics["tried"]
    assert first.statistics["tried"] == second.statistics["tried"]
    last = scene.freeze().bodies[-1].name
    np.testing.assert_array_equal(first.position(last), second.position(last))


@pytest.mark.parametrize("first", [20, 60, 200])
def test_it_goes_on_from_a_snapshot_to_the_bit(model: Model, first: int) -> None:
    """Amid a stretch, before one, and after another method was taken."""
    times = np.linspace(0.01, SECONDS, 30)
    one, other = tried(model, 1e-4), tried(model, 1e-4)
    states = np.empty((30, len(one.state())))
    stored = one.integrate_through(times, states, first)
    other.resume(one.snapshot())
    rest = passed(one, times[stored:], ever(10**6))
    np.testing.assert_array_equal(rest, passed(other, times[stored:], ever(10**6)))
    assert one.trials == other.trials
    assert one.statistics == other.statistics


def rough(model: Model, rtol: float) -> TriedMethods:
    """Return a run by Radau's method whose only rival is dop853 with a tolerance of its own."""
    dynamics, span = Dynamics(model), (0.0, LONG)
    steppers = [
        lambda dynamics, name=name, r=r: row_for(model, name).make(dynamics, *span, StepControl(r, 0.1 * r, None))
        for name, r in (("radau5", 1e-9), ("dop853", rtol))
    ]
    return TriedMethods(steppers[0](dynamics), steppers[1:], dynamics, span, 1e-9, WorkCounter(model, False))


def test_a_method_that_disagrees_is_not_taken() -> None:
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    parent = scene.ground
    for i in range(8):
        joint = kf.Revolute("y", position=0.2 * i, forces=kf.CoordinateForce(damping=0.01))
        options = {} if i == 0 else {"at": (0.3, 0, 0)}
        parent = scene.add_rigid_body(f"link {i}", 1.0, 0.1, com=(0.15, 0, 0), parent=parent, joint=joint, **options)
    model = scene.freeze()
    times = np.linspace(0.01, LONG, 30)
    for rtol, is_taken in ((1e-9, True), (1e-2, False)):
        run = rough(model, rtol)
        passed(run, times, ever(10**6))
        assert (run.name == "radau5, then dop853") == is_taken
        assert run.trials[-1].off > 1.0 or is_taken


def test_where_a_method_fails_the_first_goes_on(model: Model, monkeypatch: pytest.MonkeyPatch) -> None:
    run = tried(model, 1e-3)
    times = np.linspace(0.01, SECONDS, 30)
    states = np.empty((30, len(run.state())))
    stored = 0
    while run.name == "radau5":
        stored += run.integrate_through(times[stored:], states[stored:], 1)

    def fails(*given: object) -> int:
        raise StepFailure("no step is small enough", "another method")

    monkeypatch.setattr(run._now, "integrate_through", fails)
    passed(run, times[stored:], ever(50))
    assert run.name.endswith("then radau5")
    assert run.t >= SECONDS


def test_trials_cost_no_more_than_their_share() -> None:
    """Of a run of many steps in which nothing is better."""
    plan, work, steps, t = TrialPlan(3, 0.0, 1.0, 16), 1e6, 0, 0.0
    lengths = []
    while t < 1.0:
        steps = plan.next_look
        plan.work, t = work * steps, 1e-4 * steps
        if plan.begins_stretch(t, steps, 0):
            begun = steps
            steps = plan.next_look
            plan.work, t = work * steps, 1e-4 * steps
            plan.tried_work += work * (steps - begun)
            lengths.append(steps - begun)
            assert not plan.takes(Trial(plan.rival, 0.0, 0.0, 1.0, np.inf, 10), 0, False, False)
            plan.next_look = steps + 1
    assert plan.tried_work <= SHARE * plan.work
    assert lengths == [16 * 2**i for i in range(len(lengths))]
    assert len(lengths) > 3


def test_controllers_are_not_asked_in_trials() -> None:
    times: list[float] = []
    scene = drawn(FLEXIBLE).scene

    def hold(t: float, reads: np.ndarray, memory: dict[str, float]) -> float:
        times.append(t)
        return -0.1 * reads[0]

    first = scene.freeze().bodies[0].name
    reads = (f"joint_coordinates {first}",)
    scene = scene.copy()
    scene.add_controller("hold", hold, every=1e-3, reads=reads, drives=f"motor {first}")
    run = scene.simulate((0.0, SECONDS), rtol=1e-3)
    assert run.statistics["tried"]
    np.testing.assert_allclose(times, 1e-3 * np.arange(len(times)), atol=1e-12)


def test_a_trial_that_begins_at_a_sample_holds_what_is_held_from_there_on() -> None:
    """A cart of 2 kg under a force that is held: it goes over to 3 N where the trial begins, and to -1 N within it."""
    scene = kf.System()
    scene.add_rigid_body("cart", 2.0, joint=kf.Prismatic("x"))
    options = {"every": 0.1, "reads": ("joint_coordinates cart",), "drives": "motor cart"}
    scene.add_controller("pull", lambda t, reads, memory: 0.0, **options)
    model = scene.freeze()
    options = RunOptions(t_span=(0.0, 1.0), method="dop853")
    rival = set_up(model, options).stepper
    first = rival.state()
    held = slice(2, 2 + model.state_count)
    held_3, held_1 = first.copy(), first.copy()
    held_3[held], held_1[held] = 3.0, -1.0
    stretch = Stretch(0.1, first, 0.0, -np.inf, [(0.1, held_3), (0.2, held_1)])
    found, _ = went_over(rival, stretch, (0.25, first), held, np.inf, WorkCounter(model, False))
    x = 0.5 * 1.5 * 0.1**2 + 0.15 * 0.05 - 0.5 * 0.5 * 0.05**2  # m
    assert found is not None
    assert found[:2] == pytest.approx((x, 0.15 - 0.5 * 0.05), rel=1e-9)


def test_another_method_is_not_tried_where_one_is_asked_for() -> None:
    model = drawn(FLEXIBLE).scene.freeze()
    assert not choose(model, RunOptions(t_span=(0.0, SECONDS), method="radau5")).rivals
    assert choose(model, RunOptions(t_span=(0.0, SECONDS))).rivals


@pytest.mark.parametrize("seed", [FLEXIBLE, 4205, 4208, 4218])
def test_a_method_that_is_not_tried_is_left_out_with_the_reason(seed: int) -> None:
    model = drawn(seed).scene.freeze()
    choice = choose(model, RunOptions(t_span=(0.0, SECONDS)))
    assert choice.left_out is not None
    with_control = {name for name in own_methods() if METHODS[name].has_error_control}
    assert choice.left_out.keys() < with_control - {choice.name}
    assert len(choice.rivals) >= len(with_control) - 1 - len(choice.left_out)  # the rest; one may also take over
    assert all(choice.left_out.values())
    if any(load.acts_at_once for load in model.loads) and not model.rigid_contacts:
        assert choice.left_out["extrapolation"] == "it may step over what contact 'drop' begins at once"
