"""Directors of a shell: one normal for each smooth side of a node, so that folds keep their edge.

The normals of the cells at a node that differ by less than an angle, directly or by a chain of others, are one side,
with their mean as its director; smooth surfaces have one side a node, a fold two, a T three.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from kanefe.fe_model.model import Cells
from kanefe.fe_model.shapes import shape


@dataclass(frozen=True, eq=False)
class Directors:
    """The sides of the nodes of a shell.

    Attributes
    ----------
    of_cells : tuple of ndarray of int, shape (m, nodes per cell)
        Number of the side at each node of each cell, by blocks.
    node : ndarray of int, shape (s,)
        Node of each side.
    normal : ndarray, shape (s, 3)
        Unit director of each side.
    """

    of_cells: tuple[np.ndarray, ...]
    node: np.ndarray
    normal: np.ndarray

    @property
    def folded(self) -> np.ndarray:
        """Nodes with more than one side."""
        return np.flatnonzero(np.bincount(self.node) > 1)


def directors(nodes: np.ndarray, blocks: Sequence[Cells], smooth: float) -> Directors:
    """Return the directors of cells whose normals are consistent.

    Parameters
    ----------
    nodes : ndarray, shape (n, 3)
        m.
    blocks : sequence of Cells
        Triangles and quadrangles of second order.
    smooth : float
        Angle in rad from which two cells make a fold.
    """
    normals = np.concatenate([corner_normals(nodes, block).reshape(-1, 3) for block in blocks])
    node = np.concatenate([block.nodes.ravel() for block in blocks])
    at = sp.csr_matrix((np.ones(len(node)), (np.arange(len(node)), node)), shape=(len(node), len(nodes)))
    near = (at @ at.T).tocoo()
    angle = np.arccos(np.clip(np.einsum("ki,ki->k", normals[near.row], normals[near.col]), -1.0, 1.0))
    one_side = angle < smooth
    graph = sp.coo_matrix((np.ones(one_side.sum()), (near.row[one_side], near.col[one_side])), shape=near.shape)
    side = connected_components(graph, directed=False)[1]
    mean = np.zeros((side.max() + 1, 3))
    np.add.at(mean, side, normals)
    mean /= np.linalg.norm(mean, axis=1)[:, None]
    owner = np.empty(len(mean), dtype=np.int64)
    owner[side] = node
    ends = np.cumsum([block.nodes.size for block in blocks])[:-1]
    of_cells = tuple(part.reshape(block.nodes.shape) for part, block in zip(np.split(side, ends), blocks, strict=True))
    return Directors(of_cells, owner, mean)


def corner_normals(nodes: np.ndarray, block: Cells) -> np.ndarray:
    """Return the unit normals of cells at their own nodes, shape (m, nodes per cell, 3)."""
    element = shape(block.kind)
    tangents = np.einsum("pna,mni->mpai", element.gradients(element.nodes), nodes[block.nodes])
    normals = np.cross(tangents[:, :, 0], tangents[:, :, 1])
    return np.asarray(normals / np.linalg.norm(normals, axis=2, keepdims=True))
