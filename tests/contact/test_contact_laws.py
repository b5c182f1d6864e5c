"""Laws of normal force and friction against closed forms, in a moving, turned frame; Python and compiled alike."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

import kanefe as kf
from acting_loads import WAYS, acted, assert_complex_steps_are_differences
from kanefe import shapes
from kanefe.frames import cross, rotation_matrix
from kanefe.kernels.constraints.tolerances import HELD_BEYOND
from kanefe.loads.action import Action, End

SHARE = 0.5
K, LAMBDA, C_NORMAL = 2e4, 0.3, 150.0
D, RATE = 0.01, 0.4
"""Depth, m, and its rate, m/s."""

STIFF, DAMP = 3e4, 20.0
"""Of anchors: of all points together."""
k, c = SHARE * STIFF, SHARE * DAMP

NORMAL = SHARE * K * D * (1.0 + LAMBDA * RATE)
"""Normal force of Hunt and Crossley's law there, N."""

TURN = rotation_matrix(np.array((0.8, 0.2, -0.4, np.sqrt(1.0 - 0.84))))
SURFACE = End(np.array((0.3, -0.2, 0.5)), TURN, np.array((0.1, 0.7, -0.4)), np.array((0.5, -0.3, 0.8)))
SPIN = np.array((0.6, -0.9, 0.4))
"""Angular velocity of what touches past the surface, in axes of the surface, rad/s."""


def contact_of(normal: Any, friction: Any = None, radius: float = 0.0, belt: Sequence[float] = (0.0, 0.0, 0.0)) -> Any:
    """Return a contact of two points or balls on a plane, of which the second is far above it."""
    scene = kf.System()
    body = scene.add_rigid_body("body", 1.0, 0.1, joint=kf.Free(position=(0.0, 0.0, 9.0)))
    floor = scene.add_surface("floor", scene.ground, shapes.Plane("z"))
    skin = scene.add_surface("skin", body, shapes.Points([(0, 0, 0), (0, 0, 5)], radius=radius, share=SHARE))
    scene.add_contact("c", skin, floor, normal=normal, friction=friction, surface_velocity=belt)
    return scene.freeze().loads[0]


def meeting_ends(
    depth: float = D, rate: float = RATE, slide: Sequence[float] = (0.0, 0.0), radius: float = 0.0
) -> tuple[End, End]:
    """Return the ends where the first point is so deep in the surface, and moves past it so, in axes of the surface."""
    point = np.array((0.05, -0.04, -depth))
    at = SURFACE.p + TURN @ (point + np.array((0.0, 0.0, radius)))
    w = SURFACE.w + TURN @ SPIN
    past = TURN @ np.array((*slide, -rate))
    place = SURFACE.p + TURN @ point
    v = SURFACE.v + cross(SURFACE.w, place - SURFACE.p) + past - cross(w, place - at)
    return SURFACE, End(at, TURN @ rotation_matrix(np.array((0.8, 0.1, -0.2, math.sqrt(0.31)))), v, w)


def state_of(load: Any, stretch: Sequence[float] = (), held: bool = True, twists: Sequence[float] = ()) -> np.ndarray:
    """Return the states with a stretch of the first point in axes of the surface, m."""
    states = load.initial_states.copy()
    at = load.begins
    states[at : at + len(stretch)] = stretch
    if load.friction is not None and load.friction.has_memory:
        states[at + 3 :: load.each] = float(held)
    states[load.turning(0)] = twists if len(twists) else 0.0
    return states


def force_on_point(action: Action, ends: Sequence[End], place: np.ndarray | None = None) -> np.ndarray:
    """Return the force on what touches, in axes of the surface; what acts on the surface is its reaction there."""
    force, at = action.wrenches[1, :3], ends[1].p if place is None else place
    np.testing.assert_allclose(action.wrenches[0, :3], -force, atol=1e-12 * np.abs(force).max())
    # both moments about the origin of N cancel
    total = sum(cross(end.p, wrench[:3]) + wrench[3:] for end, wrench in zip(ends, action.wrenches, strict=True))
    np.testing.assert_allclose(total, 0.0, atol=1e-12 * np.abs(action.wrenches).max())
    np.testing.assert_allclose(action.wrenches[1, 3:], cross(at - ends[1].p, force), atol=1e-12 * abs(force).max())
    return TURN.T @ force


