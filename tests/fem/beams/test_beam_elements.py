"""The general beam element: interpolation, strain, stiffness."""

from __future__ import annotations

import numpy as np
import pytest

from kanefe_fem.beams import elements as be

LENGTHS = np.array([0.4, 1.3])
INFINITE = np.full(2, np.inf)


def properties(shear: bool) -> be.ElementProperties:
    EI_y, EI_z = np.array([2.0e3, 5.0e3]), np.array([3.0e3, 4.0e3])
    return be.ElementProperties(
        length=LENGTHS,
        EA=np.array([1.0e6, 2.0e6]),
        GJ=np.array([700.0, 900.0]),
        EI_y=EI_y,
        EI_z=EI_z,
        shear_y=np.array([3.0e5, 1.0e5]) if shear else INFINITE,
        shear_z=np.array([2.0e5, 4.0e5]) if shear else INFINITE,
    )


def rigid_modes(length: float) -> np.ndarray:
    """Motion of the two nodes under unit translations and rotations about node 1, shape (12, 6)."""
    R = np.vstack([np.eye(6), np.eye(6)])
    R[7, 5], R[8, 4] = length, -length
    return R


@pytest.mark.parametrize("shear", [False, True])
def test_the_interpolation_meets_the_nodes_and_every_rigid_motion(shear):
    xi = np.array([0.0, 0.27, 1.0])
    N = be.interpolation(properties(shear), xi)
    assert N[:, 0, :, :6] == pytest.approx(np.tile(np.eye(6), (2, 1, 1)), abs=1e-15)
    assert N[:, 2, :, 6:] == pytest.approx(np.tile(np.eye(6), (2, 1, 1)), abs=2e-15)
    assert abs(N[:, 0, :, 6:]).max() == 0.0
    assert abs(N[:, 2, :, :6]).max() < 2e-15 * 6 / LENGTHS.min()
    for e, length in enumerate(LENGTHS):
        field = N[e] @ rigid_modes(length)
        for g, x in enumerate(xi * length):
            exact = np.eye(6)
            exact[1, 5], exact[2, 4] = x, -x
            assert field[g] == pytest.approx(exact, abs=1e-14)


@pytest.mark.parametrize("shear", [False, True])
def test_a_rigid_motion_has_neither_strain_nor_force(shear):
    p = properties(shear)
    B, K = be.strain_displacement(p, np.array([0.1, 0.8])), be.spatial_stiffness(p)
    for e, length in enumerate(LENGTHS):
        R = rigid_modes(length)
        assert abs(B[e] @ R).max() < 1e-14 * abs(B[e]).max()
        assert abs(K[e] @ R).max() < 1e-14 * abs(K[e]).max()
        values = np.linalg.eigvalsh(K[e])
        assert (values[6:] > 1e-6 * values[-1]).all()  # no mechanism: exactly six zero values
        assert abs(values[:6]).max() < 1e-13 * values[-1]


def test_the_hermite_element_has_no_shear_strain_and_the_planar_stiffness():
    p = properties(shear=False)
    B = be.strain_displacement(p, np.linspace(0.0, 1.0, 5))
    assert abs(B[:, :, 1:3]).max() < 1e-14 * abs(B).max()
    K = be.spatial_stiffness(p)
    for e, length in enumerate(LENGTHS):
        planar = be.planar_stiffness(length, p.EA[e], p.EI_z[e])
        assert abs(K[e][np.ix_(be.PLANAR_DOFS, be.PLANAR_DOFS)] - planar).max() < 1e-14 * abs(planar).max()
        x = 0.3 * length
        row = be.strain_displacement(p, np.array([0.3]))[e, 0][[0, 5]][:, be.PLANAR_DOFS]
        assert row == pytest.approx(be.planar_strain_displacement(x, length), rel=1e-12, abs=1e-12)


def test_the_timoshenko_field_is_in_equilibrium():
    """Without load, shear force = - d(moment)/dx in both planes at every station, and both are what the strains say."""
    p = properties(shear=True)
    xi = np.array([0.0, 0.5, 1.0])
    B = be.strain_displacement(p, xi)
    for e, length in enumerate(LENGTHS):
        moment_z, moment_y = p.EI_z[e] * B[e, :, 5], p.EI_y[e] * B[e, :, 4]
        shear_y, shear_z = p.shear_y[e] * B[e, :, 1], p.shear_z[e] * B[e, :, 2]
        scale = 1e-12 * abs(shear_y).max()
        assert (moment_z[2] - moment_z[0]) / length == pytest.approx(-shear_y[1], rel=1e-11, abs=scale)
        assert (moment_y[2] - moment_y[0]) / length == pytest.approx(shear_z[1], rel=1e-11, abs=scale)
        assert np.ptp(shear_y, axis=0).max() < scale
        assert np.ptp(shear_z, axis=0).max() < scale


def test_the_stiffness_with_shear_is_przemienieckis():
    p = properties(shear=True)
    K = be.spatial_stiffness(p)
    for e, a in enumerate(LENGTHS):
        for EI, phi, dofs, sign in (
            (p.EI_z[e], p.phi_y[e], [1, 5, 7, 11], 1.0),
            (p.EI_y[e], p.phi_z[e], [2, 4, 8, 10], -1.0),
        ):
            s = sign
            block = np.array(
                [
                    [12, s * 6 * a, -12, s * 6 * a],
                    [s * 6 * a, (4 + phi) * a**2, -s * 6 * a, (2 - phi) * a**2],
                    [-12, -s * 6 * a, 12, -s * 6 * a],
                    [s * 6 * a, (2 - phi) * a**2, -s * 6 * a, (4 + phi) * a**2],
                ]
            )
            block *= EI / (a**3 * (1 + phi))
            assert abs(K[e][np.ix_(dofs, dofs)] - block).max() < 1e-13 * abs(block).max()
        for k, dofs in ((p.EA[e] / a, [0, 6]), (p.GJ[e] / a, [3, 9])):
            assert K[e][np.ix_(dofs, dofs)] == pytest.approx(k * np.array([[1, -1], [-1, 1]]), rel=1e-14)


def test_little_shear_flexibility_tends_to_the_hermite_element():
    stiff = properties(shear=False)
    nearly = be.ElementProperties(
        stiff.length, stiff.EA, stiff.GJ, stiff.EI_y, stiff.EI_z, np.full(2, 1e16), np.full(2, 1e16)
    )
    xi = np.array([0.2, 0.6])
    assert be.interpolation(nearly, xi) == pytest.approx(be.interpolation(stiff, xi), abs=1e-10)
