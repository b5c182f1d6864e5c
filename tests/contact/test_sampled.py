"""Points that stand for shapes on ground that is not flat: where they are, what they carry, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from kanefe import shapes

SIZE = (0.4, 0.2, 0.1)
CORNERS = np.array([(x, y, z) for x in (-0.2, 0.2) for y in (-0.1, 0.1) for z in (-0.05, 0.05)])
FACES = shapes.Convex(CORNERS).triangles
TOUCHING = {
    "box": shapes.Box(SIZE),
    "hull": shapes.Convex(CORNERS),
    "mesh": shapes.Mesh(shapes.Convex(CORNERS).vertices, FACES),
    "cylinder": shapes.Cylinder(0.1, 0.3, "x"),
    "capsule": shapes.Capsule(0.1, 0.3, (1, 2, 2)),
    "torus": shapes.Torus(0.3, 0.05, (1, 2, 2)),
}
GRID = np.linspace(-2.0, 2.0, 21)
WEIGHT, STIFFNESS = 98.1, 1e5  # N, N/m


@pytest.mark.parametrize("spacing", [0.1, 0.03])
@pytest.mark.parametrize("name", TOUCHING)
def test_no_place_of_a_shape_is_farther_from_the_next_point_than_the_spacing(name, spacing):
    shape = TOUCHING[name]
    stand = shape.sampled(spacing)
    for place in stand.points:
        assert shape.distance(place)[0] == pytest.approx(-stand.radius, abs=1e-12)
    generator = np.random.default_rng(3)
    for place in generator.uniform(-0.5, 0.5, (200, 3)):
        distance, normal = shape.distance(place)
        if abs(distance) < 0.05:  # from farther in the normal leads past what is round
            on_shape = place - distance * normal
            assert shape.distance(on_shape)[0] == pytest.approx(0.0, abs=1e-12)
            assert np.linalg.norm(stand.points - on_shape, axis=1).min() <= stand.radius + spacing


def ground(kind: str) -> shapes.SurfaceShape:
    if kind == "field":
        return shapes.HeightField(GRID, GRID, np.zeros((21, 21)))
    slab = shapes.Convex([(x, y, z) for x in (-2, 2) for y in (-2, 2) for z in (-1, 0)])
    return shapes.Mesh(slab.vertices, slab.triangles)


def lying(shape: shapes.SurfaceShape, under: shapes.SurfaceShape, height: float, law: object = None) -> kf.System:
    scene = kf.System(gravity=(0, 0, -9.81))
    floor = scene.add_surface("floor", scene.ground, under)
    body = scene.add_rigid_body("body", WEIGHT / 9.81, 0.1, joint=kf.Free(position=(0.013, 0.017, height)))
    skin = scene.add_surface("skin", body, shape)
    law = law or kf.HuntCrossley(STIFFNESS, damping=1.0)
    scene.add_contact("lies", skin, floor, normal=law, friction=kf.Coulomb(0.5))
    return scene


@pytest.mark.parametrize("kind", ["field", "mesh"])
@pytest.mark.parametrize(
    ("shape", "half"),
    [
        (TOUCHING["box"], 0.05),
        (TOUCHING["hull"], 0.05),
        (shapes.Cylinder(0.2, 0.1, "z"), 0.05),
        (shapes.Capsule(0.1, 0.4), 0.1),
    ],
)
def test_what_lies_on_level_ground_sinks_by_its_weight_over_the_stiffness(shape, half, kind):
    """It has no tolerance but that of the balance: all points of the face that lies carry the same."""
    if isinstance(shape, shapes.Capsule):
        shape = shapes.Capsule(shape.radius, shape.length, "x")
    rest = kf.equilibrium(lying(shape, ground(kind), half + 0.01))
    assert rest.position("body")[2] == pytest.approx(half - WEIGHT / STIFFNESS, abs=1e-9)
    assert rest.contact("lies").normal == pytest.approx(WEIGHT, rel=1e-6)


def test_a_rigid_box_lies_on_a_field_of_heights():
    rest = kf.equilibrium(lying(TOUCHING["box"], ground("field"), 0.06, kf.Rigid()))
    assert rest.position("body")[2] == pytest.approx(0.05, abs=1e-9)


def test_a_mound_under_the_middle_of_a_box_carries_it():
    """Its corners are over the edge of the mound: 0.05 m lower than its top, to which the box sinks by some mm."""
    heights = 0.05 * np.exp(-(GRID[:, None] ** 2 + GRID**2) / (2.0 * 0.2**2))
    scene = lying(TOUCHING["box"].sampled(0.05), shapes.HeightField(GRID, GRID, heights), 0.15)
    rest = kf.equilibrium(scene)
    assert 0.09 < rest.position("body")[2] < 0.1
    # the forces along the normals, which lean by some degrees; corners would carry it at 0.05 m, and steeper
    assert WEIGHT < rest.contact("lies").normal < 1.01 * WEIGHT


def test_a_cylinder_that_stands_on_its_end_is_told_of():
    """Its rim has no lowest point: it took 28 s to fall 3 cm. Sampled it stands."""
    tin = shapes.Cylinder(0.1, 0.1, "z")
    with pytest.warns(kf.SimulationWarning, match=r"a rim that lies flat.*shape.sampled\(spacing\)"):
        lying(tin, shapes.Plane("z"), 0.06).freeze()
    rest = kf.equilibrium(lying(tin.sampled(0.05), shapes.Plane("z"), 0.06))
    assert rest.position("body")[2] == pytest.approx(0.05 - WEIGHT / STIFFNESS, abs=1e-9)


def test_points_are_closer_where_the_ground_is_finer():
    fine = np.linspace(-1.0, 1.0, 81)
    counts = []
    for places in (GRID, fine):
        scene = lying(TOUCHING["box"], shapes.HeightField(places, places, np.zeros((len(places), len(places)))), 0.1)
        counts.append(len(scene.freeze().loads[0].probes))
    assert counts[0] < counts[1] == len(TOUCHING["box"].sampled(0.125 * TOUCHING["box"].bounds.size).points)


def test_balls_of_a_tyre_roll_over_a_field_of_heights_and_keep_its_height():
    wheel = shapes.Torus(0.3, 0.05, "y").sampled(0.02)
    scene = lying(wheel, ground("field"), 0.36)
    rest = kf.equilibrium(scene)
    ripple = 0.02**2 / (8 * 0.3)
    assert 0.35 - WEIGHT / STIFFNESS - ripple < rest.position("body")[2] < 0.35


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda: shapes.Plane("z").sampled(0.1), "a plane is not represented by points"),
        (lambda: shapes.Box(SIZE, inside=True).sampled(0.1), "a box is not represented by points"),
        (lambda: shapes.Box(SIZE).sampled(0.0), "spacing must be one number, finite and > 0"),
        (
            lambda: shapes.Box((1.0, 1.0, 1.0)).sampled(1e-6),
            r"6e\+12 points would represent a box, and 4000 are permitted. Remedy",
        ),
        (
            lambda: shapes.Cylinder(1.0, 1.0).sampled(1e-6),
            "points would represent a .*, and 4000 are permitted. Remedy",
        ),
        (
            lambda: shapes.Capsule(0.1, 1.0).sampled(1e-320),
            "points would represent a .*, and 4000 are permitted. Remedy",
        ),
        (
            lambda: shapes.Box(SIZE).sampled(0.002),
            "points would represent a box, and 4000 are permitted. Remedy: a larger",
        ),
        (lambda: shapes.Points([(0, 0, 0)], share=2.0), "share of points is that of each of the whole stiffness"),
        (
            lambda: lying(TOUCHING["torus"], ground("mesh"), 1.0),
            r"Remedy: a plane, or points .* shape.sampled\(spacing\)",
        ),
    ],
)
def test_what_is_refused_by_name(call, told):
    with pytest.raises(kf.ModelError, match=told):
        call()
