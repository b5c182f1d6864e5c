"""Functions that `kanefe.compiled` takes: runs are those of Python and never call it, and what is refused."""

import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import kanefe as kf
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.sampled_tables import sample_tables
from kanefe.integrate.sampling import Sampler
from kanefe.kernels.steppers.sampling import progress_of
from kanefe.loads.functions import CompiledCallback
from kanefe_fem import Rectangle, beam_body, straight_beam
from loop_scenes import four_bar
from steel_beams import STEEL

OF_BAR = (
    "joint_coordinates bar",
    "joint_speeds bar",
    "modal_coordinates bar 1",
    "modal_speeds bar",
    "deflection bar/tip z",
)


def held(t: float, r: Any) -> float:
    return -20.0 * r[0] - 0.5 * r[1] ** 3 - r[2] + 0.01 * r[5]


def pushed(t: float, r: Any) -> tuple[float, float, float]:
    return 0.1 * np.sin(20.0 * t), 0, -100.0 * r[0]


HELD = kf.compiled(held, reads=OF_BAR)
PUSHED = kf.compiled(pushed, reads=OF_BAR[-1])


def bar() -> kf.System:
    """Return a bar on a hinge, level in gravity."""
    beam = straight_beam(0.3, Rectangle(0.01, 0.02), STEEL, elements=10)
    options = {"reduction": kf.CraigBampton(modes=3), "damping": kf.ModalDamping(0.05)}
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    scene.add_flexible_body(
        "bar", beam_body(beam, {"root": "clamped", "tip": "rigid"}, **options), joint=kf.Revolute("y")
    )
    return scene


def bar_with(motor: Any, force: Any) -> kf.System:
    scene = bar()
    scene.add_motor(scene.body("bar"), motor)
    tool = scene.add_rigid_body("tool", 0.1, 1e-4, parent=scene.body("bar").interface("tip"))
    scene.add_force(tool.frame(orientation=kf.rotation_about("z", 0.7)), force, follows=True)
    return scene


def deflection(state: Any) -> float:
    frame = state.model.flexible_terms("bar").body.interface("tip")
    return float(frame.displacements(state.modal_coordinates("bar")[None])[0, 2])


def read(state: Any) -> tuple[float, ...]:
    joint = state.joint_coordinates("bar")[0], state.joint_speeds("bar")[0], state.modal_coordinates("bar")[1]
    return *joint, *state.modal_speeds("bar"), deflection(state)


def test_a_run_is_that_of_functions_in_python_and_calls_none(monkeypatch: pytest.MonkeyPatch) -> None:
    python = bar_with(lambda t, state: held(t, read(state)), lambda t, state: pushed(t, (deflection(state),)))
    given = {"method": "rk4", "step": 1e-5, "output_step": 0.005}
    expected = python.simulate((0.0, 0.01), **given)
    calls = list[Any]()
    monkeypatch.setattr(CompiledCallback, "__call__", lambda *given: calls.append(given))
    scene = bar_with(HELD, PUSHED)
    run = scene.simulate((0.0, 0.01), **given)
    assert scene.freeze().route.is_autonomous
    assert not calls
    for name in ("bar", "tool"):  # round-off of 4000 evaluations, of a motion of a millimetre
        np.testing.assert_allclose(run.velocity(name), expected.velocity(name), rtol=0, atol=1e-11)
    assert abs(run.position("tool")[-1] - run.position("tool")[0]).max() > 1e-5


def test_values_and_the_literal_route_are_those_of_runs() -> None:
    model = bar_with(HELD, PUSHED).freeze()
    y = model.initial_state + 0.01 * np.random.default_rng(0).standard_normal(len(model.initial_state))
    rates = model.literal.evaluate(0.1, np.append(y, (0.0, 0.0))).rates
    np.testing.assert_allclose(model.route.evaluate(0.1, np.append(y, (0.0, 0.0))).rates, rates, rtol=1e-9, atol=1e-6)


def test_functions_of_time_go_to_motors_and_motions() -> None:
    scene = kf.System()
    swing = kf.Motion(*(kf.compiled(f) for f in (lambda t: 0.1 * t * t, lambda t: 0.2 * t, lambda t: 0.2)))
    arm = scene.add_rigid_body("arm", 1.0, 0.1, joint=kf.Revolute("z", motion=swing))
    end = scene.add_rigid_body("end", 1.0, 0.1, parent=arm, at=(1, 0, 0), joint=kf.Revolute("z"))
    scene.add_motor(end, kf.compiled(lambda t: 0.3))
    assert scene.freeze().route.is_autonomous
    assert scene.simulate((0.0, 1.0)).joint_coordinates("arm")[-1, 0] == pytest.approx(0.1)


