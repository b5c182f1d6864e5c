"""Springs and bushings between frames: closed forms, what they take from the start, and bad input."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import kanefe as kf
from kanefe.errors import ModelError, SimulationError
from kanefe.frames import rotation_matrix
from kanefe.kane.assemble import accelerations
from kanefe.kane.energy import elastic_energy
from kanefe.states.state import State
from scenes import derivatives, lattice_body


@pytest.mark.parametrize("method", ["dop853", "generalised-alpha"])
def test_two_points_on_a_spring_swing_about_their_middle(method: str) -> None:
    m1, m2, k, c, rest = 1.0, 3.0, 80.0, 0.9, 0.5
    scene = kf.System()
    one = scene.add_point("one", m1)
    two = scene.add_point("two", m2, at=(0.6, 0.0, 0.0))
    scene.add_spring("s", one, two, stiffness=k, damping=c, rest_length=rest)
    result = scene.simulate((0.0, 1.0), rtol=1e-8, method=method)
    m = m1 * m2 / (m1 + m2)
    decay = c / (2 * m)
    w, t = math.sqrt(k / m - decay**2), result.times
    exact = rest + 0.1 * np.exp(-decay * t) * (np.cos(w * t) + decay / w * np.sin(w * t))
    length = result.position("two")[:, 0] - result.position("one")[:, 0]
    assert length == pytest.approx(exact, abs=1e-5)  # of either method at 1e-8 a step
    assert result.energy.elastic[0] == pytest.approx(0.5 * k * 0.1**2, rel=1e-12)
    assert abs(result.energy.balance_error).max() < k * 0.1 * 1e-5  # what that is of the spring's energy
    assert result.energy.dissipated[-1] > 0.05


def test_a_spring_without_a_rest_length_is_slack_at_the_start() -> None:
    scene = kf.System()
    ball = scene.add_point("ball", 1.0, joint=kf.Translation(position=(0.0, 3.0, 4.0)))
    scene.add_spring("s", scene.ground, ball, stiffness=10.0)
    model = scene.freeze()
    assert model.loads[0].rest_length == 5.0
    assert accelerations(State(model, 0.0, model.initial_coordinates, model.initial_speeds)) == pytest.approx(
        np.zeros(3)
    )


@pytest.mark.parametrize(
    ("force", "expected"),
    [
        (([0.5, 1.0, 2.0], [-3.0, 0.0, 8.0]), lambda x: np.interp(x, [0.5, 1.0, 2.0], [-3.0, 0.0, 8.0])),
        (lambda length, rate: 4.0 * (length - 0.7) ** 3 + 0.1 * rate, lambda x: 4.0 * (x - 0.7) ** 3),
    ],
    ids=["table", "function"],
)
def test_tables_and_functions_give_the_tension(force: Any, expected: Callable[[float], float]) -> None:
    for x in (0.5, 0.8, 1.0, 1.7, 2.0):
        scene = kf.System()
        ball = scene.add_point("ball", 2.0, joint=kf.Translation(position=(x, 0.0, 0.0)))
        scene.add_spring("s", scene.ground, ball, force=force)
        model = scene.freeze()
        du = accelerations(State(model, 0.0, model.initial_coordinates, model.initial_speeds))
        assert du == pytest.approx((-expected(x) / 2.0, 0.0, 0.0), abs=1e-14)


def test_a_table_goes_on_straight_beyond_its_ends() -> None:
    scene = kf.System()
    ball = scene.add_point("ball", 2.0, at=(1, 0, 0))
    scene.add_spring("s", scene.ground, ball, force=([0.5, 1.0, 2.0], [-3.0, 0.0, 8.0]))
    spring = scene.freeze().loads[0]
    assert spring.pull(0.0, 3.0, 0.0, np.zeros(0)) == pytest.approx(16.0)
    assert spring.pull(0.0, 0.25, 0.0, np.zeros(0)) == pytest.approx(-4.5)


def test_the_work_of_a_user_s_spring_is_booked() -> None:
    scene = kf.System()
    ball = scene.add_point("ball", 1.0, joint=kf.Translation(position=(0.3, 0.0, 0.2), velocity=(0.0, 1.0, 0.0)))
    scene.add_spring("s", scene.ground, ball, force=lambda length, rate: 30.0 * length**3 + 0.4 * rate, damping=0.1)
    result = scene.simulate((0.0, 1.0), rtol=1e-9)
    assert abs(result.energy.balance_error).max() < 1e-8
    assert abs(result.energy.work).max() > 1e-3
    assert result.energy.dissipated[-1] > 1e-3
    assert result.energy.elastic.max() == 0.0


def test_a_bushing_holds_in_six_directions() -> None:
    m, J = 2.0, np.array((0.1, 0.2, 0.25))
    K = np.array((50.0, 80.0, 30.0, 2.0, 3.0, 4.0))
    turn = (0.8, 0.1, 0.5, -0.3)
    scene = kf.System()
    body = scene.add_rigid_body("body", m, J, joint=kf.Free(), orientation=turn)
    scene.add_bushing("b", scene.ground.frame(orientation=turn), body, stiffness=K)
    model = scene.freeze()
    A = rotation_matrix(np.array(turn))
    small = 1e-6
    for i in range(6):
        step = np.zeros(6)
        step[i] = small
        q = model.advance(model.initial_coordinates, step)
        du = accelerations(State(model, 0.0, q, np.zeros(6)))
        expected = np.zeros(6)
        expected[i] = -K[i] * small / (m if i < 3 else J[i - 3])
        # beyond the first order: some K theta^2 = 1e-10; the joint measures translations in its frame F
        assert du == pytest.approx(expected, abs=1e-10)
    assert A.shape == (3, 3)


def test_the_moment_of_a_bushing_is_that_of_its_potential_at_any_angle() -> None:
    scene = kf.System()
    body = scene.add_rigid_body("body", 1.0, 1.0, joint=kf.Spherical())
    scene.add_bushing("b", scene.ground, body, stiffness=(0, 0, 0, 2.0, 3.0, 5.0))
    model = scene.freeze()
    for angles in ((0.4, -0.2, 0.7), (1.5, 1.0, -1.8), (0.0, 0.0, 3.0)):
        q = model.advance(model.initial_coordinates, np.array(angles))
        du = accelerations(State(model, 0.0, q, np.zeros(3)))  # unit inertia: the moment in the body's axes
        for i in range(3):
            step = np.eye(3)[i]
            slope, _ = derivatives(
                lambda s, step=step, q=q: np.array(elastic_energy(State(model, 0.0, model.advance(q, s * step)))), 0.01
            )
            assert du[i] == pytest.approx(-float(slope), abs=1e-9)


def test_a_force_of_a_bushing_turns_what_it_pushes_off_from() -> None:
    # both bodies are free: the couple of the two forces at a distance is balanced by a moment on a
    scene = kf.System()
    a = scene.add_rigid_body("a", 1.0, 1.0, joint=kf.Free())
    b = scene.add_rigid_body("b", 1.0, 1.0, joint=kf.Free(position=(0.5, 0.2, 0.0)))
    scene.add_bushing("pull", a, b, stiffness=(10.0, 0.0, 0.0))
    model = scene.freeze()
    du = accelerations(State(model, 0.0, model.initial_coordinates, model.initial_speeds))
    assert du[:6] == pytest.approx((5.0, 0, 0, 0, 0, -0.2 * 5.0), abs=1e-14)
    assert du[6:] == pytest.approx((-5.0, 0, 0, 0, 0, 0), abs=1e-14)


def test_a_law_sees_displacement_and_rates_in_the_axes_of_a() -> None:
    seen: dict[str, Any] = {}

    def law(d: np.ndarray, rate: np.ndarray) -> np.ndarray:
        seen.update(d=d.copy(), rate=rate.copy())
        return np.array((0.0, 0.0, 7.0, 0.0, 0.5, 0.0))

    turn = np.array((1.0, 1.0, 0.0, 0.0)) / math.sqrt(2)  # y of a is z of N
    scene = kf.System()
    joint = kf.Free(position=(0.1, 0.2, 0.3), velocity=(1.0, 2.0, 3.0), angular_velocity=(0.0, 0.0, 0.4))
    body = scene.add_rigid_body("body", 2.0, 0.5, joint=joint)
    scene.add_bushing("b", scene.ground.frame(orientation=turn), body, law=law)
    model = scene.freeze()
    du = accelerations(State(model, 0.0, model.initial_coordinates, model.initial_speeds))
    assert seen["d"] == pytest.approx((0.1, 0.3, -0.2, -math.pi / 2, 0.0, 0.0), abs=1e-14)
    assert seen["rate"] == pytest.approx((1.0, 3.0, -2.0, 0.0, 0.4, 0.0), abs=1e-14)
    # 7 N along z of a is along -y of N; 0.5 N m about y of a is about z of N
    assert du == pytest.approx((0.0, -3.5, 0.0, 0.0, 0.0, 1.0), abs=1e-14)


def test_a_spring_on_a_node_is_a_known_force_there() -> None:
    accelerated = []
    for by_spring in (True, False):
        scene = kf.System()
        arm = scene.add_flexible_body("arm", lattice_body(0), joint=kf.Free())
        start = arm.body.nodes[3]
        if by_spring:
            end = scene.ground.frame(at=start + np.array((0.0, 0.0, 2.0)))
            scene.add_spring("s", arm.node(3), end, stiffness=5.0, rest_length=1.0)
        else:
            scene.add_force(arm.node(3), (0.0, 0.0, 5.0))
        model = scene.freeze()
        accelerated.append(accelerations(State(model, 0.0, model.initial_coordinates, model.initial_speeds)))
    assert accelerated[0] == pytest.approx(accelerated[1], abs=1e-11)


def test_a_scene_without_springs_runs_no_spring_code(monkeypatch: Any) -> None:
    def fail(*arguments: Any) -> None:
        raise AssertionError("asked for the ends of a spring in a scene without one")

    monkeypatch.setattr("kanefe.tree.scene_state.SceneState.load_ends", fail)
    scene = kf.System(gravity=(0, -9.81, 0))
    scene.add_rigid_body("rod", 1.0, 0.1, com=(0.5, 0, 0), joint=kf.Revolute("z"))
    assert scene.simulate((0.0, 0.1)).energy.elastic.max() == 0.0


def test_a_spring_that_shrinks_to_nothing_is_named() -> None:
    scene = kf.System()
    ball = scene.add_point("ball", 1.0, joint=kf.Translation(position=(1.0, 0.0, 0.0)))
    scene.add_spring("s", scene.ground, ball, stiffness=1.0)
    model = scene.freeze()
    with pytest.raises(SimulationError, match=r"points 0 and 1 of spring 's' coincide at t = 0\.5 s.*Remedy"):
        accelerations(State(model, 0.5, np.zeros(3), np.zeros(3)))


def spring(**options: Any) -> Callable[[kf.System, Any, Any], None]:
    return lambda scene, ball, arm: scene.add_spring(**{"name": "s", "a": scene.ground, "b": ball, **options})


def bushing(**options: Any) -> Callable[[kf.System, Any, Any], None]:
    return lambda scene, ball, arm: scene.add_bushing(**{"name": "s", "a": scene.ground, "b": ball, **options})


@pytest.mark.parametrize(
    ("add", "message"),
    [
        (spring(), "spring 's' does nothing. Remedy: give stiffness, damping or force"),
        (spring(name=""), "the name of a spring must be a text"),
        (spring(name="taken", stiffness=1.0), "already has a spring called 'taken'. Remedy: another"),
        (bushing(name="taken", stiffness=(1, 1, 1)), "already has a spring called 'taken'"),
        (spring(stiffness=-1.0), "stiffness of spring 's' must be one number, finite and >= 0, not -1"),
        (spring(damping=np.nan), "damping of spring 's' must be one number, finite and >= 0, not nan"),
        (spring(stiffness=1.0, rest_length=-0.1), "rest_length of spring 's' must be finite and >= 0 m, not -0.1"),
        (spring(stiffness=1.0, force=lambda x, v: x), "spring 's' has a stiffness and a force of its own. Remedy"),
        (spring(force=([1, 1], [0, 1])), "the lengths in the table of spring 's' must increase. Remedy: sort"),
        (spring(force=([1, 2, 3], [0, 1])), r"the table of spring 's' needs .* shapes \(3,\) and \(2,\)"),
        (spring(force=5.0), "force of spring 's' must be a function or a table"),
        (spring(stiffness=1.0, b="ball"), "end b of spring 's' must be a body or an interface of this scene, or"),
        (spring(stiffness=1.0, b=kf.System().ground), "end b of spring 's': the ground belongs to another system"),
        (bushing(), "bushing 's' does nothing. Remedy"),
        (bushing(stiffness=(1, 2)), "stiffness of bushing 's' must be three or six numbers"),
        (bushing(stiffness=(1, 2, -3)), "stiffness of bushing 's' must be three or six numbers, finite and >= 0"),
        (bushing(law=3.0), "law of bushing 's' must be a function of displacement and rate, not 3"),
        (bushing(stiffness=(1, 1, 1), law=lambda d, v: -d), "has a stiffness and a law of its own. Remedy"),
        (
            lambda scene, ball, arm: scene.add_bushing("s", ball, arm.node(3), stiffness=np.ones(6)),
            "end b of bushing 's': 'node 3' of 'arm' has no rotation of its own. Remedy: an interface",
        ),
        (
            lambda scene, ball, arm: scene.add_spring("s", ball, arm, stiffness=1.0),
            "end b of spring 's': flexible body 'arm' is held at its interfaces",
        ),
    ],
)
def test_bad_springs_are_named(add: Callable[..., None], message: str) -> None:
    scene = kf.System()
    ball = scene.add_point("ball", 1.0, at=(1, 0, 0))
    arm = scene.add_flexible_body("arm", lattice_body(0))
    scene.add_spring("taken", scene.ground, ball, stiffness=1.0)
    with pytest.raises(ModelError, match=message):
        add(scene, ball, arm)
    assert len(scene.freeze().loads) == 1


def test_what_only_the_start_shows_is_named_too() -> None:
    def scene_of(**options: Any) -> tuple[kf.System, Any]:
        scene = kf.System()
        ball = scene.add_point("ball", 1.0, at=(1, 0, 0))
        return scene, ball

    scene, ball = scene_of()
    scene.add_spring("flat", ball, ball.frame(), stiffness=1.0)
    with pytest.raises(
        ModelError, match=r"spring 'flat' has no length at the start: 'ball' and 'ball' .* Remedy: move"
    ):
        scene.freeze()
    scene, ball = scene_of()
    scene.add_spring("bad", scene.ground, ball, force=lambda length, rate: np.nan)
    with pytest.raises(ModelError, match="force of spring 'bad' must be one finite number; at t = 0 s, length 1 m and"):
        scene.simulate((0.0, 1.0))
    scene, ball = scene_of()
    scene.add_bushing("bad", scene.ground, ball, law=lambda d, rate: d[:3])
    with pytest.raises(ModelError, match="law of bushing 'bad' must give six finite numbers; at t = 0 s it gave"):
        scene.freeze()
    scene, ball = scene_of()
    scene.freeze()
    for late in (lambda: scene.add_spring("s", scene.ground, ball), lambda: scene.add_bushing("s", ball, ball)):
        with pytest.raises(ModelError, match="'s' cannot be added or changed: the scene was frozen"):
            late()
