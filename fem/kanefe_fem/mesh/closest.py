"""Closest points on the facets of a skin, with the shape functions there."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from scipy.spatial import cKDTree

from kanefe.fe_model.model import Cells
from kanefe.fe_model.shapes import Shape, shape

CANDIDATES = 8
"""Number of facets, by the distance of their middles, on which the closest point is sought."""

ITERATIONS = 12
"""Largest number of steps of the search on a facet; flat ones need one."""


class OnFacets(NamedTuple):
    """Points on facets.

    Attributes
    ----------
    shares : csr_matrix, shape (k, n)
        Shape functions of the nodes there, one row a point.
    distance : ndarray, shape (k,)
        From the points that were asked for, m.
    """

    shares: sp.csr_matrix
    distance: np.ndarray


def closest_points(nodes: np.ndarray, facets: Sequence[Cells], points: np.ndarray) -> OnFacets:
    """Return the closest points of facets to given points.

    Parameters
    ----------
    nodes : ndarray, shape (n, 3)
        m.
    facets : sequence of Cells
    points : ndarray, shape (k, 3)
        m.
    """
    best = np.full(len(points), np.inf)
    columns = np.zeros((len(points), 9), dtype=np.int64)
    values = np.zeros((len(points), 9))
    for block in facets:
        element = shape(block.kind)
        corners = nodes[block.nodes]
        middles = corners[:, : element.corners].mean(axis=1)
        count = min(CANDIDATES, len(middles))
        near = cKDTree(middles).query(points, count)[1].reshape(len(points), count)
        for which in near.T:
            N, distance = _closest(element, corners[which], points)
            better = distance < best
            best[better] = distance[better]
            columns[better], values[better] = 0, 0.0
            columns[better, : N.shape[1]], values[better, : N.shape[1]] = block.nodes[which[better]], N[better]
    rows = np.repeat(np.arange(len(points)), 9)
    return OnFacets(sp.csr_matrix((values.ravel(), (rows, columns.ravel())), (len(points), len(nodes))), best)


def _closest(element: Shape, corners: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return shape functions and distances of the closest points on one facet each, by Gauss and Newton's method."""
    xi = np.tile(element.nodes[: element.corners].mean(axis=0), (len(points), 1))
    for _ in range(ITERATIONS):
        N, gradients = element.values(xi), element.gradients(xi)
        left = points - np.einsum("pn,pni->pi", N, corners)
        J = np.einsum("pna,pni->pia", gradients, corners)
        step = np.linalg.solve(J.swapaxes(1, 2) @ J, (J.swapaxes(1, 2) @ left[:, :, None]))[:, :, 0]
        moved = _inside(element, xi + step)
        if np.abs(moved - xi).max(initial=0.0) < 1e-13:
            break
        xi = moved
    N = element.values(xi)
    return N, np.linalg.norm(points - np.einsum("pn,pni->pi", N, corners), axis=1)


def _inside(element: Shape, xi: np.ndarray) -> np.ndarray:
    """Return the nearest coordinates within the reference shape."""
    if not element.is_simplex:
        return np.clip(xi, 0.0, 1.0)
    over = np.maximum(xi.sum(axis=1) - 1.0, 0.0)
    xi = np.maximum(xi - 0.5 * over[:, None], 0.0)
    return np.asarray(xi / np.maximum(xi.sum(axis=1), 1.0)[:, None])
