"""Impacts that leave a point without speed in its surface, or points that depend on each other, end like others."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from contact_conditions import ConeProblem, left_of, solved
from kanefe.checks.verification.runner import run_case
from kanefe.checks.verification.woodpecker import CASES, toy
from kanefe.integrate.events.contact_changes import ContactChange, LastLook
from kanefe.integrate.events.storms import without_end
from robustness.rocking import cam, rocking_block, stack, tossed_cube

ENDLESS = (-0.308124961857349, 0.043934921306949, 0.144379563125173, -0.791631275300168, -0.121571254882793)
ENDLESS += (0.032861951071738, -0.597879959627860, 1.179133295729506, -0.387746582418233, -0.022533470793785)
ENDLESS += (2.214635346520332, 0.600201966007129, -1.239792104665495)
SHARED = (0.308242243181483, -0.027404533793442, 0.134660868777246, 0.713298847396912, 0.592889065757174)
SHARED += (0.042992186976971, 0.371266725926137, -1.272483324070135, 0.144882848810741, -0.180419336749680)
SHARED += (-1.831739096258429, -1.659139687425392, 3.111234493000452)
"""Measured tosses of a cube (contact-nets, Pfrommer, Halm and Posa 2020): position (m), Euler parameters, velocity
(m/s) and angular velocity (rad/s)."""


def cube(start: tuple[float, ...], restitution: float) -> kf.System:
    """Return the cube of the tosses."""
    scene = kf.System(gravity=(0, 0, -9.81))
    board = scene.add_surface("board", scene.ground, kf.shapes.Plane("z"))
    q = np.array(start[3:7])
    joint = kf.Free(start[:3], tuple(q / np.linalg.norm(q)), start[7:10], start[10:13])
    body = scene.add_rigid_body("cube", 0.37, 8.1e-4, joint=joint)
    box = scene.add_surface("box", body, kf.shapes.Box((0.1048, 0.1048, 0.1048)))
    scene.add_contact("lands", box, board, normal=kf.Rigid(restitution), friction=kf.Coulomb(0.18))
    return scene


@pytest.mark.parametrize(("start", "restitution", "end"), [(ENDLESS, 0.0, 0.5), (SHARED, 0.125, 0.3)])
def test_tosses_whose_corners_strike_one_after_the_other_run(start, restitution, end):
    assert cube(start, restitution).simulate((0.0, end)).status.is_finished


def test_the_woodpecker_goes_on():
    """At its third beat an edge is struck, stays where it is and is lifted off by the acceleration that is left."""
    assert toy().simulate((0.0, 0.45), output_step=0.05).status.is_finished


@pytest.mark.slow
def test_the_cycle_of_the_woodpecker():
    assert [row for row in run_case(CASES[0]) if not row.passed] == []


@pytest.mark.parametrize("build", [rocking_block, cam, tossed_cube], ids=lambda build: build.__name__)
def test_random_ones_finish(build):
    for seed in range(3):
        scene, end = build(seed)
        assert scene.simulate((0.0, end), output_step=end).status.is_finished, seed


@pytest.mark.parametrize(("seed", "end"), [(8, 0.05), (30, 0.12), (45, 0.08)])
def test_stacks_that_are_thrown_up_go_on(seed, end):
    """Their blocks press on each other with nothing but round-off."""
    scene, _ = stack(seed)
    assert scene.simulate((0.0, end), output_step=end).status.is_finished


def test_what_falls_freely_is_held_and_let_go_by_the_least_of_forces():
    """Springs of 10 nN pull one body onto another and push a third off it, which thereby leaves at 1e-9 of gravity."""
    scene = kf.System(gravity=(0, 0, -9.81))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    below = scene.add_rigid_body("below", 1.0, 0.01, joint=kf.Prismatic("z", speed=1.0))
    top = scene.add_surface("top", below, kf.shapes.Plane("z"))
    scene.add_contact("thrown", below, floor, normal=kf.Rigid(), friction=kf.Coulomb(0.5))
    for name, pushed in (("pulled", -1e-8), ("pushed", 1e-8)):
        spring = kf.CoordinateForce(stiffness=1e-3, rest=pushed / 1e-3)
        body = scene.add_rigid_body(name, 1.0, 0.01, parent=below, joint=kf.Prismatic("z", forces=spring))
        scene.add_contact(name, body, top, normal=kf.Rigid(), friction=kf.Coulomb(0.5))
    result = scene.simulate((0.0, 0.1))
    assert result.status.is_finished
    off = result.position("pushed")[-1, 2] - result.position("below")[-1, 2]
    # two bodies below it take their share of 10 nN: its acceleration is 1.5 of force over mass (m)
    assert off == pytest.approx(0.5 * 1.5e-8 * 0.1**2, rel=1e-3)
    assert abs(result.position("pulled")[-1, 2] - result.position("below")[-1, 2]) < 1e-15


def corners(seed: int) -> ConeProblem:
    """Return a box whose four lower corners strike a plane, with speeds of very different sizes."""
    rng = np.random.default_rng(seed)
    half, mass = rng.uniform(0.02, 0.2, 3), 1.0
    inertia = mass / 3.0 * (half @ half - half**2)
    places = np.array([(x * half[0], y * half[1], -half[2]) for x in (-1, 1) for y in (-1, 1)])
    J = np.array([np.append(e, np.cross(r, e)) for r in places for e in np.eye(3)[[2, 0, 1]]])
    speeds = np.append(rng.normal(size=2), (-abs(rng.normal()), *(10.0 * rng.normal(size=3))))
    rates = J @ (speeds * 10.0 ** rng.uniform(-3.0, 1.0, 6))
    b = rates.copy()
    b[::3] += rng.choice((0.125, 0.5)) * np.minimum(rates[::3], 0.0)
    return ConeProblem(
        (J / np.repeat((mass, *inertia), (3, 1, 1, 1))) @ J.T, b, np.ones(4), np.zeros(4), np.full((4, 2), np.nan)
    )


def test_corners_that_depend_on_each_other_have_impulses():
    """What restitution asks of four corners three speeds can all but not do: sweeps take steps as short."""
    for seed in range(60):
        problem = corners(seed)
        x = solved(problem)
        assert x is not None, seed
        assert left_of(problem, x) <= 1e-8 * np.abs(x).max(), seed


def test_a_body_that_cannot_part_from_all_it_meets_is_struck_by_poissons_law():
    """A point between two planes that both touch it has to leave one with half a speed, and cannot for the other."""
    scene = kf.System()
    walls = [("below", "z"), ("above", "-z")]
    ball = scene.add_point("ball", 1.0, joint=kf.Prismatic("z", speed=-1.0))
    for name, normal in walls:
        wall = scene.add_surface(name, scene.ground, kf.shapes.Plane(normal))
        scene.add_contact(name, ball, wall, normal=kf.Rigid(0.5))
    result = scene.simulate((0.0, 0.1))
    assert result.status.is_finished
    assert np.abs(result.velocity("ball")[-1]).max() < 1e-9


@pytest.mark.parametrize("far", [0.0, 1e4])
def test_slips_do_not_depend_on_the_distance_from_the_origin(far):
    scene = kf.System(gravity=(0, 0, -9.81))
    root = scene.ground.frame(at=(far, 0, 0))
    shake = kf.Motion(lambda t: 0.05 * np.sin(12 * t), lambda t: 0.6 * np.cos(12 * t), lambda t: -7.2 * np.sin(12 * t))
    belt = scene.add_frame("belt", parent=root, joint=kf.Prismatic("x", motion=shake))
    top = scene.add_surface("top", belt, kf.shapes.Plane("z"))
    start = kf.Free(position=(0, 0, 0.05), velocity=(0.6, 0.2, 0))
    block = scene.add_rigid_body("block", 1.0, 0.01, parent=root, joint=start)
    feet = [block.frame(at=(x, y, -0.05)) for x, y in ((0.1, 0.1), (-0.1, 0.1), (0, -0.12))]
    scene.add_contact("feet", feet, top, normal=kf.Rigid(), friction=kf.Coulomb(0.4))
    result = scene.simulate((0.0, 1.0), output_step=0.5)
    np.testing.assert_allclose(result.position("block")[-1, :2] - (far, 0.0), (8.870e-3, 5.675e-3), rtol=0, atol=2e-6)
    np.testing.assert_allclose(result.events["feet stick"], (0.5688, 0.8307), rtol=0, atol=1e-4)


def test_the_message_names_the_contacts():
    model = cube(ENDLESS, 0.0).freeze()
    change = ContactChange(
        "a rigid contact: touch",
        None,
        model=model,
        kind="touch",
        span=1.0,
        stop=1.0,
        rtol=1e-6,
        look=LastLook(model),
        titles=["rigid contact 'lands'"],
    )
    failure = without_end(change, "acted 32 times within 0 s")
    assert failure.reason.startswith("rigid contact 'lands': touch acted 32 times")
    assert "moreau-jean" in failure.remedy
    assert "terminal" not in failure.remedy
