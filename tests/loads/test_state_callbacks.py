"""Loads as functions of time and state: what they see, how they are told apart, and what they may not give."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import kanefe as kf
from kanefe.errors import ModelError
from kanefe.kane.assemble import assemble
from kanefe.loads.functions import takes_state
from kanefe.states.kinematics import interface_motion, sweep_outward
from kanefe.states.state import State
from kanefe.tree.scene_state import SceneState
from loaded_scenes import tree
from scenes import chain_scene, flexible_scene, random_state

T = 0.3


@pytest.mark.parametrize("slopes", ["rotation-vector", "tait-bryan"])
def test_the_state_is_that_of_the_sweep(slopes: str) -> None:
    model = chain_scene(3, slopes).freeze()
    q, u = random_state(model, 4)
    full = model.all_speeds(T, u)
    motions = sweep_outward(model, T, q, full)
    state = SceneState(model, T, q, u, frames=motions)
    point = np.array((0.1, -0.2, 0.3))
    for body, G in zip(model.bodies, motions, strict=True):
        frames = [("", G)]
        if body.flexible:
            for n in body.flexible.body.interfaces:
                frames.append((n.name, interface_motion(G, n, body.flexible, q, full, model.slopes)))
        for interface, F in frames:
            where = (body.name, interface)
            assert state.position(*where) == pytest.approx(F.p_NoFo_N, abs=1e-14)
            assert state.position(*where, point) == pytest.approx(F.p_NoFo_N + F.A_NF @ point, abs=1e-14)
            assert state.velocity(*where) == pytest.approx(F.A_NF @ F.v, abs=1e-13)
            v = F.A_NF @ (F.v + np.cross(F.w, point))
            assert state.velocity(*where, point=point) == pytest.approx(v, abs=1e-13)
            assert state.rotation(*where) == pytest.approx(F.A_NF, abs=1e-14)
            assert state.angular_velocity(*where) == pytest.approx(F.w, abs=1e-13)
        assert state.joint_coordinates(body.name) == pytest.approx(body.joint_coordinates(T, q), abs=0)
        assert state.joint_speeds(body.name) == pytest.approx(full[body.speeds], abs=0)
    first = model.flexible_terms("first")
    assert np.array_equal(state.modal_coordinates("first"), q[first.eta])
    assert np.array_equal(state.modal_speeds("first"), u[first.speeds])
    assert state.time == T
    with pytest.raises(ModelError, match="no body called 'nobody'"):
        state.position("nobody")
    with pytest.raises(ModelError, match="no interface called 'side'"):
        state.velocity("first", "side")


def test_markers_are_seen_as_the_sweep_has_them() -> None:
    scene, bodies = tree(1)
    ends = (
        bodies["node"],
        bodies["tip"].frame((0.1, 0.2, 0.3), (1, 2, 3, 4)),
        bodies["nut"],
        scene.ground.frame((1, 2, 3)),
    )
    markers = [scene._marker(end, "end") for end in ends]
    model = scene.freeze()
    q, u = random_state(model, 4)
    full = model.all_speeds(T, u)
    motions = sweep_outward(model, T, q, full)
    state = SceneState(model, T, q, u, frames=motions)
    for marker in markers:
        expected = State(model, T, q, u).marker(marker).end
        for ours, theirs in zip(state.placed_marker(marker).end, expected, strict=True):
            assert ours == pytest.approx(theirs, abs=1e-12)


def test_what_a_callback_changes_in_its_answers_changes_nothing() -> None:
    model = chain_scene(3).freeze()
    q, u = random_state(model, 4)
    full = model.all_speeds(T, u)
    state = SceneState(model, T, q, u, frames=sweep_outward(model, T, q, full))
    before = q.copy(), full.copy(), state.rotation("base").copy()
    for array in (
        state.rotation("base"),
        state.angular_velocity("base"),
        state.position("base"),
        state.joint_speeds("tip"),
        state.joint_coordinates("tip"),
        state.modal_coordinates("first"),
        state.modal_speeds("first"),
    ):
        array[...] = 7.0
    assert np.array_equal(q, before[0])
    assert np.array_equal(full, before[1])
    assert np.array_equal(state.rotation("base"), before[2])


def test_a_controlled_joint_moves_as_with_the_spring_that_its_motor_imitates() -> None:
    k, c, J = 5.0, 0.4, 0.2
    scene = kf.System()
    arm = scene.add_rigid_body("arm", 1.0, J, joint=kf.Revolute("z", position=0.5))
    scene.add_motor(arm, lambda t, state: -k * state.joint_coordinates("arm")[0] - c * state.joint_speeds("arm")[0])
    result = scene.simulate((0.0, 2.0), rtol=1e-9)
    decay, t = c / (2 * J), result.times
    w = math.sqrt(k / J - decay**2)
    exact = 0.5 * np.exp(-decay * t) * (np.cos(w * t) + decay / w * np.sin(w * t))
    assert result.joint_coordinates("arm")[:, 0] == pytest.approx(exact, abs=1e-7)
    assert abs(result.energy.balance_error).max() < 1e-7
    assert result.energy.work.max() > 0.1


def test_functions_of_time_and_of_state_may_stand_side_by_side() -> None:
    loads: list[Any] = [lambda t: (1.0, t, 0.0), lambda t, state: (1.0, state.time, 0.0)]
    sides = []
    for load in loads:
        scene = flexible_scene(0, loads=False)
        from kanefe.scene.scene import RigidBody

        hub = RigidBody(scene, 0, "hub")
        scene.add_force(hub, load, follows=True)
        scene.add_torque(hub.frame(orientation=(0.9, 0.1, 0.2, 0.3)), load, follows=True)
        model = scene.freeze()
        assert [x.takes_state for x, _ in model.bodies[0].loads] == [load is loads[1]] * 2
        sides.append(assemble(State(model, T, *random_state(model, 1)))[1])
    assert sides[0] == pytest.approx(sides[1], abs=1e-15)


class Controller:
    def __call__(self, t: float, state: SceneState) -> float:
        return 1.0

    def method(self, t: float) -> float:
        return 1.0


@pytest.mark.parametrize(
    ("function", "expected"),
    [
        (lambda t: 1.0, False),
        (lambda t, state: 1.0, True),
        (lambda t, gain=3.0: gain, False),
        (lambda t, state, gain=3.0: gain, True),
        (lambda *arguments: 1.0, False),
        (math.sin, False),
        (np.sin, False),
        (Controller(), True),
        (Controller().method, False),
        (functools.partial(lambda gain, t, state: gain, 2.0), True),
    ],
)
def test_functions_are_told_apart_by_what_they_must_be_given(function: Any, expected: bool) -> None:
    assert takes_state(function, "f") is expected


@pytest.mark.parametrize(
    "function", [lambda: 1.0, lambda t, state, more: 1.0, lambda t, *, state: 1.0], ids=["none", "three", "keyword"]
)
def test_functions_of_anything_else_are_refused(function: Any) -> None:
    scene = kf.System()
    hub = scene.add_rigid_body("hub", 1.0, 0.1, joint=kf.Revolute("z"))
    for add, what in ((scene.add_force, "force on"), (scene.add_torque, "torque on"), (scene.add_motor, "motor of")):
        with pytest.raises(ModelError, match=rf"the {what} 'hub' must be a function of time, f\(t\), or of time and"):
            add(hub, function)


@pytest.mark.parametrize(
    ("add", "function", "message"),
    [
        ("add_force", lambda t, state: (1.0, 2.0), r"the force on 'hub' must give three finite numbers; at t = 0 s it"),
        ("add_force", lambda t, state: np.full(3, np.nan), "the force on 'hub' must give three finite numbers; at t"),
        (
            "add_torque",
            lambda t, state: 1.0,
            r"the torque on 'hub' must give three .* gave 1\.0\. Remedy: add_motor for",
        ),
        ("add_torque", lambda t, state: "much", "the torque on 'hub' must give three finite .* gave 'much'"),
        ("add_force", lambda t, state: (0.0, 1j, 0.0), "the force on 'hub' must give three finite .* 1j"),
        ("add_motor", lambda t, state: (1.0, 2.0), "the motor of 'hub' must give one finite number; at t = 0 s it"),
        ("add_motor", lambda t: np.inf, "the motor of 'hub' must give one finite number; at t = 0 s it gave"),
    ],
)
def test_what_a_function_gives_wrongly_is_named_with_the_time(add: str, function: Any, message: str) -> None:
    scene = kf.System()
    hub = scene.add_rigid_body("hub", 1.0, 0.1, joint=kf.Revolute("z"))
    getattr(scene, add)(hub, function)
    with pytest.raises(ModelError, match=message):
        scene.simulate((0.0, 1.0))


def test_a_motor_needs_a_free_coordinate() -> None:
    scene = kf.System()
    sleeve = scene.add_rigid_body("sleeve", 1.0, 0.1, joint=kf.Cylindrical("z", motion=(kf.Motion.steady(1.0), None)))
    ball = scene.add_rigid_body("ball", 1.0, 0.1, joint=kf.Free())
    scene.add_motor(sleeve, 2.0, coordinate=1)
    with pytest.raises(
        ModelError, match=r"coordinate 0 of its cylindrical joint is not one .* There are: 1 \(angle \[rad\]\)"
    ):
        scene.add_motor(sleeve, 2.0)
    with pytest.raises(ModelError, match=r"coordinate 0 of its free joint is not one .* There are: none"):
        scene.add_motor(ball, 2.0)
    with pytest.raises(ModelError, match="the motor of 'sleeve' must be a finite number, not 'much'"):
        scene.add_motor(sleeve, "much", coordinate=1)
    model = scene.freeze()
    du = np.linalg.solve(*assemble(State(model, 0.0, model.initial_coordinates, model.initial_speeds)))
    assert du[0] == pytest.approx(2.0 / 0.1)


def compiled_scene(force: Callable, motor: Callable) -> kf.System:
    scene = kf.System(gravity=(0, 0, -9.81))
    rod = scene.add_rigid_body("rod", 1.0, 1 / 12, com=(0.5, 0, 0), joint=kf.Revolute("y"))
    tip = scene.add_rigid_body("tip", 1.0, 1 / 12, com=(0.5, 0, 0), joint=kf.Revolute("z"), parent=rod)
    scene.add_force(rod, force, point=(1, 0, 0))
    scene.add_motor(tip, motor)
    return scene


def test_functions_compiled_by_numba_stay_in_compiled_steps() -> None:
    """They take the state as an array; the run never comes back to Python, and is the one of plain functions."""
    numba = pytest.importorskip("numba")

    def force(t: float, y: np.ndarray) -> tuple[float, float, float]:
        return -0.1 * y[2], np.sin(t), 0.0

    def motor(t: float) -> float:
        return np.cos(t)

    compiled = compiled_scene(numba.njit(force), numba.njit(motor))
    python = compiled_scene(lambda t, state: force(t, state.vector), motor)
    ends = []
    for scene in (compiled, python):
        result = scene.simulate((0.0, 1.0), method="rk4", step=0.01, output_step=0.5)
        ends.append(np.concatenate((result.joint_coordinates("tip")[-1], result.joint_speeds("rod")[-1])))
    np.testing.assert_allclose(ends[0], ends[1], rtol=0, atol=1e-13)  # round-off of 400 evaluations
    assert compiled.freeze().route.is_autonomous
    assert not python.freeze().route.is_autonomous


def test_a_compiled_function_that_turns_nan_is_named() -> None:
    numba = pytest.importorskip("numba")
    scene = compiled_scene(numba.njit(lambda t: (0.0, 0.0, np.sqrt(0.5 - t))), lambda t: 0.0)
    with pytest.warns(kf.SimulationWarning, match=r"the force on 'rod' must give three finite numbers; at t = 0\.5"):
        scene.simulate((0.0, 1.0), method="rk4", step=0.01)


def compiled_motor(function: Callable[..., Any]) -> kf.System:
    numba = pytest.importorskip("numba")
    scene = kf.System()
    rod = scene.add_rigid_body("rod", 1.0, 0.1, joint=kf.Revolute("y", position=0.3))
    scene.add_motor(rod, numba.njit(function))
    return scene


@pytest.mark.parametrize(
    ("function", "words"),
    [
        (lambda t, y: y.angle, r"of the motor of 'rod' cannot be called as f\(t, y\) .* one number: Unknown attribute"),
        (lambda t, y: np.zeros(2), "of the motor of 'rod' cannot be called"),
        (lambda t: (0.0, 1.0), r"cannot be called as f\(t\) that gives one number"),
        (lambda t, y: y[2], r"of the motor of 'rod' raised IndexError at t = 0 s: .* the state y has 2 entries"),
    ],
)
def test_what_is_wrong_with_a_compiled_function_is_named(function: Callable[..., Any], words: str) -> None:
    scene = compiled_motor(function)
    with pytest.raises(ModelError, match=words):
        scene.simulate((0.0, 1.0))


def raises_late(t: float) -> float:
    if t > 0.5:
        raise ValueError("too late")
    return 0.0


def reads_beyond_late(t: float, y: Any) -> float:
    return float(y[0 if t < 0.5 else 2])


@pytest.mark.parametrize(("function", "words"), [(raises_late, "too late"), (reads_beyond_late, "IndexError")])
@pytest.mark.parametrize("method", ["rk4", "radau5"])
def test_what_a_compiled_function_raises_ends_the_run(
    function: Callable[..., Any], words: str, method: str, capfd: pytest.CaptureFixture[str]
) -> None:
    """Machine code cannot raise to its caller: before, the run went on with the value of before."""
    scene, step = compiled_motor(function), 0.01 if method == "rk4" else None
    with pytest.warns(kf.SimulationWarning, match=f"of the motor of 'rod' raised .*{words}"):
        result = scene.simulate((0.0, 1.0), method=method, step=step)
    assert result.times[-1] == pytest.approx(0.5, abs=0.03)
    assert "Exception ignored" not in capfd.readouterr().err


@pytest.mark.parametrize("read", ["position", "rotation", "velocity"])
def test_a_body_is_named_by_a_text(read: str) -> None:
    scene = kf.System()
    rod = scene.add_rigid_body("rod", 1.0, 0.1, joint=kf.Revolute("z"))
    scene.add_motor(rod, lambda t, state: getattr(state, read)({})[0])
    with pytest.raises(ModelError, match=r"named by texts, not \{\} and ''"):
        scene.simulate((0.0, 0.1))


def test_a_compiled_function_that_writes_to_the_state_is_refused() -> None:
    """In compiled code it would write to the state of the run."""
    numba = pytest.importorskip("numba")

    def writes(t, y):
        y[:] += 1.0
        return 0.0

    def works_on_a_copy(t, y):
        own = y.copy()
        own[:] += 1.0
        return 0.0 * own[0]

    def pushed(function: Any) -> kf.System:
        scene = kf.System()
        scene.add_motor(scene.add_rigid_body("rod", 1.0, 0.1, joint=kf.Revolute("z")), numba.njit(function))
        return scene

    assert pushed(works_on_a_copy).simulate((0.0, 0.1)).joint_coordinates("rod")[-1] == 0.0
    with pytest.raises(ModelError, match=r"motor of 'rod' takes the state y only if .*Remedy: let it work on a copy"):
        pushed(writes).simulate((0.0, 0.1))
