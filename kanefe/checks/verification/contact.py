"""Cases of friction in contacts: sticking, sliding, rolling and spinning.

The contacts are compliant, with deflections proportional to 1 / stiffness. Where the closed form holds for rigid
contacts, results must be close to it, and the difference must decrease as the stiffness increases.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from kanefe.checks.verification.case import Case, Check, Reference
from kanefe.checks.verification.scenes import whole_run
from kanefe.contact import Coulomb, HuntCrossley, LuGre
from kanefe.contact.shapes import Plane, Sphere, Torus
from kanefe.contact.surface import Surface
from kanefe.frames import rotation_about, rotation_matrix
from kanefe.joints import Free, Motion, Prismatic, Revolute, Translation
from kanefe.result import Result
from kanefe.system import System

GRAVITY = 9.81
STIFFNESS = 1e6, 1e7
"""Contact stiffnesses of the runs that are compared with closed forms of rigid contacts, N/m."""

DAMPING = 0.3
"""Damping lambda of Hunt and Crossley's law, s/m: it damps the initial bouncing; steady motions do not depend on it."""

RTOL = 1e-9


def run_of(scene: System, span: float, rtol: float = RTOL, **options: Any) -> Result:
    """Return the result of a run from t = 0, with the method that kanefe selects."""
    model = scene.freeze()
    return Result(model, whole_run(model, (0.0, span), rtol, **options))


def falling_with_stiffness(quantity: str, errors: Sequence[float], order: float, tolerance: float) -> Check:
    """Check that an error is proportional to a power of 1 / stiffness, from errors at stiffnesses with the ratio 10."""
    found = math.log10(abs(errors[0]) / abs(errors[1]))
    return Check.absolute(f"power of 1 / stiffness by which the error of {quantity} falls", found, order, tolerance)


def shaken(reference: Reference) -> Iterator[Check]:
    """K01, K01b: a block on a shaken slope, on which it must not slip."""
    values = reference.values
    for rtol in (1e-3, 1e-8):
        result = run_of(shaken_slope(values["mu"]), 21.0, rtol, output_step=0.05)
        history = result.contact("block on slope")
        yield Check.absolute(f"slip in 20 s of shaking, rtol {rtol:g} [m]", history.slip[-1], values["slip"], 1e-12)
    load = float((history.tangential / history.normal)[result.times > 1.0].max())
    yield Check.absolute("largest T / N", load, values["T over N"], 1e-4)


def shaken_slope(mu: float) -> System:
    """Return a block on a table that is tilted within 1 s, and shaken in its plane from the start."""
    angle, shake, omega = math.radians(5.0), 0.02 * GRAVITY, 2.0 * math.pi

    def tilt(order: int) -> Callable[[float], float]:
        rise = np.polynomial.Polynomial((0.0, 0.0, 0.0, 10.0, -15.0, 6.0)).deriv(order)
        return lambda t: angle * (float(rise(t)) if t < 1.0 else float(order == 0))

    scene = System(gravity=(0.0, 0.0, -GRAVITY))
    table = scene.add_rigid_body("table", 1.0, 1.0, joint=Revolute("y", motion=Motion(tilt(0), tilt(1), tilt(2))))
    shaking = Motion(
        lambda t: -shake / omega**2 * math.sin(omega * t),
        lambda t: -shake / omega * math.cos(omega * t),
        lambda t: shake * math.sin(omega * t),
    )
    slope = scene.add_rigid_body("slope", 1.0, 1.0, parent=table, joint=Prismatic("x", motion=shaking))
    top = scene.add_surface("top", slope, Plane("z"))
    start = Free(position=(0.0, 0.0, -GRAVITY / STIFFNESS[0]), velocity=(-shake / omega, 0.0, 0.0))
    block = scene.add_rigid_body("block", 1.0, 0.01, joint=start)
    law = HuntCrossley(STIFFNESS[0], DAMPING)
    scene.add_contact("block on slope", block, top, normal=law, friction=Coulomb(mu))
    return scene


