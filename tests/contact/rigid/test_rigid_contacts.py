"""Rigid contacts: what touches, sticks, slips and bounces without yielding, and what is refused of them."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pytest

import kanefe as kf
from kanefe import shapes
from kanefe.checks.verification.rigid_contact import rocking_block
from kanefe.constraints.rows import MarkerMotion
from kanefe.contact.rigid.meeting import Meeting, meetings_with
from kanefe.kernels.contact.rigid_points import SLIPPING
from kanefe.kernels.impacts.contact_questions import Asks
from kanefe.literal.contact_forces import probe_forces
from kanefe.states.constraints import meetings

G = 9.81
GRID = np.linspace(-2.0, 2.0, 9)
HILLS = 0.1 * np.outer(np.sin(2.0 * GRID), np.cos(GRID))


def on_floor(**start: object) -> tuple[kf.System, object, object]:
    scene = kf.System(gravity=(0, 0, -G))
    floor = scene.add_surface("floor", scene.ground, shapes.Plane("z"))
    return scene, floor, scene.add_rigid_body("body", 1.0, 0.02, joint=kf.Free(**start))


PAIRS = {
    "ball on plane": (shapes.Plane((0.2, -0.1, 1.0)), shapes.Sphere(0.3)),
    "points on plane": (shapes.Plane((0.2, -0.1, 1.0)), shapes.Points([(0.1, 0.2, -0.3), (0.0, -0.1, 0.2)])),
    "ring on plane": (shapes.Plane((0.2, -0.1, 1.0)), shapes.Torus(0.4, 0.1, axis=(1.0, 0.2, 0.3))),
    "ball on ball": (shapes.Sphere(0.7), shapes.Sphere(0.3)),
    "ball in a room": (shapes.Sphere(1.5, inside=True), shapes.Sphere(0.3)),
    "ball on hills": (shapes.HeightField(GRID, GRID, HILLS), shapes.Sphere(0.2)),
    "point on hills": (shapes.HeightField(GRID, GRID, HILLS), shapes.Points([(0.1, 0.2, -0.3)])),
}


@pytest.mark.parametrize("pair", PAIRS.values(), ids=PAIRS)
def test_rates_of_rates_are_exact(pair):
    """The rate of the gap is that of the rows, and its own rate is ``J du + remainder``: by central differences.

    Of what is on hills along the normal alone, and where it is: their distance is that from a tangent plane.
    """
    scene = kf.System(gravity=(0, 0, -G))
    table = scene.add_rigid_body("table", 3.0, (0.2, 0.3, 0.4), joint=kf.Free())
    away = kf.Free(position=(0, 0, 0 if getattr(pair[0], "inside", False) else 5))
    thing = scene.add_rigid_body("thing", 1.0, (0.1, 0.12, 0.08), com=(0.05, 0, 0), joint=away)
    top = scene.add_surface("top", table, pair[0], at=(0.1, 0, 0), orientation=kf.rotation_about("y", 0.2))
    skin = scene.add_surface("skin", thing, pair[1], at=(0, 0.02, 0))
    scene.add_contact("c", skin, top, normal=kf.Rigid())
    model = scene.freeze()
    rng = np.random.default_rng(3)
    q, u, z = model.parts(model.initial_state.copy())
    q[:3], q[7:10] = 0.1 * rng.standard_normal(3), (0.3, 0.2, 1.2)
    for at in (3, 10):
        q[at : at + 4] += 0.2 * rng.standard_normal(4)
        q[at : at + 4] /= np.linalg.norm(q[at : at + 4])
    u[:] = rng.standard_normal(len(u))
    y, rates = np.concatenate((q, u, z)), model.rhs(0.0, np.concatenate((q, u, z)))

    def met(step):
        return meetings(model.literal.view(0.0, y + step * rates))[0]

    step = 1e-5
    now, ahead, behind = met(0.0), met(step), met(-step)
    for one, after, before in zip(now, ahead, behind, strict=True):
        assert (after.gap - before.gap) / (2 * step) == pytest.approx(one.rates[0], abs=1e-8)
        # free fall: the accelerations of the frames are in the remainders but for J du, which is found by rows
        state = model.literal.view(0.0, y)
        a, b = state.marker(model.loads[0].ends[0]), state.marker(model.loads[0].ends[1])
        e, J = one.axes[0], np.zeros(len(u))
        for F, sign in ((b, 1.0), (a, -1.0)):
            force, arm = F.A_NF.T @ e, F.A_NF.T @ (one.point - F.p_NoFo_N)
            J += sign * (force @ F.V + np.cross(arm, force) @ F.W)
        assert J @ u == pytest.approx(one.rates[0], abs=1e-12)
        found = J @ rates[len(q) : len(q) + len(u)] + one.remainder[0]
        assert found == pytest.approx((after.rates[0] - before.rates[0]) / (2 * step), abs=2e-7)


def test_a_table_on_four_legs_stands_and_its_legs_carry_it():
    """What each leg carries is not determined; together they do, none pulls, and nothing moves."""
    scene, floor, table = on_floor(position=(0, 0, 0.7))
    feet = [table.frame(at=(x, y, -0.7)) for x in (-0.4, 0.4) for y in (-0.3, 0.3)]
    load = scene.add_rigid_body("load", 3.0, 0.01, parent=table, at=(0.3, 0.2, 0.0))
    assert load is not None
    scene.add_contact("c", feet, floor, normal=kf.Rigid(), friction=kf.Coulomb(0.5))
    result = scene.simulate((0.0, 1.0), output_step=0.25)
    history = result.contact("c")
    np.testing.assert_allclose(history.normal, 4.0 * G, rtol=1e-12)
    assert set(history.status) == {"sticks"}
    assert history.slip[-1] == 0.0
    assert abs(result.position("body") - (0, 0, 0.7)).max() < 1e-14
    forces = probe_forces(result.run.model.literal.view(1.0, result.run.states[-1]))
    assert min(force.normal for force in forces) >= -1e-9
    np.testing.assert_allclose(result.joint_reaction("load")[-1, :3], (0, 0, 3.0 * G), atol=1e-9)


@pytest.mark.parametrize("impact", ["newton", "poisson"])
@pytest.mark.parametrize("mu", [0.1, 1.0])
def test_a_ball_that_strikes_slides_or_grips(impact, mu):
    """Impulses of a ball with spin: it grips where 2/7 of the slip's momentum is within the cone of the normal's."""
    e, v, slip = 0.6, 2.0, 1.4
    scene = kf.System()
    floor = scene.add_surface("floor", scene.ground, shapes.Plane("z"))
    start = kf.Free(position=(0, 0, 0.2), velocity=(slip, 0, -v))
    ball = scene.add_rigid_body("ball", 1.0, 0.4 * 0.1**2, joint=start)
    skin = scene.add_surface("skin", ball, shapes.Sphere(0.1))
    scene.add_contact("c", skin, floor, normal=kf.Rigid(e, impact), friction=kf.Coulomb(mu))
    result = scene.simulate((0.0, 0.2), rtol=1e-10, output_step=0.1)
    impulse = min(mu * (1.0 + e) * v, 2.0 / 7.0 * slip)
    np.testing.assert_allclose(result.velocity("ball")[-1], (slip - impulse, 0, e * v), atol=1e-12)
    np.testing.assert_allclose(result.angular_velocity("ball")[-1], (0, impulse / 0.04, 0), atol=1e-11)
    assert abs(result.energy.balance_error).max() < 1e-12


def test_newtons_and_poissons_impacts_differ_where_others_take_part():
    """A rod falls level on two supports of unlike laws: each parts with its share of its speed, or of its impulse."""
    speeds = {}
    for impact in ("newton", "poisson"):
        scene = kf.System()
        floor = scene.add_surface("floor", scene.ground, shapes.Plane("z"))
        start = kf.Free(position=(0, 0, 0.1), velocity=(0, 0, -1.0))
        rod = scene.add_rigid_body("rod", 1.0, 1.0 / 12.0, joint=start)
        for name, x, e in (("left", -0.5, 0.0), ("right", 0.25, 0.5)):
            scene.add_contact(name, rod.frame(at=(x, 0, 0)), floor, normal=kf.Rigid(e, impact))
        result = scene.simulate((0.0, 0.11), rtol=1e-9, output_times=(0.0, 0.11))
        v, w = result.velocity("rod")[-1, 2], result.angular_velocity("rod")[-1, 1]
        speeds[impact] = v + 0.5 * w, v - 0.25 * w
    np.testing.assert_allclose(speeds["newton"], (0.0, 0.5), atol=1e-10)
    # stopped by 1/3 and 2/3 at the ends; then half of 2/3 more on the right, and as much on the left as keeps it there
    inverse = np.array([[1.0 + 12 * 0.25, 1.0 - 12 * 0.125], [1.0 - 12 * 0.125, 1.0 + 12 * 0.0625]])
    stopped = np.linalg.solve(inverse, (1.0, 1.0))
    after = inverse[:, 1] * 0.5 * stopped[1]
    kept = max(0.0, -after[0] / inverse[0, 0])
    np.testing.assert_allclose(speeds["poisson"], after + inverse[:, 0] * kept, atol=1e-10)


def test_no_impact_is_missed_where_a_step_ends_just_before_it():
    """Between two walls steps of 2 ms end at impacts but for round-off."""
    scene = kf.System()
    mass = scene.add_point("mass", 1.0, joint=kf.Prismatic("x", speed=1.0))
    for name, normal, x in (("left", "x", -1e-3), ("right", "-x", 1e-3)):
        wall = scene.add_surface(name, scene.ground, shapes.Plane(normal), at=(x, 0, 0))
        scene.add_contact(name, mass, wall, normal=kf.Rigid(1.0))
    result = scene.simulate((0.0, 0.04), rtol=1e-8, output_step=0.04)
    touches = np.sort(np.concatenate([result.events[f"{name} touch"] for name in ("left", "right")]))
    np.testing.assert_allclose(touches, 1e-3 + 2e-3 * np.arange(20), atol=1e-13)


def test_a_block_rocks_down_to_rest_through_infinitely_many_impacts():
    result = rocking_block(0.3, size=(1.0, 1.0)).simulate((0.0, 1.5), rtol=1e-7, output_step=0.1)
    (rest,) = result.events["c rest"]
    assert result.events["c touch"][-1] < rest < 1.5
    assert result.contact("c").status[-1] == "sticks"
    assert abs(result.angular_velocity("block")[-1]).max() < 1e-9
    assert result.position("block")[-1, 2] == pytest.approx(0.5, abs=1e-9)


def test_a_run_goes_on_from_a_checkpoint_inside_a_stick(tmp_path):
    """A block on a slope that is tilted until it slips: to the bit as if it had not been interrupted."""

    def tilted(**options):
        scene = kf.System(gravity=(0, 0, -G))
        turning = kf.Motion(lambda t: 0.4 * t, lambda t: 0.4, lambda t: 0.0)
        table = scene.add_rigid_body("table", 1.0, 1.0, joint=kf.Revolute("y", motion=turning))
        top = scene.add_surface("top", table, shapes.Plane("z"))
        block = scene.add_rigid_body("block", 1.0, 0.01, joint=kf.Free())
        scene.add_contact("c", block, top, normal=kf.Rigid(), friction=kf.Coulomb(0.2, static=0.3))
        return scene.simulate((0.0, 1.0), rtol=1e-8, output_step=0.1, **options)

    whole, path = tilted(), tmp_path / "run.npz"
    cut = tilted(checkpoint=path, most_steps=6)
    assert not cut.status.is_finished
    assert cut.contact("c").status[-1] == "sticks"
    resumed = tilted(resume=path)
    np.testing.assert_array_equal(resumed.position("block"), whole.position("block"))
    np.testing.assert_array_equal(resumed.events["c slip"], whole.events["c slip"])
    # the floor's own turning adds nothing at the axis: tan(0.4 t) = 0.3
    assert whole.events["c slip"][0] == pytest.approx(math.atan(0.3) / 0.4, abs=1e-8)


def test_a_stuck_block_does_not_creep_and_a_run_may_begin_in_a_stick():
    scene, floor, body = on_floor()
    scene.add_force(body, lambda t: (2.0 * math.sin(40.0 * t), 0.0, 0.0))
    scene.add_contact("c", body, floor, normal=kf.Rigid(), friction=kf.Coulomb(0.3))
    result = scene.simulate((0.0, 2.0), rtol=1e-3, output_step=0.5)
    assert result.contact("c").slip[-1] == 0.0
    assert abs(result.position("body")).max() < 1e-14
    again = scene.copy().simulate((2.0, 3.0), start=result.at(2.0), rtol=1e-3, output_step=0.5)
    assert abs(again.position("body")).max() < 1e-14


def test_reactions_and_forces_of_what_slips_balance():
    """A driven sledge under a block that slips on it: the drive pulls the friction and its own inertia."""
    scene = kf.System(gravity=(0, 0, -G))
    pulled = kf.Motion(lambda t: 4.0 * t * t, lambda t: 8.0 * t, lambda t: 8.0)
    sledge = scene.add_rigid_body("sledge", 2.0, 1.0, joint=kf.Prismatic("x", motion=pulled))
    top = scene.add_surface("top", sledge, shapes.Plane("z"))
    block = scene.add_rigid_body("block", 1.0, 0.01, joint=kf.Free())
    scene.add_contact("c", block, top, normal=kf.Rigid(), friction=kf.Coulomb(0.5))
    result = scene.simulate((0.0, 0.5), rtol=1e-8, output_step=0.1)
    history = result.contact("c")
    np.testing.assert_allclose(history.tangential[1:], 0.5 * G, rtol=1e-10)
    np.testing.assert_allclose(result.driving_force("sledge").reshape(-1)[1:], 2.0 * 8.0 + 0.5 * G, rtol=1e-9)
    np.testing.assert_allclose(result.joint_reaction("sledge")[1:, 2], 3.0 * G, rtol=1e-9)
    assert abs(result.energy.balance_error).max() < 1e-9
    assert history.work[-1] == pytest.approx(0.5 * G * (4.0 - 0.25 * G) * 0.25, rel=1e-8)


def test_an_event_sees_the_force_of_a_contact_and_a_load_may_not():
    scene, floor, body = on_floor()
    scene.add_force(body, lambda t: (0.0, 0.0, 20.0 * t))
    scene.add_contact("c", body, floor, normal=kf.Rigid())
    half = kf.Event("half", lambda t, state: state.load("c")[3] - 0.5 * G, direction=-1)
    result = scene.copy().simulate((0.0, 0.6), events=half)
    assert result.events["half"] == pytest.approx([G / 40.0], abs=1e-9)
    assert result.events["c lift"] == pytest.approx([G / 20.0], abs=1e-9)
    scene.add_force(body, lambda t, state: 0.1 * state.load("c")[:3])
    with pytest.raises(kf.ModelError, match="circular"):
        scene.simulate((0.0, 0.1))


def test_a_scene_with_rigid_contacts_is_pickled_and_frozen_twice():
    scene, floor, body = on_floor(position=(0, 0, 0.1), velocity=(1.0, 0, 0))
    scene.add_contact("c", body, floor, normal=kf.Rigid(0.5), friction=kf.Coulomb(0.5))
    model = pickle.loads(pickle.dumps(scene.freeze()))
    y = model.route.start(0.0)
    y[2], y[9] = 0.0, -1.0
    found = model.literal.asked_contacts(Asks.TOUCH, 0.0, y, 1.0).changed()
    np.testing.assert_allclose(model.parts(found.y)[1][:3], (1.0 - min(1.0, 0.5 * 1.5), 0.0, 0.5), atol=1e-12)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"normal": 3.0}, "must be a law"),
        ({"friction": kf.Coulomb((0.3, 0.4))}, "same in all directions"),
        ({"friction": kf.Coulomb(0.3, stiffness=1e5)}, "without springs"),
        ({"friction": kf.Coulomb(0.3, rolling=0.01)}, "turn freely"),
        ({"friction": kf.LuGre(1e5, 300.0, 0.4, 1.0, 1.5, 1e-3)}, "is Coulomb's"),
        ({"surface_velocity": (1, 0, 0)}, "no friction"),
    ],
)
def test_what_a_rigid_contact_has_not_is_refused(options, message):
    scene, floor, body = on_floor()
    with pytest.raises(kf.ModelError, match=message):
        scene.add_contact("c", body, floor, **{"normal": kf.Rigid(), **options})


@pytest.mark.parametrize("motion", [None, kf.Motion.steady(0.5)])
def test_a_contact_between_what_nothing_moves_is_refused(motion):
    """Of a lever that is fixed, or driven, against the ground: it is not friction that leaves its force open."""
    scene = kf.System(gravity=(0, 0, -G))
    joint = kf.Fixed() if motion is None else kf.Revolute("y", motion=motion)
    lever = scene.add_rigid_body("lever", 1.0, 0.1, joint=joint)
    tip = scene.add_surface("tip", lever, shapes.Sphere(0.1), at=(1, 0, 0))
    floor = scene.add_surface("floor", scene.ground.frame(at=(0, 0, -0.5)), shapes.Plane("z"))
    scene.add_rigid_body("other", 1.0, 0.1, joint=kf.Free())
    scene.add_contact("c", tip, floor, normal=kf.Rigid(), friction=kf.Coulomb(0.3))
    with pytest.raises(kf.ModelError, match=r"'c'.*neither its surface.*probe 1 is free.*Remedy"):
        scene.freeze()


@pytest.mark.parametrize(
    ("touched", "touching", "message"),
    [
        (shapes.Capsule(0.5, 1.0), shapes.Sphere(0.1), "a capsule has edges"),
        (shapes.Box((1, 1, 1), inside=True), shapes.Sphere(0.1), "a box has edges"),
    ],
)
def test_shapes_that_rigid_contacts_do_not_follow_are_refused(touched, touching, message):
    scene, _, body = on_floor()
    skin = scene.add_surface("skin", body, touching)
    with pytest.raises(kf.ModelError, match=message):
        scene.add_contact("c", skin, scene.add_surface("other", scene.ground, touched), normal=kf.Rigid())


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((1.2,), "restitution of Rigid"),
        ((-0.1,), "restitution of Rigid"),
        ((0.5, "moreau"), "'poisson' or 'distributing'"),
    ],
)
def test_laws_of_impact_are_checked(arguments, message):
    with pytest.raises(kf.ModelError, match=message):
        kf.Rigid(*arguments)


def test_what_begins_in_a_surface_and_what_does_not_serve_is_refused():
    scene, floor, body = on_floor(position=(0, 0, -0.01))
    scene.add_contact("c", body, floor, normal=kf.Rigid())
    with pytest.raises(kf.ModelError, match=r"begins 0\.01 m deep"):
        scene.freeze()
    scene, floor, body = on_floor()
    scene.add_contact("c", body, floor, normal=kf.Rigid())
    for analysis in (kf.buckling, kf.stability_limit, kf.floquet):
        with pytest.raises(kf.ModelError, match="not supported with rigid contacts, here rigid contact 'c'"):
            analysis(scene)
    for method in ("generalised-alpha", "hht"):
        with pytest.raises(kf.ModelError, match="does not handle the rigid contact 'c'"):
            scene.simulate((0.0, 1.0), method=method, step=0.1)


def test_painleves_paradox_ends_a_run_with_cause_and_remedy():
    """A rod that is pushed slides into positions in which friction below the limit of the start has no answer."""
    scene, floor, _ = on_floor(position=(0, 0, 5.0))
    angle = math.radians(45.0)
    start = kf.Free(
        position=(0.5 * math.cos(angle), 0, 0.5 * math.sin(angle)),
        orientation=kf.rotation_about("y", -angle),
        velocity=(-5.0, 0, 0),
    )
    rod = scene.add_rigid_body("rod", 1.0, (1e-3, 1.0 / 12.0, 1.0 / 12.0), joint=start)
    scene.add_contact("c", rod.frame(at=(-0.5, 0, 0)), floor, normal=kf.Rigid(), friction=kf.Coulomb(1.6))
    with pytest.warns(kf.SimulationWarning, match="Painleve"):
        result = scene.simulate((0.0, 1.0), rtol=1e-8)
    assert result.status.kind == "failed"
    assert "HuntCrossley" in result.status.remedy
    assert 0.0 < result.status.time < 0.1


def test_what_lies_and_slides_is_met_once_a_state_and_only_where_it_touches(monkeypatch):
    """A box that slides on four of its eight corners: one call for all of them in each evaluation and projection."""
    calls: list[int] = []

    def counted(shape, probes, *motions):
        calls.append(len(probes))
        return meetings_with(shape, probes, *motions)

    monkeypatch.setattr("kanefe.contact.rigid.rigid_contact.meetings_with", counted)
    scene, floor, body = on_floor(position=(0, 0, 0.1), velocity=(3.0, 0.3, 0))
    scene.add_contact(
        "c",
        scene.add_surface("skin", body, shapes.Box((0.6, 0.4, 0.2))),
        floor,
        normal=kf.Rigid(),
        friction=kf.Coulomb(0.5),
    )
    model = scene.freeze()
    y = model.route.start(0.0)
    for ask in (model.literal.evaluate, model.literal.projected):
        calls.clear()
        ask(0.0, y)
        assert calls == [4]


def test_a_slip_ends_where_it_goes_back_or_has_turned() -> None:
    scene, floor, body = on_floor(position=(0.0, 0.0, 1.0))
    scene.add_contact("foot", body.frame(), floor, normal=kf.Rigid(), friction=kf.Coulomb(0.5))
    contact, surface = scene.freeze().rigid_contact(0), MarkerMotion(np.zeros(3), np.eye(3), *[np.zeros(3)] * 4)

    def left(kept: float, rates: tuple[float, float]) -> float:
        """Of one that was kept along x, where axes along the surface are x and y."""
        met = Meeting(0.0, np.zeros(3), np.zeros(3), np.eye(3)[[2, 0, 1]], np.array((0.0, *rates)), np.zeros(3))
        return contact.left_of_slip(met, np.array((kept, 0.0, 0.0)), surface)

    turned = np.array((SLIPPING.turned, np.sqrt(1.0 - SLIPPING.turned**2)))
    for kept in (1e-9, 1e-10):
        assert left(kept, 3.0 * turned) == pytest.approx(0.0, abs=1e-15)
        assert left(kept, (3.0, 0.0)) == pytest.approx(3.0 - 3.0 * SLIPPING.turned)
    assert left(0.2, (-SLIPPING.back * 0.2, 0.0)) == pytest.approx(0.0, abs=1e-15)
    assert left(0.2, (0.0, 0.0)) == pytest.approx(SLIPPING.back * 0.2)
    assert left(0.2, (0.2, 0.0)) == pytest.approx(0.0, abs=1e-15)
