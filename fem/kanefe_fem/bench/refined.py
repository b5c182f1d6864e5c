"""Meshes of tetrahedra with every edge halved."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kanefe.finite_element_model import Cells
from kanefe_fem.mesh import Mesh

# In VTK's numbers of the quadratic element. The octahedron that is left in the middle is cut along one diagonal.
TETRAHEDRA = ((0, 4, 6, 7), (4, 1, 5, 8), (6, 5, 2, 9), (7, 8, 9, 3),
              (6, 8, 4, 5), (6, 8, 5, 9), (6, 8, 9, 7), (6, 8, 7, 4))  # fmt: skip
TRIANGLES = ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5))
EDGES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))


def refined(mesh: Mesh) -> Mesh:
    """Return a mesh of quadratic tetrahedra with each cut into eight, of the same curved shape.

    Lines and single points are left out.
    """
    lifted = mesh.with_order(2)
    places = _barycentric()
    parts = [_ordered(part, places) for part in TETRAHEDRA]

    def cut(block: Cells) -> Cells:
        return Cells("tetra", np.concatenate([block.nodes[:, part] for part in parts]))

    def cut_facets(block: Cells) -> Cells:
        return Cells("triangle", np.concatenate([block.nodes[:, list(part)] for part in TRIANGLES]))

    halves = replace(
        lifted,
        cells={name: tuple(cut(block) for block in blocks) for name, blocks in lifted.cells.items()},
        facets={name: tuple(cut_facets(block) for block in blocks) for name, blocks in lifted.facets.items()},
        lines={},
        points={},
    ).with_order(2)
    nodes = np.array(halves.nodes)
    for old, new in zip(lifted.cell_blocks, halves.cell_blocks, strict=True):
        for number, part in enumerate(parts):
            own = new.nodes[number * len(old.nodes) : (number + 1) * len(old.nodes), 4:]
            at = np.array([places[part[list(edge)]].mean(axis=0) for edge in EDGES])
            nodes[own] = np.einsum("ec,ncx->nex", _shape_functions(at), lifted.nodes[old.nodes])
    return replace(halves, nodes=nodes)


def _barycentric() -> np.ndarray:
    """Return the coordinates of the ten nodes, (10, 4)."""
    corners = np.eye(4)
    return np.concatenate((corners, [corners[list(edge)].mean(axis=0) for edge in EDGES]))


def _shape_functions(at: np.ndarray) -> np.ndarray:
    """Return the shape functions of the quadratic tetrahedron at barycentric coordinates, (points, 10)."""
    of_corners = at * (2.0 * at - 1.0)
    return np.concatenate((of_corners, np.stack([4.0 * at[:, a] * at[:, b] for a, b in EDGES], axis=1)), axis=1)


def _ordered(part: tuple[int, ...], places: np.ndarray) -> np.ndarray:
    """Return the corners of a part so that its volume is positive."""
    corners = places[list(part), 1:]
    is_odd = np.linalg.det(corners[1:] - corners[0]) < 0.0
    return np.array(part)[[0, 2, 1, 3] if is_odd else [0, 1, 2, 3]]
