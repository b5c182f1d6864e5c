"""Rest on rigid contacts, and small motions about it, against closed forms; round-off where no other reason is told."""

from __future__ import annotations

import math

import numpy as np
import pytest

import kanefe as kf
from kanefe import shapes
from kanefe.linear.equilibrium.other_rest import OtherRestWarning
from kanefe.linear.equilibrium.rigid_rest import _Rest
from kanefe_fem import Material, Rectangle, beam_body, straight_beam

G = 9.81
LEGS = ((-0.5, -0.4), (0.5, -0.4), (0.0, 0.6), (0.5, 0.6))


def block(tilt: float, mu: float, height: float = 0.0) -> kf.System:
    """A block of 2 kg with four feet on a slope, its x axis down it."""
    scene = kf.System(gravity=(G * math.sin(tilt), 0, -G * math.cos(tilt)))
    floor = scene.add_surface("floor", scene.ground, shapes.Plane("z"))
    body = scene.add_rigid_body("block", 2.0, 0.05, joint=kf.Free(position=(0.3, 0, 0.1 + height)))
    feet = scene.add_surface("feet", body, shapes.Points([(x, y, -0.1) for x in (-0.2, 0.2) for y in (-0.1, 0.1)]))
    scene.add_contact("c", feet, floor, normal=kf.Rigid(), friction=kf.Coulomb(mu))
    return scene


def table(legs: tuple[tuple[float, float], ...], com: tuple[float, float, float] = (0.1, 0.05, 0.0)) -> kf.System:
    scene = kf.System(gravity=(0, 0, -G))
    floor = scene.add_surface("floor", scene.ground, shapes.Plane("z"))
    top = scene.add_rigid_body("top", 2.0, 0.1, com=com, joint=kf.Free(position=(0, 0, 0.7)))
    for i, (x, y) in enumerate(legs):
        scene.add_contact(f"leg {i}", top.frame(at=(x, y, -0.7)), floor, normal=kf.Rigid())
    return scene


def lever(stiffness: float, start: float = 0.0) -> kf.System:
    """A lever of 1 m and 2 kg on a hinge with a spring, above a stop 0.2 m below it."""
    scene = kf.System(gravity=(0, 0, -G))
    hinge = kf.Revolute("y", position=start, forces=kf.CoordinateForce(stiffness=stiffness))
    body = scene.add_rigid_body("lever", 2.0, 0.1, com=(0.5, 0, 0), joint=hinge)
    stop = scene.add_surface("stop", scene.ground, shapes.Plane("z"), at=(0, 0, -0.2))
    scene.add_contact("end", body.frame(at=(1.0, 0, 0)), stop, normal=kf.Rigid())
    return scene


def test_a_block_within_its_cone_stays_where_it_was_put():
    tilt = 0.3
    scene = block(tilt, mu=0.4)
    found = kf.equilibrium(scene)
    np.testing.assert_array_equal(found.position("block"), (0.3, 0, 0.1))
    assert found.contact("c").normal == pytest.approx(2.0 * G * math.cos(tilt), rel=1e-12)
    assert found.contact("c").tangential == pytest.approx(2.0 * G * math.sin(tilt), rel=1e-12)
    assert found.contact("c").status == "sticks"
    assert found.carrying == {"c": pytest.approx(2.0 * G * math.cos(tilt))}
    assert "contact c: carries 18.7437 N, friction 5.79811 N" in str(found)
    result = scene.simulate((0.0, 1.0), start=found)
    np.testing.assert_allclose(result.position("block")[-1], (0.3, 0, 0.1), rtol=0, atol=1e-14)


def test_a_block_that_is_let_go_above_a_slope_rests_on_it():
    found = kf.equilibrium(block(0.3, mu=0.4, height=0.05))
    assert found.position("block")[2] == pytest.approx(0.1, abs=1e-14)
    assert found.contact("c").normal == pytest.approx(2.0 * G * math.cos(0.3), rel=1e-9)


def test_a_slope_beyond_the_cone_is_named_with_what_friction_lacks():
    with pytest.raises(
        kf.SimulationError, match=r"contact 'c' would slip: .* a friction of 5\.798 N and holds 1\.874 N"
    ):
        kf.equilibrium(block(0.3, mu=0.1))


@pytest.mark.parametrize("com", [(0.1, 0.05, 0.0), (0.0, 0.0, 0.0), (-0.2, -0.3, 0.1)])
def test_three_legs_carry_what_statics_says(com):
    found = kf.equilibrium(table(LEGS[:3], com))
    wanted = np.linalg.solve(np.vstack((np.ones(3), np.transpose(LEGS[:3]))), 2.0 * G * np.array((1.0, *com[:2])))
    np.testing.assert_allclose([found.carrying[f"leg {i}"] for i in range(3)], wanted, rtol=1e-12)
    assert found.undetermined == ()


