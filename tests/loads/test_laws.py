"""Each load between frames against its law as it is printed: virtual power, energy, slopes and rates of its states.

The forces follow from the principle of virtual power: with what a law is of, displacements x of its ends and the
forces -F over them, the wrenches on the ends are ``-(dx/dtwist)^T F``. Here dx is of differences, by a path of its own.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator
from scipy.spatial.transform import Rotation

import kanefe as kf
from kanefe.joints.joint_friction import RubbingSurfaces
from kanefe.kernels.constraints.tolerances import HELD_BEYOND
from kanefe.kernels.force_elements.coordinate_friction import BALL, PADS, THREAD
from kanefe.loads.action import End
from kanefe.loads.base import Load
from kanefe.loads.bushing import Bushing
from kanefe.loads.coordinate_friction import CoordinateFriction
from kanefe.loads.coordinate_stop import CoordinateStop
from kanefe.loads.spring import SpringDamper
from scenes import derivatives

NONE = np.zeros(0)
Moving = Callable[[float], tuple[End, ...]]

STEP = 2e-3
# order-8 differences over steps of 2e-3 of motions of some rad/s: truncation below 1e-12, round-off 2e-16 / 2e-3 of
# forces and energies of up to 1e3 in N and J
CLOSE = {"rtol": 1e-9, "atol": 1e-9}


class Path:
    """An end that moves smoothly: a polynomial, and a turn by the exponential of a polynomial."""

    def __init__(self, rng: np.random.Generator, at: Sequence[float] = (0, 0, 0), turn: float = 1.0) -> None:
        self.p, self.begun = rng.normal(size=(3, 3)) * 0.3, Rotation.from_rotvec(turn * rng.normal(size=3))
        self.p[0] += at
        self.w = rng.normal(size=(2, 3))

    def at(self, s: float) -> End:
        """Return the end at a time; velocities are of differences but at zero."""
        A = (Rotation.from_rotvec(self.w[0] * s + 0.5 * self.w[1] * s * s) * self.begun).as_matrix()
        p = self.p[0] + self.p[1] * s + 0.5 * self.p[2] * s * s
        # of a rotation vector r(s) the angular velocity is dr/ds to first order in r
        return End(p, A, self.p[1] + self.p[2] * s, self.w[0] + self.w[1] * s)


def paths(rng: np.random.Generator, count: int, turn: float = 1.0) -> Moving:
    """Return ends about a line along x, which move by some dm/s and rad/s."""
    moving = [Path(rng, (1.2 * i, 0, 0), turn) for i in range(count)]
    return lambda s: tuple(path.at(s) for path in moving)


def displaced(ends: Sequence[End], number: int, direction: int, s: float) -> tuple[End, ...]:
    """Return ends of which one is moved along a direction of N by s, or turned about it."""
    end, step = ends[number], s * np.eye(3)[direction % 3]
    if direction < 3:
        moved = end._replace(p=end.p + step)
    else:
        moved = end._replace(A=Rotation.from_rotvec(step).as_matrix() @ end.A)
    return (*ends[:number], moved, *ends[number + 1 :])


def faster(ends: Sequence[End], number: int, direction: int, s: float) -> tuple[End, ...]:
    """Return ends of which one has s more of a velocity, or of an angular velocity, along a direction of N."""
    end, step = ends[number], s * np.eye(6)[direction]
    return (*ends[:number], end._replace(v=end.v + step[:3], w=end.w + step[3:]), *ends[number + 1 :])


def by_virtual_power(ends: Sequence[End], x: Callable[..., np.ndarray], F: np.ndarray) -> np.ndarray:
    """Return the wrenches of forces -F over displacements x of ends."""
    found = np.zeros((len(ends), 6))
    for i in range(len(ends)):
        for c in range(6):
            slope, _ = derivatives(lambda s, i=i, c=c: np.atleast_1d(x(displaced(ends, i, c, s))), STEP)
            found[i, c] = -slope @ F
    return found


def length_of(ends: Sequence[End]) -> float:
    """Return the way over the ends."""
    return sum(math.dist(a.p, b.p) for a, b in pairwise(ends))


def seen_from_a(ends: Sequence[End]) -> np.ndarray:
    """Return the place and rotation vector of b in the axes of a."""
    a, b = ends[:2]
    return np.append(a.A.T @ (b.p - a.p), Rotation.from_matrix(a.A.T @ b.A).as_rotvec())


def rate_of(x: Callable[..., Any], moving: Moving) -> np.ndarray:
    """Return how fast displacements change along a motion."""
    return np.atleast_1d(derivatives(lambda s: np.atleast_1d(x(moving(s))), STEP)[0])


def power_left(load: Load, t: float, moving: Moving, states: np.ndarray) -> float:
    """Return ``P + dU/dt + taken - given``, the balance of a load along a motion: zero."""
    done = load.action(t, moving(0.0), states)
    power = sum(w[:3] @ e.v + w[3:] @ e.w for w, e in zip(done.wrenches, moving(0.0), strict=True))
    stored, _ = derivatives(lambda s: np.array(load.action(t, moving(s), states + s * done.rates).potential), STEP)
    return float(power + stored + done.taken - done.given)


class Case(NamedTuple):
    """A load, its displacements and, from these and their rates, the forces over them and the energy in it."""

    load: Load
    x: Callable[..., Any]
    F: Callable[[np.ndarray, np.ndarray], Any]
    potential: Callable[[np.ndarray], float]
    ends: int = 2
    states: np.ndarray = NONE


def spring(**options: Any) -> SpringDamper:
    given = {"stiffness": 70.0, "damping": 4.0, "rest_length": 0.8, "lengths": NONE, "forces": NONE, "function": None}
    return SpringDamper("s", ("a", "b"), **{**given, **options})


TABLE = np.array((0.2, 0.9, 1.3, 2.0)), np.array((-9.0, 1.0, 12.0, 13.0))


def cable(kind: str, slack: float, breaking: float | None = None, states: Any = ()) -> Case:
    """A rope or a winch over three points, that much longer than its way at the seed's start."""
    way = length_of(paths(np.random.default_rng(3), 3)(0.0))
    if kind == "rope":
        l0 = way + slack
        rope = kf.Rope("r", ("a", "b", "c"), 5e2, damping=8.0, length=l0, breaking_load=breaking)

        def pull(x: np.ndarray, v: np.ndarray) -> float:
            broken = len(states) and states[0] == 0.0
            return 0.0 if x[0] < l0 or broken else max(0.0, (5e2 * (x[0] - l0) + 8.0 * v[0]) / l0)

        stored = 0.0 if len(states) and states[0] == 0.0 else 1.0
        return Case(
            rope, length_of, pull, lambda x: stored * 0.5 * 5e2 / l0 * max(0.0, x[0] - l0) ** 2, 3, np.array(states)
        )
    table = (0.0, 1.0), (40.0, 80.0)
    winch = kf.Winch("w", ("a", "b", "c"), tension=table, stiffness=6e2, speed=0.4, damping=90.0)
    ends = paths(np.random.default_rng(3), 3)(0.0)
    winch = winch.started(0.25, ends)  # 50 N there
    assert winch.length == pytest.approx(way - 50.0 / 6e2)
    z = np.array((slack,))

    def held(x: np.ndarray, v: np.ndarray) -> float:
        return max(0.0, 6e2 * (x[0] - winch.length - z[0]))

    return Case(winch, length_of, held, lambda x: 0.5 * held(x, x) ** 2 / 6e2, 3, z)


