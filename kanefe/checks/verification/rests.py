"""Cases of equilibria on contacts with friction, which `kanefe.equilibrium` finds from a position above the ground."""

from __future__ import annotations

import math
from collections.abc import Iterator

from kanefe.checks.verification.case import Case, Check, Reference
from kanefe.checks.verification.contact import GRAVITY
from kanefe.contact import Coulomb, HuntCrossley, Rigid, shapes
from kanefe.joints import Free
from kanefe.kernels.contact.laws.normal_law import NormalLaw
from kanefe.linear.equilibrium.equilibria import equilibrium
from kanefe.system import System

STIFFNESS = 1e8
"""Stiffness of each pair of compliant feet, N/m."""


def pulled_chest(reference: Reference) -> Iterator[Check]:
    """L07: a chest on a slope, pulled down the slope above its centre of mass; the search starts half a metre above."""
    values = reference.values
    laws: tuple[tuple[str, NormalLaw | Rigid, float], ...] = (
        ("rigid", Rigid(), 1e-9),
        ("yielding", HuntCrossley(STIFFNESS, exponent=1.0), 1e-6),
    )
    for name, law, tolerance in laws:
        found = equilibrium(_chest(law))
        for feet in ("lower", "upper"):
            force = float(found.contact(feet).normal)
            yield Check.relative(f"{name} feet: normal force, {feet} [N]", force, values[feet], tolerance)
        rub = sum(float(found.contact(feet).tangential) for feet in ("lower", "upper"))
        yield Check.relative(f"{name} feet: friction of all [N]", rub, values["friction"], tolerance)


def _chest(law: NormalLaw | Rigid) -> System:
    scene = System(gravity=(GRAVITY * math.sin(0.3), 0.0, -GRAVITY * math.cos(0.3)))
    slope = scene.add_surface("slope", scene.ground, shapes.Plane("z"))
    chest = scene.add_rigid_body("chest", 2.0, 0.05, joint=Free(position=(0.0, 0.0, 0.6)))
    scene.add_force(chest, (3.0, 0.0, 0.0), point=(0.0, 0.0, 0.05))
    for name, x in (("lower", 0.2), ("upper", -0.2)):
        feet = scene.add_surface(name, chest, shapes.Points([(x, y, -0.1) for y in (-0.1, 0.1)]))
        scene.add_contact(name, feet, slope, normal=law, friction=Coulomb(0.6))
    return scene


CASES = (Case("L07", pulled_chest),)
