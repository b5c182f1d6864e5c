"""Reactions and loads as functions of the user may ask for them: in events and loads, and what is circular."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import kanefe as kf
from kanefe.errors import ModelError
from scenes import lattice_body

G = 9.81


def pendulum(**options: Any) -> kf.System:
    scene = kf.System(gravity=(0, 0, -G))
    scene.add_rigid_body("bob", 1.0, com=(0, 0, -1), joint=kf.Revolute("y", position=1.2), **options)
    return scene


def test_an_event_at_a_tension() -> None:
    """M (g cos phi + l w^2) with w^2 = 2 g / l (cos phi - cos phi0): 3 m g cos phi - 2 m g cos phi0."""

    def tension(t: float, state: kf.SceneState) -> float:
        return float(np.linalg.norm(state.joint_reaction("bob")[:3])) - 15.0

    scene = pendulum()
    result = scene.simulate((0.0, 1.0), rtol=1e-9, events=kf.Event("torn", tension, terminal=True))
    angle = np.arccos((15.0 / G + 2.0 * np.cos(1.2)) / 3.0)
    assert result.status.kind == "stopped"
    # of a point on a bar without mass there is no force across
    assert result.joint_coordinates("bob")[-1, 0] == pytest.approx(angle, abs=1e-7)


@pytest.mark.parametrize("tree", ["rigid", "flexible", "unreduced"])
def test_events_see_what_results_tell(tree: str) -> None:
    scene = kf.System(gravity=(0, 0, -G))
    drive = kf.Revolute("y", motion=kf.Motion(lambda t: np.sin(t), lambda t: np.cos(t), lambda t: -np.sin(t)))
    if tree == "rigid":
        arm: kf.Frame = scene.add_rigid_body("arm", 1.0, 0.1, com=(0.5, 0, 0), joint=drive)
    else:
        reduction = None if tree == "unreduced" else kf.CraigBampton(modes=2)
        arm = scene.add_flexible_body("arm", lattice_body(0, reduction=reduction), joint=drive).interface("tip")
    bob = scene.add_rigid_body("bob", 2.0, 0.1, parent=arm, at=(0, 0, 0), joint=kf.Revolute("z"))
    scene.add_spring("spring", scene.ground.frame(at=(0, 0, -2)), bob, stiffness=5.0, rest_length=1.0)
    seen: list[tuple[float, np.ndarray, np.ndarray, np.ndarray]] = []

    def look(t: float, state: kf.SceneState) -> None:
        seen.append((t, state.joint_reaction("bob"), state.driving_force("arm"), state.load("spring")))

    at = kf.Event("at", lambda t, state: t - 0.05, action=look)
    result = scene.simulate((0.0, 0.1), output_times=[0.0, 0.05, 0.1], rtol=1e-8, events=at)
    (t, reaction, driving, load), row = seen[0], 1
    assert t == pytest.approx(0.05)
    scale = np.abs(result.joint_reaction("bob")[row]).max()
    # the moment is found to 1e-13 s; states besides it agree to the tolerance of the dense output
    np.testing.assert_allclose(reaction, result.joint_reaction("bob")[row], rtol=0, atol=1e-5 * scale)
    np.testing.assert_allclose(driving[0], result.driving_force("arm")[row], rtol=1e-5)
    np.testing.assert_allclose(load, result.load("spring")[row], rtol=0, atol=1e-6 * abs(load).max())


def test_an_event_at_the_force_of_a_loop() -> None:
    scene = kf.System(gravity=(0, 0, -G))
    weight = scene.add_rigid_body("weight", 2.0, joint=kf.Prismatic("z"))
    scene.add_loop_joint("hook", kf.Fixed, scene.ground, weight, starts_on=True)
    scene.add_force(weight, lambda t: (0.0, 0.0, -10.0 * t))
    torn = kf.Event(
        "torn",
        lambda t, state: state.loop_force("hook")[2] - 25.0 if state.is_on("hook") else 1.0,
        action=lambda t, state: state.switched(off="hook"),
    )
    result = scene.simulate((0.0, 1.0), events=torn)
    assert result.events["torn"] == pytest.approx([(25.0 - 2.0 * G) / 10.0], abs=1e-9)


def test_a_load_may_look_at_others() -> None:
    """A motor that takes half of the pull of a spring leaves half of its stiffness."""

    def run(stiffness: float, share: float) -> np.ndarray:
        scene = kf.System()
        cart = scene.add_rigid_body("cart", 2.0, joint=kf.Prismatic("x", position=1.0))
        scene.add_spring("spring", scene.ground, cart, stiffness=stiffness, rest_length=0.8)
        scene.add_motor(cart, lambda t, state: share * state.load("spring")[2])
        scene.add_force(cart, lambda t, state: (0.0, *state.load("the motor of 'cart'"), 0.0))
        return scene.simulate((0.0, 1.0), rtol=1e-9, output_step=0.1).position("cart")

    np.testing.assert_allclose(run(10.0, 0.5), run(5.0, 0.0), rtol=0, atol=1e-7)


def test_linearise_sees_through_loads_that_look_at_others() -> None:
    scene = kf.System()
    cart = scene.add_rigid_body("cart", 2.0, joint=kf.Prismatic("x", position=1.0))
    scene.add_spring("spring", scene.ground, cart, stiffness=10.0, rest_length=1.0)
    scene.add_motor(cart, lambda t, state: 0.5 * state.load("spring")[2])
    assert kf.linearise(scene).stiffness[0, 0] == pytest.approx(5.0, rel=1e-9)


@pytest.mark.parametrize(
    ("function", "words"),
    [
        (lambda t, state: state.joint_reaction("bob")[0], "'bob' asks for the joint reaction of 'bob', .* circular"),
        (lambda t, state: state.driving_force("bob")[0], "'bob' asks for the driving force of 'bob', .* circular"),
        (lambda t, state: state.loop_force("hook")[0], "asks for the force of loop joint 'hook', .* circular"),
        (lambda t, state: state.load("the motor of 'bob'")[0], "itself: the motor of 'bob' for the motor of 'bob'"),
        (lambda t, state: state.load("wind")[0], "the scene has no load 'wind'. It has: the motor of 'bob'"),
    ],
)
def test_what_is_circular_is_refused(function: Any, words: str) -> None:
    scene = pendulum()
    scene.add_motor(scene.body("bob"), function)
    with pytest.raises(ModelError, match=words):
        scene.simulate((0.0, 0.1))


def test_two_loads_that_ask_for_each_other_are_named() -> None:
    scene = pendulum()
    bob = scene.body("bob")
    scene.add_motor(bob, lambda t, state: float(state.load("the force on 'bob'")[0]))
    scene.add_force(bob, lambda t, state: (*state.load("the motor of 'bob'"), 0.0, 0.0))
    with pytest.raises(ModelError, match=r"itself: the .* for the .* for the .*Remedy: one of them"):
        scene.simulate((0.0, 0.1))


def test_an_event_may_ask_for_loads_by_name_only_if_there_are() -> None:
    event = kf.Event("none", lambda t, state: state.loop_force("hook")[0])
    with pytest.raises(ModelError, match=r"no loop joint 'hook'. It has: none"):
        pendulum().simulate((0.0, 0.1), events=event)
    event = kf.Event("none", lambda t, state: state.driving_force("bob")[0])
    with pytest.raises(ModelError, match="nothing drives the joint of 'bob'"):
        pendulum().simulate((0.0, 0.1), events=event)
