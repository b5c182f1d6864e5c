"""Matrices of one straight beam element: planar (6 degrees of freedom) and spatial (12).

Local axes L: x along the axis from node 1 to node 2, y and z across. The degrees of freedom of a node are
(u, v, theta_z) in the plane and (u, v, w, theta_x, theta_y, theta_z) in space; node 1 comes first.

The paper's planar element (Eq. 40-48) comes first, as printed or corrected; then the general one, for both theories,
which interpolates displacement and rotation of the sections by the exact solution of an unloaded Timoshenko beam (as
Przemieniecki, "Theory of Matrix Structural Analysis", 1968, and Friedman & Kosmatka, Comput. Struct. 47 (1993)
473-481): cubic deflection, quadratic rotation, constant shear strain. With the shear parameter
``Phi = 12 E I / (kappa G A l^2)`` set to zero it is the Hermite element of Euler and Bernoulli.
"""

from __future__ import annotations

import numpy as np

from kanefe_fem.beams.coupled import coupled_polynomials
from kanefe_fem.beams.properties import ElementProperties

PLANAR_ROWS = [0, 1, 5]
"""Components of a section's motion (u, v, theta_z) that a planar element keeps."""

PLANAR_DOFS = [0, 1, 5, 6, 7, 11]
"""Degrees of freedom of the spatial element that the planar element keeps."""


def planar_strain_displacement(x: float, length: float) -> np.ndarray:
    """Return the strain-displacement matrix B of the planar Hermite element (Eq. 40, corrected).

    Row 1 is the axial strain, row 2 the curvature. The print calls it the shape function, and lacks the factor x in
    the columns of the two rotations: as printed, a rigid rotation would bend the beam.

    Parameters
    ----------
    x : float
        Station on the axis, 0 at node 1, in m.
    length : float
        Length l of the element in m.

    Returns
    -------
    ndarray, shape (2, 6)
        In 1/m (translations), and 1 (rotations) per m for the curvature.
    """
    a = length
    return np.array(
        [
            [-1.0 / a, 0.0, 0.0, 1.0 / a, 0.0, 0.0],
            [
                0.0,
                -6.0 / a**2 + 12.0 * x / a**3,
                -4.0 / a + 6.0 * x / a**2,
                0.0,
                6.0 / a**2 - 12.0 * x / a**3,
                -2.0 / a + 6.0 * x / a**2,
            ],
        ]
    )


def planar_stiffness(length: float, EA: float, EI: float) -> np.ndarray:
    """Return the planar Euler-Bernoulli stiffness matrix ``int B^T diag(EA, EI) B dx`` in L, with B of Eq. 40.

    Parameters
    ----------
    length : float
        In m.
    EA, EI : float
        Axial stiffness in N and bending stiffness in N m2.

    Returns
    -------
    ndarray, shape (6, 6)
        In N/m, N and N m.
    """
    stations, weights = gauss_stations(2)  # exact: the integrand is quadratic in x
    total = np.zeros((6, 6))
    for xi, weight in zip(stations, weights, strict=True):
        strain = planar_strain_displacement(xi * length, length)
        total += weight * length * strain.T @ np.diag([EA, EI]) @ strain
    return total


def planar_mass(length: float, mass_per_length: float) -> np.ndarray:
    """Return the planar consistent mass matrix in L, without rotary inertia (Eq. 41).

    Parameters
    ----------
    length : float
        l in m.
    mass_per_length : float
        rho A in kg/m.

    Returns
    -------
    ndarray, shape (6, 6)
        In kg, kg m and kg m2.
    """
    a = length
    return (
        mass_per_length
        * a
        / 420.0
        * np.array(
            [
                [140.0, 0.0, 0.0, 70.0, 0.0, 0.0],
                [0.0, 156.0, 22.0 * a, 0.0, 54.0, -13.0 * a],
                [0.0, 22.0 * a, 4.0 * a**2, 0.0, 13.0 * a, -3.0 * a**2],
                [70.0, 0.0, 0.0, 140.0, 0.0, 0.0],
                [0.0, 54.0, 13.0 * a, 0.0, 156.0, -22.0 * a],
                [0.0, -13.0 * a, -3.0 * a**2, 0.0, -22.0 * a, 4.0 * a**2],
            ]
        )
    )


