"""Laws of impact: none of the defaults makes energy, Newton's says where it does, and several contacts say so."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import kanefe as kf
from contact_conditions import impact
from kanefe import shapes
from kanefe.kernels.impacts.contact_questions import Asks
from kanefe.kernels.impacts.stronge import held_by
from kanefe.kernels.values.tensors import Symmetric
from kanefe.order_n.contact_changing import decider_of
from kanefe.states.constraints import meetings

GAINS = {72: 79.05, 17: 12.74}
"""Kinetic energy after over that before of scenes of `pendulum` by Newton's law (Kane & Levinson's problem)."""


def cases(count: int) -> list[list[float]]:
    """Return restitution, friction, two angles (rad) and two rates (rad/s) of some scenes."""
    rng, limits = np.random.default_rng(0), ((0.3, 1.0), (0.1, 1.5), (-1.2, 1.2), (-1.5, 1.5), (-3, 3), (-3, 3))
    return [[rng.uniform(*pair) for pair in limits] for _ in range(count)]


def struck(G: np.ndarray, rates: np.ndarray, e: float, mu: float) -> np.ndarray | None:
    """Return Stronge's impulse of one contact."""
    found = impact(G, rates, [kf.Rigid(e)], [mu])
    return None if found is None else found.impulses


def pendulum(case: list[float], impact: str) -> kf.System:
    """Return a double pendulum whose tip meets a rough floor."""
    e, mu, first, second, rate_1, rate_2 = case
    s = kf.System()
    floor = s.add_surface("floor", s.ground, shapes.Plane("z"))
    height, rod = np.cos(first) + np.cos(first + second) + 0.005, (1 / 12, 1 / 12, 1e-4)
    joint = kf.Revolute("y", position=first, speed=rate_1)
    upper = s.add_rigid_body("upper", 1.0, rod, com=(0, 0, -0.5), at=(0, 0, height), joint=joint)
    joint = kf.Revolute("y", position=second, speed=rate_2)
    lower = s.add_rigid_body("lower", 1.0, rod, com=(0, 0, -0.5), at=(0, 0, -1.0), parent=upper, joint=joint)
    normal = kf.Rigid(e, impact)
    s.add_contact("tip", lower.frame(at=(0, 0, -1.0)), floor, normal=normal, friction=kf.Coulomb(mu))
    return s


@pytest.mark.parametrize("number", GAINS)
def test_impacts_make_no_energy_and_newtons_say_what_they_make(number):
    case = cases(number + 1)[number]
    energy = pendulum(case, "stronge").simulate((0.0, 0.2), output_step=0.02).energy
    assert energy.kinetic.max() <= energy.kinetic[0] * (1.0 + 1e-9)
    # no gravity and no damper: friction takes energy in impacts only, so that their line is the balance
    np.testing.assert_allclose(
        energy.impacts, energy.kinetic - energy.kinetic[0], rtol=0, atol=1e-6 * energy.kinetic[0]
    )
    assert np.all(np.diff(energy.impacts) <= 1e-12)
    assert energy.impacts[-1] < 0.0
    with pytest.warns(kf.SimulationWarning, match=r"law made .* J: \d+ of rigid contact 'tip'; the first at t ="):
        newton = pendulum(case, "newton").simulate((0.0, 0.2)).energy
    assert newton.kinetic.max() / newton.kinetic[0] == pytest.approx(GAINS[number], rel=1e-3)
    assert newton.impacts.max() > 0.0


def test_a_scene_that_is_stepped_says_it_in_the_step_of_the_impact():
    sim = pendulum(cases(18)[17], "newton").start()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sim.step(0.006)
    with pytest.warns(kf.SimulationWarning, match="Newton's law made"):
        sim.step(0.001)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sim.step(0.001)


def drawn(seed: int, count: int = 1) -> tuple[np.ndarray, np.ndarray, np.random.Generator]:
    """Return responses and rates of some contacts of one body or several, in space."""
    rng = np.random.default_rng(seed)
    B = rng.standard_normal((3 * count, 3 * count + 1 if seed % 3 else max(3, 3 * count - 2)))
    rates = rng.standard_normal(3 * count)
    rates[0] = -abs(rates[0])
    return B @ B.T, rates, rng


def test_what_moves_in_one_way_alone_bounces_though_its_slip_ends_with_its_approach():
    """Both end at one instant; friction makes the slope of the approach more by mu |g|, and that of the bounce less."""
    rng, e, mu = np.random.default_rng(0), 0.4, 0.2
    for _ in range(200):
        g = np.array((1.0, *rng.uniform(-1.0, 1.0, 2)))
        v, rubs = rng.uniform(1e-3, 1.0), mu * np.hypot(*g[1:])
        p = struck(np.outer(g, g), -v * g, e, mu)
        assert p is not None
        # energy stored v^2 / (2 c1), of which e^2 = v'^2 v^-2 c1 / c2 comes back; round-off over the slip at the turn
        assert g @ p - v == pytest.approx(e * v * np.sqrt((1.0 - rubs) / (1.0 + rubs)), rel=1e-9)


