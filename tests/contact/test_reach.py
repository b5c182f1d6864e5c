"""What is out of reach: nothing of it is computed, nothing is missed, and both routes agree."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest

import kanefe as kf
import scenes
from kanefe import shapes
from kanefe.kernels.events import roots_of_step
from kanefe.kernels.events.watched_run import Lookouts, Passage, WatchedRun
from kanefe.kernels.loads.acting import acting_in
from kanefe.kernels.loads.reach import Bound, Bounds, ReachSizes, find_near, gap_to
from kanefe.kernels.scene import state_in, work_in
from kanefe.kernels.sweeps.outward import sweep_outward
from kanefe.kernels.values.filled import filled_rows
from kanefe.kernels.values.tensors import Vector
from kanefe.order_n.tables import reach_tables
from touched_shapes import TOUCHED

LAW = kf.HuntCrossley(2e4, damping=0.4)
ROUGH = kf.Coulomb(0.4, stiffness=3e4, damping=20.0)
SKIN = shapes.Sphere(0.1)
STATIC = kf.Coulomb(0.3, static=0.5, stiffness=3e4, damping=20.0)


@pytest.mark.parametrize("shape", TOUCHED.values(), ids=TOUCHED)
def test_what_is_out_of_bounds_does_not_touch(shape):
    """Of balls that a shape's bounds say are away, all balls in them are away; some of those near by are not told."""
    rng = np.random.default_rng(3)
    bounds = shape.bounds
    own = {name: getattr(bounds, name) for name in ("axes", "lower", "upper", "rounding", "stretch", "is_room")}
    own |= {"row": -1, "first_ball": 0, "ball_count": 0, "origin": np.zeros(3)}
    bound = Bounds(*filled_rows(Bound, [own]))[0]
    told = 0
    for _ in range(1000):
        centre, radius = rng.uniform(-1.5, 1.5, 3), rng.uniform(0.0, 0.2)
        if gap_to(bound, Vector(*(bounds.axes.T @ centre)), radius) <= 0.0:
            continue
        told += 1
        for _ in range(5):
            inner = rng.uniform(0.0, 1.0) * radius
            along = rng.standard_normal(3)
            x = centre + (radius - inner) * along / np.linalg.norm(along)
            assert inner - shape.distance(x)[0] <= 0.0
    assert told > 2


