"""What surfaces look like: closed triangles on the surface itself, turning outwards."""

import numpy as np
import pytest

import kanefe as kf
from kanefe.contact.geometry.shape import SurfaceShape
from kanefe.contact.outlines import AROUND, outline

TILTED = (1.0, 2.0, -2.0)
FLAT = 1.0 - np.cos(np.pi / AROUND)  # of what is round, how far the middle of a side is inside
SHAPES = {
    "sphere": (kf.shapes.Sphere(0.3), 4 / 3 * np.pi * 0.3**3),
    "capsule": (kf.shapes.Capsule(0.2, 1.0, axis=TILTED), np.pi * 0.04 + 4 / 3 * np.pi * 0.2**3),
    "cylinder": (kf.shapes.Cylinder(0.2, 1.0, axis="-y"), np.pi * 0.04),
    "box": (kf.shapes.Box((0.2, 0.4, 1.0)), 0.08),
    "torus": (kf.shapes.Torus(0.5, 0.1, axis=TILTED), 2 * np.pi**2 * 0.5 * 0.01),
    "mesh": (
        kf.shapes.Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]),
        1 / 6,
    ),
}


@pytest.mark.parametrize("name", SHAPES)
def test_a_body_has_its_surface_and_volume(name):
    shape, volume = SHAPES[name]
    drawn = outline(shape)
    a, b, c = (drawn.vertices[drawn.triangles[:, i]] for i in range(3))
    np.testing.assert_allclose(np.cross(b - a, c - a).sum(axis=0), 0.0, atol=1e-12)  # it is closed
    found = np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0
    assert found == pytest.approx(volume, rel=8 * FLAT)
    assert found <= volume * (1 + 1e-12)
    assert max(abs(shape.distance(vertex)[0]) for vertex in drawn.vertices) < 1e-12


def test_planes_are_squares_across_their_normal():
    drawn = outline(kf.shapes.Plane(TILTED))
    assert drawn.is_endless
    normal = np.cross(drawn.vertices[1] - drawn.vertices[0], drawn.vertices[2] - drawn.vertices[0])
    np.testing.assert_allclose(normal, np.array(TILTED) / 3.0, atol=1e-12)


def test_ground_turns_upwards():
    x = np.linspace(0.0, 1.0, 4)
    drawn = outline(kf.shapes.HeightField(x, x[:3], np.outer(x, x[:3])))
    a, b, c = (drawn.vertices[drawn.triangles[:, i]] for i in range(3))
    assert (np.cross(b - a, c - a)[:, 2] > 0.0).all()
    assert drawn.vertices[-1] == pytest.approx((1.0, x[2], x[2]))


def test_points_are_balls():
    drawn = outline(kf.shapes.Points([(0, 0, 0), (2, 0, 0)], radius=0.1))
    assert np.linalg.norm(drawn.vertices - np.round(drawn.vertices / 2) * 2, axis=1) == pytest.approx(0.1)


def test_a_shape_of_the_user_has_no_looks():
    class Own(SurfaceShape):
        distance = bounds = numbers = None

    assert outline(Own()) is None
