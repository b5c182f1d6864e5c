"""Smooth parts and sharp edges of a surface of triangles, for its shading."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

SMOOTH = np.cos(np.radians(35.0))
"""Cosine of the angle between two triangles up to which their common edge is not drawn."""


class Shaded(NamedTuple):
    """Triangles with separate vertices on both sides of a sharp edge.

    Attributes
    ----------
    points : ndarray of int, shape (v,)
        The point of each vertex.
    triangles : ndarray of int, shape (m, 3)
        Numbers of vertices.
    creases : ndarray of int, shape (e, 2)
        Sharp edges and borders, by numbers of points.
    """

    points: np.ndarray
    triangles: np.ndarray
    creases: np.ndarray


def shaded(places: np.ndarray, triangles: np.ndarray) -> Shaded:
    """Return a surface of points (p, 3) with its vertices split at sharp edges.

    Examples
    --------
    >>> corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], dtype=float)
    >>> split = shaded(corners, np.array([(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]))
    >>> len(split.points), len(split.creases)
    (12, 6)
    """
    count = len(triangles)
    corner = np.arange(3 * count).reshape(-1, 3)
    normals = np.cross(
        places[triangles[:, 1]] - places[triangles[:, 0]], places[triangles[:, 2]] - places[triangles[:, 0]]
    )
    normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]
    starts, ends = triangles.T.ravel(), np.roll(triangles, -1, axis=1).T.ravel()
    at_start, at_end = corner.T.ravel(), np.roll(corner, -1, axis=1).T.ravel()
    is_turned = starts > ends
    low, high = np.where(is_turned, ends, starts), np.where(is_turned, starts, ends)
    at_low, at_high = np.where(is_turned, at_end, at_start), np.where(is_turned, at_start, at_end)
    owner = np.tile(np.arange(count), 3)
    order = np.lexsort((high, low))
    keys = np.column_stack((low, high))[order]
    first = np.flatnonzero(np.any(np.diff(keys, axis=0, prepend=-1), axis=1))
    sizes = np.diff(np.append(first, len(keys)))
    pairs = first[sizes == 2]
    one, two = order[pairs], order[pairs + 1]
    is_smooth = np.einsum("ij,ij->i", normals[owner[one]], normals[owner[two]]) > SMOOTH
    one, two = one[is_smooth], two[is_smooth]
    rows, columns = np.concatenate((at_low[one], at_high[one])), np.concatenate((at_low[two], at_high[two]))
    links = sp.coo_matrix((np.ones(len(rows)), (rows, columns)), (3 * count, 3 * count))
    vertices, label = connected_components(links, directed=False)
    points = np.empty(vertices, dtype=np.int64)
    points[label] = triangles.ravel()
    creases = keys[np.concatenate((first[sizes != 2], pairs[~is_smooth]))]
    return Shaded(points, label.reshape(-1, 3), creases)