def patches(h: float, friction=None, arm: bool = False) -> kf.System:
    """Return a lattice above a floor, with two patches of four points, of which one turns, and a point on a ball."""
    scene = kf.System(gravity=(0, 0, -9.81))
    body = scenes.lattice_body(1, {"tip": "rigid"}, interior=4, reduction=kf.CraigBampton(modes=8))
    member = scene.add_flexible_body("lattice", body, joint=kf.Free(position=(0, 0, h)))
    floor = scene.add_surface("floor", scene.ground, shapes.Plane("z"))
    tip = member.interface("tip")
    corners = [tip.frame(at=(0.1 * (i % 2), 0.1 * (i // 2), -0.2)) for i in range(4)]
    for i, frames in enumerate(([member.node(n) for n in range(4)], corners)):
        if arm:
            frames = [frame.frame(at=(0.02, 0.01, -0.03), orientation=kf.rotation_about("x", 0.3)) for frame in frames]
        scene.add_contact(f"patch {i}", frames, floor, normal=LAW, friction=friction)
    ball = scene.add_rigid_body("ball", 1.0, 0.1, joint=kf.Free(position=(0.5, 0.0, -0.6)))
    skin = scene.add_surface("skin", ball, shapes.Sphere(0.4))
    scene.add_contact("on ball", [member.node(5)], skin, normal=LAW, friction=friction)
    return scene


def displaced(model, seed: int) -> np.ndarray:
    q, u = scenes.random_state(model, seed)
    return np.concatenate((q, u, 1e-3 * np.random.default_rng(seed).standard_normal(model.state_count), (0.0, 0.0)))


@pytest.mark.filterwarnings("ignore:contact:kanefe.SimulationWarning")
@pytest.mark.parametrize("friction", [None, STATIC], ids=["smooth", "rough"])
@pytest.mark.parametrize("arm", [False, True])
def test_routes_agree_on_patches(arm, friction):
    pushed, model = 0, patches(3.0, friction, arm).freeze()
    assert model.route.name == "order n"
    for h in (0.1, 0.4, 3.0):
        for seed in range(6):
            y = displaced(model, seed)
            y[2] = h
            theirs = model.literal.evaluate(0.0, y).rates
            np.testing.assert_allclose(model.route.evaluate(0.0, y).rates, theirs, rtol=1e-9, atol=1e-9)
            ours, literal = model.route.energy(0.0, y), model.literal.energy(0.0, y)
            assert ours.total == pytest.approx(literal.total, rel=1e-12)
            status = model.loads[0].touches(model.literal.state(0.0, y).load_ends(0), np.zeros(50))
            pushed += any(touch.depth > 0.0 for touch in status)
    assert pushed > 0  # modes, and so these states, differ by sign from one LAPACK to another


def test_points_of_patches_have_no_rows():
    scene = patches(3.0)
    bare = kf.System()
    bare.add_flexible_body("lattice", scene.body("lattice").body, joint=kf.Free())
    bare.add_rigid_body("ball", 1.0, 0.1, joint=kf.Free())
    assert len(scene.freeze().route.tables.rows) == len(bare.freeze().route.tables.rows)


def cloud(count: int, friction=None) -> kf.System:
    scene = kf.System()
    rng = np.random.default_rng(7)
    skins = []
    for i in range(count):
        ball = scene.add_rigid_body(f"ball {i}", 1.0, 0.1, joint=kf.Free(position=tuple(rng.uniform(-1.0, 1.0, 3))))
        skins.append(scene.add_surface(f"skin {i}", ball, shapes.Sphere(rng.uniform(0.05, 0.25))))
    scene.add_contacts(skins, normal=LAW, friction=friction)
    return scene


def near_loads(model, y: np.ndarray) -> int:
    """Return how many loads are evaluated at a state, as the kernels find them."""
    route = model.route
    work = work_in(route.scene, np.zeros(route.memory_size))
    sweep_outward(route.scene, state_in(route.tables, 0.0, y, np.zeros((0, 3)), np.zeros(0)), work, False)
    find_near(route.scene, work)
    return int((acting_in(route.scene, work).nearness > 0.0).sum())


@pytest.mark.filterwarnings("ignore:contact:kanefe.SimulationWarning")
@pytest.mark.parametrize("friction", [None, ROUGH], ids=["smooth", "rough"])
def test_of_many_balls_only_those_that_meet_are_looked_at(friction):
    model = cloud(24, friction).freeze()
    reach = model.route.between.reach
    assert len(reach.teams) == 0
    assert len(reach.balls) == 24  # a ball that touches and is touched counts once
    y = displaced(model, 5)
    y[: model.coordinate_count] = model.initial_state[: model.coordinate_count]
    depths = [
        float(np.linalg.norm(y[7 * i : 7 * i + 3] - y[7 * j : 7 * j + 3]))
        - sum(load.probes[0][1].radius + load.shape.radius for load in (model.loads[k],))
        for k, (i, j) in enumerate((i, j) for i in range(24) for j in range(i + 1, 24))
    ]
    touching, near = sum(d < 0.0 for d in depths), near_loads(model, y)
    assert 0 < touching <= near <= touching + 5 < len(depths) / 4
    np.testing.assert_allclose(
        model.route.evaluate(0.0, y).rates, model.literal.evaluate(0.0, y).rates, rtol=1e-10, atol=1e-9
    )
    assert model.route.energy(0.0, y).total == pytest.approx(model.literal.energy(0.0, y).total, rel=1e-12)


def test_events_of_what_comes_from_far_are_found():
    """Two balls that fly past each other touch for a moment: by a sweep, and each by itself."""
    touches = []
    for count in (2, 12):
        scene = kf.System()
        skins = []
        for i in range(count):
            at, speed = (float(i), 0.0, 0.0), (0.0, 0.0, 0.0)
            if i == 0:
                at, speed = (1.0, 0.7, 0.19), (0.0, -1.5, 0.0)
            ball = scene.add_rigid_body(f"ball {i}", 1.0, 0.1, joint=kf.Free(position=at, velocity=speed))
            skins.append(scene.add_surface(f"skin {i}", ball, shapes.Sphere(0.1)))
        scene.add_contacts(skins, normal=LAW)
        result = scene.simulate((0.0, 1.0))
        touches.append(np.concatenate([times for name, times in result.events.items() if name.endswith("touch")]))
    exact = (0.7 - np.sqrt(0.2**2 - 0.19**2)) / 1.5
    for found in touches:
        np.testing.assert_allclose(found, [exact], atol=1e-9)


def box_of_balls(count: int) -> kf.System:
    """Return balls that fly about in a box, between walls."""
    scene, rng = kf.System(gravity=(0, 0, -9.81)), np.random.default_rng(3)
    side = int(np.ceil(count ** (1 / 3)))
    skins = []
    for i in range(count):
        place = 0.3 * (np.array((i % side, i // side % side, i // side**2)) + 0.5) + rng.uniform(-0.04, 0.04, 3)
        joint = kf.Free(position=tuple(place), velocity=tuple(rng.uniform(-1.0, 1.0, 3)))
        skins.append(scene.add_surface(f"skin {i}", scene.add_rigid_body(f"ball {i}", 1.0, 4e-3, joint=joint), SKIN))
    for at, axis in ((0, "z"), (0, "x"), (side, "-x"), (0, "y"), (side, "-y")):
        place = tuple(0.3 * at * (name == axis[-1]) for name in "xyz")
        skins.append(scene.add_surface(f"wall {axis}", scene.ground.frame(at=place), shapes.Plane(axis)))
    scene.add_contacts(skins, normal=kf.HuntCrossley(1e5, damping=0.3))
    return scene


def test_events_of_many_balls_do_not_depend_on_how_pairs_are_found(monkeypatch):
    touches = []
    for sweep_from in (0, 1000):
        monkeypatch.setattr(reach_tables, "SWEEP_FROM", sweep_from)
        scene = box_of_balls(9)
        events = scene.simulate((0.0, 0.15), rtol=1e-8, output_step=0.05).events
        assert ReachSizes(scene.freeze().route.between.reach.sizes).swept_balls == (9 if sweep_from == 0 else 0)
        touches.append(sorted((x[0], name) for name, x in events.items() if name.endswith("touch") and len(x)))
    assert [name for _, name in touches[0]] == [name for _, name in touches[1]]
    assert len(touches[0]) > 5
    np.testing.assert_allclose([t for t, _ in touches[0]], [t for t, _ in touches[1]], atol=1e-7)


class Known(NamedTuple):
    """What `find_roots` sees of a step with one event of one load, where `near` tells whether it is looked at."""

    times: np.ndarray
    found: np.ndarray
    near: np.ndarray


@pytest.mark.parametrize("near", [0.0, 1.0])
def test_an_estimate_beside_values_is_no_dip(near, monkeypatch):
    """What was nowhere near is looked at once, where the step begins; no minimum is searched between both."""
    looks = []

    def value(data, t):
        looks.append(t)
        single.found[0, 0] = -2.05e-3
        return -2.05e-3

    monkeypatch.setattr(roots_of_step, "value_at", value)
    times, values = np.array((0.25, 0.5, 0.75, 1.0)), np.array([-2.0, -1.95, -1.9, -1.85])[:, None] * 1e-3
    step = Known(times, values, np.array((near,)))
    single = Known(times, np.zeros((1, 1)), np.ones(1))
    one, none = np.zeros(1, dtype=np.int64), np.zeros(1)
    watched = WatchedRun(
        *(one, one + 1, one, one, none.copy(), np.array((-3.0e-3,)), none, none - np.inf, np.empty((4, 2)), one),
        *(np.empty((0, 4)), np.empty(5), np.empty(5), np.empty((8, 2)), np.empty((4, 2)), one, none, none, none, 0),
        *(none, 1.0, 1.0, 1e-6, 1.0),
    )
    assert roots_of_step.find_roots(step, Passage(Lookouts(step, step, single, None), watched, None, 0.0), 0.0) == 0
    assert looks == ([0.0] if near else [])
    assert watched.known[0] == near
    assert watched.values[0] == (-2.05e-3 if near else -3.0e-3)
