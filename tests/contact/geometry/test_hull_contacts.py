"""Hulls of points on planes and in rooms: the stiffness of a patch is the one that was given, however many points."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import kanefe as kf
from contact_scenes import LAW, assert_routes_agree, scene_of
from kanefe import shapes

RADIUS, WIDTH, STIFFNESS, WEIGHT = 0.1, 0.02, 1e6, 490.5


def roller(points: int) -> shapes.Convex:
    angles = 2.0 * np.pi * (np.arange(points) + 0.5) / points
    return shapes.Convex([(RADIUS * np.sin(a), y, RADIUS * np.cos(a)) for a in angles for y in (-WIDTH / 2, WIDTH / 2)])


def sinks(shape: shapes.Convex, turn: Rotation, ground: shapes.SurfaceShape, height: float = 0.0) -> float:
    """Return by how much a shape sinks, relative to weight over stiffness."""
    lowest = float((shape.vertices @ turn.as_matrix().T)[:, 2].min())
    scene = kf.System(gravity=(0, 0, -9.81))
    floor = scene.add_surface("floor", scene.ground, ground)
    joint = kf.Prismatic("z", position=height - lowest)
    skin = scene.add_surface("skin", scene.add_rigid_body("body", WEIGHT / 9.81, joint=joint), shape, orientation=turn)
    scene.add_contact("on", skin, floor, normal=kf.KelvinVoigt(STIFFNESS))
    return float(height - lowest - kf.equilibrium(scene).position("body")[2]) * STIFFNESS / WEIGHT


@pytest.mark.parametrize("points", [7, 48, 180])
def test_a_roller_of_points_sinks_by_weight_over_stiffness(points):
    face = Rotation.from_euler("y", 0.0 if points % 2 == 0 else np.pi / points)
    assert sinks(roller(points), face, shapes.Plane("z")) == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("turned", [("y", np.pi / 24), ("yx", (np.pi / 24, 0.5)), ("x", np.pi / 2)], ids=str)
def test_so_does_it_on_an_edge_a_corner_and_its_end(turned):
    assert sinks(roller(24), Rotation.from_euler(*turned), shapes.Plane("z")) == pytest.approx(1.0, abs=1e-9)


def test_points_between_an_edge_and_its_neighbours_take_little():
    """Of a roller whose neighbouring edges press too the patch is softer, by what these are less deep, 0.1 here."""
    depth, points = WEIGHT / STIFFNESS, 128
    between = RADIUS * (1.0 - np.cos(2.0 * np.pi / points))
    found = sinks(roller(points), Rotation.from_euler("y", np.pi / points), shapes.Plane("z"))
    assert 1.0 <= found <= 1.0 + between / depth


@pytest.mark.filterwarnings("ignore::kanefe.linear.equilibrium.other_rest.OtherRestWarning")
def test_each_wall_of_a_room_has_the_whole_stiffness():
    """In a corner of a room a block presses on floor and wall, on each by its own weight there."""
    scene = kf.System(gravity=(-3.0, 0, -9.0))
    room = scene.add_surface("room", scene.ground, shapes.Box((2.0, 2.0, 2.0), inside=True))
    joint = kf.Translation(position=(-0.8, 0.0, -0.8))
    cube = shapes.Convex([(x, y, z) for x in (-0.2, 0.2) for y in (-0.2, 0.2) for z in (-0.2, 0.2)])
    block = scene.add_surface("skin", scene.add_rigid_body("block", 10.0, 1.0, joint=joint), cube)
    scene.add_contact("in", block, room, normal=kf.KelvinVoigt(STIFFNESS))
    place = kf.equilibrium(scene).position("block")
    assert place[2] + 0.8 == pytest.approx(-90.0 / STIFFNESS, rel=0.1)
    assert place[0] + 0.8 == pytest.approx(-30.0 / STIFFNESS, rel=0.1)


ROOM = shapes.Box((2.0, 2.0, 2.0), inside=True)


@pytest.mark.filterwarnings("ignore::kanefe.errors.SimulationWarning")
@pytest.mark.parametrize("touched", [shapes.Plane("z"), ROOM], ids=["plane", "room"])
def test_routes_agree(touched):
    hull = shapes.Convex(0.3 * np.random.default_rng(1).standard_normal((12, 3)))
    friction = kf.Coulomb(0.4, static=0.5, torsional=0.05, stiffness=3e4, damping=20.0)
    assert_routes_agree(scene_of(touched, hull, LAW, friction), range(6), (0.3, 0.6, 0.9))


def test_derivatives_are_those_of_its_shares():
    """As it turns over an edge, with four corners in the ground."""
    scene = kf.System(gravity=(0, 0, -9.81))
    floor = scene.add_surface("floor", scene.ground, shapes.Plane("z"))
    cart = scene.add_rigid_body("cart", 50.0, 1.0, joint=kf.Prismatic("z", position=RADIUS - 8e-4))
    hub = scene.add_rigid_body("hub", 1.0, 0.1, parent=cart, joint=kf.Revolute("y", position=np.pi / 128 + 2e-3))
    scene.add_contact("on", scene.add_surface("skin", hub, roller(128)), floor, normal=kf.KelvinVoigt(STIFFNESS))
    model = scene.freeze()
    y, step = model.initial_state, 1e-9
    for i in range(2):
        e = step * np.eye(len(y))[i]
        differences = (model.route.evaluate(0.0, y + e).rates - model.route.evaluate(0.0, y - e).rates) / (2.0 * step)
        np.testing.assert_allclose(model.jacobian(0.0, y)[:, i], differences[:4], rtol=1e-4, atol=1e-2)
        assert abs(differences).max() > 1e3