OLEO = {"area": 3e-3, "pressure": 8e5, "volume": 9e-3, "orifice": 600.0, "rebound": 1500.0, "extended": 2.5}


def oleo(exponent: float) -> Case:
    p, A, V, pa = OLEO["pressure"], OLEO["area"], OLEO["volume"], 101325.0

    def push(x: np.ndarray, v: np.ndarray) -> float:
        gas = A * (p * (1.0 - (2.5 - x[0]) * A / V) ** -exponent - pa)
        return -(gas - (1500.0 if v[0] > 0.0 else 600.0) * v[0] * abs(v[0]))

    def stored(x: np.ndarray) -> float:
        """The work of the gas from full extension, by Gauss's quadrature."""
        at, weights = np.polynomial.legendre.leggauss(40)
        s = 2.5 - x[0]
        strokes = 0.5 * s * (at + 1.0)
        return float(0.5 * s * weights @ (A * (p * (1.0 - strokes * A / V) ** -exponent - pa)))

    return Case(kf.Oleo("o", ("a", "b"), exponent=exponent, **OLEO), length_of, push, stored)


def full(seed: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(6, 6))
    return 20.0 * rng.normal(size=(6, 6)), root @ root.T


def bushing_and_seen() -> tuple[Bushing, np.ndarray, np.ndarray]:
    K, C = full(1)
    return Bushing("b", ("a", "b"), K, C, None), K, C


