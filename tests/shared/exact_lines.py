"""Exact beams for tests: random ones, and sections with every coupling."""

from __future__ import annotations

from typing import Any

import numpy as np

import kanefe as kf
import kanefe_fem as fem
from kanefe.bodies.exact.beam import ExactBeam
from kanefe_fem.beams.beam_section import BeamSection
from kanefe_fem.beams.exact import Theory

LENGTH = 1.3


def coupled_section(size: float = 1.0) -> BeamSection:
    """Return a section whose strains are coupled and whose centre of mass is off the axis."""
    D = np.diag([300.0, 200.0, 150.0, 6.0, 5.0, 4.0])
    D[0, 3] = D[3, 0] = 10.0
    D[4, 5] = D[5, 4] = 0.5
    return fem.Section.from_stiffness(
        stiffness=size * D, rho_A=size, rho_I=(1e-2 * size, 2e-2 * size), centre_of_mass=(0.02, 0.03)
    )


BASES: dict[str, Any] = {
    "numbers": 3,
    "splines": kf.BSpline(2, 2),
    "mixed": {
        "stretch": 2,
        "shear_y": 1,
        "shear_z": 2,
        "twist": 3,
        "curvature_y": 2,
        "curvature_z": kf.BSpline(1, 2),
    },
}


def random_beam(seed: int, theory: Theory, basis: str) -> ExactBeam:
    """Return a tapered, twisted and curved beam in any direction, with interfaces at its ends and within."""
    rng = np.random.default_rng(seed)
    axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    functions = BASES[basis]
    if isinstance(functions, dict) and theory != "shear-deformable":
        left_out = {"shear-rigid": ("stretch", "shear_y", "shear_z"), "stretching": ("shear_y", "shear_z")}[theory]
        functions = {name: one for name, one in functions.items() if name not in left_out}
    return fem.exact_beam(
        LENGTH,
        lambda s: coupled_section(1.0 + 0.4 * s),
        theory=theory,
        basis=functions,
        curvature=lambda s: (0.3 - s, 0.2, -0.4 + 0.5 * s),
        axes=axes * np.sign(np.linalg.det(axes)),
        interfaces={"root": 0.0, "middle": 0.5, "tip": LENGTH},
        damping=kf.RayleighDamping(stiffness=0.01),
    )
