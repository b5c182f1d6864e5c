"""Mechanisms with more constraints than they need: doubled, spatial pins in a plane, and Bennett's linkage."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from kanefe.checks.robustness.case import Effort, Finding, StressCase
from kanefe.checks.robustness.loops import loop_opening
from kanefe.checks.robustness.runs import controlled_methods, follow, is_accurate, tolerance
from kanefe.checks.robustness.units import MILLIMETRES, SI, Units
from kanefe.equations.constraint_report import constraint_report
from kanefe.equations.model import Model
from kanefe.frames import euler_parameters
from kanefe.integrate.trajectory import Trajectory
from kanefe.joints import Fixed, Joint, Revolute, Spherical
from kanefe.result import Result
from kanefe.system import System

SPAN = 3.0
RTOL = 1e-9


def four_bar(pin: Joint, copies: int = 1, braces: int = 0, units: Units = SI) -> Model:
    """Return a crank-rocker whose loop is closed by a pin, `copies` times over.

    Parameters
    ----------
    pin : Joint
        Spherical() is what a loop in a plane needs at least, Revolute("z") holds three rows more.
    copies : int
        How often the same pin is added.
    braces : int
        Fixed loop joints between the crank and a plate that is fixed to it anyway.
    units : Units
        In which it is written.
    """
    scene = System(gravity=(0.0, -9.81 * units.acceleration, 0.0))
    bar, metre = (units.mass, 0.1 * units.inertia), units.length
    turning = Revolute("z", position=1.0, speed=6.0 * units.rate)
    crank = scene.add_rigid_body("crank", *bar, com=(0.5 * metre, 0, 0), joint=turning)
    coupler = scene.add_rigid_body(
        "coupler", *bar, parent=crank, at=(metre, 0, 0), com=(metre, 0, 0), joint=Revolute("z")
    )
    rocker = scene.add_rigid_body("rocker", *bar, at=(2 * metre, 0, 0), com=(0, 0.9 * metre, 0), joint=Revolute("z"))
    ends = coupler.frame(at=(2 * metre, 0, 0)), rocker.frame(at=(0, 1.8 * metre, 0))
    for i in range(copies):
        scene.add_loop_joint(f"pin {i}", pin, *ends)
    if braces:
        at = (0.3 * metre, 0, 0)
        plate = scene.add_rigid_body(
            "plate", 0.5 * units.mass, 0.01 * units.inertia, parent=crank, at=at, joint=Fixed()
        )
        for i in range(braces):
            up = 0.1 * i * metre
            scene.add_loop_joint(f"brace {i}", Fixed(), crank.frame(at=(at[0], up, 0)), plate.frame(at=(0, up, 0)))
    return scene.freeze()


def parallel_cranks(count: int) -> Model:
    """Return a bar on `count` parallel cranks of one length: all but two of them are too many."""
    scene = System(gravity=(0.0, -9.81, 0.0))
    joint = Revolute("z", position=0.3, speed=-2.0)
    cranks = [
        scene.add_rigid_body(f"crank {i}", 1.0, 1 / 12, com=(0, 0.5, 0), at=(i, 0, 0), joint=joint)
        for i in range(count)
    ]
    bar = scene.add_rigid_body(
        "bar",
        2.0,
        0.3,
        com=(0.5 * (count - 1), 0, 0),
        parent=cranks[0],
        at=(0, 1, 0),
        joint=Revolute("z", position=-0.3, speed=2.0),
    )
    for i in range(1, count):
        scene.add_loop_joint(f"pin {i}", Revolute("z"), bar.frame(at=(i, 0, 0)), cranks[i].frame(at=(0, 1, 0)))
    return scene.freeze()


BENNETT_A, BENNETT_TWIST_A, BENNETT_TWIST_B = 1.0, math.radians(30.0), math.radians(75.0)
BENNETT_B = BENNETT_A * math.sin(BENNETT_TWIST_B) / math.sin(BENNETT_TWIST_A)
"""Length of the second link by Bennett's condition on lengths and twists: a / sin(alpha) = b / sin(beta)."""


def bennett() -> Model:
    """Return Bennett's linkage: four hinges in space, which only these lengths and twists let move."""
    scene = System(gravity=(1.0, -2.0, -5.0))
    links = ((BENNETT_A, BENNETT_TWIST_A), (BENNETT_B, BENNETT_TWIST_B)) * 2
    start = bennett_angles(0.8)
    last = None
    for i, ((length, twist), angle) in enumerate(zip(links[:3], start[:3], strict=True)):
        before = links[i - 1] if i else (0.0, 0.0)
        last = scene.add_rigid_body(
            f"link {i}",
            1.0,
            0.1,
            com=(0.5 * length, 0.0, 0.0),
            parent=last,
            at=(before[0], 0.0, 0.0),
            orientation=_turn(before[1]),
            joint=Revolute("z", position=angle, speed=1.0 if i == 0 else 0.0),
        )
        end = last.frame(at=(length, 0.0, 0.0), orientation=_turn(twist))
    # the fourth link is the ground: its hinge axis, seen from the first one, is one link back
    (length, twist) = links[3]
    back = scene.ground.frame(orientation=_turn(-twist)).frame(at=(-length, 0.0, 0.0))
    scene.add_loop_joint("closing", Revolute("z"), end, back)
    return scene.freeze()


def _turn(twist: float) -> list[float]:
    """Return the Euler parameters of a turn about x."""
    return list(euler_parameters((1.0, 0.0, 0.0), twist).tolist())


