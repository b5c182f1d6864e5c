"""Speeds after an impact of rigid contacts against those of compliant ones of 1e9 N/m: 100 scenes drawn by a seed.

Double pendulums and boxes with friction, and beams of 4 to 24 modes whose tip meets a stop, all of restitution 1: there
compliant contacts have one limit, however they are damped. Friction is far stiffer than the contact, since one that
yields along the surface as well as across it has another limit. Contacts of 1e9 N/m are soft for what moves with little
mass, as tips of beams do: where they differ, stiffer ones tell whether that is the limit.
`python tests/benchmarks/stiff_limit.py` prints the table.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np

import kanefe as kf
import kanefe_fem as fem
from kanefe.frames import rotation_matrix

STIFFNESSES = 1e9, 1e11, 1e13
"""Stiffnesses of contacts, N/m: the first, and those to which others are compared that differ."""

STIFFER = 1e5
"""Stiffness of friction relative to that of its contact."""

LASTS = 4e-3
"""Span within which an impact of the first stiffness is over, s."""

OUTPUTS = 800
"""Number of output times in that span."""

HERTZ, TOGETHER = 1e11, 1.2e-3
"""Stiffness of contacts of bodies that touch (N/m^1.5), and span within which they have parted (s)."""

WANTED = 0.02
"""Difference of a speed, relative to the largest, up to which both agree."""


class Drawn(NamedTuple):
    """A scene that touches, and what is in it."""

    kind: str
    scene: kf.System
    about: str


Law = kf.Rigid | kf.HuntCrossley


def laws(k: float, mu: float) -> tuple[Law, kf.Coulomb | None]:
    """Return normal law and friction of a contact of a stiffness, N/m; infinite: a rigid one."""
    if k == np.inf:
        return kf.Rigid(1.0), kf.Coulomb(mu) if mu else None
    soft = kf.Coulomb(mu, stiffness=STIFFER * k, damping=2.0 * np.sqrt(STIFFER * k))
    return kf.HuntCrossley(k), soft if mu else None


def pendulum(rng: np.random.Generator, k: float) -> Drawn:
    """Return a double pendulum whose tip is on a rough floor and goes down."""
    mu, first, second = rng.uniform(0.1, 1.5), rng.uniform(-1.2, 1.2), rng.uniform(-1.5, 1.5)
    rates = rng.uniform(-3.0, 3.0, 2)
    down = -np.sin(first) * rates[0] - np.sin(first + second) * (rates[0] + rates[1])
    rates = rates * np.sign(down) * (-1.0)
    s = kf.System()
    floor = s.add_surface("floor", s.ground, kf.shapes.Plane("z"))
    height, rod = np.cos(first) + np.cos(first + second), (1 / 12, 1 / 12, 1e-4)
    joint = kf.Revolute("y", position=first, speed=-rates[0])
    upper = s.add_rigid_body("upper", 1.0, rod, com=(0, 0, -0.5), at=(0, 0, height), joint=joint)
    joint = kf.Revolute("y", position=second, speed=-rates[1])
    lower = s.add_rigid_body("lower", 1.0, rod, com=(0, 0, -0.5), at=(0, 0, -1.0), parent=upper, joint=joint)
    normal, friction = laws(k, mu)
    s.add_contact("tip", lower.frame(at=(0, 0, -1.0)), floor, normal=normal, friction=friction)
    return Drawn("pendulum", s, f"mu {mu:.2f}")


def box(rng: np.random.Generator, k: float) -> Drawn:
    """Return a box with a corner on a rough floor, which it strikes in space."""
    mu, sides = rng.uniform(0.05, 1.0), rng.uniform(0.1, 0.4, 3)
    axis = rng.standard_normal(3)
    turn = kf.rotation_about(tuple(axis / np.linalg.norm(axis)), rng.uniform(0.2, 1.2))
    corners = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]) * sides
    up = rotation_matrix(turn)[2]
    low = corners[np.argmin(corners @ up)]
    spin, velocity = rng.uniform(-3, 3, 3), np.append(rng.uniform(-2, 2, 2), -1.5)
    s = kf.System()
    floor = s.add_surface("floor", s.ground, kf.shapes.Plane("z"))
    start = kf.Free(position=(0, 0, -float(low @ up)), orientation=turn, velocity=velocity, angular_velocity=spin)
    inertia = tuple((sides @ sides - sides**2) / 12.0)
    body = s.add_rigid_body("box", 1.0, inertia, joint=start)
    normal, friction = laws(k, mu)
    s.add_contact("tip", body.frame(at=tuple(low)), floor, normal=normal, friction=friction)
    return Drawn("box", s, f"mu {mu:.2f}")


def beam(rng: np.random.Generator, k: float) -> Drawn:
    """Return a beam that swings about its root onto a stop under its tip."""
    count, side = int(rng.integers(4, 25)), rng.uniform(0.01, 0.03)
    steel = fem.Material(E=210e9, nu=0.3, rho=7850.0)
    model = fem.straight_beam(1.0, fem.Rectangle(side, side), steel, elements=30, planar=True)
    body = fem.beam_body(model, {"root": "clamped"}, reduction=kf.CraigBampton(modes=count))
    s = kf.System()
    part = s.add_flexible_body("beam", body, joint=kf.Revolute("z", speed=-rng.uniform(0.5, 3.0)))
    floor = s.add_surface("stop", s.ground, kf.shapes.Plane("y"))
    normal, _ = laws(k, 0.0)
    s.add_contact("tip", part.node(30), floor, normal=normal)
    return Drawn("beam", s, f"{count} modes, side {1e3 * side:.0f} mm")


MAKERS = pendulum, box, beam


def speeds_after(seed: int, k: float) -> tuple[Drawn, np.ndarray]:
    """Return a scene, and its free speeds after the impact of contacts of a stiffness, N/m."""
    drawn = MAKERS[seed % 3](np.random.default_rng(seed), k)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        model = drawn.scene.freeze()
        if k == np.inf:
            return drawn, np.asarray(model.parts(model.route.start(0.0))[1])
        span = LASTS * np.sqrt(STIFFNESSES[0] / k)
        result = drawn.scene.simulate((0.0, span), output_step=span / OUTPUTS, rtol=1e-7)
    at = int(np.searchsorted(result.times, result.events["tip lift"][0]))
    return drawn, np.asarray(model.parts(result.run.states[at])[1])


def differences(count: int = 100) -> Iterator[tuple[str, str, list[float]]]:
    """Yield kind, what it is, and the largest difference of speeds over the largest speed, by stiffness."""
    for seed in range(count):
        drawn, rigid = speeds_after(seed, np.inf)
        found: list[float] = []
        for k in STIFFNESSES:
            compliant = speeds_after(seed, k)[1]
            found.append(float(np.abs(rigid - compliant).max() / np.abs(rigid).max()))
            if found[-1] <= WANTED:
                break
        yield drawn.kind, f"{seed}: {drawn.about}", found


def touching(count: int, has_faces: bool, normal: Law) -> np.ndarray:
    """Return the speeds of bodies of unlike masses that touch in a row, balls or boxes, after the first has struck."""
    masses, s = np.random.default_rng(count).uniform(0.5, 2.0, count), kf.System()
    starts = [kf.Prismatic("x", position=0.2 * i - 1e-4 * (i == 0), speed=float(i == 0)) for i in range(count)]
    bodies = [s.add_rigid_body(f"{i}", float(masses[i]), 0.004, joint=starts[i]) for i in range(count)]
    for i, (a, b) in enumerate(pairwise(bodies)):
        first, second = (
            s.add_surface(f"a{i}", a, kf.shapes.Sphere(0.1)),
            s.add_surface(f"b{i}", b, kf.shapes.Sphere(0.1)),
        )
        if has_faces:
            first = s.add_surface(f"face{i}", a, kf.shapes.Plane("x"), at=(0.1, 0, 0))
            second = [b.frame(at=(-0.1, y, z)) for y in (-0.1, 0.1) for z in (-0.1, 0.1)]
        s.add_contact(f"pair{i}", second, first, normal=normal)
    result = s.simulate((0.0, TOGETHER), output_times=(TOGETHER,), rtol=1e-7)
    return np.array([result.joint_speeds(f"{i}")[-1, 0] for i in range(count)])


def of_rows() -> Iterator[str]:
    """Yield what simultaneous and distributed impacts of bodies in a row miss those of Hertz by."""
    for has_faces in (False, True):
        for count in range(3, 8):
            hertz = touching(count, has_faces, kf.HuntCrossley(HERTZ, exponent=1.5))
            missed = [
                float(np.abs(touching(count, has_faces, kf.Rigid(1.0, law)) - hertz).max())
                for law in ("stronge", "distributing")
            ]
            what = f"{count} {'boxes' if has_faces else 'balls'} that touch"
            yield f"{what}: simultaneous {missed[0]:.3f}, distributing {missed[1]:.1e} of the speed of the first"


def main() -> None:
    """Print the tables."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for line in of_rows():
            print(line, flush=True)
    worst: dict[str, list[list[float]]] = {}
    for kind, about, found in differences():
        worst.setdefault(kind, []).append(found)
        if found[0] > WANTED:
            print(f"{kind} {about}: {', '.join(f'{one:.1e}' for one in found)}", flush=True)
    for kind, rows in worst.items():
        first, last = [row[0] for row in rows], [row[-1] for row in rows]
        near, all_near = (sum(one <= WANTED for one in each) for each in (first, last))
        print(
            f"{kind}: {near} of {len(rows)} within {WANTED:.0%} at {STIFFNESSES[0]:g} N/m, {all_near} with stiffer; "
            f"median {np.median(first):.1e}"
        )


if __name__ == "__main__":
    main()
