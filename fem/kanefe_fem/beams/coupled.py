"""Interpolation in beam elements whose section couples stretch, shear, twist and bending.

Inside an unloaded element the section forces n are constant and the moments m linear, ``m' + e_x x n = 0``; the strains
are ``C (n, m)`` with the compliance C of the section, and their integrals

    theta' = kappa,    u' = gamma - e_x x theta

are a quadratic rotation and a cubic deflection. The motion of the ends determines both: static deflections under loads
at nodes are exact. For sections without coupling the interpolation is that of `elements.py` (compare Giavotto et al.,
"Anisotropic beam theory and applications", Comput. Struct. 16 (1983) 403-413, for sections by a 6 x 6 matrix).
"""

from __future__ import annotations

import numpy as np

_ACROSS = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""Matrix of the cross product with e_x."""


def coupled_polynomials(length: np.ndarray, stiffness: np.ndarray) -> np.ndarray:
    """Return N(xi) as `kanefe_fem.beams.elements.interpolation_polynomials` does, shape (m, 6, 12, 4).

    Parameters
    ----------
    length : ndarray, shape (m,)
        m.
    stiffness : ndarray, shape (m, 6, 6)
        Stiffness of the sections, in the order N, V_y, V_z, T, M_y, M_z; rows and columns of zeros where a theory has
        no strain.
    """
    a = length[:, None, None]
    C = _compliance(stiffness)
    of_strain, of_curvature = C[:, :3], C[:, 3:]
    # section forces (n, m) = (F0 + xi F1) z with z = (n, m at node 1)
    F0 = np.broadcast_to(np.eye(6), C.shape)
    F1 = np.zeros(C.shape)
    F1[:, 3:, :3] = -a * _ACROSS
    # motion = (1, xi, xi^2, xi^3) of z, and of the motion (u, theta) of node 1
    of_z = np.zeros((len(length), 6, 6, 4))
    of_z[:, 3:, :, 1] = a * of_curvature @ F0
    of_z[:, 3:, :, 2] = a / 2.0 * of_curvature @ F1
    of_z[:, :3, :, 1] = a * of_strain @ F0
    of_z[:, :3, :, 2] = a / 2.0 * of_strain @ F1 - a**2 / 2.0 * _ACROSS @ of_curvature @ F0
    of_z[:, :3, :, 3] = -(a**2) / 6.0 * _ACROSS @ of_curvature @ F1
    of_first = np.zeros((len(length), 6, 6, 4))
    of_first[..., 0] = np.eye(6)
    of_first[:, :3, 3:, 1] = -a * _ACROSS

    across = F0 - F1  # z from the forces at node 2, by which the flexibility of the element is symmetric
    flexibility = of_z.sum(axis=-1) @ across
    size = np.sqrt(np.diagonal(flexibility, axis1=1, axis2=2))
    scale = size[:, :, None] * size[:, None, :]
    identity = np.broadcast_to(np.eye(6), C.shape)
    inverse = np.linalg.solve(flexibility / scale, identity) / scale
    of_ends = across @ inverse @ np.concatenate((-of_first.sum(axis=-1), identity), axis=2)  # z from both ends
    N = np.einsum("mijk,mjl->milk", of_z, of_ends)
    N[:, :, :6] += of_first
    return N


def _compliance(stiffness: np.ndarray) -> np.ndarray:
    """Return the inverse of the stiffness over the strains of the theory; zero for the others."""
    C = np.zeros(stiffness.shape)
    exists = np.diagonal(stiffness, axis1=1, axis2=2) != 0.0
    for pattern in np.unique(exists, axis=0):
        members, kept = np.flatnonzero((exists == pattern).all(axis=1)), np.flatnonzero(pattern)
        D = stiffness[np.ix_(members, kept, kept)]
        size = np.sqrt(np.diagonal(D, axis1=1, axis2=2))
        scale = size[:, :, None] * size[:, None, :]
        C[np.ix_(members, kept, kept)] = np.linalg.inv(D / scale) / scale
    return C
