"""Convex shapes on each other, by coal: distances against closed forms, and what contacts do by them."""

from __future__ import annotations

import sys

import numpy as np
import pytest

import kanefe as kf
from contact_scenes import LAW, assert_routes_agree, scene_of
from kanefe import shapes
from kanefe.contact.geometry import _coal
from kanefe.contact.geometry._coal import nearest

G = 9.81
needs_library = pytest.mark.collision


def turned(rng) -> np.ndarray:
    Q, R = np.linalg.qr(rng.standard_normal((3, 3)))
    Q = Q * np.sign(np.diag(R))
    return Q * np.linalg.det(Q)


def apart(a, u, b, v) -> float:
    """Return the distance of segments a + s u and b + t v, s and t of -1 to 1: of all candidates the least."""
    places = [np.linalg.solve([[u @ u, -u @ v], [u @ v, -v @ v]], [(b - a) @ u, (b - a) @ v])]
    for end in (-1.0, 1.0):
        places.append((end, np.clip((a + end * u - b) @ v / (v @ v), -1, 1)))
        places.append((np.clip((b + end * v - a) @ u / (u @ u), -1, 1), end))
    inside = [(s, t) for s, t in places if max(abs(s), abs(t)) <= 1.0]
    return min(float(np.linalg.norm(a + s * u - b - t * v)) for s, t in inside)


@needs_library
def test_capsules_are_as_far_as_their_axes_less_their_radii():
    rng, one, other = np.random.default_rng(0), shapes.Capsule(0.1, 1.0, "z"), shapes.Capsule(0.2, 0.6, (1, 1, 0))
    seen = np.zeros(2)
    for _ in range(100):
        R, x = turned(rng), 0.4 * rng.standard_normal(3)
        gap, normal, point = nearest(one, R, x, other)
        wanted = apart(x, 0.5 * R[:, 2], np.zeros(3), 0.3 * other.axis) - 0.3
        assert gap == pytest.approx(wanted, abs=1e-12)
        assert np.linalg.norm(normal) == pytest.approx(1.0, abs=1e-12)
        # the place is in the middle between both surfaces
        if gap > -0.1:
            assert one.distance(R.T @ (point - x))[0] == pytest.approx(0.5 * gap, abs=1e-9)
            assert other.distance(point)[0] == pytest.approx(0.5 * gap, abs=1e-9)
        seen[int(gap < 0.0)] += 1
        assert nearest(one, R, x + 1e-6 * normal, other)[0] == pytest.approx(gap + 1e-6, abs=1e-9)
    assert seen.min() > 10


@needs_library
@pytest.mark.parametrize(
    "one",
    [
        shapes.Convex(np.random.default_rng(1).standard_normal((30, 3)) * 0.3),
        shapes.Cylinder(0.2, 0.6, "y"),
        shapes.Box((0.2, 0.3, 0.5)),
    ],
    ids=["hull", "cylinder", "box"],
)
def test_what_stands_over_a_large_box_is_as_far_as_its_lowest_place(one):
    rng, table = np.random.default_rng(2), shapes.Convex([probe.point for probe in shapes.Box((8, 8, 2)).probes()])
    for x in (0.9, 0.3, 0.1, 0.05):
        R = turned(rng)
        if isinstance(one, shapes.Cylinder):
            axis = float(R[2, 1])
            lowest = -0.3 * abs(axis) - 0.2 * np.sqrt(1.0 - axis**2)
        else:
            lowest = min(float((R @ probe.point)[2]) for probe in one.probes())
        gap, normal, _ = nearest(one, R, np.array((0.1, 0.2, x + 1.0)), table)
        assert gap == pytest.approx(x + lowest, abs=1e-10)
        np.testing.assert_allclose(normal, (0, 0, 1), atol=1e-9)


@needs_library
@pytest.mark.parametrize(
    ("touched", "touching"),
    [
        (shapes.Capsule(0.4, 0.8), shapes.Capsule(0.2, 0.5, "y")),
        (shapes.Box((1.0, 0.9, 0.8)), shapes.Convex([(-0.3, 0, 0), (0.3, 0, 0), (0, 0.3, 0.1), (0, 0, 0.4)])),
        (shapes.Box((1.0, 0.9, 0.8)), shapes.Capsule(0.2, 0.5, "x")),
    ],
    ids=["capsules", "hull on box", "capsule on box"],
)
def test_routes_agree(touched, touching):
    """Poses differ by round-off, of which hpp-fcl makes up to 1e-8 m at edges: 4e-4 N, 4e-5 J."""
    friction = kf.Coulomb(0.4, static=0.5, stiffness=3e4, damping=20.0)
    assert_routes_agree(scene_of(touched, touching, LAW, friction), range(12), (0.6, 0.65, 0.7), atol=1e-2)


@needs_library
def test_rods_that_meet_crosswise_bounce_as_by_the_closed_form():
    """K07: what Kelvin's and Voigt's law without tension leaves of a speed, 0.744079 at a damping ratio of 0.1."""
    k, m = 1e5, 2.0
    scene = kf.System()
    rail = scene.add_surface("rail", scene.ground, shapes.Capsule(0.1, 1.0, "x"))
    rod = scene.add_rigid_body("rod", m, 0.1, joint=kf.Free(position=(0.1, 0, 0.25), velocity=(0, 0, -1.0)))
    skin = scene.add_surface("skin", rod, shapes.Capsule(0.1, 1.0, "y"))
    scene.add_contact("c", skin, rail, normal=kf.KelvinVoigt(k, damping=0.2 * np.sqrt(k * m)))
    result = scene.simulate((0.0, 0.2), rtol=1e-9)
    np.testing.assert_allclose(result.events["c touch"], 0.05, rtol=1e-9)
    assert result.velocity("rod")[-1, 2] == pytest.approx(0.744079, abs=1e-6)
    assert abs(result.energy.balance_error).max() < 1e-7