LINES = {
    "spring": Case(
        spring(), length_of, lambda x, v: 70.0 * (x[0] - 0.8) + 4.0 * v[0], lambda x: 35.0 * (x[0] - 0.8) ** 2
    ),
    "table": Case(
        spring(stiffness=0.0, rest_length=0.0, lengths=TABLE[0], forces=TABLE[1]),
        length_of,
        lambda x, v: np.interp(x[0], *TABLE) + 4.0 * v[0],
        lambda x: 0.0,
    ),
    "function": Case(
        spring(function=lambda x, v: x**3 - 2.0 * v),
        length_of,
        lambda x, v: 70.0 * (x[0] - 0.8) + 2.0 * v[0] + x[0] ** 3,
        lambda x: 35.0 * (x[0] - 0.8) ** 2,
    ),
    "rope": cable("rope", -0.2),
    "rope that may break": cable("rope", -0.2, 1e4, (1.0,)),
    "broken rope": cable("rope", -0.2, 1e4, (0.0,)),
    "slack rope": cable("rope", 0.2),
    "winch": cable("winch", -0.05),
    "slack winch": cable("winch", 0.3),
    "oleo": oleo(1.3),
    "slow oleo": oleo(1.0),
}


@pytest.mark.parametrize("seed", [3, 4])
@pytest.mark.parametrize("name", LINES)
def test_forces_along_a_line_are_those_of_the_law(name: str, seed: int) -> None:
    case = LINES[name]
    for way in (1.0, -1.0):  # both ways of the motion: oil, dampers
        forward = paths(np.random.default_rng(seed), case.ends)
        moving: Moving = lambda s, way=way, forward=forward: tuple(  # noqa: E731
            e._replace(v=way * e.v, w=way * e.w) for e in forward(way * s)
        )
        ends, v = moving(0.0), rate_of(case.x, moving)
        x = np.atleast_1d(case.x(ends))
        done = case.load.action(0.25, ends, case.states)
        wanted = by_virtual_power(ends, case.x, np.atleast_1d(case.F(x, v)))
        np.testing.assert_allclose(done.wrenches, wanted, **CLOSE)
        assert done.potential == pytest.approx(case.potential(x), rel=1e-11, abs=1e-11)
        assert power_left(case.load, 0.25, moving, case.states) == pytest.approx(0.0, abs=1e-7)
        assert case.load.exchanges_energy or (done.taken, done.given) == (0.0, 0.0)


@pytest.mark.parametrize("name", LINES)
def test_the_stiffness_along_a_line_is_the_slope_of_the_law(name: str) -> None:
    case = LINES[name]
    ends = paths(np.random.default_rng(3), case.ends)(0.0)
    x, v = np.atleast_1d(case.x(ends)), rate_of(case.x, paths(np.random.default_rng(3), case.ends))
    found = case.load.tangent(0.25, ends, case.states)
    assert found is not None
    # along the way, by its gradient: what turning does under load is left out
    gradient = by_virtual_power(ends, case.x, -np.ones(1)).ravel()
    by_x, _ = derivatives(lambda s: np.atleast_1d(case.F(x + s, v)), 1e-4)
    by_v, _ = derivatives(lambda s: np.atleast_1d(case.F(x, v + s)), 1e-4)
    if case.load.kind == "spring" and case.load.function is not None:  # none is known of a user's function
        by_x, by_v = np.array((70.0,)), np.array((4.0,))
    K = found.rows.T @ (found.stiffness[:, None] * found.rows)
    C = found.rows.T @ (found.damping[:, None] * found.rows)
    # differences over 1e-4 of forces of some hundreds: 1e-16 * 1e3 / 1e-4
    np.testing.assert_allclose(K, by_x * np.outer(gradient, gradient), rtol=1e-8, atol=1e-8)
    np.testing.assert_allclose(C, by_v * np.outer(gradient, gradient), rtol=1e-8, atol=1e-8)


def test_what_a_winch_pays_out_is_bounded_and_a_settled_one_holds_its_tension() -> None:
    case = LINES["winch"]
    ends = paths(np.random.default_rng(3), 3)(0.0)
    way = length_of(ends)
    for paid_out, wanted in ((-0.05, 30.0 / 90.0), (-0.2, 0.4), (0.01, -6.0 / 90.0), (0.5, -0.4)):
        z = np.array((paid_out,))  # at 50 N nothing is paid out; 6e2 N/m and 90 N s/m; 0.4 m/s at most
        done = case.load.action(0.25, ends, z)
        assert done.rates == pytest.approx([wanted], abs=1e-12)
        assert done.given == pytest.approx(-max(0.0, 50.0 - 6e2 * paid_out) * wanted, abs=1e-11)
    settled = case.load.resting(ends)
    done = settled.action(0.25, ends, NONE)
    np.testing.assert_allclose(done.wrenches, by_virtual_power(ends, length_of, np.array((50.0,))), **CLOSE)
    assert done.potential == pytest.approx(50.0 * way)
    assert len(done.rates) == 0
    assert case.load.rested(ends, np.zeros(1)) == pytest.approx([way - case.load.length - 40.0 / 6e2])  # as t = 0


