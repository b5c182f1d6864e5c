"""Cells made quadrangles of nine nodes, which bend better than others.

Triangles are joined in pairs: two of six nodes have the nine of a quadrangle, the one of their common edge in its
middle. Quadrangles of eight nodes get one more.
"""

from __future__ import annotations

import numpy as np

from kanefe.fe_model.model import Cells
from kanefe_fem.shells.orientation import twins

SHARPEST = np.radians(25.0)
"""Least angle between sides of a quadrangle, rad; below it, or as far below 180 degrees, triangles stay apart."""

FLAT = np.cos(np.radians(15.0))
"""Cosine of the largest angle between the planes of two triangles that are joined."""


def of_nine_nodes(nodes: np.ndarray, block: Cells, kept: np.ndarray) -> tuple[np.ndarray, list[Cells]]:
    """Return nodes (n, 3) in m and the cells of a block as quadrangles of nine nodes, with the triangles that are left.

    Arguments as of `joined`; normals are kept.
    """
    if block.kind == "quad9":
        return nodes, [block]
    if block.kind == "quad8":
        table = np.column_stack((block.nodes, len(nodes) + np.arange(len(block.nodes))))
        nodes = np.concatenate((nodes, np.zeros((len(table), 3))))
        return centred(nodes, table), [Cells("quad9", table)]
    quadrangles, left = joined(nodes, block.nodes, kept)
    cells = Cells("quad9", quadrangles), Cells("triangle6", block.nodes[left])
    return centred(nodes, quadrangles), [one for one in cells if len(one.nodes)]


def joined(nodes: np.ndarray, triangles: np.ndarray, kept: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return quadrangles made of two triangles each, and what is left.

    Of all pairs across an edge those with angles nearest to right ones are taken first.

    Parameters
    ----------
    nodes : ndarray, shape (n, 3)
        m.
    triangles : ndarray of int, shape (m, 6)
        Nodes in VTK's order, normals on one side.
    kept : ndarray of int
        Mid-side nodes of edges that stay: those of groups of lines.

    Returns
    -------
    quadrangles : ndarray of int, shape (k, 9)
        The node in the middle is that of the edge between the two.
    left : ndarray of int, shape (m - 2 k,)
        Triangles that stay.
    """
    edges = np.concatenate([triangles[:, [i, (i + 1) % 3]] for i in range(3)])
    pairs = twins(edges)
    first, side = pairs % len(triangles), pairs // len(triangles)
    turn = (side[:, :, None] + np.arange(3)) % 3
    a, b = (triangles[first[:, i, None], turn[:, i]] for i in range(2))  # corners, the common edge first
    mid_a, mid_b = (triangles[first[:, i, None], 3 + turn[:, i]] for i in range(2))
    quads = np.column_stack((a[:, 0], b[:, 2], a[:, 1], a[:, 2], mid_b[:, 1:], mid_a[:, 1:], mid_a[:, 0]))
    worst = _worst_angle(nodes[quads[:, :4]])
    flat = _cosine(nodes[a], nodes[b]) > FLAT
    good = np.flatnonzero((worst < np.pi / 2.0 - SHARPEST) & flat & ~np.isin(quads[:, 8], kept))
    good = good[np.argsort(worst[good], kind="stable")]
    taken = good[_matching(first[good], len(triangles))]
    free = np.ones(len(triangles), dtype=bool)
    free[first[taken]] = False
    return quads[taken], np.flatnonzero(free)


def _matching(pairs: np.ndarray, count: int) -> np.ndarray:
    """Return numbers of pairs (k, 2) without a common member, the first ones first, such that few of them stay alone.

    Where two that stay alone are neighbours of a pair, one of each, two pairs are made of the four.
    """
    beside: list[list[tuple[int, int]]] = [[] for _ in range(count)]
    mate: dict[int, tuple[int, int]] = {}
    for number, (i, j) in enumerate(pairs.tolist()):
        beside[i].append((number, j))
        beside[j].append((number, i))
        if i not in mate and j not in mate:
            mate[i], mate[j] = (number, j), (number, i)
    for alone in [i for i in range(count) if i not in mate]:
        for number, i in beside[alone]:
            other = mate[i][1] if i in mate else alone
            ends = [(n, k) for n, k in beside[other] if k not in mate and k != alone]
            if alone not in mate and i in mate and ends:
                last, end = ends[0]
                mate[alone], mate[i], mate[other], mate[end] = (number, i), (number, alone), (last, end), (last, other)
    return np.unique([number for number, _ in mate.values()]).astype(np.int64)


def centred(nodes: np.ndarray, quadrangles: np.ndarray) -> np.ndarray:
    """Return the nodes with those in the middle of quadrangles (k, 9) moved to where their sides ask for them.

    On the middle of the common edge of two triangles a node makes the map to the cell quadratic where it need not be.
    """
    moved = nodes.copy()
    corners, mids = nodes[quadrangles[:, :4]].sum(axis=1), nodes[quadrangles[:, 4:8]].sum(axis=1)
    moved[quadrangles[:, 8]] = 0.5 * mids - 0.25 * corners
    return moved


def _worst_angle(corners: np.ndarray) -> np.ndarray:
    """Return the largest difference from a right angle at the corners (k, 4, 3) of quadrangles, rad."""
    ahead, behind = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
    lengths = np.linalg.norm(ahead, axis=2) * np.linalg.norm(behind, axis=2)
    cosine = np.einsum("kci,kci->kc", ahead, behind) / lengths
    return np.abs(np.arccos(np.clip(cosine, -1.0, 1.0)) - np.pi / 2.0).max(axis=1)


def _cosine(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Return the cosine of the angle between the normals of triangles with corners (k, 3, 3)."""
    one, other = (np.cross(c[:, 1] - c[:, 0], c[:, 2] - c[:, 0]) for c in (first, second))
    lengths = np.linalg.norm(one, axis=1) * np.linalg.norm(other, axis=1)
    return np.asarray(np.einsum("ki,ki->k", one, other) / lengths)