def planar_transformation(theta: float) -> np.ndarray:
    """Return T_L<-n, which takes the planar degrees of freedom from the axes of G to those of the beam (Eq. 42).

    Parameters
    ----------
    theta : float
        Angle of the beam's axis in G in rad.

    Returns
    -------
    ndarray, shape (6, 6)
        Orthogonal.
    """
    c, s = np.cos(theta), np.sin(theta)
    node = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    return np.kron(np.eye(2), node)


def rotate_element_matrix(matrix_L: np.ndarray, T_Ln: np.ndarray) -> np.ndarray:
    """Return an element matrix in the axes of G: ``T^T M_L T`` (Eq. 42).

    Parameters
    ----------
    matrix_L : ndarray, shape (..., d, d)
        Mass or stiffness in L.
    T_Ln : ndarray, shape (..., d, d)
        From `planar_transformation` or `spatial_transformation`.

    Returns
    -------
    ndarray, shape (..., d, d)
        The matrix in G.
    """
    return np.swapaxes(T_Ln, -1, -2) @ matrix_L @ T_Ln


def planar_position_from_com(length: float, theta: float = 0.0) -> np.ndarray:
    """Return the position of a planar element's nodes from its centre of mass (Eq. 43 for theta = 0, Eq. 44).

    Parameters
    ----------
    length : float
        In m.
    theta : float
        Angle of the axis in rad.

    Returns
    -------
    ndarray, shape (6,)
        (x, y, 0) of node 1, then of node 2, in m.
    """
    c, s = 0.5 * length * np.cos(theta), 0.5 * length * np.sin(theta)
    return np.array([-c, -s, 0.0, c, s, 0.0])


def planar_position_in_G(length: float, theta: float, r: float, phi: float) -> np.ndarray:
    """Return the position of a planar element's nodes from the origin of G (Eq. 47).

    Parameters
    ----------
    length, theta : float
        Length in m and angle of the axis in rad.
    r, phi : float
        Polar coordinates of the centre of mass in m and rad.

    Returns
    -------
    ndarray, shape (6,)
        (x, y, 0) of node 1, then of node 2, in m.
    """
    com = r * np.array([np.cos(phi), np.sin(phi), 0.0])
    return planar_position_from_com(length, theta) + np.tile(com, 2)


def planar_moment_of_inertia(mass_n: np.ndarray, position: np.ndarray) -> float:
    """Return ``x^T M x``, the moment of inertia about the origin of `position` in kg m2 (Eq. 45, Eq. 48).

    Parameters
    ----------
    mass_n : ndarray, shape (6, 6)
        Mass matrix in the axes of G.
    position : ndarray, shape (6,)
        From `planar_position_from_com` or `planar_position_in_G`.
    """
    return float(position @ mass_n @ position)


def planar_first_moment(mass_n: np.ndarray, position: np.ndarray) -> np.ndarray:
    """Return the first moment of mass about the origin of `position` in kg m, shape (2,) (Eq. 46).

    Eq. 46 writes ``M x = 0``. It holds for the resultant, the sum over both nodes of the rows of each direction; the
    rows themselves are -m l/12 and m l/12.

    Parameters
    ----------
    mass_n : ndarray, shape (6, 6)
        Mass matrix in the axes of G.
    position : ndarray, shape (6,)
        From `planar_position_from_com` or `planar_position_in_G`.
    """
    return (mass_n @ position).reshape(2, 3)[:, :2].sum(axis=0)


