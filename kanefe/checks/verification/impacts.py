"""Cases of impacts: restitution, duration and force of compliant contacts, a bouncing ball, a slack rope."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from kanefe.checks.verification.case import Case, Check, Reference
from kanefe.checks.verification.contact import GRAVITY, falling_with_stiffness, run_of
from kanefe.contact import Hertz, HuntCrossley, KelvinVoigt, Restitution
from kanefe.contact.shapes import Plane, Sphere
from kanefe.joints import Prismatic
from kanefe.kernels.contact.laws.normal_law import NormalLaw
from kanefe.loads import Rope
from kanefe.result import Result
from kanefe.system import System

STIFFNESS = 1e4


def restitution_of(law: NormalLaw) -> float:
    """Return the ratio of speeds after and before an impact of a mass of 1 kg at 1 m/s."""
    scene = System()
    wall = scene.add_surface("wall", scene.ground, Plane("z"))
    mass = scene.add_point("mass", 1.0, joint=Prismatic("z", position=1e-3, speed=-1.0))
    scene.add_contact("c", mass, wall, normal=law)
    return float(run_of(scene, 0.2, 1e-11).velocity("mass")[-1, 2])


def hunt_crossley(reference: Reference) -> Iterator[Check]:
    """K06: restitution of Hunt and Crossley's law, which depends on lambda times speed only."""
    for number, expected in reference.values.items():
        for stiffness, exponent in ((STIFFNESS, 1.0), (100.0 * STIFFNESS, 1.5), (1e3 * STIFFNESS, 2.2)):
            found = restitution_of(HuntCrossley(stiffness, float(number), exponent=exponent))
            what = f"restitution, lambda v = {number}, k = {stiffness:g}, n = {exponent:g}"
            yield Check.absolute(what, found, expected, 1e-7)
        found = restitution_of(Restitution(STIFFNESS, expected))
        yield Check.absolute(f"the restitution {expected:.6f} requested", found, expected, 1e-7)


def kelvin_voigt(reference: Reference) -> Iterator[Check]:
    """K07: restitution of a spring and damper that separate before they pull."""
    for ratio, expected in reference.values.items():
        law = KelvinVoigt(STIFFNESS, 2.0 * float(ratio) * math.sqrt(STIFFNESS))
        yield Check.absolute(f"restitution, damping ratio {ratio}", restitution_of(law), expected, 1e-7)


def bouncing(reference: Reference) -> Iterator[Check]:
    """K08: a bouncing ball that comes to rest after infinitely many impacts."""
    values, count = reference.values, 8
    e, fall = 0.8, math.sqrt(2.0 / GRAVITY)
    landings = fall * (1.0 + 2.0 * np.cumsum(np.append(0.0, e ** np.arange(1, count))))
    errors = []
    for stiffness in (1e7, 1e8):
        result = bouncing_ball(stiffness, 4.5, 1e-9)
        touches = result.events["c touch"]
        errors.append(float(np.abs(touches[:count] - landings).max()))
    yield Check.absolute(f"times of the first {count} landings [s]", touches[:count], landings, 5e-3)
    # an impact lasts pi sqrt(m / k), slightly longer with damping
    yield falling_with_stiffness("the times", errors, 0.5, 0.05)
    yield Check.absolute("the last landing [s]", touches[-1], values["rest"], 0.02)
    yield Check.absolute("depth at rest [m]", -result.position("ball")[-1, 2], GRAVITY / stiffness, 1e-9)


def bouncing_ball(stiffness: float, span: float, rtol: float) -> Result:
    """Return the run of K08."""
    scene = System(gravity=(0.0, 0.0, -GRAVITY))
    floor = scene.add_surface("floor", scene.ground, Plane("z"))
    ball = scene.add_point("ball", 1.0, joint=Prismatic("z", position=1.0))
    scene.add_contact("c", ball, floor, normal=Restitution(stiffness, 0.8))
    return run_of(scene, span, rtol)