def test_a_broken_winch_pays_out_nothing() -> None:
    winch = kf.Winch("w", ("a", "b"), tension=5.0, stiffness=6e2, speed=0.4, damping=90.0, breaking_load=70.0)
    ends = paths(np.random.default_rng(3), 2)(0.0)
    winch = winch.started(0.0, ends)
    for z in ((-0.2, 0.0), (0.2, 0.0)):
        done = winch.action(0.0, ends, np.array(z))
        assert not done.wrenches.any()
        assert done.rates == pytest.approx([0.0, 0.0])
    assert winch.action(0.0, ends, np.array((-0.2, 1.0))).potential > 0.0


def test_events_of_cables_look_at_stretch_and_tension() -> None:
    ends = paths(np.random.default_rng(3), 2)(0.0)
    way, rate = length_of(ends), rate_of(length_of, paths(np.random.default_rng(3), 2))[0]
    rope = kf.Rope("r", ("a", "b"), 5e2, damping=8.0, length=way - 0.1, breaking_load=300.0).in_detail()
    slack, taut, breaks = rope.events
    pull = (5e2 * 0.1 + 8.0 * rate) / (way - 0.1)
    for event, wanted in ((slack, 0.1), (taut, 0.1), (breaks, 300.0 - pull)):
        assert event.function(0.0, ends, np.ones(1)) == pytest.approx(wanted)
    assert slack.function(0.0, ends, np.zeros(1)) == pytest.approx(0.1 - way)
    winch = kf.Winch("w", ("a", "b"), tension=5.0, stiffness=60.0, speed=0.4, damping=90.0, breaking_load=70.0)
    winch = winch.in_detail().started(0.0, ends)
    wound_up, slack, taut, breaks = winch.events
    for paid_out in (-0.2, 0.3):
        z, stretch = np.array((paid_out, 1.0)), 5.0 / 60.0 - paid_out
        assert slack.function(0.0, ends, z) == taut.function(0.0, ends, z) == pytest.approx(stretch)
        assert breaks.function(0.0, ends, z) == pytest.approx(70.0 - max(0.0, 60.0 * stretch))
    assert slack.function(0.0, ends, np.array((0.0, 0.0))) < 0.0
    assert wound_up.function(0.0, ends, np.array((-0.2, 1.0))) == pytest.approx(min(1.0, 0.999 * way))
    assert [event.direction for event in winch.events] == [-1, -1, 1, -1]


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("has_law", [False, True])
def test_a_bushing_is_its_springs_and_dampers_at_any_angle(seed: int, has_law: bool) -> None:
    load, K, C = bushing_and_seen()
    moving = paths(np.random.default_rng(seed), 2)
    ends = moving(0.0)
    a, b = ends
    x = seen_from_a(ends)
    rates = np.append(rate_of(seen_from_a, moving)[:3], a.A.T @ (b.w - a.w))
    law = np.zeros(6)
    if has_law:
        load = Bushing("b", ("a", "b"), K, C, lambda d, v: np.sin(d) - v)
        law = np.sin(x) - rates
    done = load.action(0.0, ends, NONE)
    springs = by_virtual_power(ends, seen_from_a, K @ x)
    beside = law - C @ rates
    on_b = np.append(a.A @ beside[:3], a.A @ beside[3:])
    on_a = np.append(-on_b[:3], -on_b[3:] - np.cross(b.p - a.p, on_b[:3]))
    np.testing.assert_allclose(done.wrenches, [springs[0] + on_a, springs[1] + on_b], **CLOSE)
    even = 0.5 * (K + K.T)
    assert done.potential == pytest.approx(0.5 * x @ even @ x)
    assert done.taken == pytest.approx(rates @ C @ rates)
    skew = rate_of(seen_from_a, moving) @ (K - even) @ x
    assert done.given == pytest.approx(law @ rates - skew)
    assert power_left(load, 0.0, moving, NONE) == pytest.approx(0.0, abs=1e-8)