TABLE = kf.TableLaw((5e-3, 0.02, 0.03), (80.0, 200.0, 900.0), damping=LAMBDA)


def pchip(d: float) -> float:
    from scipy.interpolate import PchipInterpolator

    return float(PchipInterpolator((0.0, 5e-3, 0.02, 0.03), (0.0, 80.0, 200.0, 900.0))(d))


Law = tuple[Any, Callable[[float], float], Callable[[float, float], float]]
LAWS: dict[str, Law] = {
    "hunt-crossley": (kf.HuntCrossley(K, LAMBDA), lambda d: K * d, lambda f, r: f * (1.0 + LAMBDA * r)),
    "exponent": (kf.HuntCrossley(K, LAMBDA, 2.2), lambda d: K * d**2.2, lambda f, r: f * (1.0 + LAMBDA * r)),
    "hertz": (kf.Hertz(K, LAMBDA), lambda d: K * d**1.5, lambda f, r: f * (1.0 + LAMBDA * r)),
    "kelvin-voigt": (kf.KelvinVoigt(K, C_NORMAL), lambda d: K * d, lambda f, r: f + C_NORMAL * r),
    "restitution": (kf.Restitution(K, 0.6), lambda d: K * d, lambda f, r: f * (1.0 + 0.25 * r)),
    "table": (TABLE, pchip, lambda f, r: f * (1.0 + LAMBDA * r)),
}
"""Each with its elastic force, and the force at an elastic one and a rate; of all points together."""


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("rate", [RATE, -RATE, 0.0, -8.0])
@pytest.mark.parametrize("depth", [D, 0.03])
@pytest.mark.parametrize("name", LAWS)
def test_normal_laws_are_their_closed_forms(name: str, depth: float, rate: float, way: str) -> None:
    """At -8 m/s all of them would pull, and let go."""
    law, elastic_of, force_of = LAWS[name]
    load = contact_of(law)
    states = load.initial_states + (0.25 if name == "restitution" else 0.0)
    ends = meeting_ends(depth, rate)
    done = acted(load, ends, states, way)
    elastic = elastic_of(depth)
    force = max(0.0, force_of(elastic, rate))
    assert (force == 0.0) == (rate == -8.0)
    np.testing.assert_allclose(force_on_point(done, ends), (0.0, 0.0, SHARE * force), rtol=1e-12, atol=1e-12)
    assert done.potential == pytest.approx(SHARE * quad(elastic_of, 0.0, depth, points=(5e-3, 0.02))[0], rel=1e-9)
    assert done.taken == pytest.approx(SHARE * (force - elastic) * rate, rel=1e-11, abs=1e-12)
    assert done.given == 0.0
    assert not np.any(done.rates)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("name", LAWS)
def test_nothing_acts_where_nothing_touches(name: str, way: str) -> None:
    load = contact_of(LAWS[name][0])
    done = acted(load, meeting_ends(-1e-9, 3.0), load.initial_states, way)
    assert not np.any(done.wrenches)
    assert (done.potential, done.taken, done.given) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("name", LAWS)
def test_slopes_of_normal_laws_are_those_of_their_forces(name: str) -> None:
    law, elastic_of, _ = LAWS[name]
    h = 1e-6
    wanted = SHARE * (elastic_of(D + h) - elastic_of(D - h)) / (2.0 * h)
    assert law.slope(D, SHARE) == pytest.approx(wanted, rel=1e-6)  # the square of h over D


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("friction", ["none", "sticks", "slips"])
def test_complex_steps_of_normal_laws_are_differences(name: str, friction: str) -> None:
    rough = {"none": None, "sticks": kf.Coulomb(0.4, stiffness=STIFF, damping=DAMP)}
    rough["slips"] = kf.Coulomb(0.01, stiffness=STIFF, damping=DAMP)
    load = contact_of(LAWS[name][0], rough[friction])
    stretch = () if friction == "none" else (1e-3, -5e-4, 2e-4)
    assert_complex_steps_are_differences(load, meeting_ends(slide=(0.02, -0.01)), state_of(load, stretch))


