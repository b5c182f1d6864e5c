"""Solid meshes that are stiffened by their own motion."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from kanefe.bodies.flexible import FlexibleBody
from kanefe.checks.verification import Case, Check, Reference
from kanefe.checks.verification.rotors import spin_eigenvalues
from kanefe.joints import Motion, Revolute
from kanefe.reduction import CraigBampton
from kanefe.reduction.stiffening import StiffeningLevel
from kanefe.system import System
from kanefe_fem.materials.isotropic import Material
from kanefe_fem.mesh.simple import box_mesh
from kanefe_fem.solids.body import solid_body
from kanefe_fem.verification import spin_up

SLENDERNESS, ELEMENTS = 400.0, 150
"""Slenderness of the blade and number of its elements. It stretches by the fraction 6 (speed / slenderness)^2, unlike
the reference, and its chordwise mode is slower by as much. Elements longer than three times their thickness are too
stiff."""

LINE_MASS = 0.1
"""Values of rho A and EI of the blade, which give the density of the material."""


def slender_bar(interfaces: Mapping[str, str], modes: int, stiffening: StiffeningLevel = "none") -> FlexibleBody:
    """Return a square bar of quadratic hexahedra with EI = rho A and L = 1."""
    side = 1.0 / SLENDERNESS
    mesh = box_mesh((1.0, side, side), (ELEMENTS, 1, 1), "hexahedron", start=(0.0, -side / 2, -side / 2))
    material = Material(E=12.0 * LINE_MASS / side**4, nu=0.0, rho=LINE_MASS / side**2)
    return solid_body(
        mesh, material, interfaces, reduction=CraigBampton(modes=modes), stiffening=stiffening, cache=False
    )


def arm_of_solids(reference: Reference) -> Iterator[Check]:
    """D01: 40 quadratic hexahedra."""
    side = spin_up.SIDE
    mesh = box_mesh((spin_up.LENGTH, side, side), (40, 1, 1), "hexahedron", start=(0.0, -side / 2, -side / 2))
    # with kappa = 5/6, nu = 1/6 gives this ratio of EA to GA
    material = Material(E=spin_up.EA / side**2, nu=1.0 / 6.0, rho=spin_up.LINE_MASS / side**2)

    def arm(stiffening: StiffeningLevel) -> FlexibleBody:
        interfaces = {"root": "clamped", "tip": "rigid"}
        reduction = CraigBampton(modes=10)
        return solid_body(mesh, material, interfaces, reduction=reduction, stiffening=stiffening, cache=False)

    yield from spin_up.spin_up_checks(reference, arm, "40 quadratic hexahedra")


def rotating_blade(reference: Reference) -> Iterator[Check]:
    """D03a: flap and chord frequencies of a rotating blade from a mesh, in one body."""
    blade = slender_bar({"root": "clamped"}, modes=24, stiffening="inertial")
    first, every = [], []
    for name, expected in reference.values.items():
        speed = float(name.split("gamma=")[1])
        scene = System()
        scene.add_flexible_body("blade", blade, joint=Revolute("z", motion=Motion.steady(speed)))
        found = spin_eigenvalues(scene.freeze())[:6].imag
        # for a square section, chord is the slower mode of each pair
        pairs = list(zip(found, np.sort(np.concatenate((expected["chord"], expected["flap"]))), strict=True))
        first += pairs[:2]
        every += pairs
    quantity = f"first flap and chord at 0 ... 12, {ELEMENTS} quadratic hexahedra"
    yield Check.relative(quantity, [p[0] for p in first], [p[1] for p in first], 1e-4)
    quantity = f"flap and chord 1-3 at 0 ... 12, {ELEMENTS} quadratic hexahedra"
    yield Check.relative(quantity, [p[0] for p in every], [p[1] for p in every], 1e-3)


CASES = (Case("D01", arm_of_solids), Case("D03a", rotating_blade))