def pushed(reference: Reference) -> Iterator[Check]:
    """K02: a sliding block that comes to rest."""
    values, errors = reference.values, []
    for stiffness in STIFFNESS:
        result = run_of(pushed_block(stiffness), 1.5, 1e-10)
        errors.append(float(result.position("block")[-1, 0]) - values["way"])
    yield Check.absolute("distance [m]", errors[1] + values["way"], values["way"], 1e-6)
    yield Check.absolute("time [s]", result.events["c stick"], [values["time"]], 1e-6)
    yield falling_with_stiffness("the distance", errors, 1.0, 0.05)
    yield Check.relative("work of friction [J]", result.contact("c").work[-1], values["work"], 1e-5)


def pushed_block(stiffness: float) -> System:
    """Return the block of K02."""
    scene = System(gravity=(0.0, 0.0, -GRAVITY))
    floor = scene.add_surface("floor", scene.ground, Plane("z"))
    start = Free(position=(0.0, 0.0, -GRAVITY / stiffness), velocity=(5.0, 0.0, 0.0))
    block = scene.add_rigid_body("block", 1.0, 0.01, joint=start)
    scene.add_contact("c", block, floor, normal=HuntCrossley(stiffness, DAMPING), friction=Coulomb(0.5))
    return scene


def belt(reference: Reference) -> Iterator[Check]:
    """K04: stick-slip of a mass on a spring and a moving belt."""
    values, errors = reference.values, []
    for stiffness in STIFFNESS:
        scene = System(gravity=(0.0, 0.0, -10.0))
        top = scene.add_surface("top", scene.ground, Plane("z"))
        start = Free(position=(0.0, 0.0, -10.0 / stiffness), velocity=(0.1, 0.0, 0.0))
        mass = scene.add_rigid_body("mass", 1.0, 0.01, joint=start)
        friction = Coulomb(0.25, static=0.4)
        scene.add_contact(
            "c", mass, top, normal=HuntCrossley(stiffness, DAMPING), friction=friction, surface_velocity=(0.1, 0.0, 0.0)
        )
        scene.add_bushing("spring", scene.ground, mass, stiffness=(100.0, 0.0, 0.0))
        result = run_of(scene, 2.6, 1e-10, output_step=1e-3)
        slip, stick = result.events["c slip"][1:], result.events["c stick"][1:]  # after the first cycle
        count = min(len(slip), len(stick))
        errors.append(float(np.diff(slip).mean()) - values["period"])
    yield Check.absolute("period [s]", np.diff(slip), np.full(len(slip) - 1, values["period"]), 1e-5)
    slipping = stick[:count] - slip[:count]
    yield Check.absolute("duration of a slip [s]", slipping, np.full(count, values["slip"]), 2e-5)
    x = result.position("mass")[result.times > 1.5, 0]
    yield Check.absolute("amplitude [m]", 0.5 * (x.max() - x.min()), values["amplitude"], 1e-6)
    yield falling_with_stiffness("the period", errors, 1.0, 0.05)


def bristles(reference: Reference) -> Iterator[Check]:
    """K19: a mass pulled by a spring against bristle friction, with a normal force of 1 N."""
    values, stiffness = reference.values, STIFFNESS[0]
    scene = System(gravity=(0.0, 0.0, -1.0))
    floor = scene.add_surface("floor", scene.ground, Plane("z"))
    mass = scene.add_point("mass", 1.0, joint=Translation(position=(0.0, 0.0, -1.0 / stiffness)))
    pulled = Prismatic("x", motion=Motion(lambda t: 0.1 * t, lambda t: 0.1, lambda t: 0.0))
    hand = scene.add_rigid_body("hand", 1.0, 1.0, joint=pulled)
    scene.add_bushing("spring", hand, mass, stiffness=(2.0, 0.0, 0.0))
    friction = LuGre(1e5, math.sqrt(1e5), 0.4, coulomb=1.0, static=1.5, stribeck_speed=1e-3)
    scene.add_contact("c", mass, floor, normal=HuntCrossley(stiffness, DAMPING), friction=friction)
    # by one method: where auto tries another on the way, what that adds is of the size of the tolerance
    run = whole_run(scene.freeze(), (0.0, 25.0), 1e-10, output_step=1.0, method="radau5")
    x, v, z = run.coordinates[-1][0], run.speeds[-1][0], run.internal[-1][2]
    yield Check.absolute("position after 25 s [m]", x, values["x"], 1e-9)
    yield Check.absolute("speed [m/s]", v, values["v"], 1e-11)
    yield Check.absolute("deflection of the bristles [m]", z, values["z"], 1e-11)


