"""Boxes on boxes: faces, corners, edges that cross, and what they rest and slide on."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from kanefe import shapes
from kanefe.frames import rotation_matrix
from kanefe.integrate.auto.suited_method import candidates
from kanefe.kernels.contact.contact_boxes import SLOT, HalfBox, box_slot, boxes_meet
from kanefe.kernels.force_elements.places import Ends
from kanefe.kernels.values.tensors import Vector
from kanefe.loads.action import End

LAW = kf.HuntCrossley(2e4, damping=0.4)
ROUGH = kf.Coulomb(0.4, stiffness=3e4, damping=20.0)


def end_at(p, turn=(1.0, 0.0, 0.0, 0.0)) -> End:
    return End(np.array(p, dtype=float), rotation_matrix(np.array(turn)), np.zeros(3), np.zeros(3))


class BoxPair:
    """How a box of half sizes `own` at an end meets one of half sizes `other` at a surface."""

    def __init__(self, surface: End, other, end: End, own):
        numbers = [x for one in (surface, end) for x in (*one.p, *one.A.ravel(), *one.v, *one.w)]
        ends = Ends(numbers)
        self._boxes = HalfBox(ends[1], Vector(*own)), HalfBox(ends[0], Vector(*other))
        self._met = boxes_meet(*self._boxes)
        self.normal, self.overlap = np.array(self._met.normal.numbers), self._met.overlap
        self.edges = (self._met.first, self._met.second) if self._met.first >= 0 else None

    def slot(self, i: int):
        """Return depth and place of a slot."""
        depth, point = box_slot(self._met, i, *self._boxes)
        return depth, np.array(point.numbers)


def pair(size=(0.4, 0.5, 0.6), other=(1.0, 0.8, 0.5), swapped: bool = False, friction=None) -> kf.System:
    scene = kf.System(gravity=(0, 0, -9.81))
    skins = []
    for name, dims in (("below", other), ("above", size)):
        body = scene.add_rigid_body(name, 2.0, (0.1, 0.12, 0.08), joint=kf.Free())
        skins.append(scene.add_surface(name, body, shapes.Box(dims)))
    scene.add_contact("contact", *(skins if swapped else skins[::-1]), normal=LAW, friction=friction)
    return scene


def states(model, count: int):
    """Return states in which the boxes are near each other, turned by up to all there is."""
    for seed in range(count):
        rng = np.random.default_rng(seed)
        q, u, z = model.parts(model.initial_state.copy())
        for at in (3, 10):
            e = np.array((1.0, 0, 0, 0)) + rng.choice((0.02, 1.0)) * rng.standard_normal(4)
            q[at : at + 4] = e / np.linalg.norm(e)
        away = rng.standard_normal(3)
        q[7:10] = rng.uniform(0.3, 0.8) * away / np.linalg.norm(away)
        z[:] = 1e-3 * rng.standard_normal(len(z))
        yield np.concatenate((q, rng.standard_normal(len(u)), z, (0.0, 0.0)))


@pytest.mark.filterwarnings("ignore:contact:kanefe.SimulationWarning")
@pytest.mark.parametrize("friction", [None, ROUGH], ids=["smooth", "rough"])
def test_routes_agree(friction):
    model = pair(friction=friction).freeze()
    led_by_edges = led_by_faces = 0
    for y in states(model, 40):
        theirs = model.literal.evaluate(0.0, y).rates
        np.testing.assert_allclose(model.route.evaluate(0.0, y).rates, theirs, rtol=1e-9, atol=1e-8)
        ends = model.literal.state(0.0, y).load_ends(0)
        met = BoxPair(ends[0], (0.5, 0.4, 0.25), ends[1], (0.2, 0.25, 0.3))
        led_by_edges += met.overlap > 0.0 and met.edges is not None
        led_by_faces += met.overlap > 0.0 and met.edges is None
    assert led_by_edges > 1
    assert led_by_faces > 5


@pytest.mark.filterwarnings("ignore:contact:kanefe.SimulationWarning")
def test_it_is_the_same_whichever_touches():
    one, other = pair().freeze(), pair(swapped=True).freeze()
    for y in states(one, 20):
        np.testing.assert_allclose(
            one.literal.evaluate(0.0, y).rates, other.literal.evaluate(0.0, y).rates, rtol=1e-9, atol=1e-9
        )


@pytest.mark.filterwarnings("ignore:contact:kanefe.SimulationWarning")
def test_derivatives_are_those_of_differences():
    model = pair(friction=ROUGH).freeze()
    done = 0
    for y in states(model, 12):
        if abs(model.literal.evaluate(0.0, y).rates[-2]) == 0.0:
            continue
        along = np.random.default_rng(1).standard_normal((1, len(y)))
        along[:, -2:] = 0.0
        found, h = model.route.derivatives(0.0, y, along)[0], 1e-7
        ends = [model.route.evaluate(0.0, y + side * h * along[0]).rates for side in (1.0, -1.0)]
        wanted = (ends[0] - ends[1]) / (2.0 * h)
        assert np.abs(found - wanted).max() < 1e-5 * np.abs(wanted).max()
        done += 1
    assert done > 3


def active(p, turn, own, other):
    """Return the slots of a box above the origin's box that touch, and their places."""
    surface, end = end_at((0, 0, 0)), end_at(p, turn)
    met = BoxPair(surface, other, end, own)
    slots = [(i, *met.slot(i)) for i in range(SLOT.slots)]
    return met, [(i, depth, point) for i, depth, point in slots if depth > 0.0]


