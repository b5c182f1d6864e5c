"""Contacts that are loaded where a scene starts, by which a method is chosen."""

from __future__ import annotations

import pytest

import kanefe as kf
from kanefe import shapes
from kanefe.integrate.auto.loaded_contacts import loaded_depth

K, MASS, G = 1e5, 2.0, 9.81
DEPTH = MASS * G / K
"""Depth at rest, m."""


def block(height: float = 0.0, velocity=(0.0, 0.0, 0.0), gravity: float = G, stiffness: float = K) -> kf.System:
    """Return a block with four points, so high above a floor."""
    scene = kf.System(gravity=(0, 0, -gravity))
    body = scene.add_rigid_body("block", MASS, 0.02, joint=kf.Free(position=(0, 0, 0.1 + height), velocity=velocity))
    points = [body.frame(at=(x, y, -0.1)) for x in (-0.2, 0.2) for y in (-0.2, 0.2)]
    floor = scene.add_surface("floor", scene.ground, shapes.Plane("z"))
    friction = kf.Coulomb(0.5, stiffness=stiffness, damping=50.0)
    scene.add_contact("contact", points, floor, normal=kf.HuntCrossley(stiffness, damping=20.0), friction=friction)
    return scene


@pytest.mark.parametrize(
    ("height", "velocity"),
    [(0.0, (0, 0, 0)), (0.0, (2.0, 0, 0)), (-DEPTH, (1.0, 1.0, 0)), (0.0, (0, 0, -0.01))],
)
def test_what_rests_or_slides_is_loaded(height, velocity):
    assert loaded_depth(block(height, velocity).freeze(), 0.0) == pytest.approx(DEPTH, rel=1e-9)


@pytest.mark.parametrize(
    ("height", "velocity"),
    [(1e-2, (0, 0, 0)), (0.0, (0, 0, -1.0)), (0.0, (0, 0, 1.0)), (-10.0 * DEPTH, (0, 0, 0))],
    ids=["falls", "hits", "leaves", "is thrown out"],
)
@pytest.mark.filterwarnings("ignore:contact:kanefe.SimulationWarning")
def test_what_falls_or_bounces_is_not(height, velocity):
    assert loaded_depth(block(height, velocity).freeze(), 0.0) == 0.0


def test_what_only_touches_is_not_loaded():
    assert loaded_depth(block(gravity=0.0).freeze(), 0.0) == 0.0


def test_a_block_that_slides_from_the_start_is_stepped_over():
    """Its contact is damped and stiff: the explicit method would take thousands of steps."""
    scene = block(velocity=(2.0, 0, 0), stiffness=2e6)
    run, explicit = (scene.simulate((0.0, 3.0), rtol=1e-4, output_step=1.0, method=m) for m in ("auto", "dop853"))
    assert run.statistics["method"].startswith("radau5")
    assert run.statistics["steps"] < 0.5 * explicit.statistics["steps"]
