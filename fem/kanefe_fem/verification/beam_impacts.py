"""Impacts of beams: a mass that falls on a beam, and a bar whose end hits a wall."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator

import numpy as np

from kanefe.checks.verification import Case, Check, Reference
from kanefe.checks.verification.contact import GRAVITY, run_of
from kanefe.contact import HuntCrossley
from kanefe.contact.shapes import Plane
from kanefe.errors import UnitWarning
from kanefe.fe_model.damping import ModalDamping
from kanefe.fe_model.interface import Interface
from kanefe.joints import Prismatic
from kanefe.reduction import CraigBampton
from kanefe.system import System
from kanefe_fem.beams.body import beam_body, straight_beam
from kanefe_fem.beams.sections import Rectangle, Section
from kanefe_fem.materials.isotropic import Material

STIFFNESS = 1e9
"""Stiffness of the contacts, N/m: a thousand times the stiffness of the beam, and fifty times that of the bar."""

YOUNG, DENSITY = 210e9, 7850.0
AREA, BAR_MODES, BAR_ELEMENTS = 1e-4, 40, 60
STIFF_IN_BENDING = 1e6
"""Factor on the bending stiffness, so that the lowest modes of the bar are axial."""

NEAR = 1e-6
"""Initial gap, m."""


def mass_on_beam(reference: Reference) -> Iterator[Check]:
    """F02a: a mass falls on the middle of a simply supported beam with a thousandth of its mass."""
    values, elements = reference.values, 20
    side = (12.0 * values["EI"] / YOUNG) ** 0.25
    light = Material(E=YOUNG, nu=0.3, rho=1e-3 * values["m"] / (side**2 * values["L"]))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UnitWarning)  # the density is far below that of steel
        model = straight_beam(values["L"], Rectangle(side, side), light, elements=elements, planar=True)
    supports = {"root": Interface(fixed=("x", "y")), "tip": Interface(fixed=("y",))}
    # damped, so that it stays in contact with the mass
    body = beam_body(model, supports, reduction=CraigBampton(modes=9), damping=ModalDamping(0.05))
    scene = System(gravity=(0.0, -GRAVITY, 0.0))
    beam = scene.add_flexible_body("beam", body)
    mass = scene.add_point("mass", values["m"], joint=Prismatic("y", position=values["h"]))
    below = scene.add_surface("below", mass, Plane("-y"), at=(0.5 * values["L"], 0.0, 0.0))
    scene.add_contact("c", beam.node(elements // 2), below, normal=HuntCrossley(STIFFNESS, 1.0))
    result = run_of(scene, 0.115, 1e-7, output_step=2e-5)
    events = result.events
    lasts = events["c lift"][-1] - events["c touch"][0]
    yield Check.relative("largest deflection [m]", -result.position("mass")[:, 1].min(), values["delta_max"], 5e-3)
    yield Check.relative("largest force [N]", result.contact("c").normal.max(), values["F_max"], 5e-3)
    yield Check.relative("duration [s]", lasts, values["contact_duration"], 5e-3)
    speed = -float(np.interp(events["c touch"][0], result.times, result.velocity("mass")[:, 1]))
    yield Check.relative("speed at the impact [m/s]", speed, values["v_impact"], 5e-3)


def bar_on_wall(reference: Reference) -> Iterator[Check]:
    """K10: the end of a bar hits a rigid wall, until the wave returns from the other end."""
    values, wave = reference.values, math.sqrt(YOUNG / DENSITY)
    section = Section.from_stiffness(
        EA=YOUNG * AREA, EI_z=STIFF_IN_BENDING * YOUNG * AREA**2 / 12.0, rho_A=DENSITY * AREA
    )
    model = straight_beam(1.0, section, elements=BAR_ELEMENTS, planar=True)
    body = beam_body(model, {"root": "clamped"}, reduction=CraigBampton(modes=BAR_MODES))
    scene = System()
    bar = scene.add_flexible_body("bar", body, joint=Prismatic("x", position=-1.0 - NEAR, speed=1.0))
    wall = scene.add_surface("wall", scene.ground, Plane("-x"))
    scene.add_contact("c", bar.node(BAR_ELEMENTS), wall, normal=HuntCrossley(STIFFNESS))
    result = run_of(scene, 4.5e-4, 1e-7, output_step=2.5e-7)
    normal, t = result.contact("c").normal, result.times
    touch, lift = result.events["c touch"][0], result.events["c lift"][-1]
    share = (t - touch) * wave / 2.0
    held = normal[(share > 0.2) & (share < 0.8)]
    scatter = f"which oscillates by {100.0 * held.std() / values['force']:.0f} % (standard deviation)"
    impulse = float(np.sum(0.5 * (normal[1:] + normal[:-1]) * np.diff(t)))
    yield Check.relative("impulse [N s]", impulse, values["impulse"], 2e-2)
    yield Check.relative("duration [s]", lift - touch, values["duration"], 2e-2)
    yield Check.relative(f"mean force while the wave runs [N], {scatter}", held.mean(), values["force"], 2e-2)


CASES = (Case("F02a", mass_on_beam), Case("K10", bar_on_wall))
