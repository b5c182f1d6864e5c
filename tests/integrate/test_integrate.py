"""Time integration: orders, stiff modes at large steps, rotations, drives, and what is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import kanefe as kf
from kanefe.errors import ModelError, SimulationError, SimulationWarning
from kanefe.integrate.auto.stiffest_rate import stiffest_rate
from kanefe.integrate.methods.table import METHODS
from kanefe.integrate.run import integrate
from kanefe.kane.energy import kinetic_energy, momenta
from kanefe.states.state import State
from run_scenes import ADAPTIVE, PLUGGED, SCENES, double_pendulum, soft_arm, tumbling
from scenes import lattice_body
from steel_beams import steel_bar


def final(scene: kf.System, span: tuple[float, float] = (0.0, 1.0), **options: Any) -> np.ndarray:
    run = integrate(scene.freeze(), span, output_step=span[1] - span[0], **options)
    return run.coordinates[-1]


@pytest.mark.parametrize("scene", SCENES)
def test_generalised_alpha_is_of_order_two(scene: str) -> None:
    make = SCENES[scene]
    reference = final(make(), rtol=1e-12, method="dop853")
    tolerances = np.array([1e-6, 1e-7, 1e-8])
    runs = [
        integrate(make().freeze(), (0.0, 1.0), output_step=1.0, rtol=r, method="generalised-alpha") for r in tolerances
    ]
    errors = np.array([abs(run.coordinates[-1] - reference).max() for run in runs])
    steps = np.array([run.statistics["steps"] for run in runs])
    # The step follows a local error h^3 ~ rtol of an order-2 method: steps ~ rtol^(-1/3), error ~ rtol^(2/3).
    # A start with small steps and the end on the last output blur the count of steps by some percent.
    assert np.polyfit(np.log(tolerances), np.log(steps), 1)[0] == pytest.approx(-1 / 3, abs=0.04)
    assert np.polyfit(np.log(tolerances), np.log(errors), 1)[0] == pytest.approx(2 / 3, abs=0.05)
    assert np.polyfit(np.log(steps), np.log(errors), 1)[0] == pytest.approx(-2.0, abs=0.25)


@pytest.mark.parametrize("scene", SCENES)
def test_dop853_reaches_its_tolerance(scene: str) -> None:
    make = SCENES[scene]
    reference = final(make(), rtol=1e-13, method="dop853")
    errors = np.array([abs(final(make(), rtol=r, method="dop853") - reference).max() for r in (1e-5, 1e-7, 1e-9)])
    # some ten steps each add at most their tolerance
    assert np.all(errors < [1e-4, 1e-6, 1e-8])
    assert errors[2] < 1e-2 * errors[0]


def test_generalised_alpha_steps_over_elastic_modes_of_100_kilohertz() -> None:
    scene = steel_bar()
    model = scene.freeze()
    assert stiffest_rate(model, 0.0) > 2 * np.pi * 1e5
    run = integrate(model, (0.0, 0.5), rtol=1e-4, method="generalised-alpha", output_step=0.05)
    # An explicit method would need 0.5 s * 2 pi * 1e5 Hz / 2 = 160,000 steps.
    assert run.statistics["steps"] < 150
    assert run.statistics["evaluations"] < 1000
    # A physical pendulum: theta'' = m g L/2 / (m L^2/3 + rotary inertia) cos(theta); the bar barely bends.
    rigid = kf.System(gravity=(0.0, 0.0, -9.81))
    body = model.bodies[0].flexible.body
    c = body.center_of_mass
    about_com = body.inertia - body.mass * (c @ c * np.eye(3) - np.outer(c, c))
    rigid.add_rigid_body("bar", body.mass, about_com, com=c, joint=kf.Revolute("y"))
    angle = final(rigid, (0.0, 0.5), rtol=1e-10, method="dop853")
    # rtol 1e-4 of an order-2 method over half a swing; deflection is 1e-5 m
    assert run.coordinates[-1][0] == pytest.approx(angle[0], abs=2e-3)


def test_auto_takes_the_implicit_method_for_stiff_bodies_only() -> None:
    soft = integrate(soft_arm().freeze(), (0.0, 0.2), rtol=1e-4)
    assert soft.statistics["method"] == "dop853"
    stiff = integrate(steel_bar(damping=kf.ModalDamping(0.01)).freeze(), (0.0, 0.1), rtol=1e-3, output_step=0.1)
    assert stiff.statistics["method"] == "extrapolation"
    assert "Hz are stiff over 0.1 s" in stiff.statistics["reason"]
    # the same bar over an instant is not stiff
    assert integrate(steel_bar().freeze(), (0.0, 1e-4), rtol=1e-3, output_step=1e-4).statistics["method"] == "dop853"
    assert integrate(double_pendulum().freeze(), (0.0, 0.2)).statistics["reason"] == "no stiff elastic modes"


@pytest.mark.parametrize("method", ADAPTIVE)
def test_rotations_stay_rotations(method: str) -> None:
    model = tumbling().freeze()
    run = integrate(model, (0.0, 3.0), rtol=1e-6, method=method, output_step=0.5)
    lengths = np.linalg.norm(run.coordinates[:, 3:], axis=1)
    # on the group: exact; parameters integrated freely: their length drifts with the tolerance, and is not used
    assert lengths == pytest.approx(np.ones(len(lengths)), abs=1e-14 if method == "generalised-alpha" else 1e-4)
    for q, u in zip(run.coordinates, run.speeds, strict=True):
        _, angular = momenta(State(model, 0.0, q, u))
        # the middle axis is unstable: the body turns over meanwhile, and errors of 1e-6 a step grow
        assert angular == pytest.approx(momenta(State(model, 0.0, run.coordinates[0], run.speeds[0]))[1], abs=2e-2)


def test_translation_of_a_free_body_is_uniform() -> None:
    run = integrate(tumbling().freeze(), (0.0, 1.0), rtol=1e-3, method="generalised-alpha", output_step=0.5)
    assert run.coordinates[:, 0] == pytest.approx(run.times, abs=1e-12)  # linear in time: exact at any step


@pytest.mark.parametrize("method", ADAPTIVE)
def test_a_driven_joint_reproduces_its_motion_and_tells_its_torque(method: str) -> None:
    motion = kf.Motion(lambda t: 0.4 * np.sin(3 * t), lambda t: 1.2 * np.cos(3 * t), lambda t: -3.6 * np.sin(3 * t))
    scene = kf.System(gravity=(0.0, -9.81, 0.0))
    scene.add_rigid_body("rod", 2.0, 0.3, com=(0.5, 0, 0), joint=kf.Revolute("z", motion=motion))
    scene.add_rigid_body("other", 1.0, 0.1, joint=kf.Revolute("z", speed=1.0))  # something for the method to integrate
    result = scene.simulate((0.0, 1.0), rtol=1e-6, method=method, output_step=0.1)
    t = result.times
    theta = 0.4 * np.sin(3 * t)
    assert result.joint_coordinates("rod")[:, 0] == pytest.approx(theta, abs=1e-14)
    assert result.joint_speeds("rod")[:, 0] == pytest.approx(1.2 * np.cos(3 * t), abs=1e-14)
    torque = (0.3 + 2.0 * 0.25) * -3.6 * np.sin(3 * t) + 2.0 * 9.81 * 0.5 * np.cos(theta)
    assert result.driving_force("rod").ravel() == pytest.approx(torque, abs=1e-12)
    lifted = 2.0 * 9.81 * 0.5 * (np.sin(theta) - np.sin(theta[0]))
    kinetic = 0.5 * 0.8 * (1.2 * np.cos(3 * t)) ** 2
    # work is integrated by the method: order 8 at rtol 1e-6, or the trapezoidal rule of an order-2 method
    tolerance = 1e-6 if method == "dop853" else 0.05
    assert result.energy.work == pytest.approx(lifted + kinetic - kinetic[0], abs=tolerance)


def test_a_scene_that_is_driven_all_through_needs_no_integration() -> None:
    scene = kf.System()
    scene.add_rigid_body("rotor", 1.0, 0.2, joint=kf.Revolute("z", motion=kf.Motion.steady(5.0)))
    for method in ADAPTIVE:
        result = scene.simulate((0.0, 1.0), method=method, output_step=0.25)
        assert result.joint_coordinates("rotor")[:, 0] == pytest.approx([0, 1.25, 2.5, 3.75, 5.0], abs=1e-14)
        assert result.driving_force("rotor").ravel() == pytest.approx(np.zeros(5), abs=1e-14)


@pytest.mark.parametrize("method", ADAPTIVE)
def test_time_starts_where_the_span_does(method: str) -> None:
    # theta'' = t / I: an explicit function of time
    scene = kf.System()
    wheel = scene.add_rigid_body("wheel", 1.0, 0.5, joint=kf.Revolute("z"))
    scene.add_torque(wheel, lambda t: t)
    run = integrate(scene.freeze(), (2.0, 3.0), rtol=1e-8, method=method, output_step=0.25)
    assert run.times == pytest.approx([2.0, 2.25, 2.5, 2.75, 3.0], abs=1e-15)
    s = run.times - 2.0
    exact = (s**3 / 6 + s**2) / 0.5
    assert run.coordinates[:, 0] == pytest.approx(exact, abs=1e-11 if method == "dop853" else 1e-5)
    speed = (s**2 / 2 + 2 * s) / 0.5
    assert run.work == pytest.approx(0.25 * speed**2, abs=1e-9 if method == "dop853" else 1e-4)


@pytest.mark.parametrize("method", ADAPTIVE)
@pytest.mark.parametrize(("step", "expected"), [(0.25, 5), (0.3, 5), (2.0, 2), (None, 501)])
def test_states_are_stored_at_the_times_asked_for(method: str, step: float | None, expected: int) -> None:
    run = integrate(double_pendulum().freeze(), (0.0, 1.0), rtol=1e-3, method=method, output_step=step)
    assert len(run.times) == len(run.coordinates) == len(run.speeds) == len(run.work) == expected
    assert (run.times[0], run.times[-1]) == (0.0, 1.0)
    if step == 0.3:
        assert run.times == pytest.approx([0.0, 0.3, 0.6, 0.9, 1.0], abs=1e-15)


@pytest.mark.parametrize("method", ADAPTIVE)
def test_stored_states_do_not_depend_on_how_many_are_stored(method: str) -> None:
    few = integrate(double_pendulum().freeze(), (0.0, 1.0), rtol=1e-7, method=method, output_step=0.5)
    many = integrate(double_pendulum().freeze(), (0.0, 1.0), rtol=1e-7, method=method, output_step=0.01)
    # dense output of order 7, or steps that end on the outputs: both within the tolerance of the method
    assert many.coordinates[::50] == pytest.approx(few.coordinates, abs=1e-5)


def test_statistics_say_what_was_done() -> None:
    run = integrate(double_pendulum().freeze(), (0.0, 1.0), rtol=1e-5, method="generalised-alpha")
    assert run.statistics["method"] == "generalised-alpha"
    assert run.statistics["reason"] == "asked for"
    assert run.statistics["rtol"] == 1e-5
    assert run.statistics["steps"] >= 50
    assert run.statistics["evaluations"] >= run.statistics["steps"]
    assert run.statistics["rejected"] >= 0
    assert run.statistics["seconds"] > 0


def test_a_scene_at_rest_stays_at_rest() -> None:
    scene = kf.System()
    scene.add_flexible_body("arm", lattice_body(0), joint=kf.Free())
    for method in ADAPTIVE:
        run = integrate(scene.freeze(), (0.0, 1.0), method=method, output_step=0.5)
        assert np.array_equal(run.coordinates, np.tile(run.coordinates[0], (3, 1)))
        assert kinetic_energy(State(scene.freeze(), 0.0, run.coordinates[-1], run.speeds[-1])) == 0.0


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"t_span": (1.0, 0.0)}, r"t_span \(1\.0, 0\.0\) must run forward: two finite times, the end after the start"),
        ({"t_span": (0.0, 0.0)}, "must run forward"),
        ({"t_span": (0.0, np.inf)}, "must run forward"),
        ({"t_span": (np.nan, 1.0)}, "must run forward"),
        ({"t_span": 5.0}, r"t_span must be two times in s, such as \(0\.0, 5\.0\), not 5\.0"),
        ({"t_span": (0.0, 1.0, 2.0)}, r"t_span must be two times .*, not 3\. Remedy: output_times="),
        ({"rtol": 0.0}, r"rtol must lie between 0 and 1, not 0\.0"),
        ({"rtol": -1e-6}, "rtol must lie between 0 and 1"),
        ({"rtol": np.nan}, "rtol must lie between 0 and 1, not nan"),
        ({"rtol": 1.0}, "rtol must lie between 0 and 1"),
        (
            {"method": "euler"},
            rf"there is no method 'euler'\. Remedy: auto, {', '.join(sorted(METHODS))}",
        ),
        ({"method": "rk4"}, "rk4 needs a step in s"),
        ({"method": "rk4", "step": 0.0}, r"step must be above zero s and within the span, not 0\.0"),
        ({"method": "rk4", "step": np.nan}, "step must be above zero s and within the span, not nan"),
        ({"method": "rk4", "step": 2.0}, r"step must be above zero s and within the span, not 2\.0"),
        ({"method": "rk4", "step": 0.1, "rtol": 1e-6}, "rtol has no meaning for rk4, whose steps are fixed"),
        ({"method": "rk4", "step": 0.1, "atol": 1e-6}, "atol has no meaning for rk4, which has no error control"),
        ({"method": "extrapolation", "rtol": 1e-10}, "rtol=1e-10 is below the round-off of extrapolation"),
        ({"rtol": 1e-30}, r"rtol=1e-30 is below the round-off of dop853\. Remedy: 3e-14 or more$"),
        ({"output_step": 0.0}, r"output_step must be above zero s, not 0\.0"),
        ({"output_step": np.nan}, "output_step must be above zero s, not nan"),
        ({"output_step": 1e-12}, r"output_step of 1e-12 s asks for 1e\+12 states\. Remedy: a larger one"),
        ({"output_step": "0.1"}, "output_step must be above zero s, not '0.1'"),
        ({"rtol": "1e-6"}, "rtol must lie between 0 and 1, not '1e-6'"),
        ({"step": "0.1", "method": "rk4"}, "step must be above zero s and within the span, not '0.1'"),
        ({"atol": 0.0}, r"atol must be above zero, not 0\.0"),
        (
            {"atol": 1e-9, "method": "generalised-alpha"},
            "atol has no meaning for generalised-alpha.* Remedy: leave it out",
        ),
    ],
)
def test_bad_options_are_named(options: dict, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        integrate(double_pendulum().freeze(), **{"t_span": (0.0, 1.0), **options})


@pytest.mark.parametrize("method", ADAPTIVE)
def test_a_tolerance_below_round_off_is_refused(method: str) -> None:
    with pytest.raises(ModelError, match=f"rtol=1e-30 is below the round-off of {method}"):
        integrate(double_pendulum().freeze(), (0.0, 1.0), method=method, rtol=1e-30)


@pytest.mark.parametrize("method", ADAPTIVE)
def test_motion_without_inertia_is_named(method: str) -> None:
    scene = kf.System()
    hub = scene.add_rigid_body("hub", 1.0, 0.1, joint=kf.Revolute("z"))
    scene.add_rigid_body("pin", 0.0, 0.0, parent=hub, joint=kf.Revolute("x"))
    with pytest.raises(
        SimulationError, match=r"mass matrix is singular: .* pin: rate \[rad/s\]\. Remedy: give a body there"
    ):
        scene.simulate((0.0, 1.0), method=method)


@pytest.mark.parametrize("method", ADAPTIVE)
@pytest.mark.parametrize("kind", ["force", "torque", "motor"])
def test_a_load_that_turns_nan_is_named_with_its_time(kind: str, method: str) -> None:
    scene = kf.System()
    wheel = scene.add_rigid_body("wheel", 1.0, 0.5, joint=kf.Revolute("z"))

    def load(t: float) -> Any:
        value = 1.0 if t < 0.5 else np.nan
        return value if kind == "motor" else (0.0, 0.0, value)

    (scene.add_force if kind == "force" else scene.add_torque)(wheel, load)
    named = (
        rf"the {'force' if kind == 'force' else 'torque'} on 'wheel' must give .* at t = 0\.[5-9]\d* s it gave .*nan"
    )
    with pytest.warns(SimulationWarning, match=named):
        result = scene.simulate((0.0, 1.0), method=method)
    assert result.status.kind == "failed"
    assert 0.1 < result.times[-1] < 0.5 + 1e-12  # what was computed before is there


@pytest.mark.parametrize("method", ADAPTIVE)
@pytest.mark.parametrize("which", ["position", "velocity", "acceleration"])
def test_a_motion_that_turns_nan_is_named_with_its_time(which: str, method: str) -> None:
    functions = {"position": lambda t: t, "velocity": lambda t: 1.0, "acceleration": lambda t: 0.0}
    sound = functions[which]
    functions[which] = lambda t: sound(t) if t < 0.5 else np.nan
    scene = kf.System()
    hub = scene.add_rigid_body("hub", 1.0, 0.5, joint=kf.Revolute("z", motion=kf.Motion(**functions)))
    scene.add_rigid_body("arm", 1.0, 0.5, parent=hub, at=(1, 0, 0), com=(0.5, 0, 0), joint=kf.Revolute("z", speed=1.0))
    with pytest.warns(SimulationWarning, match=rf"motion of body 'hub'.* {which} at t = 0\.[5-9]\d* s"):
        result = scene.simulate((0.0, 1.0), method=method)
    assert result.status.kind == "failed"


@pytest.mark.parametrize("method", [*ADAPTIVE, *PLUGGED])
def test_an_error_of_a_user_s_function_ends_the_run_by_every_method(method: str) -> None:
    scene = kf.System()
    wheel = scene.add_rigid_body("wheel", 1.0, 0.5, joint=kf.Revolute("z"))

    def table(t: float) -> float:
        if t > 0.3:
            raise LookupError("the table ends at 0.3 s")
        return 1.0

    scene.add_torque(wheel, table)
    message = r"torque on 'wheel' at t = 0\.[3-9]\d* s raised LookupError: the table ends at 0\.3 s \(table, line"
    with pytest.warns(SimulationWarning, match=message):
        result = scene.simulate((0.0, 1.0), method=method)
    assert result.status.kind == "failed"
    assert 0.0 < result.times[-1] <= 0.3
    assert result.joint_speeds("wheel")[-1, 0] == pytest.approx(2.0 * result.times[-1], rel=1e-4)  # 1 N m, 0.5 kg m2


@pytest.mark.parametrize("method", ADAPTIVE)
def test_a_load_without_bound_ends_the_run_with_advice(method: str) -> None:
    scene = kf.System()
    wheel = scene.add_rigid_body("wheel", 1.0, 0.5, joint=kf.Revolute("z"))
    scene.add_torque(wheel, lambda t: 1.0 if t < 0.5 else 1e100)
    with pytest.warns(SimulationWarning, match=r"at t = 0\.(5|49\d*) s.* 'wheel: .*\. Remedy: check loads"):
        result = scene.simulate((0.0, 1.0), method=method, rtol=1e-6)
    with pytest.raises(SimulationError, match="the run failed at t = 0"):
        result.raise_for_status()
    assert np.all(np.isfinite(result.joint_coordinates("wheel")))


def test_no_progress_bar_off_a_terminal(capsys: pytest.CaptureFixture) -> None:
    double_pendulum().simulate((0.0, 0.1))
    assert capsys.readouterr().err == ""
    double_pendulum().simulate((0.0, 0.1), progress=True)
    assert "simulate" in capsys.readouterr().err


def test_fixed_steps_are_of_order_four() -> None:
    exact = double_pendulum().simulate((0.0, 1.0), rtol=1e-12, method="dop853")
    errors = []
    for step in (0.04, 0.02):
        result = double_pendulum().simulate((0.0, 1.0), method="rk4", step=step)
        # and one at the end, for the states within the last step
        assert result.statistics["evaluations"] == 4 * round(1.0 / step) + 1
        errors.append(np.abs(result.position("second")[-1] - exact.position("second")[-1]).max())
    assert 8.0 < errors[0] / errors[1] < 32.0  # 2^4: neither order 3 nor 5


def test_fixed_steps_are_the_same_compiled_and_in_python() -> None:
    """A load of zero that is a function of time keeps the steps out of compiled code."""
    compiled, python = double_pendulum(), double_pendulum()
    ball = python.add_rigid_body("ball", 1.0, 0.1, joint=kf.Free())
    python.add_force(ball, lambda t: np.zeros(3))
    ends = [scene.simulate((0.0, 1.0), method="rk4", step=0.01).position("second")[-1] for scene in (compiled, python)]
    np.testing.assert_allclose(ends[0], ends[1], rtol=0, atol=1e-13)  # round-off of 400 evaluations
