"""Geometric stiffness of beams and solids: buckling loads in closed form."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg

from kanefe.frames import skew
from kanefe_fem.beams.body import beam_model, straight_beam
from kanefe_fem.beams.sections import Rectangle, Section
from kanefe_fem.materials.isotropic import Material
from kanefe_fem.mesh.simple import box_mesh
from static_loads import held, static, tip_load

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
SOFT = Material(E=210e9, nu=0.0, rho=7850.0)


def critical_factors(model, free, u):
    """Return factors of the state u at which the body buckles: (K + factor K_g) x = 0, smallest first."""
    K, K_g = (matrix[free][:, free].toarray() for matrix in (model.stiffness, model.stress_stiffness(u)))
    squares = scipy.linalg.eigh(-K_g, K, eigvals_only=True)
    return 1.0 / squares[squares > 0][::-1]


@pytest.mark.parametrize("direction", [(1.0, 0.0, 0.0), (1.0, 2.0, -0.5)])
def test_column_buckles_at_eulers_load(direction):
    section = Rectangle(width=0.02, height=0.01)
    model = straight_beam(1.0, section, STEEL, elements=8, direction=direction, theory="euler-bernoulli")
    axis = np.asarray(direction) / np.linalg.norm(direction)
    f = -sum(tip_load(model, c, a) for c, a in zip("xyz", axis, strict=True))
    free = held(model, [0])
    expected = np.pi**2 * STEEL.E * np.array([section.I_y, section.I_z]) / 4.0
    found = critical_factors(model, free, static(model, free, f))[:2]
    np.testing.assert_allclose(np.sort(found), np.sort(expected), rtol=1e-5)  # 8 elements: h^4


def test_planar_column_buckles_at_eulers_load():
    model = straight_beam(1.0, Rectangle(width=0.02, height=0.01), STEEL, elements=8, planar=True)
    free = held(model, [0])
    found = critical_factors(model, free, static(model, free, -tip_load(model, "x")))[0]
    # Timoshenko's column is softer by 1 + P / (kappa G A), some 5e-4 here
    assert found == pytest.approx(np.pi**2 * STEEL.E * 0.01 * 0.02**3 / 48.0, rel=1e-3)


def test_cantilever_tips_over_sideways():
    """Tip load 4.0126 sqrt(EI GJ) / L^2 (Timoshenko & Gere): needs V, M and T, and rotation vectors at the nodes."""
    section = Section(A=1e-3, I_y=1e-6, I_z=1e-10, J=4e-10)  # so deep that its own deflection does not count
    model = straight_beam(1.0, section, SOFT, elements=48, theory="euler-bernoulli")
    free = held(model, [0])
    found = critical_factors(model, free, static(model, free, -tip_load(model, "z")))[0]
    # (1 - I_z/I_y)^(1/2) changes it by 5e-5, 48 elements, linear in twist, by 1e-4
    assert found == pytest.approx(4.0126 * np.sqrt(SOFT.E * 1e-10 * SOFT.shear_modulus * 4e-10), rel=2e-4)


def test_frame_buckles_alike_however_it_lies():
    """A frame's buckling load does not depend on how it lies in G, out of its plane and in it."""
    loads = []
    turn = scipy.linalg.expm(skew((0.4, -0.8, 0.3)))
    for A in (np.eye(3), turn):
        corner = np.linspace(0.0, 1.0, 5)
        nodes = [[0.0, 0.0, z] for z in corner] + [[y, 0.0, 1.0] for y in corner[1:]]
        elements = [[i, i + 1] for i in range(8)]
        up = [A @ (1.0, 0.0, 0.0)] * 4 + [A @ (0.0, 0.0, 1.0)] * 4
        model = beam_model(nodes @ A.T, elements, Rectangle(0.02, 0.05), STEEL, orientation=up)
        f = sum(tip_load(model, c, a) for c, a in zip("xyz", A @ (0.0, 0.3, -1.0), strict=True))
        free = held(model, [0])
        loads.append(critical_factors(model, free, static(model, free, f))[:3])
    np.testing.assert_allclose(loads[0], loads[1], rtol=1e-9)


@pytest.mark.fenicsx
def test_solid_column_buckles_at_eulers_load():
    from kanefe_fem.solids.model import solid_model

    model = solid_model(box_mesh((1.0, 0.02, 0.03), (20, 1, 1), "hexahedron"), SOFT)
    f = np.zeros(model.size)
    tip = model.groups["tip"].nodes
    f[3 * tip] = -1.0 / len(tip)
    free = held(model, model.groups["root"].nodes)
    found = critical_factors(model, free, static(model, free, f))[0]
    # shear lowers it by P / (kappa G A), 5e-4; 20 elements raise it by 1e-3
    assert found == pytest.approx(np.pi**2 * SOFT.E * 0.03 * 0.02**3 / 48.0, rel=3e-3)
