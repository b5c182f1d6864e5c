"""Materials that are as good as incompressible."""

from __future__ import annotations

import warnings
from collections.abc import Iterator

import numpy as np

from kanefe.checks.robustness.case import Effort, Finding, StressCase
from kanefe.errors import ModelError
from kanefe.reduction import CraigBampton
from kanefe_fem.materials.isotropic import AccuracyWarning, Material
from kanefe_fem.mesh.simple import box_mesh
from kanefe_fem.solids.body import solid_body

GAPS = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
"""Values of 0.5 - nu."""


def incompressible(effort: Effort) -> Iterator[Finding]:
    """Bend a rubber bar: its frequencies go to a limit as nu goes to 0.5, instead of locking."""
    for kind, counts in (("hexahedron", (8, 2, 2)), ("tetra", (8, 2, 2))):
        found = []
        mesh = box_mesh((1.0, 0.1, 0.1), counts, kind)  # type: ignore[arg-type]
        for gap in GAPS:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", AccuracyWarning)
                material = Material(E=5e6, nu=0.5 - gap, rho=1000.0)
                body = solid_body(mesh, material, {}, reduction=CraigBampton(modes=4), cache=False)
            found.append(body.frequencies)
        frequencies = np.array(found)
        locked = np.abs(frequencies[:, :2] / frequencies[0, :2] - 1.0).max(axis=1)
        what = f"free rubber bar of {mesh.cell_count} quadratic {kind} cells, nu = 0.4 ... 0.499999"
        yield Finding.of(
            what,
            locked,
            "bending frequencies against nu = 0.4, relative",
            0.03,
            "slender bending does not feel nu: what it does is shear, some percent, and locking",
        )
        yield Finding(
            what,
            1,
            "last change on the way to 0.5, relative",
            float(np.abs(frequencies[-1, :2] / frequencies[-2, :2] - 1.0).max()),
            1e-3,
            "the limit is finite: what locks goes on growing",
        )
    named = 0
    for nu in (0.5, 0.6, -1.0, float("nan")):
        try:
            Material(E=5e6, nu=nu, rho=1000.0)
        except ModelError as problem:
            named += "nu" in str(problem) or "Poisson" in str(problem)
    yield Finding("nu of 0.5, 0.6, -1 and NaN", 4, "not refused by name", float(4 - named), 0.0, "no such solid")


CASES = (StressCase("incompressible", "near-incompressible material", incompressible),)
