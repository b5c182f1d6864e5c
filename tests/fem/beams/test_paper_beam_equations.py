"""Eq. 40-48 of the paper: what holds as printed, and what had to be corrected."""

from __future__ import annotations

import numpy as np
import pytest

from kanefe.frames import rotation_about, rotation_matrix
from kanefe_fem.beams import elements as be
from kanefe_fem.beams import spatial_element as se

LENGTH, THETA = 0.7, 0.6
EA, EI, RHO_A = 3.0e6, 2.0e2, 1.7


def printed_eq_40(x: float, a: float) -> np.ndarray:
    """Eq. 40 as printed: no factor x in the last terms of the columns of the rotations."""
    return np.array(
        [
            [-1 / a, 0, 0, 1 / a, 0, 0],
            [0, -6 / a**2 + 12 * x / a**3, -4 / a + 6 / a**2, 0, 6 / a**2 - 12 * x / a**3, -2 / a + 6 / a**2],
        ]
    )


RIGID = {
    "along": np.array([1.0, 0, 0, 1, 0, 0]),
    "across": np.array([0, 1.0, 0, 0, 1, 0]),
    "rotation": np.array([0, 0, 1.0, 0, LENGTH, 1]),
}


@pytest.mark.parametrize("x", [0.0, 0.2, LENGTH])
@pytest.mark.parametrize("motion", sorted(RIGID))
def test_eq_40_a_rigid_motion_has_no_strain(motion, x):
    strain = be.planar_strain_displacement(x, LENGTH) @ RIGID[motion]
    assert abs(strain).max() < 1e-14 * 12 / LENGTH  # round-off of terms of size 12/l


def test_eq_40_as_printed_bends_a_rigid_rotation():
    assert abs(printed_eq_40(0.2, LENGTH) @ RIGID["rotation"]).max() > 1.0


def test_eq_40_is_the_derivative_of_the_interpolation_not_the_interpolation():
    """Row 1 is u', row 2 is v'' of the Hermite interpolation of a cubic; at node 1 a shape function would give v."""
    c = np.array([0.3, -0.2, 0.5, 0.7])  # v = c0 + c1 x + c2 x^2 + c3 x^3, u = 0.4 - 0.9 x
    v, dv, ddv = (np.polynomial.Polynomial(c).deriv(k) if k else np.polynomial.Polynomial(c) for k in (0, 1, 2))
    q = np.array([0.4, v(0.0), dv(0.0), 0.4 - 0.9 * LENGTH, v(LENGTH), dv(LENGTH)])
    for x in (0.0, 0.31, LENGTH):
        assert be.planar_strain_displacement(x, LENGTH) @ q == pytest.approx([-0.9, ddv(x)], rel=1e-12)
    assert abs(be.planar_strain_displacement(0.0, LENGTH) @ q - q[:2]).max() > 0.5


def textbook_stiffness() -> np.ndarray:
    a, k = LENGTH, EI / LENGTH**3
    axial = EA / a
    return np.array(
        [
            [axial, 0, 0, -axial, 0, 0],
            [0, 12 * k, 6 * a * k, 0, -12 * k, 6 * a * k],
            [0, 6 * a * k, 4 * a**2 * k, 0, -6 * a * k, 2 * a**2 * k],
            [-axial, 0, 0, axial, 0, 0],
            [0, -12 * k, -6 * a * k, 0, 12 * k, -6 * a * k],
            [0, 6 * a * k, 2 * a**2 * k, 0, -6 * a * k, 4 * a**2 * k],
        ]
    )


def test_eq_40_corrected_integrates_to_the_stiffness_and_the_print_does_not():
    textbook = textbook_stiffness()
    assert abs(be.planar_stiffness(LENGTH, EA, EI) - textbook).max() < 1e-14 * abs(textbook).max()
    stations, weights = np.polynomial.legendre.leggauss(4)
    x, w = 0.5 * LENGTH * (stations + 1), 0.5 * LENGTH * weights
    printed = sum(
        wi * printed_eq_40(xi, LENGTH).T @ np.diag([EA, EI]) @ printed_eq_40(xi, LENGTH)
        for xi, wi in zip(x, w, strict=True)
    )
    bending = np.ix_([1, 2, 4, 5], [1, 2, 4, 5])
    assert abs(printed - textbook)[bending].max() > 0.1 * abs(textbook[bending]).max()