def test_an_impact_takes_energy_within_the_cone_and_ends_by_what_it_has_stored():
    """Of contacts in space: a plain sum over small impulses leads to the same."""
    for seed in range(6):
        G, rates, rng = drawn(seed)
        e, mu = rng.uniform(), rng.uniform(0.0, 1.5)
        p = struck(G, rates, e, mu)
        assert p is not None
        assert p @ (rates + 0.5 * G @ p) <= 0.0
        assert np.hypot(*p[1:]) <= mu * p[0] * (1.0 + 1e-9)
        assert (rates + G @ p)[0] >= 0.0
        if seed < 2:
            # steps of 1e-3 of the impulse, of order 1
            np.testing.assert_allclose(summed(G, rates, e, mu, 1e-3 * p[0]), p, rtol=0, atol=0.02 * np.abs(p).max())


def summed(G: np.ndarray, rates: np.ndarray, e: float, mu: float, step: float) -> np.ndarray:
    """Return Stronge's impulse by Euler's steps, with friction against the slip at their ends."""
    v, p, stored, loads = rates.copy(), np.zeros(3), 0.0, True
    while True:
        b = np.column_stack((G[:, 0] + np.append(0.0, v[1:] / step), G[:, 1:]))
        own = Symmetric(b[0, 0], b[1, 0], b[2, 0], b[1, 1], b[1, 2], b[2, 2])
        x = held_by(own, mu)[1].numbers[1:]  # the least of v x + h x G x / 2: the friction that leaves the least slip
        before, p = v[0], p + step * np.append(1.0, x)
        v = rates + G @ p
        stored -= 0.5 * step * (before + v[0])
        if loads and v[0] >= 0.0:
            loads, stored = False, e * e * stored
        if not loads and stored <= 0.0:
            return p


def shared(seed: int) -> tuple[np.ndarray, np.ndarray, list[kf.Rigid], np.ndarray]:
    """Return contacts of few speeds, with unlike levers and restitutions, and their rates."""
    rng = np.random.default_rng(seed)
    k = 2 + seed % 2
    B = rng.standard_normal((3 * k, rng.integers(2, 5))) * 10.0 ** rng.uniform(-1, 1, 3 * k)[:, None]
    rates = B @ rng.standard_normal(B.shape[1])
    rates[0] = -abs(rates[0])
    mu, e = rng.uniform(0, 2, k), rng.choice((0.0, 0.5, 1.0), k)
    return B @ B.T, rates, [kf.Rigid(float(one), "poisson") for one in e], mu


@pytest.mark.parametrize("seed", [93, 491, 1685])
def test_impacts_of_several_contacts_make_no_energy(seed):
    """The whole second part of Poisson's impulses would make some: as much is given back as there is."""
    G, rates, laws, mu = shared(seed)
    found = impact(G, rates, laws, mu)
    assert found is not None
    p = found.impulses.reshape(-1, 3)
    exchanged = np.abs(found.impulses) @ np.abs(rates)
    assert found.gained == 0.0
    assert found.taken.sum() == pytest.approx(0.0, abs=1e-9 * exchanged)
    assert np.all(np.hypot(p[:, 1], p[:, 2]) <= mu * p[:, 0] + 1e-8 * np.abs(p).max())
    assert np.all((rates + G @ found.impulses)[::3] >= -1e-8 * np.abs(rates).max())


def test_shared_impacts_with_friction_make_no_energy():
    G, rates, rng = drawn(1, 2)
    mu = rng.uniform(0.0, 1.5, 2)
    found = impact(G, rates, [kf.Rigid(rng.uniform(), "distributing") for _ in mu], mu)
    assert found is not None
    p, each = found.impulses, found.impulses.reshape(-1, 3)
    assert p @ (rates + 0.5 * G @ p) < 0.0
    assert np.all(np.hypot(each[:, 1], each[:, 2]) <= mu * (1.0 + 1e-9) * each[:, 0])
    assert np.all((rates + G @ p)[::3] >= -1e-8)


