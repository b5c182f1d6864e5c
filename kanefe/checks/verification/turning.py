"""Cases of rolling and spinning friction: a ball that spins to rest, one that rolls to rest, one held on a slope."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from kanefe.checks.verification.case import Case, Check, Reference
from kanefe.checks.verification.contact import DAMPING, GRAVITY, STIFFNESS, falling_with_stiffness, run_of
from kanefe.contact import Coulomb, HuntCrossley
from kanefe.contact.shapes import Plane, Sphere
from kanefe.joints import Free
from kanefe.result import Result
from kanefe.system import System

RADIUS = 0.1


def ball_on(angle: float, friction: Coulomb, stiffness: float = STIFFNESS[1], **start: Any) -> System:
    """Return a solid ball of 1 kg on a slope that descends along x, in axes of the slope."""
    into = GRAVITY * math.cos(angle)
    scene = System(gravity=(GRAVITY * math.sin(angle), 0.0, -into))
    slope = scene.add_surface("slope", scene.ground, Plane("z"))
    joint = Free(position=(0.0, 0.0, RADIUS - into / stiffness), **start)
    ball = scene.add_rigid_body("ball", 1.0, 0.4 * RADIUS**2, joint=joint)
    skin = scene.add_surface("skin", ball, Sphere(RADIUS))
    scene.add_contact("c", skin, slope, normal=HuntCrossley(stiffness, DAMPING), friction=friction)
    return scene


def rolls_to_rest(reference: Reference) -> Iterator[Check]:
    """K05b: a ball that rolls against a resisting moment of an arm times the normal force."""
    values, errors = reference.values, []
    for stiffness in STIFFNESS:
        start = {"velocity": (1.0, 0.0, 0.0), "angular_velocity": (0.0, 1.0 / RADIUS, 0.0)}
        result = run_of(ball_on(0.0, Coulomb(0.4, rolling=0.01), stiffness, **start), 2.0, output_step=0.01)
        errors.append(float(result.position("ball")[-1, 0]) - values["way"])
    late = result.times < 0.99 * values["time"]
    slowing = np.polyfit(result.times[late], result.velocity("ball")[late, 0], 1)[0]
    yield Check.absolute("distance until rest [m]", errors[1] + values["way"], values["way"], 1e-6)
    yield Check.relative("deceleration [m/s2]", -slowing, values["deceleration"], 1e-5)
    yield Check.absolute("work of friction [J]", result.contact("c").work[-1], values["work"], 1e-5)
    yield falling_with_stiffness("the distance", errors, 1.0, 0.05)


def spins_to_rest(reference: Reference) -> Iterator[Check]:
    """K05c: a ball that spins about the normal against the friction of a small contact patch."""
    values, errors = reference.values, []
    for stiffness in STIFFNESS:
        friction = Coulomb(0.3, torsional=0.01, damping=2.0 * math.sqrt(stiffness))
        scene = ball_on(0.0, friction, stiffness, angular_velocity=(0.0, 0.0, 20.0))
        result = run_of(scene, 3.5, output_step=0.01)
        errors.append(_turned(result) - values["angle"])
    late = result.times < 0.99 * values["time"]
    slowing = np.polyfit(result.times[late], result.angular_velocity("ball")[late, 2], 1)[0]
    yield Check.relative("time at which it stops [s]", -20.0 / slowing, values["time"], 1e-6)
    yield Check.absolute("angle until then [rad]", errors[1] + values["angle"], values["angle"], 2e-4)
    yield falling_with_stiffness("the angle", errors, 1.0, 0.05)


def _turned(result: Result) -> float:
    e = result.rotation("ball")
    return 2.0 * float(np.unwrap(np.arctan2(e[:, 3], e[:, 0]), period=np.pi)[-1])


def held_on_a_slope(reference: Reference) -> Iterator[Check]:
    """K05d: a ball held on a slope by rolling resistance, and one on a slope that is too steep for that."""
    values, friction = reference.values, Coulomb(0.4, rolling=0.01)
    result = run_of(ball_on(math.atan(values["held at"]), friction), 300.0, output_step=1.0)
    place = result.position("ball")[result.times >= 100.0, 0]
    yield Check.absolute("distance from 100 s to 300 s, tan(angle) = 0.08 [m]", np.ptp(place), 0.0, 1e-12)
    result = run_of(ball_on(math.atan(values["rolls at"]), friction), 2.0, output_step=0.01)
    late = result.times > 1.0
    found = np.polyfit(result.times[late], result.velocity("ball")[late, 0], 1)[0]
    yield Check.relative("acceleration, tan(angle) = 0.12 [m/s2]", found, values["acceleration"], 1e-5)


CASES = (
    Case("K05b", rolls_to_rest),
    Case("K05c", spins_to_rest),
    Case("K05d", held_on_a_slope),
)
