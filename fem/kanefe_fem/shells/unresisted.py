"""Motions in the surface of a cell that assumed strains do not see, and what the stress does on them.

With P2(x) = (3 x^2 - 1) / 2 the moments of the strains of ``x P2(y)``, ``y P2(x)`` and ``P2(x) P2(y)`` vanish, or
nearly so: alone the share of the membrane that is integrated in full resists them, which is small in cells that are
curved and thin. A compression would tip them long before the shell buckles. Its work on them is that of strains of
second order which the stiffness has not got, and is left out.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import scipy.sparse as sp

from kanefe.fe_model.block_diagonal import block_diagonal
from kanefe.fe_model.shapes import quadrature, shape

DEGREE = 7
"""Degree of quadrature: exact for the products of two gradients and a bilinear function."""


@lru_cache
def _motions() -> tuple[np.ndarray, np.ndarray]:
    """Return the amplitudes of the motions from values at nine nodes (3, 9), and the work of 11 forces (3, 3, 11)."""
    element = shape("quad9")
    powers = [np.polynomial.legendre.legvander(2.0 * element.nodes[:, a] - 1.0, 2) for a in (0, 1)]
    every = np.einsum("ni,nj->nij", *powers).reshape(9, 9)
    amplitudes = np.linalg.inv(every).reshape(3, 3, 9)[(1, 2, 2), (2, 1, 2)]
    points, weights = quadrature("quad9", DEGREE)
    x, y = 2.0 * points.T - 1.0
    P, slope = (1.5 * x**2 - 0.5, 1.5 * y**2 - 0.5), (3.0 * x, 3.0 * y)
    gradients = 2.0 * np.array(  # with respect to the reference cell, whose sides are from 0 to 1
        [[P[1], x * slope[1]], [y * slope[0], P[0]], [slope[0] * P[1], P[0] * slope[1]]]
    )
    bilinear = np.stack((np.ones_like(x), x, y, x * y))
    products = np.einsum("kap,lbp,fp,p->klabf", gradients, gradients, bilinear, weights)
    shear = products[:, :, 0, 1] + products[:, :, 1, 0]
    return amplitudes, np.concatenate((products[:, :, 0, 0], products[:, :, 1, 1], shear[..., :3]), axis=2)


def unresisted_work(cells: np.ndarray, nodes: np.ndarray, normals: np.ndarray, forces: np.ndarray) -> sp.csr_matrix:
    """Return the geometric stiffness of motions in the surface that assumed strains do not see, (6 n, 6 n).

    Motions are taken relative to the mean rotation of the cell, so that a rigid turn has none.

    Parameters
    ----------
    cells : ndarray of int, shape (m, 9)
    nodes : ndarray, shape (n, 3)
        In m.
    normals : ndarray, shape (m, 9, 3)
        At the nodes of the cells.
    forces : ndarray, shape (m, 11)
        Forces of the assumed strains on their moments, as of `kanefe_fem.shells.problem.ShellProblem.assumed`.
    """
    amplitudes, work = _motions()
    count = len(cells)
    normal = normals.mean(axis=1)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    flat = np.eye(3) - normal[:, :, None] * normal[:, None]
    of_places = np.einsum("kn,mni->mki", amplitudes, nodes[cells])
    turn = -np.cross(np.eye(3), of_places[:, :, None])  # (m, k, j, i): motion i of a rotation about j, reversed
    motion = np.zeros((count, 3, 3, 9, 6))
    motion[..., :3] = np.einsum("kn,mij->mkinj", amplitudes, flat)
    motion[..., 3:] = np.einsum("mil,mkjl->mkij", flat, turn)[:, :, :, None] / 9.0
    columns = (6 * cells[:, None, :, None] + np.arange(6)).reshape(count, 1, 54)
    rows = np.broadcast_to(np.arange(9 * count).reshape(count, 9, 1), (count, 9, 54))
    places = rows.ravel(), np.broadcast_to(columns, rows.shape).ravel()
    seen = sp.csr_matrix((motion.ravel(), places), shape=(9 * count, 6 * len(nodes)))
    own = np.einsum("mf,klf,ij->mkilj", forces, work, np.eye(3)).reshape(count, 9, 9)
    return (seen.T @ block_diagonal(own) @ seen).tocsr()
