"""Assumed membrane strains of quadrangles, which do not lock where the surface is curved, also in distorted cells.

Displacements of second order cannot bend a curved or warped cell without stretching it somewhere. The strains along the
edges of the reference cell are replaced by their projections on few functions: bilinear ones for the stretches 11 and
22, linear ones for the shear 12 (in the manner of mixed interpolation of tensorial components: Bucalem and Bathe, Int.
J. Numer. Methods Eng. 36 (1993) 3729). Since these are components along the edges, the order of the nodes changes
nothing.
"""

from __future__ import annotations

import numpy as np

from kanefe.fe_model.shapes import quadrature, shape

SQUARES = np.array([1.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 9.0])
"""Integrals of the squares of 1, x, y and x y over the reference cell, x and y from -1 to 1 on it, area 1."""

FIELDS = np.concatenate((SQUARES, SQUARES, SQUARES[:3]))
"""Integrals of the squares of the functions of 11, 22 and 12 over the reference cell."""

DEGREE = 5
"""Degree of quadrature of the energy: three by three points."""


def energy_of_moments(
    corners: np.ndarray, axes: np.ndarray, thickness: np.ndarray, modulus: np.ndarray, power: int
) -> np.ndarray:
    """Return the energy of assumed strains from the moments of the true ones, shape (m, 11, 11).

    Parameters
    ----------
    corners : ndarray, shape (m, 9, 3)
        Nodes of the cells in m.
    axes : ndarray, shape (m, 3)
        Direction whose part in the surface is the first axis of the modulus.
    thickness : ndarray, shape (m, 9)
        At the nodes, m.
    modulus : ndarray, shape (m, 3, 3)
        A1 or B1 in Pa.
    power : int
        Power of the thickness by which it is multiplied: 1 or 2.
    """
    element = shape("quad9")
    points, weights = quadrature("quad9", DEGREE)
    J = np.einsum("pna,mni->mpia", element.gradients(points), corners)
    normal = np.cross(J[..., 0], J[..., 1])
    stretch = np.linalg.norm(normal, axis=2)
    normal /= stretch[..., None]
    first = axes[:, None] - np.einsum("mi,mpi->mp", axes, normal)[..., None] * normal
    first /= np.linalg.norm(first, axis=2)[..., None]
    inverse = np.linalg.inv(np.stack((first, np.cross(normal, first)), axis=2) @ J)
    a, b, c, d = (inverse[..., i, j] for i in range(2) for j in range(2))
    # strains in the axes from those along the edges of the reference cell
    T = np.stack(
        (
            np.stack((a * a, c * c, a * c), axis=-1),
            np.stack((b * b, d * d, b * d), axis=-1),
            np.stack((2.0 * a * b, 2.0 * c * d, a * d + b * c), axis=-1),
        ),
        axis=-2,
    )
    x, y = 2.0 * points.T - 1.0
    bilinear = np.stack((np.ones_like(x), x, y, x * y), axis=1)
    functions = np.zeros((len(points), 3, 11))
    functions[:, 0, :4], functions[:, 1, 4:8], functions[:, 2, 8:] = bilinear, bilinear, bilinear[:, :3]
    strains = T @ (functions / FIELDS)
    scale = weights * stretch * (thickness @ element.values(points).T) ** power
    return np.asarray(np.einsum("mp,mpsf,mst,mptg->mfg", scale, strains, modulus, strains, optimize=True))