def test_eq_41_is_the_integral_of_the_displacement_field():
    p = be.ElementProperties(
        length=np.array([LENGTH]),
        EA=np.ones(1),
        GJ=np.ones(1),
        EI_y=np.ones(1),
        EI_z=np.ones(1),
        shear_y=np.array([np.inf]),
        shear_z=np.array([np.inf]),
    )
    stations, weights = be.gauss_stations(4)  # exact to degree 7; N^T N has degree 6
    N = be.interpolation(p, stations)[0][:, :2][:, :, be.PLANAR_DOFS]
    mass = RHO_A * LENGTH * np.einsum("g,gia,gib->ab", weights, N, N)
    printed = be.planar_mass(LENGTH, RHO_A)
    assert abs(mass - printed).max() < 1e-14 * abs(printed).max()


def test_eq_42_turns_the_matrix_into_the_axes_of_G():
    T = be.planar_transformation(THETA)
    assert T @ T.T == pytest.approx(np.eye(6), abs=1e-15)
    assert T @ be.planar_position_from_com(LENGTH, THETA) == pytest.approx(
        be.planar_position_from_com(LENGTH), abs=1e-15
    )
    A_GL = np.array([[[np.cos(THETA), -np.sin(THETA), 0], [np.sin(THETA), np.cos(THETA), 0], [0, 0, 1.0]]])
    spatial = be.spatial_transformation(A_GL)[0][np.ix_(be.PLANAR_DOFS, be.PLANAR_DOFS)]
    assert spatial == pytest.approx(T, abs=1e-15)
    mass = be.planar_mass(LENGTH, RHO_A)
    q_n = np.arange(1.0, 7.0)
    energy = 0.5 * (T @ q_n) @ mass @ (T @ q_n)
    assert 0.5 * q_n @ be.rotate_element_matrix(mass, T) @ q_n == pytest.approx(energy, rel=1e-14)


def test_eq_43_and_44_are_positions_from_the_centre_of_mass():
    assert be.planar_position_from_com(LENGTH) == pytest.approx([-LENGTH / 2, 0, 0, LENGTH / 2, 0, 0])
    c, s = LENGTH / 2 * np.cos(THETA), LENGTH / 2 * np.sin(THETA)
    assert be.planar_position_from_com(LENGTH, THETA) == pytest.approx([-c, -s, 0, c, s, 0])


def mass_in_n(theta: float) -> np.ndarray:
    return be.rotate_element_matrix(be.planar_mass(LENGTH, RHO_A), be.planar_transformation(theta))


@pytest.mark.parametrize("theta", [0.0, THETA, 2.5])
def test_eq_45_gives_the_moment_of_inertia_about_the_centre_of_mass(theta):
    J = be.planar_moment_of_inertia(mass_in_n(theta), be.planar_position_from_com(LENGTH, theta))
    assert J == pytest.approx(RHO_A * LENGTH * LENGTH**2 / 12, rel=1e-14)


@pytest.mark.parametrize("theta", [0.0, THETA, 2.5])
def test_eq_46_holds_for_the_resultant(theta):
    mass, x = mass_in_n(theta), be.planar_position_from_com(LENGTH, theta)
    m = RHO_A * LENGTH
    assert abs(be.planar_first_moment(mass, x)).max() < 1e-15 * m * LENGTH
    # ... but not row by row, as the print could be read: node 1 has -m l/12 along the beam, node 2 has +m l/12.
    assert np.linalg.norm((mass @ x)[:2]) == pytest.approx(m * LENGTH / 12, rel=1e-13)


@pytest.mark.parametrize("theta", [0.0, THETA, 2.5])
def test_eq_47_and_48_give_the_parallel_axis_theorem(theta):
    r, phi = 1.3, -0.4
    x = be.planar_position_in_G(LENGTH, theta, r, phi)
    assert x[[0, 1]] + x[[3, 4]] == pytest.approx(2 * r * np.array([np.cos(phi), np.sin(phi)]), rel=1e-14)
    m = RHO_A * LENGTH
    J = be.planar_moment_of_inertia(mass_in_n(theta), x)
    assert J == pytest.approx(m * LENGTH**2 / 12 + m * r**2, rel=1e-14)
    first = be.planar_first_moment(mass_in_n(theta), x)
    assert first == pytest.approx(m * r * np.array([np.cos(phi), np.sin(phi)]), rel=1e-14)