def test_a_bushing_sees_half_a_turn_from_both_sides() -> None:
    load = Bushing("b", ("a", "b"), np.diag((0, 0, 0, 2.0, 2.0, 2.0)), np.zeros((6, 6)), None)
    still = End(*np.zeros((1, 3)), np.eye(3), *np.zeros((2, 3)))
    for axis in (*np.eye(3), *-np.eye(3), np.array((0.6, 0.0, 0.8))):
        for angle in (1e-9, 1e-4, 1.0, 3.0, math.pi - 1e-6):
            turned = still._replace(A=Rotation.from_rotvec(angle * axis).as_matrix())
            done = load.action(0.0, (still, turned), NONE)
            # the angle from a matrix near half a turn: 1e-16 / 1e-6 of its sine
            np.testing.assert_allclose(done.wrenches[1, 3:], -2.0 * angle * axis, rtol=1e-7, atol=1e-14 * angle)
            assert done.potential == pytest.approx(angle**2, rel=1e-7)


def tilt_of(axis: str) -> Callable[..., np.ndarray]:
    e = np.eye(3)["xyz".index(axis)]

    def seen(ends: Sequence[End]) -> np.ndarray:
        a, b = ends[:2]
        return np.append(a.A.T @ (b.p - a.p), np.cross(e, a.A.T @ b.A @ e))

    return seen


def free_about(matrix: np.ndarray, axis: str) -> np.ndarray:
    i = 3 + "xyz".index(axis)
    found = matrix.copy()
    found[i], found[:, i] = 0.0, 0.0
    return found


@pytest.mark.parametrize("kind", ["constant", "table", "of another"])
@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_a_bearing_is_its_coefficients_at_its_speed(axis: str, kind: str) -> None:
    i = 3 + "xyz".index(axis)
    speeds, count = np.array((-40.0, -1.0, 2.0, 30.0)), 3 if kind == "of another" else 2
    tables = [[free_about(matrix, axis) for matrix in full(seed)] for seed in range(4)]
    for k, (_, C) in enumerate(tables):
        C[i, i] = 0.5 + k
    Ks, Cs = (np.array(matrices) for matrices in zip(*tables, strict=True))
    ends_named = ("a", "b", "c")[:count]
    if kind == "constant":
        load = kf.Bearing("b", ends_named, Ks[0], Cs[0], axis=axis)
    else:
        load = kf.Bearing("b", ends_named, Ks, Cs, speeds=speeds, axis=axis)
    moving = paths(np.random.default_rng(7), count, turn=0.3)
    ends = moving(0.0)
    a, b = ends[:2]
    e = np.eye(3)[i - 3]
    speed = e @ a.A.T @ (ends[-1].w - a.w)
    K, C = Ks[0], Cs[0]
    if kind != "constant":
        K, C = PchipInterpolator(speeds, Ks)(speed), PchipInterpolator(speeds, Cs)(speed)
    x, rates = tilt_of(axis)(ends), rate_of(tilt_of(axis), moving)
    done = load.action(0.0, ends, NONE)
    held = by_virtual_power(ends, tilt_of(axis), K @ x + free_about(C, axis) @ rates)
    own = C[i, i] * (e @ a.A.T @ (b.w - a.w))  # the drag of the shaft itself, about its own axis
    drag = -own * b.A @ e
    held[0, 3:] -= drag
    held[1, 3:] += drag
    np.testing.assert_allclose(done.wrenches, held, **CLOSE)
    even = 0.5 * (K + K.T) if kind == "constant" else np.zeros((6, 6))
    assert done.potential == pytest.approx(0.5 * x @ even @ x)
    assert done.taken == pytest.approx(rates @ free_about(C, axis) @ rates + own * (b.A @ e) @ (b.w - a.w))
    assert power_left(load, 0.0, moving, NONE) == pytest.approx(0.0, abs=1e-8)
    if kind != "constant":
        (event,) = load.events
        assert event.function(0.0, ends, NONE) == pytest.approx(min(speed + 40.0, 30.0 - speed), abs=1e-6)


def blown(wind: kf.Wind, areas: Any) -> kf.Aerodynamics:
    return kf.Aerodynamics(
        "w", "a", wind, angles=np.linspace(-np.pi, np.pi, 7), areas=areas, flat_area=1.5, density=1.2
    )


