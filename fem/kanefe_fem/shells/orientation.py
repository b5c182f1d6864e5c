"""Sides of a surface: cells turned so that the normals of neighbours are on one side."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import breadth_first_order, connected_components

from kanefe.errors import MeshError
from kanefe.fe_model.model import Cells
from kanefe.fe_model.shapes import FACES, corner_kind, row_numbers, shape


def consistent(blocks: Sequence[Cells], source: str) -> tuple[tuple[Cells, ...], int]:
    """Return the cells with the normals of neighbours on one side, and how many of them were turned.

    Cells across an edge of two agree; where three or more meet, as in a T, each branch has sides of its own. Of a
    connected part the sides of the majority are kept.

    Parameters
    ----------
    blocks : sequence of Cells
        Triangles and quadrangles.
    source : str
        Name of the mesh in messages.

    Raises
    ------
    MeshError
        If a part has one side only, as a Moebius strip.
    """
    counts = [len(block.nodes) for block in blocks]
    first, second, alike = neighbours(blocks)
    size = sum(counts)
    sign = np.ones(size, dtype=int)
    graph = sp.csr_matrix((np.where(alike, 1, -1), (first, second)), shape=(size, size))
    graph = graph + graph.T
    part = connected_components(graph, directed=False)[1]
    for number in np.unique(part[np.concatenate((first[~alike], second[~alike]))]):
        members = np.flatnonzero(part == number)
        own = _signs(graph[members][:, members])
        sign[members] = own if own.sum() >= 0 else -own
    wrong = sign[first] * sign[second] != np.where(alike, 1, -1)
    if wrong.any():
        raise MeshError(
            f"{source}: the surface has one side only, as a Moebius strip has: its normals cannot agree (cells "
            f"{int(first[wrong][0])} and {int(second[wrong][0])}). Remedy: cut it into two bodies, or correct the mesh"
        )
    of_blocks = np.split(sign < 0, np.cumsum(counts)[:-1])
    turned = tuple(_turned(block, which) for block, which in zip(blocks, of_blocks, strict=True))
    return turned, int(np.sum(sign < 0))


def neighbours(blocks: Sequence[Cells]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the pairs of cells across edges of two cells, and whether their normals are on one side, shapes (k,).

    Cells are numbered through all blocks.
    """
    edges, cells, start = [], [], 0
    for block in blocks:
        sides = FACES[corner_kind(block.kind)]
        edges.append(np.concatenate([block.nodes[:, list(side)] for side in sides]))
        cells.append(np.tile(np.arange(start, start + len(block.nodes)), len(sides)))
        start += len(block.nodes)
    edge, cell = np.concatenate(edges), np.concatenate(cells)
    pairs = twins(edge)
    # an edge that both cells go along in one direction lies between normals on different sides
    alike = edge[pairs[:, 0], 0] != edge[pairs[:, 1], 0]
    return cell[pairs[:, 0]], cell[pairs[:, 1]], alike


def twins(edges: np.ndarray) -> np.ndarray:
    """Return the pairs of rows of edges (k, 2), in any direction, that are there just twice, shape (p, 2)."""
    number = row_numbers(np.sort(edges, axis=1))
    order = np.argsort(number, kind="stable")
    return np.asarray(order[np.bincount(number)[number[order]] == 2].reshape(-1, 2))


def _signs(graph: sp.csr_matrix) -> np.ndarray:
    """Return 1 or -1 for each cell of a connected part: the product of the entries on the way from its first cell."""
    before = breadth_first_order(graph, 0, directed=False)[1]
    before[0] = 0
    sign = np.asarray(graph[np.arange(len(before)), before]).ravel()
    sign[0] = 1
    while before.any():
        sign, before = sign * sign[before], before[before]
    return sign


def _turned(block: Cells, which: np.ndarray) -> Cells:
    nodes = block.nodes.copy()
    nodes[which] = nodes[which][:, shape(block.kind).reversal()]
    return Cells(block.kind, nodes)
