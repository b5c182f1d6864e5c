"""Steps of Moreau and Jean over impacts, of a few contacts and of many."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from kanefe import shapes
from kanefe.literal.impact_steps import struck
from kanefe.order_n import granular_contacts as granular
from kanefe.order_n.route import OrderN

G = 9.81
WALLS = (("z", (0, 0, 0)), ("x", (0, 0, 0)), ("-x", (0.3, 0, 0)), ("y", (0, 0, 0)), ("-y", (0, 0.3, 0)))


def boxed(count: int, law: kf.Rigid, mu: float, *, is_granular: bool = True, seed: int = 1) -> kf.System:
    """Return balls in a box that fall on each other; with a contact of its own for each pair, or one for all."""
    rng, radius = np.random.default_rng(seed), 0.06
    scene = kf.System(gravity=(0, 0, -G))
    walls = [scene.add_surface(f"w{i}", scene.ground, shapes.Plane(n), at=at) for i, (n, at) in enumerate(WALLS)]
    skins = []
    for i in range(count):
        start = kf.Free(
            position=(*rng.uniform(0.1, 0.2, 2), 0.07 + 0.13 * i),
            velocity=rng.standard_normal(3),
            angular_velocity=5 * rng.standard_normal(3),
        )
        ball = scene.add_rigid_body(f"b{i}", 1.0 + i, (0.001, 0.0015, 0.002), joint=start)
        skins.append(scene.add_surface(f"s{i}", ball, shapes.Sphere(radius)))
    friction = kf.Coulomb(mu)
    if is_granular:
        scene.add_contacts([*skins, *walls], normal=law, friction=friction)
        return scene
    for i, skin in enumerate(skins):
        for other in (*skins[i + 1 :], *walls):
            scene.add_contact(f"{skin.name} on {other.name}", skin, other, normal=law, friction=friction)
    return scene


@pytest.mark.parametrize(("e", "mu"), [(0.5, 0.3), (0.0, 0.6), (1.0, 0.0)])
def test_compiled_steps_are_those_of_the_literal_equations(monkeypatch, e, mu):
    monkeypatch.setattr(granular, "ENOUGH", 1e-13)
    options = {"method": "moreau-jean", "step": 4e-3, "output_step": 4e-3}
    many = boxed(3, kf.Rigid(e), mu).simulate((0.0, 0.2), **options)
    pairs = boxed(3, kf.Rigid(e), mu, is_granular=False).simulate((0.0, 0.2), **options)
    assert many.load("contacts among s0 and others")[:, 0].max() >= 2
    for name in ("b0", "b1", "b2"):
        np.testing.assert_allclose(many.position(name), pairs.position(name), atol=1e-10)
        np.testing.assert_allclose(many.angular_velocity(name), pairs.angular_velocity(name), atol=1e-7)
    assert many.statistics["penetration"] == pytest.approx(pairs.statistics["penetration"], rel=1e-9)
    for result in (many, pairs):
        assert result.statistics["contact_residual"] < 1e-8
        assert abs(result.energy.balance_error).max() < 1e-3  # what turns unevenly has errors of h^2
    taken = pairs.energy.dissipated[-1]
    assert many.energy.dissipated[-1] == pytest.approx(taken, rel=1e-7, abs=1e-12)
    assert taken == pytest.approx(0.0, abs=1e-12) if e == 1.0 else taken > 1.0


@pytest.mark.parametrize("h", [0.02, 0.004])
def test_a_pushed_block_stops_where_it_has_to(h):
    """The step in which it stops has an error of h^2, all others none."""
    scene = kf.System(gravity=(0, 0, -G))
    floor = scene.add_surface("floor", scene.ground, shapes.Plane("z"))
    block = scene.add_rigid_body("block", 1.0, 0.01, joint=kf.Free(velocity=(3.0, 0, 0)))
    scene.add_contact("c", block, floor, normal=kf.Rigid(), friction=kf.Coulomb(0.5))
    result = scene.simulate((0.0, 0.8), method="moreau-jean", step=h)
    assert result.position("block")[-1, 0] == pytest.approx(9.0 / G, abs=0.125 * 0.5 * G * h**2 * 1.01)
    history = result.contact("c")
    assert history.status[-1] == "sticks"
    assert history.work[-1] == pytest.approx(4.5, rel=1e-12)
    assert history.tangential[1] == pytest.approx(0.5 * G)


@pytest.mark.parametrize("h", [8e-3, 1e-3])
def test_an_impact_is_early_or_late_by_half_a_step_at_most(h):
    e, fall = 0.8, np.sqrt(2.0 / G)
    scene = kf.System(gravity=(0, 0, -G))
    floor = scene.add_surface("floor", scene.ground, shapes.Plane("z"))
    ball = scene.add_point("ball", 1.0, joint=kf.Prismatic("z", position=1.0))
    scene.add_contact("c", ball, floor, normal=kf.Rigid(e))
    result = scene.simulate((0.0, 0.8), method="moreau-jean", step=h, output_step=0.08)
    t = 0.8 - fall
    exact = e * G * fall * t - 0.5 * G * t * t
    assert abs(result.position("ball")[-1, 2] - exact) < 0.5 * (1.0 + e) * G * fall * h
    assert abs(result.energy.balance_error).max() < 1e-11
    assert result.statistics["penetration"] < G * fall * h


def test_steps_keep_loops_closed():
    scene = kf.System(gravity=(0, 0, -G))
    floor = scene.add_surface("floor", scene.ground, shapes.Plane("z"), at=(0, 0, -0.9))
    bob = scene.add_rigid_body("bob", 1.0, 0.01, joint=kf.Free(position=(0.6, 0, -0.8)))
    scene.add_distance("rope", scene.ground, bob, 1.0)
    scene.add_contact("c", bob, floor, normal=kf.Rigid(0.5), friction=kf.Coulomb(0.2))
    result = scene.simulate((0.0, 0.6), method="moreau-jean", step=2e-3, output_step=0.01)
    assert abs(np.linalg.norm(result.position("bob"), axis=1) - 1.0).max() < 1e-5  # lines between steps
    assert result.position("bob")[:, 2].min() > -0.905
    assert result.energy.dissipated[-1] > 0.1


def test_a_run_of_a_crowd_is_the_same_however_it_is_cut(tmp_path):
    options = {"method": "moreau-jean", "step": 1e-3}
    law = kf.Rigid(0.3)
    whole = boxed(4, law, 0.3).simulate((0.0, 0.3), output_step=0.3, **options)
    fine = boxed(4, law, 0.3).simulate((0.0, 0.3), output_step=1e-3, **options)
    np.testing.assert_allclose(whole.run.states[-1], fine.run.states[-1], rtol=0, atol=1e-9)
    path = tmp_path / "run.npz"
    part = boxed(4, law, 0.3).simulate((0.0, 0.3), output_step=0.1, checkpoint=path, most_steps=150, **options)
    assert not part.status.is_finished
    full = boxed(4, law, 0.3).simulate((0.0, 0.3), output_step=0.1, **options)
    resumed = boxed(4, law, 0.3).simulate((0.0, 0.3), output_step=0.1, resume=path, **options)
    np.testing.assert_allclose(resumed.run.states, full.run.states, rtol=0, atol=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_impulses_of_a_crowd_make_no_energy(seed):
    """Balls that roll over each other and along walls, which turn their motions round within steps."""
    rng = np.random.default_rng(seed)
    scene = boxed(4, kf.Rigid(rng.uniform()), rng.uniform(), seed=seed)
    result = scene.simulate((0.0, 1.0), method="moreau-jean", step=1e-3, output_step=1e-3)
    # sweeps end at 1e-5 of the speeds, of which an impulse of weight, (g h)^2 to what balls have at the start, is 1e-5
    assert np.diff(result.energy.dissipated).min() > -1e-9 * result.energy.kinetic[0]


def test_auto_takes_it_for_a_crowd_and_says_why():
    result = boxed(4, kf.Rigid(0.3), 0.3).simulate((0.0, 0.1))
    assert result.statistics["method"] == "moreau-jean"
    assert "26 pairs" in result.statistics["reason"]
    assert result.status.is_finished
    few = boxed(1, kf.Rigid(0.3), 0.3).simulate((0.0, 0.01), output_step=0.01)
    assert few.statistics["method"] == "dop853"


def test_balls_in_a_room_and_those_that_pass_through_each_other():
    scene = kf.System(gravity=(0, 0, -G))
    room = scene.add_surface("room", scene.ground, shapes.Sphere(1.0, inside=True))
    skins = []
    for i, x in enumerate(np.arange(-0.6, 0.65, 0.1)):
        ball = scene.add_rigid_body(f"b{i}", 1.0, 0.001, joint=kf.Free(position=(x, 0, 0)))
        skins.append(scene.add_surface(f"s{i}", ball, shapes.Sphere(0.05)))
    ignored = [(a, b) for i, a in enumerate(skins) for b in skins[i + 1 :]]
    scene.add_contacts([room, *skins], normal=kf.Rigid(), ignore=ignored)
    result = scene.simulate((0.0, 3.0), method="moreau-jean", step=1e-3, output_step=0.01)
    places = np.array([result.position(f"b{i}") for i in range(13)])
    lengths = np.linalg.norm(places, axis=-1)
    assert (
        0.95 < lengths.max() < 0.95 + 0.5 * 2.0 * G * 1e-3 * 3.0
    )  # along what curves, steps leave by v^2 h^2 / 2 R each
    assert abs(places[..., 1]).max() < 1e-12
    # without friction what slides in the room keeps its energy from its first impact on, and passes the lowest place
    assert np.array([(np.diff(np.sign(place[:, 0])) != 0).sum() >= 2 for place in places]).all()


def test_what_steps_over_impacts_have_not_is_refused():
    with pytest.raises(kf.ModelError, match="impacts of time stepping and one coefficient"):
        boxed(4, kf.Rigid(0.3, "poisson"), 0.3)
    scene = boxed(4, kf.Rigid(0.3), 0.3)
    for method in ("dop853", "radau5", "generalised-alpha"):
        with pytest.raises(kf.ModelError, match="are too many"):
            scene.copy().simulate((0.0, 0.1), method=method)
    with pytest.raises(kf.ModelError, match="needs a step"):
        scene.copy().simulate((0.0, 0.1), method="moreau-jean")
    pair = boxed(1, kf.Rigid(0.3, "poisson"), 0.3)
    with pytest.raises(kf.ModelError, match="has Newton's impact law only"):
        pair.simulate((0.0, 0.1), method="moreau-jean", step=1e-3)
    free = kf.System()
    free.add_rigid_body("b", 1.0, 1.0, joint=kf.Free())
    with pytest.raises(kf.ModelError, match="of which the scene has none"):
        free.simulate((0.0, 0.1), method="moreau-jean", step=1e-3)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"com": (0.01, 0, 0)}, "centre of mass is not its origin"),
        ({"joint": kf.Planar()}, "does not move freely"),
        ({"at": (0, 0, 1.0)}, "from the ground's origin"),
        ({"force": (1.0, 0, 0)}, "no forces on body 'other'"),
        ({"spring": 1.0}, "no other loads between frames"),
    ],
)
def test_a_crowd_is_of_loose_bodies(options, message):
    scene = boxed(4, kf.Rigid(0.3), 0.3)
    force, spring = options.pop("force", None), options.pop("spring", None)
    other = scene.add_rigid_body("other", 1.0, 0.1, **{"joint": kf.Free(position=(0, 0, 3)), **options})
    if force is not None:
        scene.add_force(other, force)
    if spring is not None:
        scene.add_spring("spring", scene.ground, other, stiffness=spring)
    with pytest.raises(kf.ModelError, match=message):
        scene.simulate((0.0, 0.1))


def test_surfaces_that_a_crowd_does_not_take_are_refused():
    scene = kf.System()
    balls = [
        scene.add_surface(f"s{i}", scene.add_rigid_body(f"b{i}", 1.0, 0.1, joint=kf.Free(position=(i, 0, 0))), skin)
        for i, skin in enumerate([shapes.Sphere(0.1)] * 5 + [shapes.Box((0.1, 0.1, 0.1))])
    ]
    with pytest.raises(kf.ModelError, match="surface 's5' is a box"):
        scene.add_contacts(balls, normal=kf.Rigid())
    with pytest.raises(kf.ModelError, match="one coefficient"):
        scene.add_contacts(balls[:-1] * 2, normal=kf.Rigid(), friction=kf.Coulomb(0.3, static=0.4))


@pytest.mark.parametrize(
    ("spoiled", "message"),
    [
        (lambda x: np.zeros_like(x), "'c': penetrated by .* m, more than the error of steps"),
        (lambda x: -x, "'c' has a tensile impulse of 0.0981 N s"),
        (lambda x: x + np.array((0.0, 0.6 * x[0], 0.0)), "impulse of friction of .* 'c' is .* more than mu N = "),
    ],
)
def test_steps_that_break_a_law_are_an_error_of_the_run(monkeypatch, spoiled, message):
    def wrong(*given):
        impulses, left, lowered = struck(*given)
        return spoiled(impulses), left, lowered

    monkeypatch.setattr("kanefe.literal.impact_steps.struck", wrong)
    monkeypatch.setattr(OrderN, "impact_steps", lambda self, *given: None)
    scene = kf.System(gravity=(0, 0, -G))
    floor = scene.add_surface("floor", scene.ground, shapes.Plane("z"))
    block = scene.add_rigid_body("block", 1.0, 0.01, joint=kf.Free())
    scene.add_contact("c", block, floor, normal=kf.Rigid(), friction=kf.Coulomb(0.5))
    with pytest.warns(kf.SimulationWarning, match=message):
        result = scene.simulate((0.0, 0.1), method="moreau-jean", step=0.01)
    assert result.status.kind == "failed"


def test_impulses_of_a_crowd_that_break_a_law_are_an_error_of_the_run(monkeypatch):
    wrong = property(lambda self: np.array([(1.0, 0.4, 0.0)]))
    monkeypatch.setattr(granular.GranularSteps, "impulses", wrong)
    with pytest.warns(kf.SimulationWarning, match="have friction beyond mu N by 0.1 N s"):
        boxed(3, kf.Rigid(), 0.3).simulate((0.0, 0.01), method="moreau-jean", step=1e-3)


GRID = np.linspace(-0.6, 0.6, 13)
HILLS = shapes.HeightField(GRID, GRID, 0.02 * np.add.outer(np.sin(9.0 * GRID), np.cos(7.0 * GRID)))


@pytest.mark.parametrize("wall", [HILLS, shapes.Sphere(0.4)], ids=["hills", "post"])
def test_walls_of_a_crowd_are_those_of_its_pairs(monkeypatch, wall):
    """A turned surface that is not flat: the same steps as with a contact for each pair by the literal equations."""
    monkeypatch.setattr(granular, "ENOUGH", 1e-13)
    found = []
    for is_granular in (True, False):
        scene = kf.System(gravity=(0, 0, -G))
        depth = -0.4 if wall is not HILLS else 0.0
        turn = kf.rotation_about((1, 2, 0), 0.1)
        skins = []
        for i in range(5):
            start = kf.Free(position=(0.13 * (i - 2), 0.02 * i, 0.2), angular_velocity=(0, 5.0, 1.0))
            ball = scene.add_rigid_body(f"b{i}", 1.0, 0.001, joint=start)
            skins.append(scene.add_surface(f"s{i}", ball, shapes.Sphere(0.05)))
        skins.append(scene.add_surface("ground", scene.ground, wall, at=(0.05, 0.0, depth), orientation=turn))
        law, friction = kf.Rigid(0.3), kf.Coulomb(0.4)
        if is_granular:
            scene.add_contacts(skins, normal=law, friction=friction)
        else:
            for i, skin in enumerate(skins):
                for other in skins[i + 1 :]:
                    scene.add_contact(f"{skin.name} on {other.name}", skin, other, normal=law, friction=friction)
        result = scene.simulate((0.0, 0.3), method="moreau-jean", step=4e-3, output_step=4e-3)
        assert result.energy.dissipated[-1] > 0.1
        found.append(np.array([result.position(f"b{i}") for i in range(5)]))
    np.testing.assert_allclose(found[0], found[1], atol=1e-9)


def test_balls_swing_in_a_drum_and_bounce_between_its_ends():
    """A lying cylinder: without friction balls keep their speed along it, and their energy of the swing."""
    scene = kf.System(gravity=(0, 0, -G))
    drum = shapes.Cylinder(0.5, 0.6, axis="y", inside=True)
    skins = [scene.add_surface("drum", scene.ground, drum)]
    for i in range(5):
        start = kf.Free(position=(0.45, 0.11 * (i - 2), 0.0), velocity=(0.0, 0.5, 0.0))
        skins.append(
            scene.add_surface(f"s{i}", scene.add_rigid_body(f"b{i}", 1.0, 0.001, joint=start), shapes.Sphere(0.05))
        )
    scene.add_contacts(skins, normal=kf.Rigid(1.0))
    h, span = 5e-4, 1.9
    result = scene.simulate((0.0, span), method="moreau-jean", step=h, output_step=0.01)
    places = np.array([result.position(f"b{i}") for i in range(5)])
    out = np.hypot(places[..., 0], places[..., 2]).max() - 0.45
    assert 0.0 <= out < 0.5 * 2.0 * G * h * span  # along what curves, steps leave by v^2 h^2 / 2 R each
    assert places[..., 2].min() == pytest.approx(-0.45, abs=0.02)
    assert places[..., 0].min() == pytest.approx(-0.45, abs=0.03)
    # in a row they hand their speed on from end to end: the first to arrive comes back at once
    assert abs(places[..., 1]).max() < 0.25 + 0.5 * h
    assert places[4, :, 1].max() == pytest.approx(0.25, abs=0.5 * 0.01)
    assert abs(result.energy.balance_error).max() < 1e-2