def sum_up(t: float, reads: Any, memory: Any) -> tuple[float, float]:
    memory[0] += 1e-3 * reads[0]
    memory[1] = max(memory[1], reads[1])
    return -20.0 * reads[0] - 5.0 * memory[0], 0.1 * memory[1]


SUM_UP = kf.compiled(sum_up, memory=2)
SLOW = kf.compiled(lambda t, reads, memory: -0.1 * reads[0])


def sum_in_python(t: float, reads: Any, memory: dict[str, Any]) -> tuple[float, float]:
    return sum_up(t, reads, memory.setdefault("kept", np.zeros(2)))


def sampled_bar(function: Callable[..., Any], delay: float, other: Callable[..., Any] | None = None) -> kf.System:
    scene = bar()
    drives = "motor bar", "force bar/tip z"
    scene.add_controller("pd", function, every=1e-3, delay=delay, reads=OF_BAR, drives=drives)
    if other is not None:
        scene.add_controller("slow", other, every=7e-3, reads="joint_speeds bar", drives="motor bar")
    return scene


def test_a_compiled_controller_has_the_memory_it_asked_for() -> None:
    model = sampled_bar(SUM_UP, 0.0, SLOW).freeze()
    samples, (of_sum, of_slow) = sample_tables(model, model.controllers, 0.0, 1.0, 0.0)
    assert of_sum is not None
    assert of_slow is not None
    assert (of_sum.tolist(), of_slow.tolist()) == ([0.0, 0.0], [])
    of_sum[:] = 1.0, 2.0  # as a run that is continued does, of which compiled code knows
    assert samples.memory.tolist() == [1.0, 2.0]


