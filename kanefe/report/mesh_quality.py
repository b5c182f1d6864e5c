"""Quality of the cells of a mesh: aspect ratio, scaled Jacobian, and the bend of sides.

Definitions as in Knupp, Ernst, Thompson, Stimpson & Pebay, "The Verdict geometric quality library", Sandia report
SAND2007-1751 (2007), from the corners of the cells: the scaled Jacobian is 1 for a regular cell and falls to 0 for a
flat one, the aspect ratio is 1 for a regular cell and grows without bound.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kanefe.fe_model.model import Cells

_EDGES = {
    "line": ((0, 1),),
    "triangle": ((0, 1), (1, 2), (2, 0)),
    "quad": ((0, 1), (1, 2), (2, 3), (3, 0)),
    "tetra": ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)),
    "hexahedron": (
        *((0, 1), (1, 2), (2, 3), (3, 0)),
        *((4, 5), (5, 6), (6, 7), (7, 4)),
        *((0, 4), (1, 5), (2, 6), (3, 7)),
    ),
}
"""Edges in VTK's order: the mid-side node of edge i is the i-th after the corners."""

_NEIGHBOURS = {
    "triangle": ((1, 2), (2, 0), (0, 1)),
    "quad": ((1, 3), (2, 0), (3, 1), (0, 2)),
    "tetra": ((1, 2, 3), (2, 0, 3), (0, 1, 3), (0, 2, 1)),
    "hexahedron": (
        *((1, 3, 4), (2, 0, 5), (3, 1, 6), (0, 2, 7)),
        *((7, 5, 0), (4, 6, 1), (5, 7, 2), (6, 4, 3)),
    ),
}
"""Corners adjacent to each corner, right-handed."""

_REGULAR = {"triangle": 2.0 / np.sqrt(3.0), "quad": 1.0, "tetra": np.sqrt(2.0), "hexahedron": 1.0}
"""Factors that make the scaled Jacobian of the regular cell one."""

CORNER_KINDS = {
    "line": "line",
    "line3": "line",
    "triangle": "triangle",
    "triangle6": "triangle",
    "quad": "quad",
    "quad8": "quad",
    "quad9": "quad",
    "tetra": "tetra",
    "tetra10": "tetra",
    "hexahedron": "hexahedron",
    "hexahedron20": "hexahedron",
    "hexahedron27": "hexahedron",
}


@dataclass(frozen=True, eq=False)
class MeshQuality:
    """Quality of all cells, block after block.

    Attributes
    ----------
    kinds : dict of str to int
        Number of cells of each shape.
    scaled_jacobian, aspect_ratio : ndarray, shape (cells,)
        NaN for lines and unknown shapes.
    bend : ndarray, shape (cells,)
        Greatest distance of a mid-side node from the middle of its side, relative to the side; 0 without such nodes.
    edges : ndarray, shape (cells, 2)
        Shortest and longest side, m.
    centres : ndarray, shape (cells, 3)
        Means of the corners, m.
    """

    kinds: dict[str, int]
    scaled_jacobian: np.ndarray
    aspect_ratio: np.ndarray
    bend: np.ndarray
    edges: np.ndarray
    centres: np.ndarray


def mesh_quality(nodes: np.ndarray, cells: tuple[Cells, ...]) -> MeshQuality:
    """Return the quality of the cells of a mesh with nodes (n, 3) in m."""
    kinds: dict[str, int] = {}
    parts = []
    for block in cells:
        if block.kind not in CORNER_KINDS or not len(block.nodes):
            continue
        kinds[block.kind] = kinds.get(block.kind, 0) + len(block.nodes)
        parts.append(_of_block(CORNER_KINDS[block.kind], nodes[block.nodes]))
    if not parts:
        nothing = np.zeros(0)
        return MeshQuality({}, nothing, nothing, nothing, np.zeros((0, 2)), np.zeros((0, 3)))
    jacobian, aspect, bend, edges, centres = (np.concatenate(columns) for columns in zip(*parts, strict=True))
    return MeshQuality(kinds, jacobian, aspect, bend, edges, centres)


def _of_block(corner_kind: str, x: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return scaled Jacobian, aspect ratio, bend, edges and centres of cells with nodes (m, nodes per cell, 3)."""
    edges = _EDGES[corner_kind]
    corners = max(max(edge) for edge in edges) + 1
    sides = np.stack([x[:, b] - x[:, a] for a, b in edges], axis=1)
    lengths = np.linalg.norm(sides, axis=2)
    mids = x[:, corners : corners + len(edges)]
    bend = np.zeros(len(x))
    if mids.shape[1] == len(edges):
        middle = np.stack([0.5 * (x[:, a] + x[:, b]) for a, b in edges], axis=1)
        bend = (np.linalg.norm(mids - middle, axis=2) / np.maximum(lengths, 1e-300)).max(axis=1)
    extremes = np.column_stack((lengths.min(axis=1), lengths.max(axis=1)))
    centres = x[:, :corners].mean(axis=1)
    if corner_kind == "line":
        nothing = np.full(len(x), np.nan)
        return nothing, nothing, bend, extremes, centres
    jacobian = _scaled_jacobian(corner_kind, x)
    return jacobian, _aspect_ratio(corner_kind, x, lengths), bend, extremes, centres


def _scaled_jacobian(kind: str, x: np.ndarray) -> np.ndarray:
    """Return the smallest Jacobian over the corners, with sides normalised to unit length."""
    values = []
    for corner, neighbours in enumerate(_NEIGHBOURS[kind]):
        sides = np.stack([x[:, n] - x[:, corner] for n in neighbours], axis=1)
        sides = sides / np.maximum(np.linalg.norm(sides, axis=2, keepdims=True), 1e-300)
        if sides.shape[1] == 3:
            values.append(np.linalg.det(sides))
        else:
            values.append(np.cross(sides[:, 0], sides[:, 1])[:, 2])  # plane bodies lie in x and y
    return _REGULAR[kind] * np.min(values, axis=0)


def _aspect_ratio(kind: str, x: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """Return longest side over inscribed circle or sphere (simplices), or over shortest side; 1 if regular."""
    longest = lengths.max(axis=1)
    with np.errstate(divide="ignore"):
        if kind == "triangle":
            area = 0.5 * np.linalg.norm(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), axis=1)
            return longest * lengths.sum(axis=1) / (4.0 * np.sqrt(3.0) * area)
        if kind == "tetra":
            a, b, c = (x[:, i] - x[:, 0] for i in (1, 2, 3))
            volume = np.abs(np.einsum("mi,mi->m", a, np.cross(b, c))) / 6.0
            faces = (np.cross(a, b), np.cross(a, c), np.cross(b, c), np.cross(b - a, c - a))
            surface = 0.5 * sum(np.linalg.norm(face, axis=1) for face in faces)
            return np.asarray(longest * surface / (6.0 * np.sqrt(6.0) * volume))
        return np.asarray(longest / lengths.min(axis=1))