def gauss_stations(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return Gauss-Legendre stations and weights on (0, 1), each of shape (count,)."""
    x, w = np.polynomial.legendre.leggauss(count)
    return 0.5 * (x + 1.0), 0.5 * w


def interpolation_polynomials(properties: ElementProperties) -> np.ndarray:
    """Return N(xi) as polynomials in xi = x/l: motion of the sections from the element's degrees of freedom.

    Parameters
    ----------
    properties : ElementProperties
        m elements.

    Returns
    -------
    ndarray, shape (m, 6, 12, 4)
        Coefficients of 1, xi, xi^2, xi^3. The six rows are the displacement (u, v, w) of the axis and the small
        rotation (theta_x, theta_y, theta_z) of the section, in L.
    """
    a = properties.length
    N = np.zeros((len(a), 6, 12, 4))
    N[:, [0, 3], [0, 3], :2] = [1.0, -1.0]  # stretch and twist: linear
    N[:, [0, 3], [6, 9], 1] = 1.0
    in_xy, in_xz = _bending_polynomials(a, properties.phi_y), _bending_polynomials(a, properties.phi_z)
    N[:, [[1], [5]], [1, 5, 7, 11]] = in_xy
    # in the x-z plane a positive slope dw/dx is a rotation of the section by -theta_y
    sign = np.array([1.0, -1.0])
    N[:, [[2], [4]], [2, 4, 8, 10]] = in_xz * (sign[:, None] * np.tile(sign, 2))[None, :, :, None]
    coupled = properties.coupled
    if coupled.size:
        N[coupled] = coupled_polynomials(a[coupled], properties.matrices[coupled])
    return N


def _bending_polynomials(length: np.ndarray, phi: np.ndarray) -> np.ndarray:
    """Return deflection and rotation from (v1, theta1, v2, theta2), shape (m, 2, 4, 4), coefficients of xi last."""
    a, s, zero, one = length, phi, np.zeros_like(phi), np.ones_like(phi)
    deflection = [
        [1.0 + s, -s, -3.0 * one, 2.0 * one],
        [zero, a * (1.0 + 0.5 * s), -a * (2.0 + 0.5 * s), a],
        [zero, s, 3.0 * one, -2.0 * one],
        [zero, -0.5 * a * s, a * (0.5 * s - 1.0), a],
    ]
    rotation = [
        [zero, -6.0 / a, 6.0 / a, zero],
        [1.0 + s, -(4.0 + s), 3.0 * one, zero],
        [zero, 6.0 / a, -6.0 / a, zero],
        [zero, s - 2.0, 3.0 * one, zero],
    ]
    return np.moveaxis(np.array([deflection, rotation]), -1, 0) / (1.0 + phi)[:, None, None, None]


def interpolation(properties: ElementProperties, xi: np.ndarray) -> np.ndarray:
    """Return N(xi): displacement and small rotation of the sections at stations of each element.

    Parameters
    ----------
    properties : ElementProperties
        m elements.
    xi : ndarray, shape (g,)
        Stations x/l in [0, 1].

    Returns
    -------
    ndarray, shape (m, g, 6, 12)
        In L.
    """
    powers = np.vander(np.asarray(xi, dtype=float), 4, increasing=True)
    return np.einsum("mijk,gk->mgij", interpolation_polynomials(properties), powers)


def strain_displacement(properties: ElementProperties, xi: np.ndarray) -> np.ndarray:
    """Return B(xi), the spatial form of Eq. 40: strains of the sections from the element's degrees of freedom.

    Parameters
    ----------
    properties : ElementProperties
        m elements.
    xi : ndarray, shape (g,)
        Stations x/l in [0, 1].

    Returns
    -------
    ndarray, shape (m, g, 6, 12)
        Rows: axial strain, shear strains along y and z, twist rate, curvatures about y and z.
    """
    xi = np.asarray(xi, dtype=float)
    N = interpolation_polynomials(properties)
    slope_powers = np.column_stack([np.zeros_like(xi), np.ones_like(xi), 2.0 * xi, 3.0 * xi**2])
    B = np.einsum("mijk,gk->mgij", N, slope_powers) / properties.length[:, None, None, None]
    rotation = np.einsum("mijk,gk->mgij", N[:, 4:6], np.vander(xi, 4, increasing=True))
    B[:, :, 1] -= rotation[:, :, 1]  # gamma_y = v' - theta_z
    B[:, :, 2] += rotation[:, :, 0]  # gamma_z = w' + theta_y
    return B


def spatial_stiffness(properties: ElementProperties) -> np.ndarray:
    """Return the stiffness matrices in L, ``int B^T D B dx``, shape (m, 12, 12) (after Eq. 40).

    Parameters
    ----------
    properties : ElementProperties
        m elements of either theory.
    """
    stations, weights = gauss_stations(2)  # exact: curvatures are linear in xi
    B = strain_displacement(properties, stations)
    D = (weights[None, :] * properties.length[:, None])[..., None, None] * properties.matrices[:, None]
    K = np.einsum("mgia,mgib->mab", B, D @ B)
    return 0.5 * (K + np.swapaxes(K, 1, 2))


def spatial_transformation(A_GL: np.ndarray) -> np.ndarray:
    """Return T_L<-n of spatial elements (Eq. 42 in space).

    Parameters
    ----------
    A_GL : ndarray, shape (m, 3, 3)
        Local axes as columns, in G.

    Returns
    -------
    ndarray, shape (m, 12, 12)
        Takes the degrees of freedom from the axes of G to those of the elements.
    """
    T = np.zeros((len(A_GL), 12, 12))
    for start in range(0, 12, 3):
        T[:, start : start + 3, start : start + 3] = np.swapaxes(A_GL, 1, 2)
    return T