def test_faces_share_a_polygon():
    """A box over the middle of a larger one, over its edge and over its corner, and turned on an equal one."""
    up, small, large = (1.0, 0.0, 0.0, 0.0), (0.1, 0.1, 0.1), (0.5, 0.5, 0.1)
    for place, corners in (
        ((0.2, 0.1), [(0.1, 0.0), (0.1, 0.2), (0.3, 0.0), (0.3, 0.2)]),
        ((0.47, 0.1), [(0.37, 0.0), (0.37, 0.2), (0.5, 0.0), (0.5, 0.2)]),
        ((0.47, 0.45), [(0.37, 0.35), (0.37, 0.5), (0.5, 0.35), (0.5, 0.5)]),
    ):
        met, found = active((*place, 0.199), up, small, large)
        np.testing.assert_allclose(met.normal, (0, 0, 1))
        np.testing.assert_allclose([depth for _, depth, _ in found], 0.001)
        np.testing.assert_allclose(sorted(point[:2].tolist() for _, _, point in found), corners, atol=1e-12)
    half = 0.5 * np.deg2rad(45.0)
    _, found = active((0, 0, 0.199), (np.cos(half), 0.0, 0.0, np.sin(half)), small, small)
    assert len(found) == 8
    np.testing.assert_allclose([np.hypot(*point[:2]) for _, _, point in found], 0.1 / np.cos(half), rtol=1e-12)


def test_edges_cross():
    """Two bars on edge, one across the other: they touch where the edges cross."""
    s = np.sqrt(0.5)
    on_edge_x = np.array((np.cos(np.pi / 8), np.sin(np.pi / 8), 0.0, 0.0))
    lower = end_at((0, 0, 0), on_edge_x)
    quarter = np.array((s, 0.0, 0.0, s))
    upper_turn = rotation_matrix(quarter) @ rotation_matrix(on_edge_x)
    half = np.array((1.0, 0.1, 0.1))
    upper = End(np.array((0.3, 0.1, 2 * 0.1 / s - 0.002)), upper_turn, np.zeros(3), np.zeros(3))
    met = BoxPair(lower, half, upper, half)
    np.testing.assert_allclose(met.normal, (0, 0, 1), atol=1e-12)
    assert met.edges == (0, 0)
    depth, point = met.slot(SLOT.edges)
    assert depth == pytest.approx(0.002, rel=1e-9)
    np.testing.assert_allclose(point, (0.3, 0.0, 0.1 / s - 0.002), atol=1e-12)
    assert all(met.slot(i)[0] < 0.0 for i in range(SLOT.edges))


@pytest.mark.parametrize(("offset", "falls"), [(0.0, False), (0.45, False), (0.55, True)])
def test_a_box_rests_on_another_until_its_centre_is_over_the_edge(offset, falls):
    scene = kf.System(gravity=(0, 0, -9.81))
    table = scene.add_surface("table", scene.ground, shapes.Box((1.0, 1.0, 0.2)))
    box = scene.add_rigid_body("box", 2.0, 2.0 * 0.04 / 6, joint=kf.Free(position=(offset, 0.0, 0.2 - 1e-4)))
    skin = scene.add_surface("skin", box, shapes.Box((0.2, 0.2, 0.2)))
    scene.add_contact("c", skin, table, normal=kf.HuntCrossley(1e5, damping=2.0), friction=kf.Coulomb(0.6))
    result = scene.simulate((0.0, 1.0))
    z = float(result.position("box")[-1, 2])
    if falls:
        assert z < 0.1
    else:
        sunk = 2.0 * 9.81 / 1e5
        lean = 0.0 if offset == 0.0 else sunk  # three quarters of a face lean by less than they sink
        assert z == pytest.approx(0.2 - sunk, abs=lean + 2e-6)
        assert result.contact("c").slip[-1] < (1e-9 if offset == 0.0 else 1e-4)  # it settles as it leans


def stack(count: int, stiffness: float = 1e5) -> kf.System:
    scene = kf.System(gravity=(0, 0, -9.81))
    lower = scene.add_surface("floor", scene.ground, shapes.Box((2.0, 2.0, 0.2)), at=(0, 0, -0.1))
    for i in range(count):
        start = kf.Free(position=(0.01 * i, 0.007 * i, 0.05 + 0.1 * i))
        box = scene.add_rigid_body(f"box {i}", 1.0, 1e-3, joint=start)
        upper = scene.add_surface(f"skin {i}", box, shapes.Box((0.1, 0.1, 0.1)))
        law = kf.HuntCrossley(stiffness, damping=0.3)
        scene.add_contact(f"c{i}", upper, lower, normal=law, friction=kf.Coulomb(0.5))
        lower = upper
    return scene


def test_auto_weighs_the_states_of_slots():
    """Systems of radau5 have 53 states a pair, most of slots that are open; it is taken where all is stiff."""
    few, stiff = (
        candidates(stack(2, k).freeze(), 0.0, span, 1e-6, 1e-7).choose() for k, span in ((1e5, 0.2), (1e9, 1e4))
    )
    assert few.name == "dop853"
    assert "but seldom acts" in few.reason
    assert stiff.name == "radau5"
    rest = kf.equilibrium(stack(2)).state
    assert stack(2).simulate((0.0, 0.2), start=rest).statistics["evaluations"] < 100  # it has nothing to follow
    auto, radau = (stack(2).simulate((0.0, 0.05), method=method) for method in ("auto", "radau5"))
    assert auto.statistics["evaluations"] < 10000
    assert abs(auto.position("box 1")[-1] - radau.position("box 1")[-1]).max() < 1e-7