def counted_answers(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    asked, answer = list[int](), Sampler.answer

    def counted(self: Sampler, *given: Any) -> None:
        if (number := progress_of(self.samples).asked) >= 0:
            asked.append(number)
        answer(self, *given)

    monkeypatch.setattr(Sampler, "answer", counted)
    return asked


@pytest.mark.parametrize(
    ("method", "delay"), [("auto", 0.0), ("auto", 2.5e-3), ("radau5", 0.4e-3), ("dop853", 0.0), ("dop853", 2.5e-3)]
)
def test_a_sampled_run_is_the_same_and_calls_no_python(
    method: str, delay: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = counted_answers(monkeypatch)
    run = sampled_bar(SUM_UP, delay, SLOW).simulate((0.0, 0.1), method=method, rtol=1e-7)
    assert not asked
    other = sampled_bar(sum_in_python, delay, lambda t, reads, memory: -0.1 * reads[0])
    called = other.simulate((0.0, 0.1), method=method, rtol=1e-7)
    assert len(asked) == 100 + 15
    for name in ("pd", "slow"):
        ours, theirs = run.controllers[name], called.controllers[name]
        np.testing.assert_array_equal(ours.times, theirs.times)
        np.testing.assert_allclose(ours.reads, theirs.reads, rtol=0, atol=1e-9)
        np.testing.assert_allclose(ours.drives, theirs.drives, rtol=0, atol=1e-9)
    # where it goes step by step, as for events in Python, samples are the same too
    never = kf.Event("never", lambda t, state: 1.0)
    watched = other.simulate((0.0, 0.1), method=method, rtol=1e-7, events=never)
    apart = np.abs(watched.controllers["pd"].reads - run.controllers["pd"].reads).max(axis=0)
    assert apart[0] < 1e-6  # of an angle of some 0.05 rad, with other steps where trials are others


def test_each_run_has_a_memory_of_its_own_and_simulations_go_back() -> None:
    scene = sampled_bar(SUM_UP, 1.5e-3)
    first, second = (scene.simulate((0.0, 0.05)).controllers["pd"] for _ in range(2))
    np.testing.assert_array_equal(first.drives, second.drives)
    sim = scene.start(method="radau5")
    sim.step(0.01)
    saved, ends = sim.save(), []
    for _ in range(2):
        sim.restore(pickle.loads(pickle.dumps(saved)))
        sim.step(0.02)
        ends.append((sim.state.model, sim.controllers["pd"].drives, sim.stepper.state()))
    np.testing.assert_array_equal(ends[0][1], ends[1][1])
    np.testing.assert_array_equal(ends[0][2], ends[1][2])
    assert len(ends[0][1]) == 30


def test_loops_are_closed_at_samples(monkeypatch: pytest.MonkeyPatch) -> None:
    asked, angles = counted_answers(monkeypatch), []
    for function in (kf.compiled(lambda t, r, m: -3.0 * r[0]), lambda t, r, m: -3.0 * r[0]):
        scene = four_bar().copy()
        name = scene.copy().freeze().bodies[0].name
        drives, reads = f"motor {name}", f"joint_speeds {name}"
        scene.add_controller("damp", function, every=0.01, reads=reads, drives=drives)
        run = scene.simulate((0.0, 0.5), rtol=1e-8)
        angles.append(run.joint_coordinates(name)[-1])
    assert len(asked) == 50
    np.testing.assert_allclose(*angles, rtol=0, atol=1e-12)


def test_defaults_hold_the_values_of_a_loop() -> None:
    """The idiom ``lambda t, k=k: ...``: all that is compiled in a loop would else see the last value."""
    amplitudes = np.array([3.0, 2.0])

    def end(function: Any, **options: Any) -> float:
        scene = kf.System()
        hub = scene.add_rigid_body("hub", 1.0, 1.0, joint=kf.Revolute("z", position=1.0))
        scene.add_motor(hub, kf.compiled(function, **options))
        return float(scene.simulate((0.0, 1.0), rtol=1e-9).joint_coordinates("hub")[-1, 0])

    for k in (2.0, 3):
        assert end(lambda t, k=k: 1.0 * k) == pytest.approx(1.0 + 0.5 * k)
        assert end(lambda t, y, k=k: -k * k * y[0]) == pytest.approx(np.cos(k))
    read = end(lambda t, x, a=amplitudes, c=2.0: -c * a[1] * x[0], reads="joint_coordinates hub")
    assert read == pytest.approx(np.cos(2.0))
    turn = kf.Motion(lambda t, c=2.0: c * t * t, lambda t, c=2.0: 2.0 * c * t, lambda t, c=2.0: 2.0 * c).compiled()
    scene = kf.System()
    scene.add_rigid_body("hub", 1.0, 1.0, joint=kf.Revolute("z", motion=turn))
    assert scene.simulate((0.0, 1.0)).joint_coordinates("hub")[-1] == pytest.approx(2.0)


def test_what_python_has_to_read_is_read_there() -> None:
    given = [sampled_bar(function, 0.0).copy() for function in (SUM_UP, sum_in_python)]
    for scene, function in zip(
        given, (kf.compiled(lambda t, r, m: 0.1 * r[0]), lambda t, r, m: 0.1 * r[0]), strict=True
    ):
        scene.add_controller("feels", function, every=5e-3, reads="acceleration bar/tip z", drives="motor bar")
    ours, theirs = (scene.simulate((0.0, 0.02)).controllers["feels"] for scene in given)
    np.testing.assert_allclose(ours.reads, theirs.reads, rtol=1e-8)
    assert abs(ours.reads).min() > 0.1


def writes(t: float, reads: Any) -> float:
    reads[0] = 1.0
    return 0.0


@pytest.mark.parametrize(
    ("function", "options", "words"),
    [
        (lambda t: unknown(t), {}, "kanefe.compiled cannot compile '<lambda>': .*'unknown' is not defined. Remedy"),  # noqa: F821
        (writes, {"reads": "joint_speeds rod"}, r"kanefe.compiled cannot compile 'writes': .*reads.copy\(\)"),
        (lambda: 1.0, {}, r"must be one of f\(t\); .* it takes 0 arguments"),
        (3.0, {}, "takes a function, not 3.0"),
        (np.sin, {}, "a function that is written in Python"),
        (lambda t: 1.0, {"reads": "joint_speeds rod"}, r"reads= belongs to f\(t, reads\)"),
        (lambda t: 1.0, {"memory": 2}, "memory of '<lambda>' must be a whole number"),
        (lambda t, r, m: 1.0, {"memory": -1}, "memory of '<lambda>' must be a whole number"),
    ],
)
def test_what_cannot_be_compiled_is_refused_at_the_door(function: Any, options: dict[str, Any], words: str) -> None:
    with pytest.raises(kf.ModelError, match=words):
        kf.compiled(function, **options)


def rod(motor: Any = None, **controller: Any) -> kf.System:
    scene = kf.System(gravity=(0, 0, -9.81))
    turned = scene.add_rigid_body("rod", 1.0, 0.1, com=(0.3, 0, 0), joint=kf.Revolute("y"))
    driven = kf.Revolute("y", motion=kf.Motion.steady(1.0))
    scene.add_rigid_body("driven", 1.0, 0.1, joint=driven)
    if motor is not None:
        scene.add_motor(turned, motor)
    if controller:
        scene.add_controller("pd", **{"every": 0.01, "reads": "joint_speeds rod", "drives": "motor rod"} | controller)
    return scene


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: rod(kf.compiled(lambda t, r: r[0], reads="position rod")), "there is no 'position'. Remedy: one of"),
        (lambda: rod(kf.compiled(lambda t, r: r[0], reads="joint_speeds rid")), "no body called 'rid'"),
        (lambda: rod(kf.compiled(lambda t, r, m: r[0])), r"the motor of 'rod' takes f\(t\) or f\(t, reads\)"),
        (lambda: rod(function=kf.compiled(lambda t, r, m: (1.0, 2.0))), "controller 'pd' gives 2 numbers for 1 drives"),
        (lambda: rod(function=kf.compiled(lambda t, r: 1.0, reads="joint_speeds rod")), "needs a function"),
        (
            lambda: rod(kf.compiled(lambda t, r: r[0], reads="joint_speeds driven")).simulate((0.0, 0.1)),
            "reads 'joint_speeds driven .* which is not in the state: a driven coordinate",
        ),
        (
            lambda: rod(kf.compiled(lambda t, r: (r[0], 0.0), reads="joint_speeds rod")).simulate((0.0, 0.1)),
            r"cannot be called as f\(t, reads\) that gives one number",
        ),
        (
            lambda: rod(kf.compiled(lambda t, r: r[3], reads="joint_speeds rod")).simulate((0.0, 0.1)),
            r"raised IndexError at t = 0 s: .* it reads 1 numbers: joint_speeds rod \[rad/s\]",
        ),
        (
            lambda: rod(kf.compiled(lambda t, r: np.log(r[0] - 1.0), reads="joint_speeds rod")).simulate((0.0, 0.1)),
            "the motor of 'rod' must give one finite number; at t = 0 s it gave nan",
        ),
        (
            lambda: rod(function=kf.compiled(lambda t, r, m: r[1])).simulate((0.0, 0.1)),
            "the compiled function of controller 'pd' raised IndexError: .* at t = 0 s",
        ),
        (
            lambda: rod(function=kf.compiled(lambda t, r, m: np.zeros(2))).simulate((0.0, 0.1)),
            r"controller 'pd' must give one finite number \(motor rod \[N m\]\); at t = 0 s it gave array",
        ),
    ],
)
def test_what_does_not_fit_its_place_is_named(make: Callable[[], Any], words: str) -> None:
    with pytest.raises(kf.ModelError, match=words):
        make()