def coulomb(**given: Any) -> kf.Coulomb:
    return kf.Coulomb(**{"mu": 0.4, "stiffness": STIFF, "damping": DAMP} | given)


HC = kf.HuntCrossley(K, LAMBDA)
STRETCH, SLIDE = np.array((1.2e-3, -0.5e-3, 0.0)), np.array((0.05, 0.11, 0.0))
PULL = k * STRETCH + c * SLIDE
"""Of the anchor of the first point, in axes of the surface, N."""

SIZE = float(np.linalg.norm(PULL))


def check_books(done: Action, drag: np.ndarray, rate: np.ndarray, slide: np.ndarray = SLIDE, spring: float = k) -> None:
    """Compare the energy, the power that is taken, and what is told of the slip, of friction on one point."""
    elastic = SHARE * K * D
    stored = 0.5 * spring * float(STRETCH @ STRETCH)
    assert done.potential == pytest.approx(0.5 * elastic * D + stored, rel=1e-12)
    taken = (NORMAL - elastic) * RATE + drag @ slide - spring * (STRETCH @ rate)
    assert done.taken == pytest.approx(taken, rel=1e-11)
    np.testing.assert_allclose(done.rates[2:5], rate, atol=1e-12)
    assert done.rates[1] == pytest.approx(drag @ (slide - rate), rel=1e-10, abs=1e-12)
    assert done.rates[0] == pytest.approx(SHARE * np.linalg.norm(slide - rate), rel=1e-10, abs=1e-12)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("given", [{"mu": 0.4}, {"mu": 0.1, "static": 0.4}])
def test_what_sticks_hangs_on_spring_and_damper(given: dict[str, float], way: str) -> None:
    """``p = k w + c v``, and the stretch follows the motion."""
    load, ends = contact_of(HC, coulomb(**given)), meeting_ends(slide=SLIDE[:2])
    done = acted(load, ends, state_of(load, STRETCH), way)
    assert 0.1 * NORMAL < SIZE < 0.4 * NORMAL
    np.testing.assert_allclose(force_on_point(done, ends), (0.0, 0.0, NORMAL) - PULL, rtol=1e-12, atol=1e-12)
    check_books(done, PULL, SLIDE)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize(
    ("given", "held", "most"),
    [
        ({"mu": 0.1}, True, 0.1),
        ({"mu": 0.1, "static": 0.4}, False, 0.1),
        ({"mu": 0.005, "static": 0.01}, True, 0.01 * HELD_BEYOND),
    ],
    ids=["one coefficient", "slips by the kinetic one", "waits for its event"],
)
def test_what_slips_is_rubbed_by_the_coefficient(given: dict[str, float], held: bool, most: float, way: str) -> None:
    """``mu N`` along p, and ``dw/dt = (force - k w) / c``."""
    load, ends = contact_of(HC, coulomb(**given)), meeting_ends(slide=SLIDE[:2])
    done = acted(load, ends, state_of(load, STRETCH, held), way)
    drag = most * NORMAL * PULL / SIZE
    np.testing.assert_allclose(force_on_point(done, ends), (0.0, 0.0, NORMAL) - drag, rtol=1e-12, atol=1e-12)
    check_books(done, drag, (drag - k * STRETCH) / c)


