"""Frequencies of a thin plate from solid elements (B07), against Kirchhoff's theory by Ritz's method."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from kanefe.checks.verification import Case, Check, Reference
from kanefe.reduction import CraigBampton
from kanefe_fem.materials.isotropic import Material
from kanefe_fem.mesh.simple import box_mesh
from kanefe_fem.solids.body import solid_body

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)

SIDE, THICKNESS = 1.0, 0.01
"""Side and thickness of the plate, m. Shear, which Kirchhoff's theory neglects, lowers the sixth frequency by about 0.2
% at this thickness."""

ELEMENTS = 16
"""Number of elements along a side; with twelve the sixth frequency of the free plate is 1.2 % too high."""


def square_plate(reference: Reference) -> Iterator[Check]:
    """B07: one layer of quadratic hexahedra, clamped at one edge, and free."""
    mesh = box_mesh((SIDE, SIDE, THICKNESS), (ELEMENTS, ELEMENTS, 1), "hexahedron")
    bending = STEEL.E * THICKNESS**3 / (12.0 * (1.0 - STEEL.nu**2))
    scale = SIDE**2 * np.sqrt(STEEL.rho * THICKNESS / bending)
    for name, interfaces in (("CFFF", {"root": "clamped"}), ("FFFF", {})):
        expected = next(values for key, values in reference.values.items() if key.startswith(name))
        body = solid_body(mesh, STEEL, interfaces, reduction=CraigBampton(modes=len(expected)))
        found = 2.0 * np.pi * body.frequencies[: len(expected)] * scale
        quantity = f"lambda 1-{len(expected)}, {name}, solid of {mesh.cell_count} quadratic hexahedra"
        yield Check.relative(quantity, found, expected, 1e-2)


CASES = (Case("B07", square_plate),)
