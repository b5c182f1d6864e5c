"""One model in mm, t, s and in m, kg, s: the same to round-off."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from kanefe.bodies.flexible import FlexibleBody
from kanefe.checks.robustness.case import Effort, Finding, StressCase
from kanefe.checks.robustness.runs import follow
from kanefe.checks.robustness.units import MILLIMETRES, SI, Units
from kanefe.errors import UnitWarning
from kanefe.joints import Revolute
from kanefe.reduction import CraigBampton
from kanefe.result import Result
from kanefe.system import System
from kanefe_fem.beams.body import beam_body, straight_beam
from kanefe_fem.beams.sections import Rectangle
from kanefe_fem.materials.isotropic import Material
from kanefe_fem.mesh.simple import box_mesh
from kanefe_fem.solids.body import solid_body

SPAN = 0.2

LIMIT = 1e-9
"""Goal: largest relative difference between unit systems."""

SLENDER_LIMIT = 5e-9
"""Limit of the frequencies of an arm whose largest squared frequency is 8e8 times the first: rounding entries of K by
1e-16 changes the first frequency by 7e-10 (Rayleigh quotient of random roundings, and eigenvalues of both matrices with
residuals in long double); seven times this is allowed."""


def _material(units: Units) -> Material:
    return Material(E=70e9 * units.pressure, nu=0.33, rho=2700.0 * units.density)


def solid_arm(units: Units, thickness: float = 0.2) -> FlexibleBody:
    """Return an arm of hexahedra of 1 m, twice as wide as thick (m)."""
    start = (0.0, -thickness, -0.5 * thickness)
    mesh = box_mesh((1.0, 2.0 * thickness, thickness), (6, 2, 1), "hexahedron", start=start)
    scaled = replace(mesh, nodes=mesh.nodes * units.length)
    interfaces = {"root": "clamped", "tip": "rigid"}
    return solid_body(
        scaled, _material(units), interfaces, reduction=CraigBampton(modes=4), stiffening="full", cache=False
    )


def beam_arm(units: Units) -> FlexibleBody:
    """Return an arm of beams."""
    section = Rectangle(0.04 * units.length, 0.02 * units.length)
    model = straight_beam(units.length, section, _material(units), elements=10)
    interfaces = {"root": "clamped", "tip": "rigid"}
    return beam_body(model, interfaces, reduction=CraigBampton(modes=4), stiffening="full")


def _swing(arm: FlexibleBody, units: Units, span: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return tip places (m), root forces (N, N m) and energies (J) of the arm with a mass on its tip."""
    scene = System(gravity=(0.0, 0.0, -9.81 * units.acceleration))
    hub = scene.add_rigid_body("hub", 4.0 * units.mass, 0.02 * units.inertia, joint=Revolute("z"))
    member = scene.add_flexible_body("arm", arm, parent=hub, at=(0.1 * units.length, 0.0, 0.0))
    scene.add_rigid_body("tip", 0.5 * units.mass, 2e-4 * units.inertia, parent=member.interface("tip"))
    scene.add_motor(hub, 20.0 * units.moment)
    model = scene.freeze()
    run = follow(model, span, rtol=1e-11, atol=1e-16, method="dop853", output_step=span / 10)
    result = Result(model, run)
    force = np.repeat((units.force, units.moment), 3)
    return (
        result.position("arm", "tip") / units.length,
        result.coupling_force("arm", "root") / force,
        result.energy.total / units.moment,
    )


def two_systems(effort: Effort) -> Iterator[Finding]:
    """Build, and swing, the same arm in millimetres and in metres."""
    arms: dict[str, tuple[Callable[[Units], FlexibleBody], float, float]] = {
        "hexahedra, 5 times as long as thick": (solid_arm, LIMIT, 0.2 * SPAN),
        # the first bending mode has a share of K's largest eigenvalue that falls with the fourth power of this
        "hexahedra, 50 times as long as thick": (partial(solid_arm, thickness=0.02), SLENDER_LIMIT, SPAN),
        "beams, 50 times as long as thick": (beam_arm, LIMIT, SPAN),
    }
    for name, (make, limit, span) in arms.items():
        reason = (
            "the goal" if limit == LIMIT else "known limit: round-off of K's entries, 1e-16, times w^2 max/min of 8e8"
        )
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UnitWarning)  # they look wrong, and are meant
            metres, millimetres = make(SI), make(MILLIMETRES)
        what = f"arm of {name} with stiffening, in mm, t, s and in m, kg, s"
        errors = {
            "frequencies": np.abs(millimetres.frequencies / metres.frequencies - 1.0).max(),
            "mass": abs(millimetres.mass / MILLIMETRES.mass / metres.mass - 1.0),
            "inertia": np.abs(millimetres.inertia / MILLIMETRES.inertia - metres.inertia).max() / metres.inertia.max(),
        }
        yield Finding.of(f"{what}: {', '.join(errors)}", list(errors.values()), "relative", limit, reason)
        values = _swing(metres, SI, span), _swing(millimetres, MILLIMETRES, span)
        turned = max(1.0, 2.0 * np.pi * metres.frequencies[0] * span)
        if limit != LIMIT:
            limit, reason = turned * limit, f"{reason}, and times the first mode's phase of {turned:.0f} rad"
        figures = [float(np.abs(a - b).max() / np.abs(a).max()) for a, b in zip(*values, strict=True)]
        yield Finding.of(
            f"{what}: tip, root force and energy of a swing of {span:g} s",
            figures,
            "relative",
            limit,
            f"{reason}; rtol 1e-11 a step",
        )


CASES = (StressCase("unit-systems", "mm, t, s and m, kg, s of one model", two_systems),)