@pytest.mark.parametrize("way", WAYS)
def test_falling_friction_is_the_root_of_its_equation(way: str) -> None:
    """``c s + N (mu + (static - mu) exp(-(s/v)^2)) = |p|`` has one root where friction falls slowly."""
    mu, static, speed = 0.03, 0.05, 2.0
    load = contact_of(HC, coulomb(mu=mu, static=static, stribeck_speed=speed))
    ends = meeting_ends(slide=SLIDE[:2])
    done = acted(load, ends, state_of(load, STRETCH, held=False), way)

    def friction(s: float) -> float:
        return NORMAL * (mu + (static - mu) * math.exp(-((s / speed) ** 2)))

    s = brentq(lambda s: c * s + friction(s) - SIZE, 0.0, SIZE / c, xtol=1e-14)
    assert s > 0.5 * speed / 2.0
    drag = friction(s) * PULL / SIZE
    np.testing.assert_allclose(force_on_point(done, ends), (0.0, 0.0, NORMAL) - drag, rtol=1e-11)
    check_books(done, drag, (drag - k * STRETCH) / c)
    stretch = -0.5 * c / k * SLIDE
    weak = acted(load, ends, state_of(load, stretch, held=False), way)  # below mu N there is no root: it holds
    pull = 0.5 * c * SLIDE
    np.testing.assert_allclose(force_on_point(weak, ends)[:2], -pull[:2], rtol=1e-12)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("exponent", [0.7, 2.0])
def test_stribeck_friction_is_the_root_of_its_equation(exponent: float, way: str) -> None:
    """``c s + N (mu + (breakaway - mu) exp(-(s/v)^exponent) + viscous s) = |p|``."""
    mu, breakaway, speed, viscous = 0.03, 0.05, 2.0, 0.02
    law = kf.Stribeck(mu, breakaway, speed, exponent, viscous, stiffness=STIFF, damping=DAMP)
    load, ends = contact_of(HC, law), meeting_ends(slide=SLIDE[:2])

    def friction(s: float) -> float:
        return NORMAL * law.coefficient(s)

    s = brentq(lambda s: c * s + friction(s) - SIZE, 0.0, SIZE / c, xtol=1e-14)
    assert law.coefficient(s) == pytest.approx(mu + 0.02 * math.exp(-((s / speed) ** exponent)) + viscous * s)
    drag = friction(s) * PULL / SIZE
    done = acted(load, ends, state_of(load, STRETCH, held=False), way)
    np.testing.assert_allclose(force_on_point(done, ends), (0.0, 0.0, NORMAL) - drag, rtol=1e-11)
    check_books(done, drag, (drag - k * STRETCH) / c)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize(("mu", "sticks"), [((0.1, 0.15), False), ((0.9, 0.5), True)])
def test_two_coefficients_are_the_axes_of_an_ellipse(mu: tuple[float, float], sticks: bool, way: str) -> None:
    load, ends = contact_of(HC, coulomb(mu=mu, along=(1.0, 1.0, 0.0))), meeting_ends(slide=SLIDE[:2])
    drag = -force_on_point(acted(load, ends, state_of(load, STRETCH), way), ends)
    axes = np.array(((1.0, 1.0, 0.0), (-1.0, 1.0, 0.0))) / math.sqrt(2.0)
    along = axes @ drag / mu
    if sticks:
        np.testing.assert_allclose(drag[:2], PULL[:2], rtol=1e-12)
        assert np.linalg.norm(along) < NORMAL
    else:
        assert np.linalg.norm(along) == pytest.approx(NORMAL, rel=1e-12)
        np.testing.assert_allclose(cross(drag - (0.0, 0.0, drag[2]), PULL), 0.0, atol=1e-12 * SIZE**2)


@pytest.mark.parametrize("way", WAYS)
def test_a_belt_gives_power(way: str) -> None:
    belt = np.array((0.3, -0.2, 0.0))
    load, ends = contact_of(HC, coulomb(mu=0.1), belt=belt), meeting_ends(slide=SLIDE[:2])
    done = acted(load, ends, state_of(load, STRETCH), way)
    slide = SLIDE - belt
    pull = k * STRETCH + c * slide
    drag = 0.1 * NORMAL * pull / np.linalg.norm(pull)
    np.testing.assert_allclose(force_on_point(done, ends)[:2], -drag[:2], rtol=1e-12)
    assert done.given == pytest.approx(-drag @ belt, rel=1e-12)
    check_books(done, drag, (drag - k * STRETCH) / c, slide)