def test_what_four_legs_share_is_told_to_be_undetermined():
    found = kf.equilibrium(table(LEGS))
    forces = np.array([found.carrying[f"leg {i}"] for i in range(4)])
    np.testing.assert_allclose(np.vstack((np.ones(4), np.transpose(LEGS))) @ forces, 2.0 * G * np.array((1, 0.1, 0.05)))
    assert found.undetermined == tuple(f"leg {i}" for i in range(4))
    assert str(found).count("not unique for rigid bodies: of least norm") == 4


def test_a_table_whose_weight_is_beside_two_legs_lifts_the_others():
    """Over the line between two of four legs the others could carry, but need not: none may pull."""
    found = kf.equilibrium(table(LEGS, com=(0.5, 0.0, 0.0)))
    assert all(force >= 0.0 for force in found.carrying.values())
    assert sum(found.carrying.values()) == pytest.approx(2.0 * G)


def test_what_would_slip_is_told_with_friction_that_it_has_not():
    """Never as "asked for 6.156e-14 N and holds 18.64 N"."""
    scene = block(0.0, mu=0.4)
    scene.add_torque(scene.body("block"), (0, 0, 3.0))
    # 3 N m over an arm of 0.224 m; shared in another way a little more
    message = r"'c' would turn: its points need a friction of 13\.\d+ N in sum and hold 7\.848 N"
    with pytest.raises(kf.SimulationError, match=message):
        kf.equilibrium(scene)
    rest = _Rest(scene.freeze(), 0.0, np.zeros(6), lambda model, q: (model, None, (q, q)), 1)
    rest.friction = {(0, 0): (np.array((6.156e-14, 0, 0)), 18.64)}
    assert "'c' would slip: no distribution of the forces is within the friction of each contact point" in str(
        rest._slips([(0, 0)])
    )


@pytest.mark.parametrize("start", [0.0, 0.15, -0.5])
def test_a_lever_comes_to_lie_on_its_stop(start):
    found = kf.equilibrium(lever(10.0, start))
    angle = math.asin(0.2)
    assert found.joint_coordinates("lever")[0] == pytest.approx(angle, abs=1e-13)
    wanted = (G * math.cos(angle) - 10.0 * angle) / math.cos(angle)
    assert found.carrying["end"] == pytest.approx(wanted, rel=1e-11)
    with pytest.raises(kf.ModelError, match="nothing in the scene can move"):
        found.linearise()


def test_a_lever_that_begins_on_its_stop_is_lifted_off_by_its_spring():
    with pytest.warns(OtherRestWarning, match=r"'end' touched at the start and lifted.*Remedy: start="):
        found = kf.equilibrium(lever(200.0, math.asin(0.2)))
    assert found.other_rest.has_lifted
    angle = float(found.joint_coordinates("lever")[0])
    assert 200.0 * angle == pytest.approx(G * math.cos(angle), rel=1e-9)
    assert found.carrying == {}
    assert found.contact("end").penetration == pytest.approx(math.sin(angle) - 0.2)
    omega = math.sqrt((200.0 + G * math.sin(angle)) / (0.1 + 2.0 * 0.25))
    np.testing.assert_allclose(2.0 * np.pi * found.linearise().modes().frequencies, [omega], rtol=1e-9)


def test_small_motions_in_a_valley_are_those_along_its_ground():
    """A point that slides in z = (a x^2 + b y^2) / 2: omega^2 = g a and g b."""
    grid = np.linspace(-2.0, 2.0, 41)
    ground = 0.1 * (grid[:, None] ** 2 + 2.0 * grid[None, :] ** 2)
    scene = kf.System(gravity=(0, 0, -G))
    valley = scene.add_surface("valley", scene.ground, shapes.HeightField(grid, grid, ground))
    point = scene.add_point("point", 1.0, joint=kf.Translation(position=(0.3, 0.4, 0.6)))
    scene.add_contact("c", point, valley, normal=kf.Rigid())
    found = kf.equilibrium(scene)
    np.testing.assert_allclose(found.position("point"), 0.0, atol=1e-9)
    wanted = np.sqrt(G * np.array((0.2, 0.4))) / (2.0 * np.pi)
    # the field is splines through the parabola, and accelerations are differenced over 1e-3 of it
    np.testing.assert_allclose(found.linearise().modes().frequencies, wanted, rtol=1e-6)


def test_a_rolling_ball_swings_in_a_bowl_slower_than_one_that_slides():
    """Radius r in a sphere of radius R: omega^2 = 5 g / (7 (R - r)) rolling, g / (R - r) sliding."""
    found = {}
    for mu in (None, 0.5):
        scene = kf.System(gravity=(0, 0, -G))
        bowl = scene.add_surface("bowl", scene.ground, shapes.Sphere(1.0, inside=True))
        start = kf.Free(position=(0, 0, -0.8))
        ball = scene.add_rigid_body("ball", 1.0, 0.4 * 0.2**2, joint=start)
        skin = scene.add_surface("skin", ball, shapes.Sphere(0.2))
        scene.add_contact("c", skin, bowl, normal=kf.Rigid(), friction=None if mu is None else kf.Coulomb(mu))
        found[mu] = float(kf.equilibrium(scene).linearise().modes().frequencies.max())
    slides = math.sqrt(G / 0.8) / (2.0 * np.pi)
    assert found[None] == pytest.approx(slides, rel=1e-8)
    assert found[0.5] == pytest.approx(math.sqrt(5.0 / 7.0) * slides, rel=1e-8)


