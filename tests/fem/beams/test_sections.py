"""Sections: closed forms against integrals and against Prandtl's stress function on a grid."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve

from kanefe.errors import ModelError
from kanefe_fem.beams.sections import Box, Rectangle, Section, SolidCircle, Tube


def torsion_constant(width: float, height: float, thickness: float, cells: int) -> float:
    """Prandtl's stress function with bilinear elements, constant over the hole: a lower bound of J, error O(h^2)."""

    def line(length):
        h = length / cells
        stiff = sp.diags([-1.0, 2.0, -1.0], [-1, 0, 1], shape=(cells - 1, cells - 1)) / h
        mass = sp.diags([1.0, 4.0, 1.0], [-1, 0, 1], shape=(cells - 1, cells - 1)) * h / 6.0
        return stiff, mass, np.linspace(0.0, length, cells + 1)[1:-1], h

    (K_y, M_y, y, h_y), (K_z, M_z, z, h_z) = line(width), line(height)
    stiffness = (sp.kron(K_y, M_z) + sp.kron(M_y, K_z)).tocsr()
    load = np.full(len(y) * len(z), 2.0 * h_y * h_z)
    inside = (np.minimum(y, width - y)[:, None] > thickness * (1 - 1e-9)) & (
        np.minimum(z, height - z)[None, :] > thickness * (1 - 1e-9)
    )
    inside = inside.ravel()
    free = np.flatnonzero(~inside)
    columns = np.empty(inside.size, dtype=int)
    columns[free], columns[inside] = np.arange(len(free)), len(free)
    tie = sp.csr_matrix((np.ones(inside.size), (np.arange(inside.size), columns)))
    phi = spsolve((tie.T @ stiffness @ tie).tocsc(), tie.T @ load)
    return float(phi @ (tie.T @ load))


@pytest.mark.parametrize(
    ("section", "inner"),
    [(Rectangle(0.06, 0.02), (0.0, 0.0)), (Box(0.06, 0.1, 0.004), (0.052, 0.092)), (Box(0.1, 0.1, 0.03), (0.04, 0.04))],
)
def test_rectangular_sections_have_the_moments_of_their_integrals(section, inner):
    outer = (section.width, section.height)
    y_power = [outer[0] ** (p + 1) * outer[1] - inner[0] ** (p + 1) * inner[1] for p in (0, 2)]
    z_power = [outer[1] ** (p + 1) * outer[0] - inner[1] ** (p + 1) * inner[0] for p in (0, 2)]
    assert section.A == pytest.approx(y_power[0], rel=1e-14)
    assert section.I_z == pytest.approx(y_power[1] / 12.0, rel=1e-14)
    assert section.I_y == pytest.approx(z_power[1] / 12.0, rel=1e-14)


def test_round_sections_have_the_moments_of_their_integrals():
    tube, outer, inner = Tube(0.05, 0.004), SolidCircle(0.05), SolidCircle(0.042)
    for name in ("A", "I_y", "I_z", "J"):
        assert getattr(tube, name) == pytest.approx(getattr(outer, name) - getattr(inner, name), rel=1e-13)
    assert outer.J == outer.I_y + outer.I_z == pytest.approx(np.pi * 0.05**4 / 32.0, rel=1e-14)


@pytest.mark.parametrize("ratio", [1.0, 2.0, 5.0])
def test_rectangle_torsion_against_the_stress_function(ratio):
    # Bilinear elements, 60 across: an O(h^2) error below 1e-3, from below.
    numeric = torsion_constant(ratio, 1.0, 1.0 + ratio, 60)
    assert numeric < Rectangle(ratio, 1.0).J
    assert Rectangle(ratio, 1.0).J == pytest.approx(numeric, rel=1e-3)
    assert Rectangle(1.0, ratio).J == Rectangle(ratio, 1.0).J


def test_rectangle_torsion_limits():
    assert Rectangle(1.0, 1.0).J == pytest.approx(0.1405770149, rel=1e-9)  # Timoshenko & Goodier, k1 = 0.1406
    thin = Rectangle(1.0, 1e-3)
    assert thin.J == pytest.approx(1e-9 / 3.0 * (1 - 0.630249e-3), rel=1e-8)