def begins_to_roll(reference: Reference) -> Iterator[Check]:
    """K05: a sliding ball that begins to roll."""
    values, radius, stiffness = reference.values, 0.1, STIFFNESS[1]
    scene = System(gravity=(0.0, 0.0, -GRAVITY))
    floor = scene.add_surface("floor", scene.ground, Plane("z"))
    start = Free(position=(0.0, 0.0, radius - GRAVITY / stiffness), velocity=(2.0, 0.0, 0.0))
    ball = scene.add_rigid_body("ball", 1.0, 0.4 * radius**2, joint=start)
    skin = scene.add_surface("skin", ball, Sphere(radius))
    scene.add_contact("c", skin, floor, normal=HuntCrossley(stiffness, DAMPING), friction=Coulomb(0.2))
    result = run_of(scene, 0.5)
    (time,) = result.events["c stick"]
    way = float(result.position("ball")[-1, 0]) - values["speed"] * (0.5 - values["time"])
    yield Check.absolute("time at which it rolls [s]", time, values["time"], 1e-6)
    yield Check.absolute("distance until then [m]", way, values["way"], 1e-6)
    yield Check.absolute("speed after that [m/s]", result.velocity("ball")[-1, 0], values["speed"], 1e-6)


def tippe_top(reference: Reference) -> Iterator[Check]:
    """K16: a spinning ball with an eccentric centre of mass conserves Jellett's integral, for any friction."""
    radius, mass = 0.02, 0.02
    offset, stiffness = 0.3 * radius, 1e4
    across, along = 131.0 / 350.0 * mass * radius**2, 0.4 * mass * radius**2
    scene = System(gravity=(0.0, 0.0, -GRAVITY))
    floor = scene.add_surface("floor", scene.ground, Plane("z"))
    start = Free(
        position=(0.0, 0.0, radius - mass * GRAVITY / stiffness),
        orientation=rotation_about("y", 0.1),
        angular_velocity=(0.0, 0.0, 155.0),
    )
    top = scene.add_rigid_body("top", mass, (across, across, along), com=(0.0, 0.0, -offset), joint=start)
    skin = scene.add_surface("skin", top, Sphere(radius))
    scene.add_contact("c", skin, floor, normal=HuntCrossley(stiffness, DAMPING), friction=Coulomb(0.3))
    result = run_of(scene, 0.3, 1e-10, output_step=0.01)
    found, slid = [], result.contact("c").slip[-1]
    for e, omega in zip(result.rotation("top"), result.angular_velocity("top"), strict=True):
        A = rotation_matrix(e)
        momentum = A @ (np.array((across, across, along)) * omega)
        found.append(momentum @ (offset * A[:, 2] - radius * np.array((0.0, 0.0, 1.0))))
    change = np.array(found) / found[0] - 1.0
    yield Check.absolute("relative change of L . a", change, np.full(len(found), reference.values["change"]), 1e-8)
    yield Check.absolute("1 if it slips by less than 1 mm", float(slid < 1e-3), 0.0, 1e-12)