def hertz(reference: Reference) -> Iterator[Check]:
    """K09: impact of a steel ball on a steel half-space."""
    radius, density, values = 0.01, 7850.0, reference.values
    mass = 4.0 / 3.0 * math.pi * radius**3 * density
    scene = System()
    floor = scene.add_surface("floor", scene.ground, Plane("z"))
    start = Prismatic("z", position=radius + 1e-6, speed=-1.0)
    ball = scene.add_rigid_body("ball", mass, 0.4 * mass * radius**2, joint=start)
    skin = scene.add_surface("skin", ball, Sphere(radius))
    law = Hertz.of_sphere(radius, 210e9, 0.3, 210e9, 0.3)
    scene.add_contact("c", skin, floor, normal=law)
    result = run_of(scene, 8e-5, 1e-10, output_step=1e-7)
    history, events = result.contact("c"), result.events
    yield Check.relative("largest depth [m]", history.penetration.max(), values["depth"], 1e-5)
    yield Check.relative("largest force [N]", history.normal.max(), values["force"], 1e-5)
    yield Check.relative("duration [s]", events["c lift"] - events["c touch"], [values["duration"]], 1e-7)
    yield Check.relative("speed after it [m/s]", result.velocity("ball")[-1, 2], 1.0, 1e-7)


def slack_rope(reference: Reference) -> Iterator[Check]:
    """K22: a falling mass that is caught by a slack rope."""
    mass, length, stiffness, slack = 10.0, 1.0, 1e5, 0.1
    scene = System(gravity=(0.0, 0.0, -GRAVITY))
    load = scene.add_point("load", mass, joint=Prismatic("z", position=slack - length))
    scene.add(Rope("lashing", (scene.ground, load), axial_stiffness=stiffness * length, length=length))
    result = run_of(scene, 0.2, 1e-10, output_step=2e-5)
    yield Check.relative("largest tension [N]", result.load("lashing")[:, 2].max(), reference.values["tension"], 1e-6)


POUND_FORCE, INCH, FEET_GRAVITY = 4.4482216152605, 0.0254, 9.80665
"""Pound-force, N; inch, m; and standard gravity for US units, m/s2."""


def landing_gear(reference: Reference) -> Iterator[Check]:
    """F05: a drop test of landing gear with lift (14 CFR 27.725), with a spring that absorbs the energy."""
    values = reference.values
    spring = values["spring"]
    for row in values["rows"]:
        weight, height, way, lift = (row[name] for name in ("W", "h_in", "d_in", "L"))
        effective = weight * (height + (1.0 - lift) * way) / (height + way)
        yield Check.relative("effective weight [lb]", effective, row["We"], 1e-12)
        yield Check.relative("limit load factor", row["nj"] * effective / weight + lift, row["n"], 1e-12)
    row = values["rows"][0]
    weight, lift = row["W"] * POUND_FORCE, row["L"]
    scene = System(gravity=(0.0, 0.0, -FEET_GRAVITY))
    floor = scene.add_surface("floor", scene.ground, Plane("z"))
    speed = math.sqrt(2.0 * FEET_GRAVITY * row["h_in"] * INCH)
    mass = scene.add_point("mass", weight / FEET_GRAVITY, joint=Prismatic("z", speed=-speed))
    scene.add_force(mass, (0.0, 0.0, lift * weight))
    stiffness = spring["k_lb_per_in"] * POUND_FORCE / INCH
    scene.add_contact("gear", mass, floor, normal=KelvinVoigt(stiffness, 0.0))
    result = run_of(scene, 0.2, 1e-11, output_step=1e-4)
    peak = float(result.contact("gear").normal.max()) / POUND_FORCE
    load_factor = peak / row["We"]
    # with outputs every 1e-4 s and w = 13.7 rad/s the peak is missed by at most (w dt)^2 / 8, relative
    yield Check.relative("largest load [lb]", peak, spring["peak_load"], 1e-6)
    yield Check.relative("load factor of the gear", load_factor, spring["nj"], 1e-6)
    yield Check.relative("load factor", load_factor * row["We"] / row["W"] + lift, spring["n"], 1e-6)
    given = row["W"] * (row["h_in"] + row["d_in"]) - lift * row["W"] * row["d_in"]
    taken = peak**2 / (2.0 * spring["k_lb_per_in"])
    yield Check.relative("energy of the drop [in lb]", taken, given, 1e-6)


CASES = (
    Case("K06", hunt_crossley),
    Case("K07", kelvin_voigt),
    Case("K08", bouncing),
    Case("K09", hertz),
    Case("K22", slack_rope),
    Case("F05", landing_gear),
)
