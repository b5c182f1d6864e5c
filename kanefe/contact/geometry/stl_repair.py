"""Closed surfaces of STL files, whose triangles have vertices of their own, with round-off, and may have no area."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kanefe.frames import Matrix

Corners = Sequence[int]

FLAT = 1e-12
"""Area, relative to the square of the longest side, below which a triangle has no area."""


def are_flat(corners: np.ndarray) -> np.ndarray:
    """Return which of some triangles (m, 3, 3) have no area."""
    sides = corners - np.roll(corners, -1, axis=1)
    areas = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    flat: np.ndarray = areas <= FLAT * np.max(np.sum(sides**2, axis=2), axis=1)
    return flat


def together(corners: Matrix) -> tuple[Matrix, np.ndarray]:
    """Return vertices (n, 3) and triangles (m, 3) of corners (3 m, 3); those that are equal are one.

    If the surface is open then, those are one that are equal to round-off: two copies of a vertex, each rounded to
    single precision after a turn or a shift, differ by one step of such numbers at the largest coordinate.
    """
    vertices, where = np.unique(corners, axis=0, return_inverse=True)
    triangles = where.reshape(-1, 3)
    largest = np.abs(vertices).max()
    if _is_closed(triangles) or not np.isfinite(largest):
        return vertices, triangles
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    near = cKDTree(vertices).query_pairs(np.spacing(np.float32(largest)), p=np.inf, output_type="ndarray")
    links = coo_array((np.ones(len(near)), (near[:, 0], near[:, 1])), shape=(len(vertices), len(vertices)))
    groups = connected_components(links, directed=False)[1]
    _, first, number = np.unique(groups, return_index=True, return_inverse=True)
    return vertices[first], number.reshape(-1)[triangles]


def _is_closed(triangles: np.ndarray) -> bool:
    """Return whether each edge of a surface is there the other way round."""
    edges = np.unique(np.concatenate([triangles[:, pair] for pair in ((0, 1), (1, 2), (2, 0))]), axis=0)
    return len(np.unique(np.concatenate((edges, edges[:, ::-1])), axis=0)) == len(edges)


def without_flat(vertices: Matrix, triangles: np.ndarray) -> np.ndarray:
    """Return the triangles (m, 3) of a surface that have an area, which is closed where it was closed before.

    One with two equal vertices is left out. One whose vertices lie on a line has its middle vertex on the side of its
    neighbour, which is cut in two there.
    """
    a, b, c = triangles.T
    triangles = triangles[(a != b) & (b != c) & (c != a)]
    left = np.flatnonzero(are_flat(vertices[triangles])).tolist()
    if not left:
        return triangles
    made: dict[int, Corners] = dict(enumerate(triangles.tolist()))
    beside = {side: number for number, corners in made.items() for side in _sides(corners)}
    for _ in range(len(made)):  # a cut leaves shorter triangles behind, so that this ends long before
        if not left:
            break
        number = left.pop()
        start, end, middle = _longest_first(vertices, made.pop(number))
        other = beside.get((end, start), -1)
        if other not in made:  # the surface is open here
            continue
        far = next(corner for corner in made.pop(other) if corner not in (start, end))
        left = [place for place in left if place != other]
        if far == middle:  # two on each other
            continue
        for place, cut in ((number, (end, middle, far)), (other, (middle, start, far))):
            made[place] = cut
            beside |= dict.fromkeys(_sides(cut), place)
            if are_flat(vertices[np.array([cut])])[0]:
                left.append(place)
    return np.array(list(made.values()), dtype=np.int64).reshape(-1, 3)


def _sides(corners: Corners) -> tuple[tuple[int, int], ...]:
    a, b, c = corners
    return (a, b), (b, c), (c, a)


def _longest_first(vertices: Matrix, corners: Corners) -> tuple[int, int, int]:
    """Return the ends of the longest side of a triangle, and its other vertex."""
    a, b, c = corners
    turns = (a, b, c), (b, c, a), (c, a, b)
    return max(turns, key=lambda turn: float(np.linalg.norm(vertices[turn[1]] - vertices[turn[0]])))