def coin(reference: Reference) -> Iterator[Check]:
    """K21: a disc that rolls in a circle while its centre stays at rest."""
    radius, tilt, stiffness = 0.1, 0.5, STIFFNESS[0]
    rate = reference.values["rate"]
    scene = System(gravity=(0.0, 0.0, -GRAVITY))
    floor = scene.add_surface("floor", scene.ground, Plane("z"))
    start = Free(
        position=(0.0, 0.0, radius * math.sin(tilt) - GRAVITY / stiffness),
        orientation=rotation_about("y", tilt),
        angular_velocity=(-rate * math.sin(tilt), 0.0, 0.0),
    )
    inertia = 0.25 * radius**2
    disc = scene.add_rigid_body("disc", 1.0, (inertia, inertia, 2.0 * inertia), joint=start)
    edge = scene.add_surface("edge", disc, Torus(radius, 0.0, axis="z"))
    scene.add_contact("c", edge, floor, normal=HuntCrossley(stiffness, DAMPING), friction=Coulomb(0.5))
    result = run_of(scene, 0.5, output_step=0.005)
    axes = np.array([rotation_matrix(e)[:, 2] for e in result.rotation("disc")])
    turned = np.unwrap(np.arctan2(axes[:, 1], axes[:, 0]))
    yield Check.relative("rate of precession [rad/s]", (turned[-1] - turned[0]) / 0.5, rate, 1e-8)
    place = result.position("disc")
    yield Check.absolute("displacement of its centre [m]", np.abs(place - place[0]).max(), 0.0, 1e-9)
    yield Check.absolute("slip [m]", result.contact("c").slip[-1], 0.0, 1e-12)


INCLINE = math.radians(10.0)
UP = np.array((math.cos(INCLINE), 0.0, math.sin(INCLINE)))
NORMAL = np.array((-math.sin(INCLINE), 0.0, math.cos(INCLINE)))
INCLINE_SPEED = 0.1 * 2.0 * math.pi  # m/s, the largest, reached at the start


def oscillating_incline(reference: Reference) -> Iterator[Check]:
    """F01a: a block on a slope that oscillates in its plane; the block slips down once a period."""
    values, errors = reference.values["res"], []
    times = np.array([time for _, time in values["events"]])
    for stiffness in STIFFNESS:
        result = run_of(block_on_incline(stiffness), 3.0, 1e-9)
        slip, stick = (result.events[f"c {what}"] for what in ("slip", "stick"))
        found = np.sort(np.concatenate((slip[slip > 0.1], stick[stick > 0.1])))
        errors.append(float(np.abs(found - times).max()) if len(found) == len(times) else math.nan)
    yield Check.absolute("times of slip and stick [s]", errors[1], 0.0, 1e-4)
    yield falling_with_stiffness("the times", errors, 1.0, 0.05)
    relative = result.position("block")[-1] - result.position("deck")[-1]
    yield Check.absolute("slip after 3 s, up positive [m]", relative @ UP, values["slip_end"], 1e-4)
    speed = (result.velocity("block")[-1] - result.velocity("deck")[-1]) @ UP
    yield Check.absolute("relative velocity after 3 s [m/s]", speed, values["vel_end"], 1e-4)


def moving_incline() -> tuple[System, Surface]:
    """Return the slope of F01a, which oscillates in its plane, and its surface."""
    amplitude, omega = 0.1, 2.0 * math.pi
    moving = Motion(
        lambda t: amplitude * math.sin(omega * t),
        lambda t: amplitude * omega * math.cos(omega * t),
        lambda t: -amplitude * omega**2 * math.sin(omega * t),
    )
    scene = System(gravity=(0.0, 0.0, -GRAVITY))
    deck = scene.add_rigid_body("deck", 1.0, 1.0, joint=Prismatic(UP.tolist(), motion=moving))
    return scene, scene.add_surface("top", deck, Plane(NORMAL))


def block_on_incline(stiffness: float) -> System:
    """Return the block of F01a."""
    scene, top = moving_incline()
    pressed = GRAVITY * math.cos(INCLINE) / stiffness
    start = Free(position=(-pressed * NORMAL).tolist(), velocity=(INCLINE_SPEED * UP).tolist())
    block = scene.add_rigid_body("block", 1.0, 0.01, joint=start)
    friction = Coulomb(0.3, damping=2.0 * math.sqrt(stiffness))  # critical damping: no oscillation while it sticks
    scene.add_contact("c", block, top, normal=HuntCrossley(stiffness, DAMPING), friction=friction)
    return scene


CASES = (
    Case("K01", shaken),
    Case("K01b", shaken),
    Case("K02", pushed),
    Case("K04", belt),
    Case("K05", begins_to_roll),
    Case("K16", tippe_top),
    Case("K19", bristles),
    Case("K21", coin),
    Case("F01a", oscillating_incline),
)