def test_a_clamped_beam_bends_over_one_stop_and_off_the_other():
    """P at the end, stops at L/4 and L/2: 5/2 P on the latter, and between it and the clamp the beam bows upwards.

    With R = P (3 L - a) / (2 a) at a = L/2: w(x) = [R (3 a x^2 - x^3) - P (3 L x^2 - x^3)] / (6 E I).
    """
    P, length, section, E = 50.0, 2.0, Rectangle(0.05, 0.02), 210e9
    model = straight_beam(length, section, Material(E=E, nu=0.3, rho=7850.0), elements=8, theory="euler-bernoulli")
    body = beam_body(model, {"root": "clamped", "tip": "rigid"}, reduction=None)
    scene = kf.System()
    beam = scene.add_flexible_body("beam", body, joint=kf.Fixed())
    scene.add_force(beam.interface("tip"), (0, 0, -P))
    for name, node in (("near", 2), ("far", 4)):
        stop = scene.add_surface(f"{name} stop", scene.ground, shapes.Plane("z"))
        scene.add_contact(name, beam.node(node), stop, normal=kf.Rigid())
    found = kf.equilibrium(scene)
    assert found.carrying == {"far": pytest.approx(2.5 * P, rel=1e-6)}
    x, a = 0.25 * length, 0.5 * length
    bow = (2.5 * P * (3 * a * x**2 - x**3) - P * (3 * length * x**2 - x**3)) / (6.0 * E * (0.05 * 0.02**3 / 12.0))
    assert -found.contact("near").penetration == pytest.approx(bow, rel=1e-6)


def test_a_block_between_wall_and_floor_leans_on_what_holds_it():
    """Pressed by 3 N onto a smooth wall beside a rough floor: the wall has all of it that friction does not need."""
    scene = kf.System(gravity=(0, 0, -G))
    floor = scene.add_surface("floor", scene.ground, shapes.Plane("z"))
    wall = scene.add_surface("wall", scene.ground, shapes.Plane("x"), at=(-0.1, 0, 0))
    body = scene.add_rigid_body("body", 1.0, 0.02, joint=kf.Free(position=(0, 0, 0.1)))
    corners = [(x, y) for x in (-0.1, 0.1) for y in (-0.1, 0.1)]
    scene.add_contact("foot", [body.frame(at=(x, y, -0.1)) for x, y in corners], floor, normal=kf.Rigid())
    scene.add_contact("side", [body.frame(at=(-0.1, x, y)) for x, y in corners], wall, normal=kf.Rigid())
    scene.add_force(body, (-3.0, 0, 0))
    found = kf.equilibrium(scene)
    assert found.carrying == {"foot": pytest.approx(G), "side": pytest.approx(3.0)}


def test_many_balls_are_refused_by_name():
    scene = kf.System(gravity=(0, 0, -G))
    skins = [scene.add_surface("floor", scene.ground, shapes.Plane("z"))]
    for i in range(20):
        ball = scene.add_rigid_body(f"ball {i}", 1.0, 0.01, joint=kf.Free(position=(i, 0, 1.0)))
        skins.append(scene.add_surface(f"skin {i}", ball, shapes.Sphere(0.1)))
    scene.add_contacts(skins, normal=kf.Rigid())
    for analysis in (kf.equilibrium, kf.linearise):
        with pytest.raises(kf.ModelError, match=r"granular contacts, here '.*'.* Remedy"):
            analysis(scene)


def test_what_is_rigid_and_what_yields_carry_beside_each_other():
    scene = kf.System(gravity=(0, 0, -G))
    floor = scene.add_surface("floor", scene.ground, shapes.Plane("z"))
    for name, mass, law in (("hard", 2.0, kf.Rigid()), ("soft", 1.0, kf.HuntCrossley(1e5, 0.3))):
        body = scene.add_rigid_body(f"{name} body", mass, 0.1, joint=kf.Prismatic("z", position=0.05))
        scene.add_contact(name, body, floor, normal=law)
    found = kf.equilibrium(scene)
    assert found.carrying == {"hard": pytest.approx(2.0 * G), "soft": pytest.approx(G)}
    assert found.joint_coordinates("soft body")[0] == pytest.approx(-G / 1e5)
    frequencies = found.linearise().modes().frequencies
    np.testing.assert_allclose(frequencies, [math.sqrt(1e5) / (2.0 * np.pi)], rtol=1e-4)  # of damping 0.6 %


def test_what_falls_past_everything_has_no_balance():
    scene = block(0.0, mu=0.5)
    scene.add_rigid_body("loose", 1.0, 0.1, joint=kf.Free(position=(0, 0, 3.0)))
    with pytest.raises(kf.SimulationError, match="along loose"):
        kf.equilibrium(scene)
