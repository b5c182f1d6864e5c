"""Reductions of a solid: the bar of the peers' scene S3, against all its degrees of freedom."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import kanefe as kf
from kanefe.reduction import flexible_body
from kanefe.reduction.load_cases import some_groups
from kanefe_fem.materials.isotropic import Material
from kanefe_fem.mesh.simple import box_mesh
from kanefe_fem.solids.model import solid_model
from reduction_cases import exact_errors, problem_of, tied_modes

pytestmark = pytest.mark.fenicsx

HIGHEST = 50.0
"""Hz; the first bending frequency with the root clamped is 42 Hz."""


@pytest.fixture(scope="module")
def bar() -> kf.FiniteElementModel:
    mesh = box_mesh((1.0, 0.1, 0.05), (6, 1, 1), "hexahedron", start=(0.0, -0.05, -0.025))
    return solid_model(mesh, Material(E=210e9, nu=0.3, rho=7850.0))


@pytest.mark.parametrize(
    "reduction",
    [
        kf.CraigBampton(modes=2, error_up_to=HIGHEST),
        kf.CraigBampton(modes=8, error_up_to=HIGHEST),
        kf.FreeInterface(modes=6, error_up_to=HIGHEST),
        kf.Krylov(order=1, error_up_to=HIGHEST),
        kf.CraigBampton(modes="auto", up_to_frequency=HIGHEST),
        kf.CraigBampton(modes="auto", up_to_frequency=HIGHEST, loads=("gravity", "tip")),
    ],
    ids=repr,
)
def test_the_estimate_bounds_the_error_of_a_solid(bar: kf.FiniteElementModel, reduction: Any) -> None:
    interfaces = {"root": "clamped", "tip": "rigid"}
    problem = problem_of(bar, interfaces)
    record = flexible_body(bar, interfaces, reduction=reduction).provenance["reduction"]
    loads = some_groups(problem, reduction.loads)
    exact = exact_errors(problem, tied_modes(problem, reduction), loads, HIGHEST)
    for (load, motion), error in exact.items():
        if error > 1e-9:
            assert error <= record["error_estimate"]["loads"][load][motion] <= 5.0 * error
    if getattr(reduction, "modes", None) == "auto":
        assert max(exact.values()) < 1e-3


def test_reductions_agree_on_the_lowest_frequencies(bar: kf.FiniteElementModel) -> None:
    interfaces = {"root": "clamped", "tip": "rigid"}
    free, held, krylov = (
        flexible_body(bar, interfaces, reduction=r).frequencies[:3]
        for r in (kf.FreeInterface(modes=6), kf.CraigBampton(modes=20), kf.Krylov((0.0, 60.0), order=3))
    )
    # free-interface modes are exact; the others approach them from above
    for found in (held, krylov):
        assert found == pytest.approx(free, rel=1e-3)
        assert np.all(found >= free * (1 - 1e-9))