@pytest.mark.parametrize("way", WAYS)
def test_an_anchor_in_the_air_comes_back(way: str) -> None:
    """``dw/dt = -k w / c``; what it gives up is taken. Bristles as fast as s0 / s1, and they keep nothing."""
    load = contact_of(HC, coulomb(torsional=0.05))
    done = acted(load, meeting_ends(-1e-3), state_of(load, STRETCH, twists=(0.2,)), way)
    assert not np.any(done.wrenches[:, :3])
    np.testing.assert_allclose(done.rates[2:5], -k / c * STRETCH, rtol=1e-12, atol=1e-14)
    k_twist = k * 0.05**2
    assert done.potential == pytest.approx(0.5 * k * STRETCH @ STRETCH + 0.5 * k_twist * 0.04, rel=1e-12)
    assert done.taken == pytest.approx(2.0 * k / c * done.potential, rel=1e-12)
    assert done.rates[5] == pytest.approx(-k / c * 0.2, rel=1e-12)
    assert not np.any(done.rates[:2])
    load = contact_of(HC, kf.LuGre(300.0, 2.0, 0.1, coulomb=0.3, static=0.5, stribeck_speed=0.2))
    done = acted(load, meeting_ends(-1e-3), state_of(load, STRETCH), way)
    np.testing.assert_allclose(done.rates[2:5], -150.0 * STRETCH, rtol=1e-12, atol=1e-14)
    assert (done.potential, done.taken) == (0.0, 0.0)


@pytest.mark.parametrize("way", WAYS)
def test_bristles_bend_and_slip_by_their_equations(way: str) -> None:
    s0, s1, s2, speed = 300.0, 2.0, 0.1, 0.2
    load = contact_of(HC, kf.LuGre(s0, s1, s2, coulomb=0.3, static=0.5, stribeck_speed=speed))
    ends = meeting_ends(slide=SLIDE[:2])
    done = acted(load, ends, state_of(load, STRETCH), way)
    v = float(np.linalg.norm(SLIDE))
    g = 0.3 + 0.2 * math.exp(-((v / speed) ** 2))
    rate = SLIDE - s0 * v / g * STRETCH
    drag = NORMAL * (s0 * STRETCH + s1 * rate + s2 * SLIDE)
    np.testing.assert_allclose(force_on_point(done, ends), (0.0, 0.0, NORMAL) - drag, rtol=1e-12, atol=1e-12)
    check_books(done, drag, rate, spring=0.0)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize(("arm", "slips"), [(0.4, True), (0.02, False)])
def test_spinning_is_held_by_a_moment(arm: float, slips: bool, way: str) -> None:
    """``k rho^2 twist + c rho^2 w`` about the normal, at most ``mu rho N``."""
    load, ends, twist = contact_of(HC, coulomb(torsional=arm)), meeting_ends(), 0.02
    done = acted(load, ends, state_of(load, twists=(twist,)), way)
    pull = arm**2 * (k * twist + c * SPIN[2])
    moment = 0.4 * arm * NORMAL if slips else pull
    assert (pull > 0.4 * arm * NORMAL) == slips
    np.testing.assert_allclose(TURN.T @ done.wrenches[1, 3:], (0.0, 0.0, -moment), rtol=1e-12, atol=1e-12)
    given = (moment - k * arm**2 * twist) / (c * arm**2)
    assert done.rates[5] == pytest.approx(given, rel=1e-10)
    assert done.rates[1] == pytest.approx(moment * (SPIN[2] - given), rel=1e-9, abs=1e-12)
    without = acted(contact_of(HC, coulomb()), ends, np.zeros(8), way)
    assert done.potential - without.potential == pytest.approx(0.5 * k * arm**2 * twist**2, rel=1e-9)
    taken = moment * SPIN[2] - k * arm**2 * twist * given
    assert done.taken - without.taken == pytest.approx(taken, rel=1e-9)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize(("arm", "slips"), [(1e-3, True), (0.4, False)])
