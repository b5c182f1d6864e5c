"""Masses that differ by many powers of ten, bodies without mass, and inertia that is zero about an axis."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal, localcontext

import numpy as np

from kanefe.checks.robustness.case import Effort, Finding, StressCase
from kanefe.checks.robustness.runs import controlled_methods, follow, is_accurate, tolerance
from kanefe.equations.model import Model
from kanefe.joints import Free, Joint, Prismatic, Revolute, Spherical, Universal
from kanefe.kane.assemble import accelerations
from kanefe.literal.consistent_start import consistent_start
from kanefe.result import Result
from kanefe.states.state import State
from kanefe.system import System
from robustness.outcomes import failure_of

RATIOS = tuple(10.0**k for k in range(-8, 9))
LINKS = 6
RTOL = 1e-9
GRAVITY = 9.81


def pendulum_chain(masses: Sequence[float], angles: Sequence[float], rates: Sequence[float]) -> Model:
    """Return points on rods of 1 m without mass, hinge by hinge; the angles are those of the joints."""
    scene = System(gravity=(0.0, -GRAVITY, 0.0))
    link = None
    for i, (mass, angle, rate) in enumerate(zip(masses, angles, rates, strict=True)):
        place = (0.0, -1.0, 0.0) if i else (0.0, 0.0, 0.0)
        joint = Revolute("z", position=angle, speed=rate)
        link = scene.add_rigid_body(f"link {i}", mass, com=(0.0, -1.0, 0.0), parent=link, at=place, joint=joint)
    return scene.freeze()


def exact_chain_accelerations(masses: Sequence[float], angles: np.ndarray, rates: np.ndarray) -> np.ndarray:
    """Return the accelerations of the joints of `pendulum_chain`, from its equations in 60 digits.

    With absolute angles a_i and m_ij the mass beyond the farther of two links:
    ``sum_j m_ij cos(a_i - a_j) a_j'' = -sum_j m_ij sin(a_i - a_j) a_j'^2 - g m_ii sin a_i``.
    """
    with localcontext() as context:
        context.prec = 60
        n = len(masses)
        a = [sum(map(Decimal, angles[: i + 1].tolist()), Decimal(0)) for i in range(n)]
        w = [sum(map(Decimal, rates[: i + 1].tolist()), Decimal(0)) for i in range(n)]
        outer = [sum(map(Decimal, masses[i:]), Decimal(0)) for i in range(n)]
        rows = []
        for i in range(n):
            pulls = [outer[max(i, j)] * _sine(a[i] - a[j]) * w[j] ** 2 for j in range(n)]
            row = [outer[max(i, j)] * _cosine(a[i] - a[j]) for j in range(n)]
            rows.append([*row, -sum(pulls) - Decimal(GRAVITY) * outer[i] * _sine(a[i])])
        absolute = _solved(rows)
        return np.array([float(absolute[i] - (absolute[i - 1] if i else 0)) for i in range(n)])


def _sine(x: Decimal) -> Decimal:
    term, total, k = x, x, 1
    while abs(term) > Decimal("1e-58"):
        term *= -x * x / ((k + 1) * (k + 2))
        total, k = total + term, k + 2
    return total


def _cosine(x: Decimal) -> Decimal:
    half = _sine(x / 2)
    return 1 - 2 * half * half


def _solved(rows: list[list[Decimal]]) -> list[Decimal]:
    """Return the solution of linear equations, rows with their right side last, by Gauss and Jordan."""
    for i in range(len(rows)):
        best = max(range(i, len(rows)), key=lambda k: abs(rows[k][i]))
        rows[i], rows[best] = rows[best], rows[i]
        rows[i] = [x / rows[i][i] for x in rows[i]]
        for k in range(len(rows)):
            if k != i:
                rows[k] = [x - rows[k][i] * y for x, y in zip(rows[k], rows[i], strict=True)]
    return [row[-1] for row in rows]


def mass_ratios(effort: Effort) -> Iterator[Finding]:
    """Chains of light and heavy bodies: accelerations against 60 digits, and energy in a run."""
    rng = np.random.default_rng(0)
    patterns: dict[str, Callable[[float, int], float]] = {
        "every second link": lambda ratio, i: ratio if i % 2 else 1.0,
        "the last link": lambda ratio, i: ratio if i == LINKS - 1 else 1.0,
        "growing from link to link": lambda ratio, i: ratio ** (i / (LINKS - 1)),
    }
    for name, mass in patterns.items():
        sweeps: list[float] = []
        dense: list[float] = []
        for ratio in RATIOS:
            masses = [mass(ratio, i) for i in range(LINKS)]
            for _ in range(effort.count(10, 2)):
                angles, rates = rng.uniform(-3, 3, LINKS), rng.uniform(-2, 2, LINKS)
                model = pendulum_chain(masses, angles.tolist(), rates.tolist())
                exact = exact_chain_accelerations(masses, angles, rates)
                found = model.rhs(0.0, model.initial_state)[LINKS:], accelerations(State(model, 0.0, angles, rates))
                for errors, values in zip((sweeps, dense), found, strict=True):
                    errors.append(float(np.abs(values - exact).max() / np.abs(exact).max()))
        what = f"chain of {LINKS} points, mass ratio 1e-8 ... 1e8 of {name}: accelerations of"
        # the inertia of what is heavy outward is taken off that of what is light inward, where it cannot move: the rest
        # has the round-off of the heavy one, 1e8 times 2e-16, and every link adds its own
        reason = "known limit: round-off times the mass ratio, of a heavy end of a light chain"
        yield Finding.of(f"{what} the order-n sweep", sweeps, "relative error", 1e-7, reason)
        reason = "round-off times the condition of the matrix, some hundred times the mass ratio"
        yield Finding.of(f"{what} the literal route", dense, "relative error", 1e-5, reason)
    drifts = []
    for ratio in RATIOS:
        model = pendulum_chain((1.0, ratio), (1.0, 0.5), (0.0, 0.0))
        run = follow(model, 2.0, rtol=RTOL, method="dop853", output_step=0.5)
        energy = Result(model, run).energy
        drifts.append(float(np.abs(energy.balance_error).max() / np.abs(energy.kinetic).max()))
    yield Finding.of(
        f"double pendulum, mass ratio 1e-8 ... 1e8, 2 s at rtol {RTOL:g}",
        drifts,
        "energy error, relative",
        1e-6,
        "hundreds of steps of rtol; at a ratio of 1e8 an rtol below 1e-10 is below round-off, and ends with advice",
    )


def massless_frames(effort: Effort) -> Iterator[Finding]:
    """Frames without mass between joints, and points, against the same joint in one piece."""
    rng = np.random.default_rng(1)
    cardan, slides, balls, swings = [], [], [], []
    for _ in range(effort.count(50, 10)):
        cloud = 0.3 * rng.standard_normal((6, 3))
        second, com = cloud.T @ cloud, rng.uniform(-0.3, 0.3, 3)
        inertia = np.trace(second) * np.eye(3) - second
        q, u = rng.uniform(-1, 1, 2), rng.standard_normal(2)
        cardan.append(_spread([_in_two(split, inertia, com, q, u) for split in (True, False)]))
        slides.append(_spread([_beside_frames(count, inertia, com, q, u) for count in (0, 1, 20)]))
        balls.append(_point_on_frames(rng))
        swings.append(_swing_of_frames(q, u))
    for what, errors in (
        ("cardan joint of two hinges and a frame without mass", cardan),
        ("1 and 20 frames without mass fixed between two bodies", slides),
        ("point on two frames without mass on slides: falls freely", balls),
        ("spherical pendulum of two hinges without mass and a point", swings),
    ):
        yield Finding.of(what, errors, "accelerations, relative", 1e-11, "round-off")
    methods = controlled_methods(_slider_crank(True))
    errors = [_error_of_rod(method) for method in methods if is_accurate(method)]
    yield Finding.of(
        "slider-crank whose rod has no mass, held by its loop alone, 2 s, by methods of high order",
        errors,
        "angle of the crank against a distance held [rad]",
        1e-6,
        "rtol 1e-8 a step over some hundred steps",
    )
    errors = [_error_of_rod(method) for method in methods if not is_accurate(method)]
    yield Finding.of(
        "slider-crank whose rod has no mass, held by its loop alone, 2 s, by methods of order 2",
        errors,
        "angle of the crank against a distance held [rad]",
        1e-2,
        "rtol 1e-6 a step over a thousand steps",
    )


def _slider_crank(has_rod: bool) -> Model:
    """Return a crank and a slider, with a rod without mass between them or with what it does: it keeps a distance."""
    scene = System(gravity=(0.0, -GRAVITY, 0.0))
    crank = scene.add_rigid_body("crank", 1.0, 0.1, com=(0.2, 0.0, 0.0), joint=Revolute("z", position=0.7, speed=5.0))
    slider = scene.add_rigid_body("slider", 0.5, 0.01, joint=Prismatic("x", position=1.3))
    if has_rod:
        joint = Revolute("z", position=-1.0)
        rod = scene.add_rigid_body("rod", 0.0, 0.0, parent=crank, at=(0.4, 0.0, 0.0), joint=joint)
        scene.add_loop_joint("pin", Spherical(), rod.frame(at=(1.0, 0.0, 0.0)), slider)
    else:
        scene.add_distance("rod", crank.frame(at=(0.4, 0.0, 0.0)), slider, 1.0)
    return scene.freeze()


def _error_of_rod(method: str) -> float:
    # from the same place at the same speed: closing the loop from a guess would not take both there
    with_rod = _slider_crank(True)
    q, u = consistent_start(with_rod, 0.0)
    held = replace(_slider_crank(False), initial_coordinates=q[:2], initial_speeds=u[:2])
    exact = follow(held, 2.0, rtol=1e-11, method="dop853", output_step=0.1)
    run = follow(with_rod, 2.0, rtol=tolerance(method, 1e-8, 1e-6), method=method, output_step=0.1)
    return float(np.abs(run.coordinates[:, 0] - exact.coordinates[:, 0]).max())


def _spread(values: Sequence[np.ndarray]) -> float:
    scale = max(float(np.abs(values[0]).max()), 1e-300)
    return max(float(np.abs(other - values[0]).max()) for other in values[1:]) / scale


def _in_two(is_split: bool, inertia: np.ndarray, com: np.ndarray, q: np.ndarray, u: np.ndarray) -> np.ndarray:
    scene = System(gravity=(1.0, -2.0, 3.0))
    if is_split:
        cross = scene.add_frame("cross", joint=Revolute("x", position=q[0], speed=u[0]))
        scene.add_rigid_body(
            "end", 2.0, inertia, com=com.tolist(), parent=cross, joint=Revolute("y", position=q[1], speed=u[1])
        )
    else:
        scene.add_rigid_body(
            "end", 2.0, inertia, com=com.tolist(), joint=Universal("x", "y", position=q.tolist(), speed=u.tolist())
        )
    return _speeds_rates(scene)


def _beside_frames(count: int, inertia: np.ndarray, com: np.ndarray, q: np.ndarray, u: np.ndarray) -> np.ndarray:
    scene = System(gravity=(1.0, -2.0, 3.0))
    last = scene.add_rigid_body("hub", 1.0, inertia, com=com.tolist(), joint=Revolute("x", position=q[0], speed=u[0]))
    for i in range(count):
        last = scene.add_frame(f"frame {i}", parent=last, at=(0.4 / count, 0.0, 0.0))
    at = (0.0 if count else 0.4, 0.0, 0.0)
    joint = Revolute("z", position=q[1], speed=u[1])
    scene.add_rigid_body("end", 2.0, inertia, com=com.tolist(), parent=last, at=at, joint=joint)
    return _speeds_rates(scene)


def _point_on_frames(rng: np.random.Generator) -> float:
    g = rng.uniform(-10, 10, 3)
    scene = System(gravity=g.tolist())
    last = scene.ground
    for axis in "xy":
        last = scene.add_frame(axis, parent=last, joint=Prismatic(axis, speed=float(rng.standard_normal())))
    scene.add_point("ball", float(10.0 ** rng.uniform(-8, 8)), parent=last, joint=Prismatic("z"))
    return float(np.abs(_speeds_rates(scene) - g).max() / np.abs(g).max())


def _swing_of_frames(q: np.ndarray, u: np.ndarray) -> float:
    """Return the error of a point 1 m below a hinge about x that carries one about y, against its closed form.

    The direction of the rod is ``(-cos(a) ... )`` as the two hinges turn it; from Lagrange's equations in a, b:
    ``cos(b) a'' = 2 sin(b) a' b' - g sin(a)`` and ``b'' = -a'^2 sin(b) cos(b) - g cos(a) sin(b)``.
    """
    scene = System(gravity=(0.0, 0.0, -GRAVITY))
    cross = scene.add_frame("cross", joint=Revolute("x", position=q[0], speed=u[0]))
    scene.add_rigid_body(
        "ball", 0.3, com=(0.0, 0.0, -1.0), parent=cross, joint=Revolute("y", position=q[1], speed=u[1])
    )
    (a, b), (da, db) = q, u
    exact = np.array(
        (
            (2.0 * np.sin(b) * da * db - GRAVITY * np.sin(a)) / np.cos(b),
            -(da**2) * np.sin(b) * np.cos(b) - GRAVITY * np.cos(a) * np.sin(b),
        )
    )
    return float(np.abs(_speeds_rates(scene) - exact).max() / np.abs(exact).max())


def _speeds_rates(scene: System) -> np.ndarray:
    model = scene.freeze()
    return model.rhs(0.0, model.initial_state)[model.coordinate_count :]


@dataclass(frozen=True)
class Loose:
    """A scene in which nothing has inertia along some speed."""

    name: str
    joint: Joint
    inertia: Sequence[float]
    mass: float = 1.0
    com: Sequence[float] = (0.0, 0.0, 0.0)


LOOSE = (
    Loose("rod on a hinge along it", Revolute("x"), (0.0, 1.0, 1.0)),
    Loose("rod on a ball joint on its axis", Spherical(), (0.0, 1.0, 1.0), com=(0.5, 0.0, 0.0)),
    Loose("free rod", Free(angular_velocity=(0.1, 1.0, 0.0)), (0.0, 1.0, 1.0)),
    Loose("free point with a rotation", Free(), (0.0, 0.0, 0.0)),
    Loose("point on a hinge", Revolute("z"), (0.0, 0.0, 0.0)),
    Loose("frame on a slide", Prismatic("x"), (0.0, 0.0, 0.0), mass=0.0),
    Loose("rod turned in space on a ball joint", Spherical(orientation=(1.0, 0.3, -0.5, 0.2)), (0.0, 1.0, 1.0)),
)


def zero_axes(effort: Effort) -> Iterator[Finding]:
    """Inertia without an axis: right where the joint doesn't need it, and refused by name where it does."""
    errors = []
    rng = np.random.default_rng(2)
    for _ in range(effort.count(50, 10)):
        # a rod along x on a cardan joint about y and z: nothing turns it about itself
        q, u = rng.uniform(-1, 1, 2), rng.standard_normal(2)
        scene = System(gravity=(0.0, 0.0, -GRAVITY))
        scene.add_rigid_body(
            "rod",
            3.0,
            (0.0, 0.25, 0.25),
            com=(0.5, 0.0, 0.0),
            joint=Universal("z", "y", position=q.tolist(), speed=u.tolist()),
        )
        # of azimuth a and elevation -b of a uniform rod of length 1 (J = m / 3)
        (_, b), (da, db) = q, u
        exact = np.array(
            (
                2.0 * np.tan(b) * da * db,
                -np.sin(b) * np.cos(b) * da**2 + 1.5 * GRAVITY * np.cos(b),
            )
        )
        errors.append(float(np.abs(_speeds_rates(scene) - exact).max() / np.abs(exact).max()))
    yield Finding.of(
        "rod without inertia about itself on a cardan joint", errors, "accelerations, relative", 1e-11, "round-off"
    )
    not_named = 0
    for loose in LOOSE:
        scene = System()
        scene.add_rigid_body("thing", loose.mass, loose.inertia, com=loose.com, joint=loose.joint)
        not_named += "nothing has inertia along thing" not in failure_of(scene.freeze(), 0.1)
    yield Finding(
        "scenes with nothing that has inertia along a free speed",
        len(LOOSE),
        "not refused by name",
        float(not_named),
        0.0,
        "they have no solution; the error names the speeds",
    )


CASES = (
    StressCase("mass-ratio", "mass ratios 1e-8 to 1e8", mass_ratios),
    StressCase("massless", "frames and points without mass", massless_frames),
    StressCase("zero-axis", "inertia that is zero about an axis", zero_axes),
)