@pytest.mark.parametrize(
    ("box", "tolerance"),
    [
        (Box(1.0, 1.0, 0.1), 5e-4),
        (Box(2.0, 1.0, 0.1), 5e-4),
        (Box(1.0, 1.0, 0.25), 1e-3),
        (Box(1.0, 2.0, 0.4), 5e-3),
    ],
)
def test_box_torsion_against_the_stress_function(box, tolerance):
    # At the corners of the hole the grid converges as h^(4/3), which the extrapolation of two grids takes out.
    coarse, fine = (torsion_constant(box.width, box.height, box.thickness, cells) for cells in (60, 120))
    rate = 2.0 ** (4.0 / 3.0)
    assert box.J == pytest.approx((rate * fine - coarse) / (rate - 1.0), rel=tolerance)


def test_box_torsion_tends_to_bredt_in_thin_walls():
    t, b, h = 1e-5, 1.0, 2.0
    assert Box(b + t, h + t, t).J == pytest.approx(4 * (b * h) ** 2 * t / (2 * (b + h)), rel=1e-5)


@pytest.mark.parametrize("shape", [(1.0, 1.0), (0.5, 1.0), (3.0, 1.0)])
def test_box_shear_factor_is_that_of_the_shear_flow_energy(shape):
    """At nu = 0 Cowper's factor is I^2 / (A int (Q/t)^2 dA) of the thin-walled shear flow."""
    flange, web = shape
    t = 1e-9
    box = Box(flange + t, web + t, t)
    s, weight = np.polynomial.legendre.leggauss(6)  # exact: polynomials of degree 4
    in_flange, in_web = 0.25 * flange * (s + 1.0), 0.5 * web * s
    q_flange = 0.5 * web * in_flange
    q_web = 0.25 * flange * web + 0.5 * (0.25 * web**2 - in_web**2)
    energy = 4 * 0.25 * flange * weight @ q_flange**2 + 2 * 0.5 * web * weight @ q_web**2
    second_moment = web**3 / 6.0 + flange * web**2 / 2.0
    kappa = second_moment**2 / (2.0 * (flange + web) * energy)
    assert box.shear_z == pytest.approx(kappa, rel=1e-6)
    assert Box(web + t, flange + t, t).shear_y == pytest.approx(kappa, rel=1e-6)


def test_shear_factors_of_cowper():
    assert Rectangle(1.0, 2.0).shear_y == Rectangle(1.0, 2.0).shear_z == pytest.approx(5 / 6, rel=1e-15)
    assert Rectangle(1.0, 2.0, nu=0.3).shear_y == pytest.approx(0.850, abs=5e-4)
    assert SolidCircle(1.0).shear_y == pytest.approx(6 / 7, rel=1e-15)
    assert SolidCircle(1.0, nu=0.3).shear_y == pytest.approx(0.886, abs=5e-4)
    assert Tube(1.0, 1e-6, nu=0.3).shear_y == pytest.approx(0.531, abs=5e-4)
    assert Box(1.0, 1.0, 1e-6, nu=0.3).shear_y == pytest.approx(0.436, abs=5e-4)
    # A tube whose hole closes is a solid bar.
    assert Tube(1.0, 0.5 - 1e-9, nu=0.3).shear_y == pytest.approx(SolidCircle(1.0, nu=0.3).shear_y, rel=1e-12)


@pytest.mark.parametrize(
    ("make", "named"),
    [
        (lambda: Tube(0.05, 0.025), "Tube: thickness"),
        (lambda: Tube(-0.05, 0.001), "outer_diameter"),
        (lambda: Box(0.1, 0.02, 0.01), "Box: thickness"),
        (lambda: Rectangle(0.1, 0.0), "Rectangle: height"),
        (lambda: Rectangle(float("nan"), 0.1), "Rectangle: width"),
        (lambda: SolidCircle("thick"), "SolidCircle: diameter"),  # type: ignore[arg-type]
        (lambda: SolidCircle(0.1, nu=0.7), "SolidCircle: nu"),
        (lambda: Section(1e-4, 1e-8, -1e-8, 1e-8), "Section: I_z"),
        (lambda: Section(1e-4, 1e-8, 1e-8, 0.0), "Section: J"),
        (lambda: Section(1e-4, 1e-8, 1e-8, 1e-8, shear_z=1.2), "Section: shear_z"),
    ],
)
def test_bad_sections_are_named(make, named):
    with pytest.raises(ModelError, match=named) as caught:
        make()
    assert "Remedy" in str(caught.value)
