"""Stiffness and damping of springs, bushings, friction and stops in the iteration of the implicit method."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import kanefe as kf
from kanefe.equations.model import Model
from kanefe.integrate.auto.stiffest_rate import stiffest_rate
from kanefe.kane.assemble import assemble
from kanefe.states.state import State
from kanefe.states.tangents import current_tangents
from kanefe.tree.tangents import constant_tangents
from scenes import derivatives

ANCHOR = 5.0  # N m/rad


def tangents(model: Model, q: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return current_tangents(State(model, 0.0, q, u), *constant_tangents(model))


def slack() -> kf.System:
    """Return two bodies at rest between slack springs, a bushing without displacement, and a rubbing joint.

    The stretch of its anchor is a state that follows the coordinate in a step: its stiffness is among the tangents.
    """
    scene = kf.System()
    turn = (0.8, 0.1, 0.5, -0.3)
    one = scene.add_rigid_body("one", 2.0, (0.1, 0.2, 0.25), joint=kf.Free(orientation=turn))
    rubbing = kf.CoordinateForce(3.0, 0.2, friction=2.0, friction_stiffness=ANCHOR, friction_damping=0.5)
    two = scene.add_rigid_body("two", 1.0, 0.1, parent=one, at=(0.5, 0, 0), joint=kf.Revolute("y", forces=rubbing))
    scene.add_spring("s", one.frame(at=(0.1, 0.2, 0.3)), scene.ground.frame(at=(1, 1, 1)), stiffness=7.0, damping=0.3)
    scene.add_spring("table", two, scene.ground.frame(at=(0, 0, 2)), force=([0.0, 50.0, 99.0], [0.0, 0.0, 1.0]))
    scene.add_bushing(
        "b", scene.ground.frame(orientation=turn), one, stiffness=np.arange(1.0, 7.0), damping=np.arange(2.0, 8.0)
    )
    far = scene.ground.frame(at=(1, 1, 0))
    scene.add_bushing("drag", one.frame(at=(0.1, 0, 0)), far, damping=np.arange(1.0, 7.0))  # a turns beside b
    return scene


def test_tangents_are_the_slopes_of_the_forces_where_nothing_is_loaded() -> None:
    model = slack().freeze()
    q, none = model.initial_coordinates, np.zeros(model.free_count)
    K, C = tangents(model, q, none)
    for i in range(model.free_count):
        step = np.eye(model.free_count)[i]

        def moved(s: float, step: np.ndarray = step) -> np.ndarray:
            return assemble(State(model, 0.0, model.advance(q, s * step), none))[1]

        by_q, _ = derivatives(moved, 0.003)
        by_u, _ = derivatives(lambda s, step=step: assemble(State(model, 0.0, q, s * step))[1], 0.003)
        # order-8 differences of forces of order one over 0.003
        by_anchor = step * ANCHOR if i == model.bodies[1].speeds[0] else np.zeros(model.free_count)
        assert K[:, i] == pytest.approx(-by_q + by_anchor, abs=1e-9)
        assert C[:, i] == pytest.approx(-by_u, abs=1e-9)


def held_by_a_spring() -> kf.System:
    scene = kf.System(gravity=(0, 0, -9.81))
    bob = scene.add_point("body", 1.0, at=(1, 0, 0))
    scene.add_spring("rod", scene.ground, bob, stiffness=1e6, damping=10.0)
    return scene


def held_by_a_bushing() -> kf.System:
    scene = kf.System(gravity=(0, 0, -9.81))
    body = scene.add_rigid_body("body", 1.0, 0.01, com=(0.1, 0, 0), joint=kf.Free())
    K = (1e6, 1e6, 1e6, 1e4, 1e4, 1e4)
    scene.add_bushing("mount", scene.ground, body, stiffness=K, damping=(10, 10, 10, 1, 1, 1))
    return scene


def held_by_friction() -> kf.System:
    scene = kf.System(gravity=(0, 0, -9.81))
    sticking = kf.Revolute("y", forces=kf.CoordinateForce(friction=20.0))
    scene.add_rigid_body("body", 1.0, 0.01, com=(0.1, 0, 0), joint=sticking)
    return scene


def held_by_a_stop() -> kf.System:
    scene = kf.System(gravity=(0, 0, -9.81))
    stop = kf.CoordinateForce(limits=(None, 0.2), limit_stiffness=1e4, limit_damping=5.0)
    scene.add_rigid_body("body", 1.0, 0.01, com=(0.1, 0, 0), joint=kf.Revolute("y", forces=stop))
    return scene


@pytest.mark.parametrize("make", [held_by_a_spring, held_by_a_bushing, held_by_a_stop])
def test_what_holds_stiffly_holds_no_step_of_the_implicit_method(make: Callable[[], kf.System]) -> None:
    # left to the iteration as loads, they cost thousands of evaluations
    result = make().simulate((0.0, 1.0), rtol=1e-5, method="generalised-alpha", output_step=0.1)
    assert result.statistics["evaluations"] < 1000
    assert abs(result.energy.balance_error).max() < 0.02


def test_auto_sees_springs_and_friction() -> None:
    assert stiffest_rate(held_by_a_spring().freeze(), 0.0) == pytest.approx(1e3, rel=1e-6)
    scene = held_by_friction()
    assert scene.simulate((0.0, 1.0), output_step=0.5).statistics["method"] == "radau5"