def test_contacts_that_do_not_move_each_other_strike_by_themselves():
    G = np.zeros((9, 9))
    for i, j in ((0, 0), (1, 1), (2, 2), (0, 2), (2, 0)):
        G[3 * i : 3 * i + 3, 3 * j : 3 * j + 3] = np.eye(3) if i == j else 0.1 * np.eye(3)
    three = impact(G, np.tile((-1.0, 0.0, 0.0), 3), [kf.Rigid(0.5)] * 3, [0.0] * 3)
    assert three is not None
    assert three.groups == [0, 1, 0]
    alone, law = drawn(5), kf.Rigid(0.7)
    both = np.zeros((6, 6))
    both[:3, :3], both[3:, 3:] = alone[0], np.eye(3)
    found = impact(both, np.append(alone[1], (0.0, 0.3, 0.0)), [law, law], [0.4, 0.4])  # the other one lies and slides
    own = struck(*alone[:2], 0.7, 0.4)
    assert found is not None
    np.testing.assert_array_equal(found.impulses, np.append(own, np.zeros(3)))


def balls(count: int, normal: kf.Rigid) -> tuple[np.ndarray, list[str]]:
    """Return the speeds after one of some balls has struck others that touch, and what the run says."""
    scene, skins = kf.System(), []
    for i in range(count):
        joint = kf.Prismatic("x", position=0.2 * (i - 1) if i else -0.3, speed=float(i == 0))
        ball = scene.add_rigid_body(f"ball{i}", 1.0, 0.004, joint=joint)
        skins.append(scene.add_surface(f"skin{i}", ball, shapes.Sphere(0.1)))
    for i in range(count - 1):
        scene.add_contact(f"pair{i}", skins[i], skins[i + 1], normal=normal)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        run = scene.simulate((0.0, 0.15), output_times=(0.15,))
    speeds = [run.joint_speeds(f"ball{i}")[-1, 0] for i in range(count)]
    return np.array(speeds), [str(one.message) for one in told]


def test_three_balls_that_touch_say_that_their_order_decides():
    speeds, told = balls(3, kf.Rigid(1.0))
    np.testing.assert_allclose(speeds, (-1 / 3, 2 / 3, 2 / 3), atol=1e-9)
    assert len(told) == 1
    assert "depend on which strikes first: rigid contact 'pair0' 1, 'pair1' 1" in told[0]
    assert "distributing" in told[0]


@pytest.mark.parametrize(("count", "first", "last"), [(3, -0.0711, 0.9946), (5, -0.0711, 0.9888)])
def test_balls_that_share_an_impact_part_as_those_of_hertz(count, first, last):
    """By a run with kf.HuntCrossley(1e9, exponent=1.5), whose depths are 1e-6 of the balls."""
    speeds, told = balls(count, kf.Rigid(1.0, "distributing"))
    assert not told
    np.testing.assert_allclose(speeds[[0, -1]], (first, last), atol=2e-3)
    assert speeds.sum() == pytest.approx(1.0, abs=1e-9)
    assert speeds @ speeds <= 1.0 + 1e-12


def test_faces_that_share_an_impact_by_many_points_do_so_by_their_stiffness():
    """Two points of a face, of unlike stiffness and exponent 1: an oscillator, whose impulses are as the stiffness."""
    G = np.zeros((6, 6))
    G[np.ix_([0, 3], [0, 3])] = 1.0
    laws = [kf.Rigid(0.6, "distributing", stiffness=k, exponent=1.0) for k in (1.0, 3.0)]
    found = impact(G, np.array((-1.0, 0, 0, -1.0, 0, 0)), laws, [0.0, 0.0])
    assert found is not None
    np.testing.assert_allclose(found.impulses[[0, 3]], (0.4, 1.2), rtol=1e-3)


def rod(mu: float, degrees: float) -> kf.System:
    """Return a rod that is pushed along a rough floor with its lower end ahead (Painleve's)."""
    scene = kf.System(gravity=(0, 0, -9.81))
    floor = scene.add_surface("floor", scene.ground, shapes.Plane("z"))
    angle = np.radians(degrees)
    place = (0.5 * np.cos(angle), 0, 0.5 * np.sin(angle))
    start = kf.Free(position=place, orientation=kf.rotation_about("y", -angle), velocity=(-1.0, 0, 0))
    body = scene.add_rigid_body("rod", 1.0, (1e-3, 1.0 / 12.0, 1.0 / 12.0), joint=start)
    scene.add_contact("c", body.frame(at=(-0.5, 0, 0)), floor, normal=kf.Rigid(), friction=kf.Coulomb(mu))
    return scene


def test_what_friction_draws_in_is_stopped_by_an_impact_without_collision():
    """The tip sticks at once, as that of ever stiffer contacts does, and the rod goes on about it."""
    model = rod(3.0, 60.0).freeze()
    y = model.route.start(0.0)
    met = meetings(model.literal.view(0.0, y))[0][0]
    # stopped along the floor and across it by one impulse: rates are zero to round-off
    np.testing.assert_allclose(met.rates, 0.0, atol=1e-12)
    assert model.parts(y)[2][2] > 0.0  # which took energy
    np.testing.assert_allclose(model.literal.start(0.0), y, rtol=0, atol=1e-9)