@needs_library
def test_a_bar_on_two_rails_slides_and_stays():
    """A capsule across two: each carries half; pushed along itself it goes v^2/(2 mu g), and sticks."""
    m, mu, v = 3.0, 0.4, 1.0
    k = 1e5
    sunk = 0.5 * m * G / k
    scene = kf.System(gravity=(0, 0, -G))
    bar = scene.add_rigid_body("bar", m, 0.2, joint=kf.Free(position=(0, 0, 0.15 - sunk), velocity=(v, 0, 0)))
    skin = scene.add_surface("skin", bar, shapes.Capsule(0.05, 4.0, "x"))
    for name, x in (("left", -0.5), ("right", 0.5)):
        rail = scene.add_surface(name, scene.ground, shapes.Capsule(0.1, 2.0, "y"), at=(x, 0, 0))
        scene.add_contact(f"on {name}", skin, rail, normal=kf.HuntCrossley(k, damping=2.0), friction=kf.Coulomb(mu))
    result = scene.simulate((0.0, 0.5), rtol=1e-6)
    way = v**2 / (2.0 * mu * G)
    # the arm of friction about the middle loads one rail more, and where it stops it rings: both carry the weight
    assert result.position("bar")[-1, 0] == pytest.approx(way, rel=2e-3)
    assert sum(result.contact(c).normal[-1] for c in ("on left", "on right")) == pytest.approx(m * G, rel=1e-2)
    assert result.contact("on left").status[-1] == "sticks"
    assert abs(result.energy.balance_error).max() < 1e-6


@needs_library
def test_a_bar_rests_on_rails():
    scene = kf.System(gravity=(0, 0, -G))
    bar = scene.add_rigid_body("bar", 3.0, 0.2, joint=kf.Prismatic("z", position=0.16))
    skin = scene.add_surface("skin", bar, shapes.Cylinder(0.05, 2.0, "x"))
    rail = scene.add_surface("rail", scene.ground, shapes.Capsule(0.1, 2.0, "y"))
    scene.add_contact("c", skin, rail, normal=kf.HuntCrossley(1e5))
    rest = kf.equilibrium(scene)
    assert rest.load("c")[3] == pytest.approx(3.0 * G, rel=1e-9)
    assert rest.load("c")[5] == pytest.approx(3.0 * G / 1e5, rel=1e-6)


def test_a_hull_lies_on_a_plane_by_its_corners():
    """Without the library: a roof on its side of four corners, which share the stiffness."""
    roof = shapes.Convex([(x, y, 0.0) for x in (-0.2, 0.2) for y in (-0.3, 0.3)] + [(0, -0.3, 0.2), (0, 0.3, 0.2)])
    assert [probe.share for probe in roof.probes()] == [0.25] * 6
    scene = kf.System(gravity=(0, 0, -G))
    floor = scene.add_surface("floor", scene.ground, shapes.Plane("z"))
    body = scene.add_rigid_body("roof", 2.0, 0.05, joint=kf.Free(position=(0, 0, 1e-4)))
    scene.add_contact("c", scene.add_surface("skin", body, roof), floor, normal=kf.HuntCrossley(1e5, damping=2.0))
    rest = kf.equilibrium(scene)
    assert rest.load("c")[3] == pytest.approx(2.0 * G, rel=1e-9)
    assert rest.load("c")[5] == pytest.approx(2.0 * G / 1e5, rel=1e-9)


def test_balls_touch_a_hull_as_a_mesh():
    corners = shapes.Box((1.0, 2.0, 3.0)).probes()
    hull, box = shapes.Convex([probe.point for probe in corners]), shapes.Box((1.0, 2.0, 3.0))
    for x in np.random.default_rng(3).uniform(-2, 2, (50, 3)):
        assert hull.distance(x)[0] == pytest.approx(box.distance(x)[0], abs=1e-12)
    for points in ([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)]):
        with pytest.raises(kf.ModelError, match="four or more, not in one plane"):
            shapes.Convex(points)
    with pytest.raises(kf.ModelError, match=r"shape \(n, 3\)"):
        shapes.Convex([(0, np.nan, 0)] * 5)


def two_rods():
    scene = kf.System()
    body = scene.add_rigid_body("body", 1.0, 0.1, joint=kf.Free())
    rods = scene.ground, body
    return scene, [scene.add_surface(f"rod {i}", rods[i], shapes.Capsule(0.1, 1.0)) for i in (0, 1)]


def test_a_missing_library_is_named_where_it_is_needed(monkeypatch):
    scene, (one, other) = two_rods()
    monkeypatch.setitem(sys.modules, "coal", None)
    monkeypatch.setitem(sys.modules, "hppfcl", None)
    _coal._library.cache_clear()
    with pytest.raises(kf.MissingDependency, match=r"'c', of a capsule on a capsule, needs coal.*kanefe\[collision\]"):
        scene.add_contact("c", one, other, normal=LAW)


@needs_library
def test_rigid_ones_are_refused_by_name():
    scene, (one, other) = two_rods()
    with pytest.raises(kf.ModelError, match="rigid contact of a capsule on a capsule is not supported"):
        scene.add_contact("c", one, other, normal=kf.Rigid())
