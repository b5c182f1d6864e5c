"""Convex shapes on each other: distances against closed forms and coal, and what contacts do by them."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from coal_distance import nearest as by_coal
from contact_scenes import LAW, assert_routes_agree, scene_of
from kanefe import shapes
from kanefe.contact.convex_numbers import convex_numbers, slots_of
from kanefe.kernels.compiler.local_numbers import local_numbers
from kanefe.kernels.contact.convex_distance import Simplex, gap_along, gap_and_normal
from kanefe.kernels.contact.convex_edges import Slot
from kanefe.kernels.contact.convex_patch import put_slots
from kanefe.kernels.contact.convex_shapes import ConvexShape, Posed
from kanefe.kernels.values.records import column
from kanefe.kernels.values.tensors import Matrix, Vector

G = 9.81


def tilted(axis: str, angle: float) -> np.ndarray:
    """Return the matrix of a rotation about y or z."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array(((c, 0, s), (0, 1, 0), (-s, 0, c)) if axis == "y" else ((c, -s, 0), (s, c, 0), (0, 0, 1)))


class Pair:
    """Two convex shapes, the first one turned and moved in the axes of the other."""

    def __init__(self, one, other, label: str = "pair") -> None:
        self._own, self._other = (ConvexShape(convex_numbers(shape).tolist()) for shape in (one, other))
        self.margins = self._own.margin + self._other.margin
        self._count = slots_of(one, other, label)

    def gap(self, R, x):
        """Return gap, normal and place."""
        gap, normal, place = gap_and_normal(self._posed(R, x), self._other, Simplex(local_numbers()))
        return gap, np.array(normal.numbers), np.array(place.numbers)

    def _posed(self, R, x) -> Posed:
        return Posed(self._own, Matrix(*R.ravel().tolist()), Vector(*x))

    def along(self, R, x, normal) -> float:
        """Return the gap along a direction."""
        return gap_along(self._posed(R, x), self._other, Vector(*normal)) - self.margins

    def slots(self, R, x):
        """Return the gap, and the places where they touch (n, 8)."""
        room = local_numbers()
        gap = put_slots(self._posed(R, x), self._other, self._count, room)
        return gap, np.array(room[: OF_SLOT * self._count]).reshape(-1, OF_SLOT)


def nearest(one, R, x, other):
    return Pair(one, other).gap(R, x)


OF_SLOT, DEPTH, PLACE, SHARE = Slot.number_count, *(column(Slot, name) for name in ("depth", "place", "share"))
RANDOM = np.random.default_rng(7)
CONVEX = {
    "box": shapes.Box((0.4, 0.3, 0.2)),
    "cylinder": shapes.Cylinder(0.15, 0.4, "y"),
    "disc": shapes.Cylinder(0.2, 0.1, (1, 1, 0)),
    "capsule": shapes.Capsule(0.1, 0.5, "z"),
    "hull": shapes.Convex(0.2 * RANDOM.standard_normal((20, 3)) + 0.1),
}
ROUND = 1e-5
"""What hpp-fcl, the older coal, leaves of distances to round edges, m; ours are a lower bound of them to 1e-9."""


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


@pytest.mark.collision
@pytest.mark.parametrize("one", CONVEX.values(), ids=list(CONVEX))
@pytest.mark.parametrize("other", CONVEX.values(), ids=list(CONVEX))
def test_shapes_apart_are_as_far_as_coal_says(one, other):
    """A distance is the largest gap along any direction: coal's normal gives none that is larger than ours."""
    rng, pair, apart = np.random.default_rng(3), Pair(one, other), 0
    for _ in range(12):
        R, x = turned(rng), rng.standard_normal(3)
        x *= rng.uniform(0.3, 0.9) / np.linalg.norm(x)
        (gap, normal, _), (theirs, their_normal, _) = pair.gap(R, x), by_coal(one, R, x, other)
        if theirs < 1e-2:
            continue
        apart += 1
        assert gap == pytest.approx(theirs, abs=ROUND)
        assert pair.along(R, x, their_normal) <= gap + 1e-9
        assert pair.along(R, x, normal) == pytest.approx(gap, abs=1e-9)
    assert apart > 3


@pytest.mark.parametrize("one", CONVEX.values(), ids=list(CONVEX))
@pytest.mark.parametrize("other", CONVEX.values(), ids=list(CONVEX))
def test_places_share_the_whole_and_one_is_the_deepest(one, other):
    rng, pair = np.random.default_rng(4), Pair(one, other)
    for _ in range(3):
        R, x = turned(rng), rng.standard_normal(3)
        gap, normal, _ = pair.gap(R, x)
        x = x - (gap + 1e-3) * normal  # 1 mm deep along it
        gap, slots = pair.slots(R, x)
        carries = slots[slots[:, SHARE] > 0.0]
        assert -2e-2 < gap < 0.0
        assert carries[:, SHARE].sum() == pytest.approx(1.0, abs=1e-8)
        assert carries[:, DEPTH].max() == pytest.approx(-gap, abs=2e-7)  # within 1e-7 of the size over a face


