"""Strains of Lagrange cells from the displacements of their nodes, with numpy: ``e = sym(grad u)`` at sample points.

Stresses are most accurate at the points of a reduced Gauss rule (Barlow 1976, "Optimal stress locations in finite
element models", Int. J. Numer. Meth. Engng 10: 243-251). So they are evaluated there and extrapolated to the nodes of
the cell by polynomials of order 1, which is exact for a linear strain in a straight cell of order 2.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from kanefe.fe_model.shapes import kind_of_order, shape

_SIMPLEX_GAUSS = {2: (2.0 / 3.0, 1.0 / 6.0), 3: (0.5854101966249685, 0.1381966011250105)}
"""Barycentric coordinates (own corner, other corners) of the rule of degree 2 with one point per corner."""


@dataclass(frozen=True, eq=False)
class Samples:
    """The points at which strains of a shape are evaluated.

    Attributes
    ----------
    points : ndarray, shape (p, dimension)
        Reference coordinates.
    to_nodes : ndarray, shape (nodes per cell, p)
        Matrix that takes values at the points to values at the nodes of the cell.
    """

    points: np.ndarray
    to_nodes: np.ndarray


@cache
def gauss_samples(kind: str) -> Samples:
    """Return the points of the most accurate stresses: one per corner, or the centre where the strain is constant."""
    element = shape(kind)
    d = element.dimension
    if element.is_simplex and element.order == 1:
        return Samples(centroid(kind), np.ones((len(element.nodes), 1)))
    corners = shape(kind_of_order(kind, 1))
    if element.is_simplex:
        own, other = _SIMPLEX_GAUSS[d]
        barycentric = other + (own - other) * np.eye(d + 1)
        points = barycentric @ corners.nodes
    elif element.corner_kind == "pyramid":
        points = 0.5 * (corners.nodes + centroid(kind))
    else:
        points = 0.5 + (corners.nodes - 0.5) / np.sqrt(3.0)
        if element.corner_kind == "wedge":
            points[:, :2] = 1.0 / 3.0 + (corners.nodes[:, :2] - 1.0 / 3.0) / 2.0  # the rule of the triangle
    to_nodes = corners.values(element.nodes) @ np.linalg.inv(corners.values(points))
    return Samples(points, to_nodes)


def centroid(kind: str) -> np.ndarray:
    """Return the reference coordinates of the centre, shape (1, dimension)."""
    element = shape(kind)
    return element.nodes[: element.corners].mean(axis=0)[None]


def strains(kind: str, x: np.ndarray, u: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return the strains of cells at reference points.

    Parameters
    ----------
    kind : str
        Shape of the cells.
    x : ndarray, shape (m, nodes per cell, 3)
        Coordinates of their nodes in m; z is ignored for a plane shape.
    u : ndarray, shape (m, nodes per cell, 3, c)
        Displacements of the nodes in m, c columns.
    points : ndarray, shape (p, dimension)
        Reference coordinates.

    Returns
    -------
    ndarray, shape (m, p, 6, c)
        xx, yy, zz, yz, xz, xy with engineering shears; for a plane shape all but xx, yy and xy are zero.
    """
    element = shape(kind)
    d, columns = element.dimension, u.shape[3]
    plane_u = np.ascontiguousarray(u[:, :, :d]).reshape(len(x), len(element.nodes), d * columns)
    result = np.zeros((len(x), len(points), 6, columns))
    for p, gradient in enumerate(element.gradients(points)):
        jacobian = np.swapaxes(x[:, :, :d], 1, 2) @ gradient  # dx/ds
        by_x = gradient @ np.linalg.inv(jacobian)  # dN/dx
        H = (np.swapaxes(by_x, 1, 2) @ plane_u).reshape(len(x), d, d, columns)  # H[a, b] = d u_b / d x_a
        for a in range(d):
            result[:, p, a] = H[:, a, a]
        result[:, p, 5] = H[:, 0, 1] + H[:, 1, 0]
        if d == 3:
            result[:, p, 3] = H[:, 1, 2] + H[:, 2, 1]
            result[:, p, 4] = H[:, 0, 2] + H[:, 2, 0]
    return result