@pytest.mark.parametrize("seed", range(6))
def test_wind_presses_by_its_table(seed: int) -> None:
    angles = np.linspace(-np.pi, np.pi, 7)
    areas = np.column_stack([np.cos(angles + k) for k in range(6)])
    gust, mean = kf.Gust((2, 5, -1), 0.1, 0.9), np.array((-2.0, 3.0, 1.0))
    (end,) = moving = paths(np.random.default_rng(seed), 1)(0.0)
    r = end.A.T @ (mean + 0.5 * (1 - math.cos(2 * math.pi * 0.3 / 0.9)) * np.array((2, 5, -1)) - end.v)
    around = np.concatenate((angles[:-1] - 2 * np.pi, angles, angles[1:] + 2 * np.pi))
    curve = PchipInterpolator(around, np.vstack((areas[:-1], areas, areas[1:])))
    own = 0.6 * (r[0] ** 2 + r[1] ** 2) * curve(math.atan2(-r[1], -r[0]))
    own[2] += 0.6 * 1.5 * abs(r[2]) * r[2]
    done = blown(kf.Wind(mean, gusts=[gust]), areas).action(0.4, moving, NONE)
    wanted = np.append(end.A @ own[:3], end.A @ own[3:])
    np.testing.assert_allclose(done.wrenches, wanted[None], rtol=1e-12, atol=1e-12)
    assert done.given == pytest.approx(wanted[:3] @ end.v + wanted[3:] @ end.w)
    assert (done.potential, done.taken) == (0.0, 0.0)


def test_calm_air_presses_nothing() -> None:
    still = End(*np.zeros((1, 3)), np.eye(3), *np.zeros((2, 3)))
    done = blown(kf.Wind((0, 0, 0)), np.ones((7, 6))).action(0.0, (still,), NONE)
    assert not done.wrenches.any()


def test_a_hub_gives_its_mean_and_harmonics_in_its_axes() -> None:
    rng = np.random.default_rng(2)
    mean, cosine, sine = rng.normal(size=(3, 6))
    share = (0.0, 1.0, 2.0), (1.0, 0.4, 0.0)
    load = kf.PeriodicLoad("p", "a", 7.0, mean, {3: (cosine, sine)}, azimuth=0.4, share=share)
    (end,) = ends = paths(rng, 1)(0.0)
    for t, scale in ((0.5, 0.7), (1.5, 0.2), (-1.0, 1.0), (9.0, 0.0)):
        own = scale * (mean + cosine * math.cos(3 * (0.4 + 7 * t)) + sine * math.sin(3 * (0.4 + 7 * t)))
        done = load.action(t, ends, NONE)
        wanted = np.append(end.A @ own[:3], end.A @ own[3:])
        np.testing.assert_allclose(done.wrenches, wanted[None], rtol=1e-12, atol=1e-12)
        assert done.given == pytest.approx(wanted[:3] @ end.v + wanted[3:] @ end.w, abs=1e-13)


def coordinates(*pairs: tuple[float, float]) -> tuple[End, ...]:
    """Return joint coordinates and their rates as ends."""
    return tuple(End(np.array((q, 0, 0)), np.eye(3), np.array((v, 0, 0)), np.zeros(3)) for q, v in pairs)


def along(*pairs: tuple[float, float]) -> Moving:
    return lambda s: coordinates(*((q + v * s, v) for q, v in pairs))


ANCHOR = {"coordinate": "it", "stiffness": 300.0, "damping": 8.0}


def rubbing(count: int, **options: Any) -> CoordinateFriction:
    given = {"units": ("m",) * count, "sliding": 4.0, "static": 4.0, "arms": (1.0, 0.5, 2.0)[:count]}
    return CoordinateFriction("f", ("q",) * count, **{**ANCHOR, **given, **options})


RATES = ((0.3, 0.2), (0.1, -0.4), (-0.2, 0.3))


@pytest.mark.parametrize("count", [1, 2, 3])
@pytest.mark.parametrize("stretch", [1e-3, -5e-2])
@pytest.mark.parametrize("mark", [None, 0.0, 1.0])
@pytest.mark.parametrize("load", [None, 6.0, -3.0])
def test_friction_of_joints_is_the_pull_of_its_anchor_up_to_the_cap(
    count: int, stretch: float, mark: float | None, load: float | None
) -> None:
    arms, options = (1.0, 0.5, 2.0)[:count], {"base": 2.0}
    if mark is not None:
        options["static"] = 7.0
    if load is not None:
        options |= {"bearing": RubbingSurfaces(arms, BALL, np.eye(3)[0]), "load_time": 0.1}
    friction = rubbing(count, **options)
    w = stretch * np.arange(1.0, count + 1.0)
    z = np.concatenate((w, () if mark is None else (mark,), () if load is None else (load, 0.3)))
    moving = along(*RATES[:count])
    v = np.array([arm * rate for arm, (_, rate) in zip(arms, RATES, strict=False)])
    pull = 300.0 * w + 8.0 * v
    cap = (7.0 if mark == 1.0 else 4.0) * (2.0 + max(0.0, load or 0.0))
    size = np.linalg.norm(pull)
    if mark == 1.0:
        cap = HELD_BEYOND * cap  # the event ends the sticking, and the step
    drag = pull * min(1.0, cap / size)
    done = friction.action(0.0, moving(0.0), z)
    np.testing.assert_allclose(done.wrenches[:, 0], -drag * arms, rtol=1e-13)
    assert not done.wrenches[:, 1:].any()
    np.testing.assert_allclose(done.rates[:count], (drag - 300.0 * w) / 8.0, rtol=1e-12, atol=1e-13)
    assert not done.rates[count:].any()
    assert done.potential == pytest.approx(150.0 * w @ w)
    assert done.taken >= -1e-12
    assert power_left(friction, 0.0, moving, z) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("rate", [0.05, 0.4, 3.0])