def test_a_least_way_out_parts_shapes():
    """Moved along the normal by their depth they touch, and in no direction nearby is the way shorter."""
    rng = np.random.default_rng(5)
    for one in CONVEX.values():
        for other in CONVEX.values():
            pair, R, x = Pair(one, other), turned(rng), rng.standard_normal(3)
            gap, normal, _ = pair.gap(R, x)
            x = x - (gap + 5e-3) * normal
            gap, normal, _ = pair.gap(R, x)
            assert -6e-3 < gap < -2e-3
            assert pair.gap(R, x + (1e-4 - gap) * normal)[0] == pytest.approx(
                1e-4, abs=1e-8
            )  # normals are known to 1e-8
            for _ in range(5):
                nearby = normal + 1e-3 * rng.standard_normal(3)
                assert pair.along(R, x, nearby / np.linalg.norm(nearby)) <= gap + 1e-9


@pytest.mark.parametrize("depth", [1e-6, 1e-4, 5e-3])
def test_no_way_out_is_longer_than_the_one_that_is_known(depth):
    """Three shapes in a hundred once were 0.03 m in each other: a flat tetrahedron seemed to be all around."""
    for seed in range(2):
        rng = np.random.default_rng(100 + seed)
        for one in CONVEX.values():
            for other in CONVEX.values():
                pair, R, x = Pair(one, other), turned(rng), rng.standard_normal(3)
                gap, normal, _ = pair.gap(R, x)
                gap, _, _ = pair.gap(R, x - (gap + depth) * normal)
                assert -gap < depth + 3e-7  # of 0.5 m, between rims


def test_a_cylinder_that_rocks_on_a_box_changes_its_places_continuously():
    """It lies, tilts both ways and rolls: force and moment of a stiffness of one have no jumps."""
    pair, radius = Pair(shapes.Cylinder(0.05, 0.2, "x"), shapes.Box((1.0, 1.0, 0.2))), 0.05
    for step in (1e-4, 1e-5):
        angles = np.arange(-40, 41) * step
        wrenches = []
        for angle in angles:
            slots = pair.slots(tilted("y", angle), np.array((0.1, 0.2, 0.1 + radius - 1e-3)))[1]
            force = slots[:, SHARE] * np.maximum(slots[:, DEPTH], 0.0)
            wrenches.append((force.sum(), force @ (slots[:, PLACE : PLACE + 3] - 0.1)))
        # half the length is 0.1 m, where a turn moves it by as much, and the arm is as long
        assert np.abs(np.diff([w[0] for w in wrenches])).max() < 0.1 * step
        assert np.abs(np.diff([w[1][0] for w in wrenches])).max() < 0.2 * 0.1 * step
        assert wrenches[len(wrenches) // 2][0] == pytest.approx(1e-3, rel=1e-6)


@pytest.mark.parametrize("turn", [0.0, 0.3])
def test_two_faces_share_as_the_polygon_between_them(turn):
    """Of a box on a hull that is a larger box: force and moments of a tilt are those of four corners."""
    table = shapes.Convex([probe.point for probe in shapes.Box((2, 2, 1)).probes()])
    pair, half = Pair(shapes.Convex([p.point for p in shapes.Box((0.4, 0.2, 0.2)).probes()]), table), (0.2, 0.1)
    R = tilted("z", turn) @ tilted("y", 1e-3)
    gap, slots = pair.slots(R, np.array((0.1, 0.2, 0.595)))
    assert gap == pytest.approx(-0.005 - half[0] * np.sin(1e-3) + 0.1 * (1.0 - np.cos(1e-3)), abs=1e-6)
    force = slots[:, SHARE] * np.maximum(slots[:, DEPTH], 0.0)
    offsets = (slots[:, PLACE : PLACE + 3] - (0.1, 0.2, 0.5)) @ tilted("z", turn)
    assert force.sum() == pytest.approx(0.005, rel=1e-3)
    # corners at half the length are by 1e-3 of that deeper or less deep
    assert abs(force @ offsets[:, 0]) == pytest.approx(1e-3 * half[0] ** 2, rel=2e-2)
    assert force @ offsets[:, 1] == pytest.approx(0.0, abs=1e-9)


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
    friction = kf.Coulomb(0.4, static=0.5, stiffness=3e4, damping=20.0)
    assert_routes_agree(scene_of(touched, touching, LAW, friction), range(12), (0.6, 0.65, 0.7))


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


def test_a_face_of_too_many_corners_is_refused():
    angles = np.linspace(0.0, 2.0 * np.pi, 120, endpoint=False)
    drum = shapes.Convex([(np.cos(a), np.sin(a), z) for a in angles for z in (-0.5, 0.5)])
    scene, (one, _) = two_rods()
    body = scene.add_rigid_body("drum", 1.0, 0.1, joint=kf.Free())
    with pytest.raises(kf.ModelError, match=r"'c'.*corners.*fewer points"):
        scene.add_contact(
            "c", scene.add_surface("skin", body, drum), scene.add_surface("box", one.frame, drum), normal=LAW
        )


def test_rigid_ones_are_refused_by_name():
    scene, (one, other) = two_rods()
    with pytest.raises(kf.ModelError, match="rigid contact of a capsule on a capsule is not supported"):
        scene.add_contact("c", one, other, normal=kf.Rigid())
