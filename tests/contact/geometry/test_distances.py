"""Signed distances of shapes and their normals against formulas of their own, and a search for the nearest place."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.optimize import minimize

from kanefe import shapes
from kanefe.contact.geometry.height_field import heights_at
from kanefe.frames import rotation_about, rotation_matrix
from touched_shapes import HILLS, TOUCHED

AXIS = np.array((1.0, 2.0, -2.0)) / 3.0


def in_cylinder(x: np.ndarray, radius: float, length: float) -> float:
    """Return the distance in the plane of radius and height, of a rectangle there."""
    height = float(AXIS @ x)
    q = np.array((np.linalg.norm(x - height * AXIS) - radius, abs(height) - 0.5 * length))
    return float(np.linalg.norm(np.maximum(q, 0.0)) + min(q.max(), 0.0))


def in_box(x: np.ndarray, size: tuple[float, float, float]) -> float:
    q = np.abs(x) - 0.5 * np.array(size)
    return float(np.linalg.norm(np.maximum(q, 0.0)) + min(q.max(), 0.0))


def in_torus(x: np.ndarray) -> float:
    height = float(AXIS @ x)
    return float(np.hypot(np.linalg.norm(x - height * AXIS) - 0.5, height) - 0.2)


def in_capsule(x: np.ndarray) -> float:
    along = np.linspace(-0.4, 0.4, 200001)
    return float(np.sqrt((x @ x) - 2.0 * along * (AXIS @ x) + along**2).min() - 0.3)


CASES: dict[str, tuple[shapes.SurfaceShape, Callable[[np.ndarray], float]]] = {
    "sphere": (shapes.Sphere(0.7), lambda x: float(np.linalg.norm(x)) - 0.7),
    "room of a sphere": (shapes.Sphere(0.7, inside=True), lambda x: 0.7 - float(np.linalg.norm(x))),
    "capsule": (shapes.Capsule(0.3, 0.8, axis=AXIS), in_capsule),
    "cylinder": (shapes.Cylinder(0.5, 0.8, axis=AXIS), lambda x: in_cylinder(x, 0.5, 0.8)),
    "room of a cylinder": (shapes.Cylinder(0.5, 0.8, axis=AXIS, inside=True), lambda x: -in_cylinder(x, 0.5, 0.8)),
    "box": (shapes.Box((1.0, 0.8, 0.6)), lambda x: in_box(x, (1.0, 0.8, 0.6))),
    "room of a box": (shapes.Box((1.0, 0.8, 0.6), inside=True), lambda x: -in_box(x, (1.0, 0.8, 0.6))),
    "torus": (shapes.Torus(0.5, 0.2, axis=AXIS), in_torus),
}


@pytest.mark.parametrize("name", CASES)
def test_distances_are_their_formulas(name: str) -> None:
    shape, wanted = CASES[name]
    places = np.random.default_rng(3).uniform(-1.0, 1.0, (200, 3))
    signs = set()
    for x in places:
        distance, normal = shape.distance(x)
        # the capsule's places along its axis are 4e-6 m apart, which changes a distance of a tenth by 1e-11
        assert distance == pytest.approx(wanted(x), abs=1e-9)
        assert np.linalg.norm(normal) == pytest.approx(1.0, rel=1e-12)
        signs.add(distance > 0.0)
    assert signs == {True, False}


def test_a_place_on_an_axis_or_in_a_centre_has_a_normal() -> None:
    for shape, depth in ((shapes.Sphere(0.7), 0.7), (shapes.Capsule(0.3, 0.8, axis="x"), 0.3)):
        distance, normal = shape.distance((0.0, 0.0, 0.0))
        assert (distance, np.linalg.norm(normal)) == (-depth, 1.0)


def test_hills_are_as_far_as_their_nearest_place() -> None:
    field = TOUCHED["hills"]
    assert isinstance(field, shapes.HeightField)

    def height(p: np.ndarray) -> float:
        return float(heights_at(field, p[:1], p[1:])[0, 0])

    for x in np.random.default_rng(4).uniform((-0.8, -0.8, 0.0), (0.8, 0.8, 0.4), (20, 3)):
        if x[2] <= height(x[:2]):
            continue
        found = minimize(lambda p, x=x: np.linalg.norm(x - (*p, height(p))), x[:2], tol=1e-12)
        assert field.distance(x)[0] == pytest.approx(found.fun, rel=1e-7)  # a minimum: flat to the square


def test_heights_between_places_are_those_of_the_grid_there() -> None:
    field = TOUCHED["hills"]
    np.testing.assert_allclose(heights_at(field, field.x, field.y), HILLS, atol=1e-15)


def test_curvature_is_the_slope_of_the_normal() -> None:
    turn = rotation_matrix(rotation_about((1, 2, 3), 0.7))
    for shape in (shapes.Sphere(0.7), shapes.Sphere(0.9, inside=True), TOUCHED["hills"]):
        for x in (np.array((0.21, -0.33, 0.25)), np.array((-0.4, 0.13, 0.31))):
            H, h = shape.curvature(x), 1e-6
            for e in turn:
                slope = (shape.distance(x + h * e)[1] - shape.distance(x - h * e)[1]) / (2.0 * h)
                np.testing.assert_allclose(H @ e, slope, atol=1e-6 * np.abs(H).max())


def test_places_of_a_box_lie_on_its_faces_and_reach_its_corners() -> None:
    size = np.array((0.2, 0.5, 3.0))
    places = np.array([probe.point for probe in shapes.Box(tuple(size)).sampled(0.1).probes()])
    assert max(abs(in_box(place, tuple(size))) for place in places) < 1e-14
    np.testing.assert_allclose(np.ptp(places, axis=0), size, rtol=1e-14)
    for corner in np.array([(i, j, k) for i in (-0.5, 0.5) for j in (-0.5, 0.5) for k in (-0.5, 0.5)]) * size:
        assert np.linalg.norm(places - corner, axis=1).min() < 1e-14