def test_friction_that_falls_slips_where_damper_and_friction_balance(rate: float) -> None:
    friction = rubbing(1, static=7.0, stribeck_speed=0.3)
    moving = along((0.0, rate))
    w = np.array((0.03,))
    done = friction.action(0.0, moving(0.0), np.append(w, 0.0))
    pull = 300.0 * w[0] + 8.0 * rate
    drag = -done.wrenches[0, 0]
    s = (pull - drag) / 8.0
    assert drag == pytest.approx(4.0 + 3.0 * math.exp(-((s / 0.3) ** 2)), rel=1e-12)
    assert power_left(friction, 0.0, moving, np.append(w, 0.0)) == pytest.approx(0.0, abs=1e-9)
    slip, stick = friction.events
    assert stick.function(0.0, moving(0.0), np.append(w, 0.0)) == pytest.approx(pull - drag)
    assert slip.function(0.0, moving(0.0), np.append(w, 1.0)) == pytest.approx(pull - 7.0)


def test_friction_at_a_rest_hangs_on_where_it_rests() -> None:
    friction = rubbing(2, static=7.0)
    rest = friction.resting(coordinates((0.3, 0), (0.1, 0)))
    ends = coordinates((0.31, 0), (0.12, 0))
    z = np.array((0.001, 0.002, 1.0))
    done = rest.action(0.0, ends, z)
    w = z[:2] + np.array((1.0, 0.5)) * (0.01, 0.02)
    np.testing.assert_allclose(done.wrenches[:, 0], -300.0 * w * (1.0, 0.5), rtol=1e-12)
    assert not done.rates.any()
    np.testing.assert_allclose(rest.rested(ends, z)[:2], w, rtol=1e-12)


@pytest.mark.parametrize("marks", [(), (1.0,), (0.0,)])
def test_friction_that_holds_is_as_stiff_as_its_anchor(marks: tuple[float, ...]) -> None:
    friction = rubbing(2, static=7.0 if marks else 4.0)
    for w, holds in ((1e-4, True), (0.1, False)):
        found = friction.tangent(0.0, coordinates((0.3, 0), (0.1, 0)), np.array((w, 0.0, *marks)))
        assert (found is not None) == holds
        if found is not None:
            K = found.rows.T @ (found.stiffness[:, None] * found.rows)
            assert np.diag(K)[[0, 6]] == pytest.approx((300.0, 300.0 * 0.25))
            assert found.damping == pytest.approx(8.0)


def resisting(slopes: np.ndarray) -> np.ndarray:
    """Return the part of the symmetric part of slopes whose eigenvalues are above zero."""
    values, along_it = np.linalg.eigh(0.5 * (slopes + slopes.T))
    return (along_it * np.maximum(values, 0.0)) @ along_it.T


SMOOTH = {
    **{name: LINES[name] for name in ("spring", "table", "function", "rope", "winch", "oleo")},
    "bushing": Case(bushing_and_seen()[0], seen_from_a, None, None),
    "bearing": Case(kf.Bearing("b", ("a", "b"), *(free_about(matrix, "x") for matrix in full(3))), None, None, None),
    "wind": Case(blown(kf.Wind((-2, 3, 1)), np.ones((7, 6))), None, None, None, 1),
}


