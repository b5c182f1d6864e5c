"""Cases of rigid contacts: unilateral constraints, impacts and set-valued friction, against closed forms."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from kanefe.checks.verification.case import Case, Check, Reference
from kanefe.checks.verification.contact import GRAVITY, INCLINE_SPEED, UP, moving_incline, run_of
from kanefe.contact import Coulomb, Rigid
from kanefe.contact.shapes import Plane
from kanefe.contact.surface import Surface
from kanefe.frames import rotation_about
from kanefe.joints import Free, Prismatic
from kanefe.result import Result
from kanefe.scene.scene import Frame
from kanefe.system import System

RTOLS = 1e-4, 1e-6, 1e-8, 1e-10


def on_floor(gravity: float = GRAVITY) -> tuple[System, Surface]:
    """Return a scene with a floor, z = 0."""
    scene = System(gravity=(0.0, 0.0, -gravity))
    return scene, scene.add_surface("floor", scene.ground, Plane("z"))


def missed(result: Result, exchanged: float) -> float:
    """Return the largest error of the energy balance, relative to the energy `exchanged` (J)."""
    return float(np.abs(result.energy.balance_error).max()) / exchanged


def pushed(reference: Reference) -> Iterator[Check]:
    """K02: a sliding block that comes to rest."""
    values = reference.values
    scene, floor = on_floor()
    block = scene.add_rigid_body("block", 1.0, 0.01, joint=Free(velocity=(5.0, 0.0, 0.0)))
    scene.add_contact("c", block, floor, normal=Rigid(), friction=Coulomb(0.5))
    result = run_of(scene, 1.5, 1e-10, output_step=0.05)
    yield Check.absolute("rigid: distance [m]", result.position("block")[-1, 0], values["way"], 1e-6)
    yield Check.absolute("rigid: time [s]", result.events["c stick"], [values["time"]], 1e-6)
    yield Check.relative("rigid: work of friction [J]", result.contact("c").work[-1], values["work"], 1e-5)
    yield Check.absolute(
        "rigid: relative error of the energy balance",
        missed(result, values["work"]),
        0.0,
        1e-8,
    )


def belt(reference: Reference) -> Iterator[Check]:
    """K04: stick-slip of a mass on a spring and a moving belt; errors are proportional to rtol."""
    values, errors = reference.values, []
    for rtol in RTOLS:
        scene, top = on_floor(10.0)
        mass = scene.add_rigid_body("mass", 1.0, 0.01, joint=Free(velocity=(0.1, 0.0, 0.0)))
        scene.add_contact(
            "c", mass, top, normal=Rigid(), friction=Coulomb(0.25, static=0.4), surface_velocity=(0.1, 0.0, 0.0)
        )
        scene.add_bushing("spring", scene.ground, mass, stiffness=(100.0, 0.0, 0.0))
        result = run_of(scene, 1.9, rtol, output_step=0.05)
        slip, stick = result.events["c slip"], result.events["c stick"]
        errors.append(abs(float(slip[1] - slip[0]) - values["period"]))
        if rtol == 1e-6:
            yield Check.absolute("rigid: period [s]", np.diff(slip), np.full(2, values["period"]), 1e-6)
            yield Check.absolute("rigid: duration of a slip [s]", stick - slip[:2], np.full(2, values["slip"]), 1e-6)
    worst = max(error / rtol for error, rtol in zip(errors, RTOLS, strict=True))
    yield Check.absolute("rigid: largest error of the period over rtol, 1e-4 to 1e-10 [s]", worst * 1e-6, 0.0, 1e-6)


def bouncing(reference: Reference) -> Iterator[Check]:
    """K08: a bouncing ball that comes to rest after infinitely many impacts."""
    e, fall, count = 0.8, math.sqrt(2.0 / GRAVITY), 30
    landings = fall * (1.0 + 2.0 * np.cumsum(np.append(0.0, e ** np.arange(1, count))))
    for impact in ("newton", "poisson"):
        scene, floor = on_floor()
        ball = scene.add_point("ball", 1.0, joint=Prismatic("z", position=1.0))
        scene.add_contact("c", ball, floor, normal=Rigid(e, impact))
        result = run_of(scene, 4.2, 1e-10, output_step=0.05)
        name = f"rigid, {impact}"
        touches = result.events["c touch"][:count]
        yield Check.absolute(f"{name}: times of the first {count} landings [s]", touches, landings, 1e-9)
        yield Check.absolute(f"{name}: rests at [s]", result.events["c rest"], [reference.values["rest"]], 1e-9)
        yield Check.absolute(f"{name}: relative error of the energy balance", missed(result, GRAVITY), 0.0, 1e-9)


def oscillating_incline(reference: Reference) -> Iterator[Check]:
    """F01a: a block on a slope that oscillates in its plane; the block slips down once a period."""
    scene, top = moving_incline()
    block = scene.add_rigid_body("block", 1.0, 0.01, joint=Free(velocity=(INCLINE_SPEED * UP).tolist()))
    scene.add_contact("c", block, top, normal=Rigid(), friction=Coulomb(0.3))
    result = run_of(scene, 3.0, 1e-6, output_step=0.1)
    found = np.sort(np.concatenate((result.events["c slip"], result.events["c stick"])))
    known = reference.values["res"]
    yield Check.absolute("rigid: slip and stick [s]", found, [time for _, time in known["events"]], 1e-6)
    relative = result.position("block")[-1] - result.position("deck")[-1]
    yield Check.absolute("rigid: slip after 3 s, up positive [m]", relative @ UP, known["slip_end"], 1e-6)
    speed = (result.velocity("block")[-1] - result.velocity("deck")[-1]) @ UP
    yield Check.absolute("rigid: relative velocity after 3 s [m/s]", speed, known["vel_end"], 1e-6)


def ladder(reference: Reference) -> Iterator[Check]:
    """K14: a ladder that slides down a smooth wall and separates from it."""
    length, angle = 2.0, math.radians(20.0)
    start = 0.5 * length * np.array((math.sin(angle), 0.0, math.cos(angle)))
    errors = []
    for rtol in (1e-4, 1e-6, 1e-8):
        scene, floor = on_floor()
        wall = scene.add_surface("wall", scene.ground, Plane("x"))
        free = Free(position=start.tolist(), orientation=rotation_about("y", 0.5 * math.pi - angle))
        inertia = length**2 / 12.0
        body = scene.add_rigid_body("ladder", 1.0, (1e-3, inertia, inertia), joint=free)
        scene.add_contact("top", body.frame(at=(-0.5 * length, 0.0, 0.0)), wall, normal=Rigid())
        scene.add_contact("foot", body.frame(at=(0.5 * length, 0.0, 0.0)), floor, normal=Rigid())
        result = run_of(scene, 0.8, rtol, output_times=(0.0, 0.8))
        (time,) = result.events["top lift"]
        errors.append(abs(float(time) - reference.values["time"]))
        if rtol == 1e-6:
            at = scene.simulate((0.0, float(time)), rtol=1e-9, output_times=(0.0, float(time)))
            height = 2.0 * at.position("ladder")[-1, 2] / (length * math.cos(angle))
            yield Check.absolute("height of its top over that of the start", height, reference.values["height"], 1e-6)
            yield Check.absolute("time at which it leaves the wall [s]", time, reference.values["time"], 1e-6)
    worst = max(error / rtol for error, rtol in zip(errors, (1e-4, 1e-6, 1e-8), strict=True))
    yield Check.absolute("largest error of that time over rtol, 1e-4 to 1e-8 [s]", worst * 1e-6, 0.0, 1e-6)


BLOCK = 0.5, 2.0
"""Width and height of the block of K13, m."""


def rocking_block(share: float, friction: float = 5.0, size: tuple[float, float] = BLOCK) -> System:
    """Return a block released at a share of its tipping angle; its contact is called "c"."""
    width, height = size
    scene, floor = on_floor()
    lean = share * math.atan(width / height)
    inertia = (width**2 + height**2) / 12.0
    c, s = math.cos(lean), math.sin(lean)
    middle = 0.5 * np.array((-width * c + height * s, 0.0, width * s + height * c))
    start = Free(position=middle.tolist(), orientation=rotation_about("y", lean))
    block = scene.add_rigid_body("block", 1.0, inertia, joint=start)
    feet: list[Frame] = [block.frame(at=(x, 0.0, -0.5 * height)) for x in (-0.5 * width, 0.5 * width)]
    scene.add_contact("c", feet, floor, normal=Rigid(), friction=Coulomb(friction))
    return scene


def rocking(reference: Reference) -> Iterator[Check]:
    """K13: a block that rocks on its edges and loses speed at each impact."""
    values = reference.values
    for share, period in values["periods"].items():
        result = run_of(rocking_block(float(share)), 0.7, 1e-10, output_step=0.01)
        (first, *_) = result.events["c touch"]
        yield Check.absolute(f"period from {share} alpha [s]", 4.0 * first, period, 1e-6)
        energy = result.energy.kinetic + result.energy.gravity
        lowest = 0.5 * GRAVITY * BLOCK[1]
        before, after = energy[0] - lowest, energy[-1] - lowest
        yield Check.absolute(
            f"share of speed left by the impact, from {share} alpha", math.sqrt(after / before), values["ratio"], 1e-6
        )
        missing = missed(result, float(before - after))
        yield Check.absolute("relative error of the energy balance", missing, 0.0, 1e-8)


def paradox(reference: Reference) -> Iterator[Check]:
    """K15: a rod pushed along a rough floor with its lower end ahead: Painleve's paradox."""
    for degrees, limit in reference.values.items():
        angle = math.radians(float(degrees))
        stopped = []
        for mu in (limit * (1.0 - 1e-6), limit * (1.0 + 1e-6)):
            scene, floor = on_floor()
            place = (0.5 * math.cos(angle), 0.0, 0.5 * math.sin(angle))
            start = Free(position=place, orientation=rotation_about("y", -angle), velocity=(-1.0, 0.0, 0.0))
            rod = scene.add_rigid_body("rod", 1.0, (1e-3, 1.0 / 12.0, 1.0 / 12.0), joint=start)
            scene.add_contact("c", rod.frame(at=(-0.5, 0.0, 0.0)), floor, normal=Rigid(), friction=Coulomb(mu))
            model = scene.freeze()
            y = model.route.start(0.0)
            moved = model.kinematics("rod", 0.0, y)
            stopped.append(1.0 - np.linalg.norm(moved.velocity + np.cross(moved.angular_velocity, (-0.5, 0.0, 0.0))))
        what = (
            f"share of the speed of its end that is lost at once, at {degrees} degrees 1e-6 below and above the limit"
        )
        yield Check.absolute(what, stopped, [0.0, 1.0], 1e-12)


CASES = (
    Case("K02", pushed),
    Case("K04", belt),
    Case("K08", bouncing),
    Case("F01a", oscillating_incline),
    Case("K13", rocking),
    Case("K14", ladder),
    Case("K15", paradox),
)