def test_a_point_that_moves_along_one_line_is_drawn_in_without_end():
    """Its slip turns until friction takes away all that the impulse does: that no impulse ends it is known at once."""
    along = np.array((1.0, 16.5, -21.9))
    assert struck(np.outer(along, along), np.array((-0.45, -0.98, -1.0)), 0.5, 0.3) is None


def test_a_slip_that_no_longer_turns_goes_straight_to_its_end():
    """It comes back the way it went, nearly, and hardly grows: in steps that its turns allow it would take seconds."""
    mu, c, g, aside = 0.02, 1e3, 20.001, 1e-3
    G, before = np.array([[1.0, 0.0, g], [0.0, c, 0.0], [g, 0.0, c]]), np.array((-1.0, aside, -1.0))
    found = struck(G, before, 0.0, mu)
    there = 1.0 / (g + mu * c)  # impulse in which a slip against the second direction ends
    back = (1.0 - there * (1.0 + mu * g)) / (1.0 - mu * g)  # and one along it, up to where nothing approaches
    # what is aside of it turns it on a way a thousandth as long
    np.testing.assert_allclose(found, (there + back, 0.0, mu * (there - back)), rtol=0, atol=1e-2 * aside)


@pytest.mark.parametrize("restitution", [0.0, 0.4])
def test_feet_that_friction_draws_in_are_stopped_by_an_impact_of_all(restitution):
    """A heavy table top, high on light legs, slides: its front foot sticks at once, and it goes on about that."""
    height, half, radius, mass = 1.0, 0.1, 0.1, 2.0
    scene = kf.System(gravity=(0, 0, -9.81))
    floor = scene.add_surface("floor", scene.ground, shapes.Plane("z"))
    start = kf.Free(position=(0, 0, height), velocity=(1.0, 0, 0))
    table = scene.add_rigid_body("table", mass, mass * radius**2, joint=start)
    feet = [table.frame(at=(x, 0, -height)) for x in (half, -half)]
    scene.add_contact("feet", feet, floor, normal=kf.Rigid(restitution), friction=kf.Coulomb(0.6))
    model = scene.freeze()
    _, u, _ = model.parts(model.route.start(0.0))
    # what turns about the foot keeps its momentum about it; then e of the impulse that lets go, within its friction
    square = radius**2 + height**2 + half**2
    stopped = np.array((height, 0, half)) * height / square
    moved, turn = u[:3], u[3:]
    taken = 0.5 * mass * (1.0 - moved @ moved - radius**2 * turn @ turn)
    assert taken >= -1e-12
    if restitution == 0.0:
        np.testing.assert_allclose(moved, stopped, rtol=0, atol=1e-9)  # m/s; the time in which the impact is looked for
        np.testing.assert_allclose(turn, (0, height / square, 0), rtol=0, atol=1e-9)
    else:
        pressed = mass * (stopped - (1.0, 0, 0))
        np.testing.assert_allclose(mass * moved[2], (1.0 + restitution) * pressed[2], rtol=1e-9)
    np.testing.assert_allclose(model.literal.start(0.0), model.route.start(0.0), rtol=0, atol=1e-9)


def test_an_impact_that_feet_share_is_that_of_the_literal_route():
    """Four feet of unlike stiffness, exponent and restitution strike with friction; compiled code decides it alone."""
    scene = kf.System(gravity=(0, 0, -9.81))
    floor = scene.add_surface("floor", scene.ground, shapes.Plane("z"))
    start = kf.Free(position=(0, 0, 0.1), velocity=(0.5, 0.2, -1.0), angular_velocity=(0.3, -0.2, 0.4))
    table = scene.add_rigid_body("table", 2.0, (0.02, 0.03, 0.04), joint=start)
    for i, (x, y) in enumerate([(0.2, 0.2), (-0.2, 0.2), (0.2, -0.2), (-0.2, -0.2)]):
        law = kf.Rigid(0.2 * i, "distributing", stiffness=1.0 + i, exponent=1.0 + 0.2 * i)
        scene.add_contact(f"{i}", table.frame(at=(x, y, -0.1)), floor, normal=law, friction=kf.Coulomb(0.3))
    model = scene.freeze()
    assert decider_of(model.route).ask(Asks.START, 0.0, model.initial_state, 1.0, 1.0, 1e-6)
    # some thousand steps, the same in both; the friction of each is found to 1e-8
    np.testing.assert_allclose(model.route.start(0.0), model.literal.start(0.0), rtol=0, atol=1e-6)
