"""Structured meshes of boxes and rectangles, with the groups "root" (x smallest) and "tip" (x largest)."""

from __future__ import annotations

from itertools import permutations
from typing import Literal

import numpy as np

from kanefe.fe_model.model import Cells
from kanefe_fem.mesh.mesh import Mesh

_CORNERS = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))
"""Of a hexahedron, in VTK order."""


def box_mesh(
    size: tuple[float, float, float],
    counts: tuple[int, int, int],
    kind: Literal["hexahedron", "tetra"],
    start: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> Mesh:
    """Return a box from `start` with edges `size` (m), cut into bricks, each brick into six tetrahedra if asked."""
    index = np.arange(np.prod(np.array(counts) + 1)).reshape(np.array(counts) + 1)
    axes = [np.linspace(0.0, length, count + 1) for length, count in zip(size, counts, strict=True)]
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3) + np.asarray(start)
    bricks = np.column_stack([_shifted(index, corner).ravel() for corner in _CORNERS])
    if kind == "hexahedron":
        cells = bricks
        ends = {"root": index[0], "tip": index[-1]}
        corners = [corner[:2] for corner in _CORNERS[:4]]
        facets = {
            name: (Cells("quad", np.column_stack([_shifted(face, corner).ravel() for corner in corners])),)
            for name, face in ends.items()
        }
        return Mesh(nodes, 3, {"body": (Cells(kind, cells),)}, facets, source="a box")
    return Mesh(nodes, 3, {"body": (Cells(kind, _tetrahedra(bricks)),)}, source="a box")


def rectangle_mesh(length: float, height: float, elements: int) -> Mesh:
    """Return a rectangle from (0, 0) in the x-y plane (m), one row of quadrilaterals along x."""
    x = np.linspace(0.0, length, elements + 1)
    nodes = np.column_stack([np.tile(x, 2), np.repeat([0.0, height], len(x))])
    first = np.arange(elements)
    quads = np.column_stack([first, first + 1, first + len(x) + 1, first + len(x)])
    lines = {"root": np.array([[0, len(x)]]), "tip": np.array([[len(x) - 1, 2 * len(x) - 1]])}
    facets = {name: (Cells("line", ends),) for name, ends in lines.items()}
    return Mesh(nodes, 2, {"body": (Cells("quad", quads),)}, facets, source="a rectangle")


def _shifted(index: np.ndarray, corner: tuple[int, ...]) -> np.ndarray:
    """Return the node of one corner of every brick of a grid of nodes."""
    return index[tuple(slice(c, n - 1 + c) for c, n in zip(corner, index.shape, strict=True))]


def _tetrahedra(bricks: np.ndarray) -> np.ndarray:
    """Cut bricks along their diagonal (Kuhn): one tetrahedron for each order in which x, y and z are stepped."""
    tetrahedra = []
    for order in permutations(range(3)):
        path = np.cumsum([np.zeros(3, dtype=int), *np.eye(3, dtype=int)[list(order)]], axis=0)
        corners = bricks[:, [_CORNERS.index(tuple(step)) for step in path.tolist()]]
        is_odd = np.linalg.det(np.eye(3)[list(order)]) < 0
        tetrahedra.append(corners[:, [0, 2, 1, 3]] if is_odd else corners)
    return np.concatenate(tetrahedra)