def bennett_angles(angle: float) -> tuple[float, float, float, float]:
    """Return the four angles of the hinges, rad: opposite ones add up to a turn, neighbours by Bennett's formula."""
    ratio = math.sin(0.5 * (BENNETT_TWIST_B + BENNETT_TWIST_A)) / math.sin(0.5 * (BENNETT_TWIST_B - BENNETT_TWIST_A))
    other = 2.0 * math.atan(ratio / math.tan(0.5 * angle))
    return angle, other, -angle, -other


def overconstrained(effort: Effort) -> Iterator[Finding]:
    """Compare over-constrained mechanisms with the same ones held by what they need."""
    span = SPAN if not effort.is_quick else 0.5
    plain = _run(four_bar(Spherical()), span)
    pins = {"a pin with 3 rows too many": four_bar(Revolute("z"))}
    pins |= {f"{n} equal pins": four_bar(Revolute("z"), copies=n) for n in ((2, 10) if not effort.is_quick else (2,))}
    errors, openings, freedoms = [], [], []
    for model in pins.values():
        run = _run(model, span)
        errors.append(float(np.abs(run.coordinates - plain.coordinates).max()))
        openings.append(_worst_opening(model, run))
        freedoms.append(abs(constraint_report(model.route).degrees_of_freedom - 1))
    what = f"four-bar held by {', '.join(pins)}, {span:g} s at rtol 1e-9"
    yield Finding.of(
        what, errors, "angles against a plain pin [rad]", 1e-6, "1e-9 a step over some hundred steps, twice"
    )
    yield Finding.of(what, openings, "opening of the loop [m]", 1e-10, "projected to round-off")

    braced = four_bar(Spherical(), braces=3)
    run = _run(braced, span)
    energy = Result(braced, run).energy
    yield Finding(
        f"four-bar with a plate held by a fixed joint and 3 fixed loop joints, {span:g} s",
        18,
        "energy, relative",
        float(np.abs(energy.balance_error).max() / energy.kinetic.max()),
        1e-6,
        "1e-9 a step over some hundred steps",
        "counted: rows too many",
    )

    yield _in_other_units(span)
    counts = (3, 6, 12) if not effort.is_quick else (3,)
    spreads = []
    for count in counts:
        model = parallel_cranks(count)
        run = _run(model, span)
        cranks = np.array([Result(model, run).joint_coordinates(f"crank {i}")[:, 0] for i in range(count)])
        spreads.append(float(np.ptp(cranks, axis=0).max()))
        freedoms.append(abs(constraint_report(model.route).degrees_of_freedom - 1))
    yield Finding.of(
        f"bar on {', '.join(map(str, counts))} parallel cranks with spatial pins, {span:g} s",
        spreads,
        "cranks out of parallel [rad]",
        1e-8,
        "projected to round-off",
    )

    model = bennett()
    freedoms.append(abs(constraint_report(model.route).degrees_of_freedom - 1))
    for method in controlled_methods(model):
        rtol = tolerance(method, RTOL, 1e-6)
        run = follow(model, span, rtol=rtol, method=method, output_step=span / 60)
        angles = run.coordinates
        exact = np.array([bennett_angles(float(a)) for a in angles[:, 0]])[:, :3]
        wrapped = np.abs(np.angle(np.exp(1j * (angles - exact))))
        yield Finding(
            f"Bennett's linkage, {span:g} s",
            len(angles),
            "angles against its formula [rad]",
            float(wrapped.max()),
            1e-8,
            "projected to round-off; rows depend on each other everywhere, by the geometry alone",
            method,
        )
        energy = Result(model, run).energy
        limit, reason = (
            (1e-6, "1e-9 a step") if is_accurate(method) else (1e-2, "1e-6 a step, some hundred steps, order 2")
        )
        yield Finding(
            f"Bennett's linkage, {span:g} s",
            1,
            "energy, relative",
            float(np.abs(energy.balance_error).max() / energy.kinetic.max()),
            limit,
            reason,
            method,
        )
    yield Finding.of("constraint_report of all of these", freedoms, "degrees of freedom off", 0.0, "each has one")


def _in_other_units(span: float) -> Finding:
    """Write the same mechanisms in other units: rows too many, and those kept, must not depend on them."""
    errors = []
    for pin, copies, braces in ((Revolute("z"), 1, 0), (Revolute("z"), 2, 0), (Spherical(), 1, 3)):
        angles = [
            follow(
                four_bar(pin, copies, braces, units),
                span * units.time,
                rtol=1e-12,
                atol=1e-15,
                method="dop853",
                output_step=span * units.time / 60,
            ).coordinates
            for units in (SI, MILLIMETRES, Units(1e-3, 1e3, 1e-3))
        ]
        errors += [float(np.abs(other - angles[0]).max()) for other in angles[1:]]
    return Finding.of(
        f"four-bars with rows too many, written in mm, t, s and in km, g, ks, {span:g} s",
        errors,
        "angles against m, kg, s [rad]",
        1e-9,
        "rtol 1e-12 a step over some hundred steps",
    )


def _run(model: Model, span: float) -> Trajectory:
    return follow(model, span, rtol=RTOL, method="dop853", output_step=span / 60)


def _worst_opening(model: Model, run: Trajectory) -> float:
    return max(loop_opening(model, t, q) for t, q in zip(run.times.tolist(), run.coordinates, strict=True))


CASES = (StressCase("over-constrained", "over-constrained mechanisms", overconstrained),)
