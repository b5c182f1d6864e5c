"""Frames of a scene: offset frames carry, load and mark like the place they stand for; a frozen scene takes nothing."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import kanefe as kf
from kanefe.errors import ModelError
from kanefe.frames import rotation_matrix
from kanefe.kane.assemble import assemble
from kanefe.states.state import State
from scenes import lattice_body, random_state

TURN = (0.9, 0.1, -0.3, 0.2)
MORE = (0.5, 0.5, 0.1, -0.4)
AT, FURTHER = np.array((0.3, -0.2, 0.1)), np.array((0.05, 0.4, -0.2))


def same_equations(one: kf.System, other: kf.System) -> None:
    models = one.freeze(), other.freeze()
    q, u = random_state(models[0], 1)
    for ours, theirs in zip(*(assemble(State(model, 0.3, q, u)) for model in models), strict=True):
        # the same places by two ways of adding up: round-off of entries of order one to ten
        assert ours == pytest.approx(theirs, abs=1e-13)


def test_a_body_on_an_offset_frame_is_where_both_offsets_take_it() -> None:
    scenes = []
    for by_frame in (True, False):
        scene = kf.System(gravity=(1, 2, 3))
        hub = scene.add_rigid_body("hub", 1.0, 0.1, joint=kf.Free())
        where: dict[str, Any]
        if by_frame:
            where = {"parent": hub.frame(AT, TURN), "at": FURTHER, "orientation": MORE}
        else:
            A = rotation_matrix(np.array(TURN)) @ rotation_matrix(np.array(MORE))
            place = AT + rotation_matrix(np.array(TURN)) @ FURTHER
            from kanefe.frames import euler_parameters_from_matrix

            where = {"parent": hub, "at": place, "orientation": euler_parameters_from_matrix(A)}
        scene.add_rigid_body("arm", 0.5, 0.02, com=(0.2, 0, 0), joint=kf.Revolute((1, 2, 0)), **where)
        scenes.append(scene)
    same_equations(*scenes)


def test_frames_of_frames_compose() -> None:
    scene = kf.System()
    hub = scene.add_rigid_body("hub", 1.0, 0.1, joint=kf.Free())
    twice = hub.frame(AT, TURN).frame(FURTHER, MORE)
    A, B = rotation_matrix(np.array(TURN)), rotation_matrix(np.array(MORE))
    assert twice.at == pytest.approx(AT + A @ FURTHER, abs=1e-15)
    assert twice.axes == pytest.approx(A @ B, abs=1e-15)


@pytest.mark.parametrize("is_flexible", [False, True])
@pytest.mark.parametrize("follows", [False, True])
@pytest.mark.parametrize("is_function", [False, True])
def test_loads_on_an_offset_frame_act_there_and_in_its_axes(
    is_flexible: bool, follows: bool, is_function: bool
) -> None:
    A = rotation_matrix(np.array(TURN))
    force, torque, point = np.array((1.0, -2.0, 0.5)), np.array((0.3, 0.1, -0.7)), np.array((0.1, 0.2, 0.3))

    def made(vector: np.ndarray) -> Any:
        return (lambda t: vector * (1 + t)) if is_function else vector

    scenes = []
    for by_frame in (True, False):
        scene = kf.System()
        if is_flexible:
            target = scene.add_flexible_body("arm", lattice_body(0), joint=kf.Free()).interface("tip")
        else:
            target = scene.add_rigid_body("hub", 1.0, 0.1, joint=kf.Free())
        if by_frame:
            target, turn, place = target.frame(AT, TURN), np.eye(3), point
        else:
            turn, place = A if follows else np.eye(3), AT + A @ point
        scene.add_force(target, made(turn @ force), point=place, follows=follows)
        scene.add_torque(target, made(turn @ torque), follows=follows)
        scenes.append(scene)
    same_equations(*scenes)


def test_a_body_on_a_frame_of_the_ground_is_placed_there() -> None:
    scene = kf.System()
    scene.add_rigid_body("post", 1.0, 0.1, parent=scene.ground.frame(AT, TURN), at=FURTHER)
    body = scene.freeze().bodies[0]
    assert body.parent == -1
    assert body.p_PoFo_P == pytest.approx(AT + rotation_matrix(np.array(TURN)) @ FURTHER, abs=1e-15)


def test_markers_say_where_they_are() -> None:
    scene = kf.System()
    hub = scene.add_rigid_body("hub", 1.0, 0.1)
    arm = scene.add_flexible_body("arm", lattice_body(0), parent=hub)
    tip = scene._marker(arm.interface("tip").frame(AT, TURN), "end a of spring 's'")
    assert tip.body == 1
    assert tip.interface.name == "tip"
    assert tip.point == pytest.approx(AT)
    assert tip.axes == pytest.approx(rotation_matrix(np.array(TURN)))
    assert tip.label == "'tip' of 'arm' at (0.3, -0.2, 0.1)"
    ground = scene._marker(scene.ground, "end b")
    assert (ground.body, ground.interface, ground.label) == (-1, None, "the ground")


def test_frames_that_cannot_do_what_is_asked_are_named() -> None:
    scene, other = kf.System(), kf.System()
    hub = scene.add_rigid_body("hub", 1.0, 0.1)
    arm = scene.add_flexible_body("arm", lattice_body(0), parent=hub)
    with pytest.raises(ModelError, match=r"end a: 'hub' belongs to another system\. Remedy: scene.body"):
        other._marker(hub, "end a")
    with pytest.raises(ModelError, match=r"end a must be a body or an interface .*scene\.ground, not 'hub'"):
        scene._marker("hub", "end a")
    for frame in (arm, arm.frame(AT)):
        with pytest.raises(ModelError, match=r"end a: flexible body 'arm' is held at .* one of \['root', 'tip'\]"):
            scene._marker(frame, "end a")
        with pytest.raises(ModelError, match="carries other bodies at its interfaces only"):
            scene.add_rigid_body("b", 1.0, parent=frame)
    with pytest.raises(ModelError, match=r"end a: 'node 3' of 'arm' has no rotation of its own\. Remedy: an interface"):
        scene._marker(arm.node(3), "end a", needs_rotation=True)
    assert scene._marker(arm.node(3), "end a").interface.name == "node 3"
    with pytest.raises(ModelError, match=r"a load on the ground moves nothing\. Remedy"):
        scene.add_force(scene.ground, (1, 0, 0))
    with pytest.raises(ModelError, match=r"at of a frame of 'hub' must be three finite numbers, not \(1, 2\)"):
        hub.frame((1, 2))
    with pytest.raises(
        ModelError, match=r"orientation of a frame of 'hub' must be a rotation, .* four Euler parameters"
    ):
        hub.frame(orientation=(0, 0, 0, 0))


CHANGES: list[tuple[Callable[[kf.System, Any], Any], str]] = [
    (lambda scene, hub: scene.add_rigid_body("b", 1.0), "body 'b'"),
    (lambda scene, hub: scene.add_flexible_body("b", lattice_body(0)), "body 'b'"),
    (lambda scene, hub: scene.add_force(hub, (1, 0, 0)), "a force"),
    (lambda scene, hub: scene.add_torque(hub, 1.0), "a torque"),
    (lambda scene, hub: setattr(scene, "gravity", (0, 0, 1)), "gravity"),
]


@pytest.mark.parametrize(("change", "what"), CHANGES)
@pytest.mark.parametrize("freeze", [lambda s: s.freeze(), lambda s: s.simulate((0.0, 0.1))], ids=["freeze", "simulate"])
def test_a_frozen_scene_says_that_it_cannot_be_changed(
    change: Callable[[kf.System, Any], Any], what: str, freeze: Callable[[kf.System], Any]
) -> None:
    scene = kf.System()
    hub = scene.add_rigid_body("hub", 1.0, 0.1, joint=kf.Revolute("z"))
    freeze(scene)
    with pytest.raises(ModelError, match=f"{what} cannot be added or changed: the scene was frozen. Remedy: .* before"):
        change(scene, hub)
    assert len(scene.freeze().bodies) == 1  # and can be frozen again