def test_a_controller_that_turns_nan_ends_the_run_at_its_sample() -> None:
    function = kf.compiled(lambda t, r, m: np.sqrt(0.05 - t))
    with pytest.warns(kf.SimulationWarning, match=r"controller 'pd' must give one finite number .* at t = 0\.06 s"):
        result = rod(function=function).simulate((0.0, 0.1))
    assert len(result.controllers["pd"].times) == 6


def test_jacobians_have_what_compiled_functions_change(monkeypatch: pytest.MonkeyPatch) -> None:
    """Those of machine code, of Python, and differences of whole rates."""
    model = bar_with(HELD, PUSHED).freeze()
    python = bar_with(lambda t, state: held(t, read(state)), lambda t, state: pushed(t, (deflection(state),))).freeze()
    y = np.append(model.initial_state, (0.0, 0.0))
    y[:-2] += 1e-3 * np.random.default_rng(0).standard_normal(len(y) - 2)
    found = []
    for one in (model, python, python):
        dynamics = Dynamics(one)
        dynamics.rate(0.1, y)
        found.append(dynamics.jacobian(0.1, y))
        if len(found) == 2:
            monkeypatch.setattr(type(python.route), "derivatives", lambda *given: None)
    size = np.abs(found[0]).max(axis=1, keepdims=True)
    assert np.all(np.abs(found[0] - found[1]) <= 1e-12 * size)
    assert np.abs(found[0] - found[2]).max() > 0.0
    assert np.all(np.abs(found[0] - found[2]) <= 1e-6 * size)


def test_an_unstable_loop_is_told_as_in_python() -> None:
    told = []
    for function in (kf.compiled(lambda t, r, m: -60.0 * r[0]), lambda t, r, m: -60.0 * r[0]):
        with pytest.warns(kf.SimulationWarning, match="controller 'pd' now changes 'motor rod") as warned:
            rod(function=function).simulate((0.0, 3.0))
        told.append([str(warning.message) for warning in warned])
    assert told[0] == told[1]


def test_poles_of_the_sampled_loop_are_those_of_the_function_in_python() -> None:
    poles = []
    for function in (SUM_UP, sum_in_python):
        poles.append(np.sort_complex(kf.sampled_loop(sampled_bar(function, 0.4e-3), start=kf.equilibrium(bar())).poles))
    np.testing.assert_allclose(*poles, atol=1e-6)