def test_rolling_is_held_by_a_moment(arm: float, slips: bool, way: str) -> None:
    """``k r^2 twist + c r^2 w`` across the normal, at most ``arm N``; of a ball whose lowest place stands still."""
    radius, twist = 0.06, np.array((0.01, -0.02, 0.0))
    load, ends = contact_of(HC, coulomb(rolling=arm), radius), meeting_ends(radius=radius)
    done = acted(load, ends, state_of(load, twists=twist), way)
    pull = radius**2 * (k * twist + c * SPIN * (1.0, 1.0, 0.0))
    size = float(np.linalg.norm(pull))
    moment = arm * NORMAL / size * pull if slips else pull
    assert (size > arm * NORMAL) == slips
    force = TURN.T @ done.wrenches[1, :3]
    np.testing.assert_allclose(force, (0.0, 0.0, NORMAL), rtol=1e-11, atol=1e-11)
    np.testing.assert_allclose(TURN.T @ done.wrenches[1, 3:], -moment, rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(done.rates[5:8], (moment / radius**2 - k * twist) / c, rtol=1e-9, atol=1e-12)


FRICTIONS = {
    "slips": (coulomb(mu=0.1), True),
    "sticks": (coulomb(mu=0.9, static=1.0), True),
    "falls": (coulomb(mu=0.03, static=0.05, stribeck_speed=2.0), False),
    "turns": (coulomb(mu=0.1, torsional=0.05, rolling=1e-3), True),
    "two": (coulomb(mu=(0.1, 0.15)), True),
    "bristles": (kf.LuGre(300.0, 2.0, 0.1, coulomb=0.3, static=0.5, stribeck_speed=0.2), True),
    "stribeck sticks": (kf.Stribeck(0.9, 1.0, 0.1, 0.7, 0.2, stiffness=STIFF, damping=DAMP), True),
    "stribeck slips": (kf.Stribeck(0.03, 0.05, 2.0, 0.7, 0.02, stiffness=STIFF, damping=DAMP), False),
}


@pytest.mark.parametrize("name", FRICTIONS)
@pytest.mark.parametrize("depth", [D, -1e-3])
def test_complex_steps_of_friction_are_differences(name: str, depth: float) -> None:
    law, held = FRICTIONS[name]
    load = contact_of(HC, law, radius=0.06)
    twists = [0.02, 0.01, -0.03, 0.01][: getattr(law, "turning_states", 0)]
    states = state_of(load, STRETCH, held, twists)
    assert_complex_steps_are_differences(load, meeting_ends(depth, slide=SLIDE[:2], radius=0.06), states)


@pytest.mark.parametrize("name", ["sticks", "turns"])
def test_the_tangent_is_the_slope_of_forces(name: str) -> None:
    """Of what presses, and of what sticks: displacements of the ends stretch the anchors, and press."""
    law = coulomb(mu=0.9, static=1.0) if name == "sticks" else None
    load = contact_of(kf.KelvinVoigt(K, 0.0), law)
    ends = [end._replace(v=np.zeros(3), w=np.zeros(3)) for end in meeting_ends()]
    states = state_of(load, np.zeros(3) if law is not None else ())
    tangent = load.tangent(0.0, ends, states)
    K_found = tangent.rows.T * tangent.stiffness @ tangent.rows
    h = 1e-7
    for at, end in enumerate(ends):
        for i in range(3):
            moved = list(ends)
            moved[at] = end._replace(p=end.p + h * np.eye(3)[i])
            stretched = states.copy()
            if law is not None:
                stretched[2:5] = TURN.T @ ((1 if at else -1) * h * np.eye(3)[i])
            change = load.action(0.0, moved, stretched).wrenches - load.action(0.0, ends, states).wrenches
            row = K_found[6 * at + i].reshape(2, 6)
            np.testing.assert_allclose(-change[:, :3] / h, row[:, :3], atol=1e-5 * np.abs(K_found).max())