SIDES = (0.04, 0.02)  # m, of the section along y and z
RHO = RHO_A / (SIDES[0] * SIDES[1])
SECTION = (RHO * SIDES[0] * SIDES[1] ** 3 / 12, RHO * SIDES[1] * SIDES[0] ** 3 / 12)
ROTATIONS = [np.eye(3), rotation_matrix(rotation_about((1, 2, -0.5), 2.2)), rotation_matrix(rotation_about("y", -0.7))]


def prism(A_GL: np.ndarray, com: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    """Return mass, first moment and inertia of a turned prism at a place, by quadrature over its volume."""
    x, w = np.polynomial.legendre.leggauss(3)
    grid = np.stack(np.meshgrid(x, x, x, indexing="ij"), axis=-1).reshape(-1, 3)
    shares = np.einsum("i,j,k->ijk", w, w, w).ravel() * RHO * LENGTH * SIDES[0] * SIDES[1] / 8
    r = (0.5 * grid * (LENGTH, *SIDES)) @ A_GL.T + com
    second = np.einsum("p,pa,pb->ab", shares, r, r)
    return shares.sum(), shares @ r, np.trace(second) * np.eye(3) - second


def test_eq_41_in_space_is_the_integral_of_the_displacement_field():
    """And its planar part is Eq. 41; sections bring their rotary inertia."""
    p = be.ElementProperties(np.array([LENGTH]), *np.ones((4, 1)), *np.full((2, 1), np.inf))
    stations, weights = be.gauss_stations(4)
    N = be.interpolation(p, stations)[0]
    section = np.diag([RHO_A, RHO_A, RHO_A, sum(SECTION), *SECTION])
    mass = LENGTH * np.einsum("g,gia,ij,gjb->ab", weights, N, section, N)
    closed = se.spatial_mass(LENGTH, RHO_A, *SECTION)
    assert abs(mass - closed).max() < 1e-14 * abs(closed).max()
    planar = se.spatial_mass(LENGTH, RHO_A)[np.ix_(be.PLANAR_DOFS, be.PLANAR_DOFS)]
    assert abs(planar - be.planar_mass(LENGTH, RHO_A)).max() < 1e-15


@pytest.mark.parametrize("A_GL", ROTATIONS)
@pytest.mark.parametrize("com", [(0.0, 0.0, 0.0), (1.3, -0.4, 0.8)])
def test_eq_42_to_48_in_space_have_the_inertia_of_the_rigid_prism(A_GL, com):
    m, first, inertia = prism(A_GL, np.array(com))
    mass = se.spatial_mass_in_G(se.spatial_mass(LENGTH, RHO_A, *SECTION), A_GL)
    x = se.spatial_position_in_G(LENGTH, A_GL, np.array(com))
    along = np.tile(np.eye(3, 6), 2)
    assert along @ mass @ along.T == pytest.approx(m * np.eye(3), abs=1e-14 * m)
    assert se.spatial_first_moment(mass, x) == pytest.approx(first, abs=1e-14 * m)
    assert se.spatial_moment_of_inertia(mass, x) == pytest.approx(inertia, abs=1e-14 * m)


def test_eq_43_to_48_in_space_are_those_of_the_plane_for_a_planar_element():
    A_GL = rotation_matrix(rotation_about("z", THETA))
    x, planar = se.spatial_position_from_com(LENGTH, A_GL), be.planar_position_from_com(LENGTH, THETA)
    assert x[be.PLANAR_DOFS] == pytest.approx(planar, abs=1e-16)
    mass = se.spatial_mass_in_G(se.spatial_mass(LENGTH, RHO_A), A_GL)
    J = se.spatial_moment_of_inertia(mass, x)
    assert J[2, 2] == pytest.approx(be.planar_moment_of_inertia(mass_in_n(THETA), planar), rel=1e-14)
    # in space x^T M x is not an inertia: it is the trace of the second moments, half the trace of J
    assert x @ mass @ x == pytest.approx(0.5 * np.trace(J), rel=1e-14)
