"""A source with curves: quadratic elements follow them by default, or how far they are off is told."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp
import scipy.sparse.linalg as spla

import kanefe as kf
from kanefe.reduction.load_cases import PRODUCTS, centrifugal_forces
from kanefe_fem import read_mesh, solid_body, solid_model
from kanefe_fem.materials.isotropic import Material
from kanefe_fem.mesh.checks import MeshWarning

pytestmark = [pytest.mark.gmsh, pytest.mark.fenicsx]

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
PLATE = {"plane": "stress", "thickness": 0.01}
SIDES = 60
BOW = 1.0 - np.cos(np.pi / SIDES)


@pytest.fixture
def disc(tmp_path: Path) -> Path:
    """Radius 1 m, 60 sides on the rim."""
    path = tmp_path / "disc.geo"
    path.write_text(
        'SetFactory("OpenCASCADE"); Disk(1) = {0, 0, 0, 1}; Mesh.MeshSizeMin = 0.1; Mesh.MeshSizeMax = 0.2;\n'
        f"Transfinite Curve{{1}} = {SIDES + 1};\n"
        'Physical Surface("disc") = {1}; Physical Curve("rim") = {1};\n'
    )
    return path


def growth(model: kf.FiniteElementModel) -> float:
    """Mean radial displacement of the rim of a disc that spins at 1 rad/s, against the closed form, less 1.

    Timoshenko & Goodier, "Theory of Elasticity", section 32: u(R) = rho w^2 R^3 (1 - nu) / (4 E).
    """
    load = centrifugal_forces(model)[:, PRODUCTS.index((2, 2))]
    R = sp.csr_matrix(model.unit_rigid_modes()[0])
    zero = sp.csr_matrix((R.shape[1], R.shape[1]))
    bordered = sp.bmat([[model.stiffness / STEEL.E, R], [R.T, zero]], format="csc")
    u = spla.spsolve(bordered, np.append(load / STEEL.E, np.zeros(R.shape[1])))[: model.size].reshape(-1, 2)
    radius = np.linalg.norm(model.nodes[:, :2], axis=1)
    rim = radius > 1.0 - 1e-9
    found = np.mean(np.einsum("na,na->n", u, model.nodes[:, :2])[rim] / radius[rim])
    return float(found / (STEEL.rho * (1.0 - STEEL.nu) / (4.0 * STEEL.E)) - 1.0)


def test_a_source_is_followed_by_quadratic_elements(disc: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error", MeshWarning)
        by_default = growth(solid_model(disc, STEEL, **PLATE))
        body = solid_body(disc, STEEL, {}, **PLATE, reduction=kf.CraigBampton(modes=4))
        linear = solid_model(disc, STEEL, order=1, **PLATE)
    with pytest.warns(MeshWarning):
        straight = growth(solid_model(read_mesh(disc), STEEL, **PLATE))
    # the polygon's area is (2 pi / 60)^2 / 6 = 1.8e-3 too small; sides of second order are off in fourth order, 1e-6
    assert straight < -1.5e-3
    assert abs(by_default) < 1e-5
    assert body.mass == pytest.approx(STEEL.rho * np.pi * 0.01, rel=1e-6)
    assert linear.mass.sum() / 2 == pytest.approx(STEEL.rho * 0.01 * SIDES / 2 * np.sin(2 * np.pi / SIDES), rel=1e-12)


def test_how_far_straight_sides_are_off_is_told(disc: Path) -> None:
    mesh = read_mesh(disc)
    assert mesh.order == 1
    assert mesh.sagitta == pytest.approx(BOW, rel=1e-9)
    assert read_mesh(disc, order=2).sagitta == 0.0
    with pytest.warns(MeshWarning, match=r"disc.geo are straight and up to 0.0014 m off .* order=2"):
        solid_model(mesh, STEEL, **PLATE)
    with warnings.catch_warnings():
        warnings.simplefilter("error", MeshWarning)
        solid_model(mesh, STEEL, order=1, **PLATE)
        solid_model(mesh.with_order(2).with_order(1), STEEL, order=1, **PLATE)


def test_cells_too_coarse_to_be_curved_are_straight_and_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where gmsh does not mend them."""
    monkeypatch.setattr("kanefe_fem._gmsh._is_folded", lambda gmsh, dimension: False)
    path = tmp_path / "rod.geo"
    path.write_text(
        'SetFactory("OpenCASCADE"); Cylinder(1) = {0, 0, 0, 0.2, 0, 0, 0.01}; Mesh.MeshSizeMax = 0.02;\n'
        'Physical Volume("rod") = {1};\n'
    )
    with pytest.warns(MeshWarning, match="cells fine enough"):
        model = solid_model(path, STEEL)
    assert model.provenance["element"].startswith("tetra10")


def test_flat_sources_are_not_touched(geo) -> None:
    assert read_mesh(geo()).sagitta == 0.0
