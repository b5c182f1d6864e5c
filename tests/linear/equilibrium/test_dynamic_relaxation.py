"""Rests of scenes that are let go far from them; what they end at is known in closed form."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from kanefe import shapes
from kanefe.frames import rotation_about
from kanefe.linear.equilibrium.dynamic_relaxation import come_to_rest

G = 9.81
SIDES = 0.2, 0.2, 0.1
LAWS = {"yielding": kf.HuntCrossley(1e6, 0.1, exponent=1.0), "rigid": kf.Rigid()}


def boxes(heights: tuple[float, ...], law: object, tilt: float = 0.0) -> kf.System:
    """Boxes of 2 kg side by side above a floor, with friction."""
    scene = kf.System(gravity=(0, 0, -G))
    floor = scene.add_surface("floor", scene.ground, shapes.Plane("z"))
    for i, height in enumerate(heights):
        pose = {"position": (i, 0, 0.5 * SIDES[2] + height), "orientation": rotation_about("y", tilt)}
        body = scene.add_rigid_body(f"box {i}", 2.0, 0.02, joint=kf.Free(**pose))
        own = scene.add_surface(f"sides {i}", body, shapes.Box(SIDES))
        scene.add_contact(f"c{i}", own, floor, normal=law, friction=kf.Coulomb(0.5))
    return scene


@pytest.mark.parametrize("law", LAWS)
def test_boxes_far_above_a_floor_come_to_lie_on_it(law):
    found = kf.equilibrium(boxes((0.25, 0.35, 2.0), LAWS[law]))
    depth = 2.0 * G / 1e6 if law == "yielding" else 0.0
    for i in range(3):
        assert found.position(f"box {i}")[2] == pytest.approx(0.05 - depth, abs=1e-11)
        assert found.carrying[f"c{i}"] == pytest.approx(2.0 * G, rel=1e-9)


def test_what_begins_far_above_a_stiff_floor_feels_it():
    found = kf.equilibrium(boxes((1.0,), kf.HuntCrossley(1e9, 0.1)))
    assert found.carrying["c0"] == pytest.approx(2.0 * G, rel=1e-9)


def test_a_box_let_go_askew_falls_flat():
    # to the long way round, over an edge, a search goes by itself; here only a motion leads
    found = kf.equilibrium(boxes((0.2,), LAWS["yielding"], tilt=0.2))
    e = found.rotation("box 0")
    np.testing.assert_allclose(np.abs(e), (1, 0, 0, 0), atol=1e-6)
    assert found.carrying["c0"] == pytest.approx(2.0 * G, rel=1e-9)


def test_a_pendulum_is_stopped_where_it_hangs():
    scene = kf.System(gravity=(0, 0, -G))
    scene.add_rigid_body("bob", 1.0, 0.01, com=(0, 0, -1.0), joint=kf.Revolute("y", position=1.0))
    model = scene.freeze()
    q = come_to_rest(model, 0.0, model.initial_coordinates)
    assert abs(q[0]) < 2e-3  # a thousandth of the first acceleration, by a sine


def test_what_nothing_stops_is_told():
    scene = kf.System(gravity=(0, 0, -G))
    scene.add_rigid_body("stone", 1.0, 0.01, joint=kf.Free())
    model = scene.freeze()
    with pytest.raises(kf.SimulationError, match="nothing stops"):
        come_to_rest(model, 0.0, model.initial_coordinates)
