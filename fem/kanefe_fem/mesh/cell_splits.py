"""How a cell of each shape is split into smaller ones, by the places of their corners on its reference element.

Simplices and cubes are cut in half along each side. The octahedron that this leaves inside a tetrahedron is cut along
one of its three diagonals; the shortest gives the best cells (Bey 1995, "Tetrahedral grid refinement"; Zhang 1995). A
pyramid gives six pyramids, one of them upside down, and four tetrahedra between them.
"""

from __future__ import annotations

from functools import cache
from itertools import product
from typing import NamedTuple

import numpy as np

from kanefe.fe_model.shapes import corner_kind, kind_of_order, shape

PER_SIDE = 8
"""Number of parts of a side of the reference element that all new nodes lie between, with room: quarters are used."""

DIAGONALS = (((0, 1), (2, 3)), ((0, 2), (1, 3)), ((0, 3), (1, 2)))
"""Sides of a tetrahedron, by the numbers of their corners, whose middles each diagonal of its middle joins."""


class Split(NamedTuple):
    """How a cell is split.

    Attributes
    ----------
    places : ndarray, shape (places, dimension)
        Of the nodes of its parts on the reference element, each once; those of the cell itself come first.
    parts : tuple of (str, ndarray of int)
        Shape of some parts, and which of the places their nodes are, (parts, nodes per part).
    """

    places: np.ndarray
    parts: tuple[tuple[str, np.ndarray], ...]


@cache
def split_cell(kind: str, diagonal: int = 0) -> Split:
    """Return the parts of a cell of this shape, of the same order; all are positive if it is.

    Parameters
    ----------
    kind : str
    diagonal : int
        Of a tetrahedron: along which of `DIAGONALS` its middle is cut.
    """
    corners = corner_kind(kind)
    parts: list[tuple[str, np.ndarray]]
    if corners == "tetra":
        parts = [("tetra", _tetrahedra(diagonal))]
    elif corners == "pyramid":
        parts = _of_pyramid()
    elif corners == "wedge":
        parts = [("wedge", _wedges())]
    elif corners == "triangle":
        parts = [("triangle", _triangles())]
    else:
        own = shape(corners).nodes
        shifts = product((0.0, 0.5), repeat=own.shape[1])
        parts = [(corners, np.array([0.5 * own + shift for shift in shifts]))]
    element, found = shape(kind), []
    for child, ends in parts:
        same = kind if child == corners else kind_of_order(child, element.order)
        nodes = np.einsum("nc,mcd->mnd", shape(child).values(shape(same).nodes), ends)
        found.append((same, nodes))
    every = np.concatenate([element.nodes, *(nodes.reshape(-1, element.dimension) for _, nodes in found)])
    lattice = np.rint(every * PER_SIDE).astype(np.int64)
    _, first, number = np.unique(lattice, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)  # those of the cell itself stay first
    place = np.argsort(order)[number.reshape(-1)][len(element.nodes) :]
    tables = np.split(place, np.cumsum([nodes.shape[0] * nodes.shape[1] for _, nodes in found])[:-1])
    return Split(
        every[np.sort(first)],
        tuple((same, table.reshape(nodes.shape[:2])) for (same, nodes), table in zip(found, tables, strict=True)),
    )


def _middle(points: np.ndarray, *corners: int) -> np.ndarray:
    return np.asarray(points[list(corners)].mean(axis=0))


def _triangles() -> np.ndarray:
    p = shape("triangle").nodes
    a, b, c = _middle(p, 0, 1), _middle(p, 1, 2), _middle(p, 2, 0)
    return np.array([(p[0], a, c), (a, p[1], b), (c, b, p[2]), (a, b, c)])


def _wedges() -> np.ndarray:
    found = []
    for low in (0.0, 0.5):
        for flat in _triangles():
            found.append([(*xy, z) for z in (low, low + 0.5) for xy in flat])
    return np.array(found)


def _tetrahedra(diagonal: int) -> np.ndarray:
    p = shape("tetra").nodes
    found = [[_middle(p, i, j) for j in range(4)] for i in range(4)]
    ends = DIAGONALS[diagonal]
    first, last = (_middle(p, *end) for end in ends)
    a, b = ends[0]
    c, d = ends[1]
    ring = [_middle(p, *side) for side in ((a, c), (b, c), (b, d), (a, d))]
    found += [[first, last, ring[i], ring[(i + 1) % 4]] for i in range(4)]
    return _positive(np.array(found))


def _of_pyramid() -> list[tuple[str, np.ndarray]]:
    p = shape("pyramid").nodes
    centre = _middle(p, 0, 1, 2, 3)
    side = [_middle(p, i, (i + 1) % 4) for i in range(4)]
    up = [_middle(p, i, 4) for i in range(4)]
    pyramids = [[p[i], side[i], centre, side[i - 1], up[i]] for i in range(4)]
    pyramids += [[*up, p[4]], [up[3], up[2], up[1], up[0], centre]]
    between = [[side[i], up[i], up[(i + 1) % 4], centre] for i in range(4)]
    return [("pyramid", np.array(pyramids)), ("tetra", _positive(np.array(between)))]


def _positive(tetrahedra: np.ndarray) -> np.ndarray:
    """Return tetrahedra with two corners exchanged where they are inside out."""
    edges = tetrahedra[:, 1:] - tetrahedra[:, :1]
    inverted = np.linalg.det(edges) < 0.0
    tetrahedra[inverted] = tetrahedra[inverted][:, [0, 2, 1, 3]]
    return tetrahedra