@pytest.mark.parametrize("name", SMOOTH)
def test_a_tangent_that_no_load_gives_comes_of_its_complex_kernel(name: str) -> None:
    case = SMOOTH[name]
    load, ends = case.load, paths(np.random.default_rng(3), case.ends, turn=0.3)(0.0)
    n = 6 * case.ends
    K, C = np.zeros((2, n, n))

    def forces(moved: Sequence[End]) -> np.ndarray:
        return load.action(0.25, moved, case.states).wrenches.ravel()

    if name == "function":  # complex steps do not go through a function of the user
        load = spring(function=lambda x, v: 12.0)
    for i in range(case.ends):
        for c in range(6):
            K[:, 6 * i + c] = -derivatives(lambda s, i=i, c=c: forces(displaced(ends, i, c, s)), STEP)[0]
            C[:, 6 * i + c] = -derivatives(lambda s, i=i, c=c: forces(faster(ends, i, c, s)), STEP)[0]
    found = Load.tangent(load, 0.25, ends, case.states)
    for values, wanted in ((found.stiffness, K), (found.damping, C)):
        # differences of forces of some 1e3 N over 2e-3
        np.testing.assert_allclose(
            found.rows.T @ (values[:, None] * found.rows), resisting(wanted), rtol=1e-7, atol=1e-7
        )


@pytest.mark.parametrize(("q", "beyond", "way"), [(0.53, 0.03, 1.0), (-0.24, 0.04, -1.0), (0.2, -0.3, 1.0)])
@pytest.mark.parametrize("rate", [-0.9, 0.7])
@pytest.mark.parametrize("damping", [0.0, 0.6, 3.0])
def test_a_stop_pushes_back_by_its_law(q: float, beyond: float, way: float, rate: float, damping: float) -> None:
    given = {"coordinate": "it", "unit": "m", "lower": -0.2, "upper": 0.5, "stiffness": 400.0}
    stop = CoordinateStop("s", ("q",), impact=0.4, least_speed=1e-3, **given)
    ends, z = coordinates((q, rate)), np.array((damping,))
    force = -way * 400.0 * max(0.0, beyond) * max(0.0, 1.0 + damping * way * rate)
    done = stop.action(0.0, ends, z)
    assert done.wrenches[0] == pytest.approx((force, 0, 0, 0, 0, 0), abs=1e-12)
    assert done.potential == pytest.approx(200.0 * max(0.0, beyond) ** 2)
    assert power_left(stop, 0.0, along((q, rate)), z) == pytest.approx(0.0, abs=1e-9)
    touch, lift = stop.events
    assert touch.function(0.0, ends, z) == lift.function(0.0, ends, z) == pytest.approx(beyond)
    found = stop.tangent(0.0, ends, z)
    acts = beyond > 0.0 and 1.0 + damping * way * rate > 0.0
    assert (found is not None) == acts
    if found is not None:
        at = lambda x, v: stop.action(0.0, coordinates((q + x, rate + v)), z).wrenches[0, :1]  # noqa: E731
        slopes = derivatives(lambda s: at(s, 0.0), 1e-4)[0], derivatives(lambda s: at(0.0, s), 1e-4)[0]
        # forces of tens over steps of 1e-4: 1e-15 * 1e1 / 1e-4
        along_it = found.rows[:, 0] ** 2
        assert [along_it @ found.stiffness] == pytest.approx(-slopes[0], rel=1e-9)
        assert [along_it @ found.damping] == pytest.approx(-slopes[1], abs=1e-9)


def test_the_load_of_joints_is_as_printed() -> None:
    """Pads, balls and threads, see `kanefe.JointFriction`: the filter follows the load of the reaction."""
    rng = np.random.default_rng(3)
    wrench = rng.normal(size=6)
    a = rng.normal(size=3)
    a /= np.linalg.norm(a)
    F, M = wrench[:3], wrench[3:]
    across = F - (F @ a) * a
    turned = np.cross(M, a) * 5.0
    half = np.linalg.norm(0.5 * across + turned) + np.linalg.norm(0.5 * across - turned)
    wanted = {
        PADS: half + 0.3 * abs(F @ a) + 2.0 * abs(M @ a),
        BALL: np.linalg.norm(F),
        THREAD: abs(0.3 * F @ a + 2.0 * 1.1),
    }
    for kind, load in wanted.items():
        surfaces = RubbingSurfaces((1.0,), kind, a, per_length=5.0, thrust=0.3, twist=2.0)
        friction = rubbing(1, bearing=surfaces, load_time=0.1, sliding=1.0, static=1.0, base=1.1)
        z = np.array((1.0, 0.0, 0.4))  # a cap of 1.1 N, above which it is drawn
        ends = coordinates((0.0, 0.0))
        assert friction.load(wrench, ends, z) == pytest.approx(load)
        assert friction.load_rates(wrench, ends, z) == pytest.approx(((0.4 + 2.0 * load) / 0.1, load / 0.1))
