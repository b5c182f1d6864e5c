"""The paper's element in space: the 12-dof counterparts of Eq. 41-48, with exact rigid-body inertia.

In the plane ``x^T M x`` is the moment of inertia, because the position turned by a right angle is a motion of the
element. In space there is one such motion for each axis a, ``R_a = (e_a x r_1, e_a, e_a x r_2, e_a)``, in which the
sections turn with the element, and the inertia is the matrix ``R^T M R``. It is exact since rigid motions are among
those that the element interpolates; of an elastically bent element only its chord is exact, which is why bodies
integrate their displacement field (`kanefe_fem.beams.mass`) instead.
"""

from __future__ import annotations

import numpy as np

from kanefe.frames import skew
from kanefe_fem.beams.elements import spatial_transformation

BENDING = np.array([[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]]) / 420.0
"""Translational inertia of bending over that of the element, rotations in lengths of it: (v, theta) of both nodes."""

TILTING = np.array([[36, 3, -36, 3], [3, 4, -3, -1], [-36, -3, 36, -3], [3, -1, -3, 4]]) / 30.0
"""Rotary inertia of bending over that of the sections per length, rotations in lengths of the element."""


def spatial_mass(length: float, rho_A: float, rho_I_y: float = 0.0, rho_I_z: float = 0.0) -> np.ndarray:
    """Return the consistent mass matrix of the spatial Euler-Bernoulli element in L (Eq. 41 in space).

    Przemieniecki, "Theory of Matrix Structural Analysis", 1968, section 11.4: Eq. 41 in both planes, with stretch and
    twist, and with the rotary inertia of the sections, without which a turn about the axis has none.

    Parameters
    ----------
    length : float
        l in m.
    rho_A : float
        Mass per length, kg/m.
    rho_I_y, rho_I_z : float
        Rotary inertia of the section about its axes y and z, per length, kg m.

    Returns
    -------
    ndarray, shape (12, 12)
        In kg, kg m and kg m2.
    """
    M, line = np.zeros((12, 12)), np.array([[2.0, 1.0], [1.0, 2.0]]) * length / 6.0
    M[np.ix_([0, 6], [0, 6])] = rho_A * line
    M[np.ix_([3, 9], [3, 9])] = (rho_I_y + rho_I_z) * line
    # in the x-z plane a positive slope dw/dx is a rotation by -theta_y
    for dofs, turned, rho_I in (([1, 5, 7, 11], 1.0, rho_I_z), ([2, 4, 8, 10], -1.0, rho_I_y)):
        arms = np.array([1.0, turned * length, 1.0, turned * length])
        M[np.ix_(dofs, dofs)] = np.outer(arms, arms) * (rho_A * length * BENDING + rho_I / length * TILTING)
    return M


def spatial_position_from_com(length: float, A_GL: np.ndarray) -> np.ndarray:
    """Return the position of a spatial element's nodes from its centre of mass (Eq. 43 and 44 in space).

    Parameters
    ----------
    length : float
        In m.
    A_GL : ndarray, shape (3, 3)
        Axes of the element as columns, in G; the identity gives Eq. 43.

    Returns
    -------
    ndarray, shape (12,)
        (x, y, z, 0, 0, 0) of node 1, then of node 2, in m.
    """
    half = 0.5 * length * np.asarray(A_GL)[:, 0]
    return np.concatenate([-half, np.zeros(3), half, np.zeros(3)])


def spatial_position_in_G(length: float, A_GL: np.ndarray, com: np.ndarray) -> np.ndarray:
    """Return the position of a spatial element's nodes from the origin of G (Eq. 47 in space).

    Parameters
    ----------
    length, A_GL
        As for `spatial_position_from_com`.
    com : ndarray, shape (3,)
        Centre of mass in G, m.
    """
    return spatial_position_from_com(length, A_GL) + np.concatenate([com, np.zeros(3), com, np.zeros(3)])


def spatial_mass_in_G(mass_L: np.ndarray, A_GL: np.ndarray) -> np.ndarray:
    """Return the mass matrix of a spatial element in the axes of G, ``T^T M_L T``, shape (12, 12) (Eq. 42 in space)."""
    T = spatial_transformation(np.asarray(A_GL)[None])[0]
    return np.asarray(T.T @ mass_L @ T)


def spatial_first_moment(mass_n: np.ndarray, position: np.ndarray) -> np.ndarray:
    """Return the first moment of mass about the origin of `position`, kg m, shape (3,) (Eq. 46 in space).

    Parameters
    ----------
    mass_n : ndarray, shape (12, 12)
        Mass matrix in the axes of G.
    position : ndarray, shape (12,)
        From `spatial_position_from_com` or `spatial_position_in_G`.

    Examples
    --------
    >>> M = spatial_mass(2.0, 3.0)
    >>> spatial_first_moment(M, spatial_position_in_G(2.0, np.eye(3), np.array([1.0, 2.0, 0.5])))
    array([ 6., 12.,  3.])
    """
    return (mass_n @ position).reshape(2, 6)[:, :3].sum(axis=0)


def spatial_moment_of_inertia(mass_n: np.ndarray, position: np.ndarray) -> np.ndarray:
    """Return ``R^T M R``, the inertia about the origin of `position`, kg m2, shape (3, 3) (Eq. 45 and 48 in space).

    Parameters
    ----------
    mass_n, position
        As for `spatial_first_moment`.
    """
    R = np.vstack([block for node in position.reshape(2, 6) for block in (-skew(node[:3]), np.eye(3))])
    return np.asarray(R.T @ mass_n @ R)
