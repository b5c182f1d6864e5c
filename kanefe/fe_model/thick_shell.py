"""A shell as a body with thickness: points beside its nodes, which turn with them, and cells between these."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from kanefe.fe_model.model import Cells
from kanefe.fe_model.shapes import FACES, MIDS, corner_kind, shape
from kanefe.fe_model.shell_stack import ShellStack


class ThickShell(NamedTuple):
    """Points of a shell through its thickness.

    Attributes
    ----------
    nodes : ndarray of int, shape (p,)
        Node with which each point moves and turns.
    arms : ndarray, shape (p, 3)
        From the node to the point, m.
    cells : tuple of Cells
        Of the points.
    """

    nodes: np.ndarray
    arms: np.ndarray
    cells: tuple[Cells, ...]


def thick_skin(cells: Sequence[Cells], stack: ShellStack) -> ThickShell:
    """Return the outside of a shell: the bottom of all places, then their top, and the rims between, facing outward."""
    places, count = stack.places, len(stack.places.node)
    heights = stack.heights_of(places.section) * places.thickness[:, None]
    arms = np.concatenate([height[:, None] * places.director for height in heights.T])
    made: list[Cells] = []
    edges = []
    for block, at in _blocks(cells, places.of_corners):
        made += [Cells(block.kind, at + count), Cells(block.kind, at[:, shape(block.kind).reversal()])]
        halves = {frozenset(mid): shape(block.kind).corners + i for i, mid in enumerate(MIDS[block.kind])}
        for a, b in FACES[corner_kind(block.kind)]:
            middle = halves[frozenset((a, b))]
            edges += [at[:, [a, middle]], at[:, [middle, b]]]
    edge = np.concatenate(edges)
    rim = edge[_alone(edge)]
    made.append(Cells("quad", np.column_stack((rim, rim[:, ::-1] + count))))
    return ThickShell(np.tile(places.node, 2), arms, tuple(made))


def layered(cells: Sequence[Cells], stack: ShellStack, *, plies: bool) -> ThickShell:
    """Return a shell as cells of its plies, or of its whole thickness.

    Points are the bottom and then the top of all places in the lowest ply of each section, then in the next. Those of
    places whose section has fewer plies belong to no cell.
    """
    places, count = stack.places, len(stack.places.node)
    first, last = stack.first[places.section], stack.first[places.section + 1]
    arms, made = [], []
    for ply in range(stack.most_layers if plies else 1):
        is_there = first + ply < last
        ends = stack.heights[np.minimum(first + ply, last - 1)] if plies else stack.heights_of(places.section)
        arms += [(height * places.thickness)[:, None] * places.director for height in ends.T]
        for block, at in _blocks(cells, places.of_corners):
            own = at[is_there[at[:, 0]]] + 2 * ply * count
            for kind, piece in LAYERED[block.kind]:
                made.append(Cells(kind, np.column_stack((own[:, piece], own[:, piece] + count))))
    return ThickShell(np.tile(places.node, len(arms)), np.concatenate(arms), tuple(made))


LAYERED = {
    "quad9": [("hexahedron", list(piece)) for piece in ((0, 4, 8, 7), (4, 1, 5, 8), (8, 5, 2, 6), (7, 8, 6, 3))],
    "triangle6": [("wedge", list(piece)) for piece in ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5))],
}
"""Cells of first order into which a layer of each shape is divided, by the nodes of their bottom."""


def _blocks(cells: Sequence[Cells], of_corners: np.ndarray) -> list[tuple[Cells, np.ndarray]]:
    """Return the blocks of a shell with the places of their nodes."""
    found, start = [], 0
    for block in cells:
        if shape(block.kind).dimension == 2:
            found.append((block, of_corners[start : start + block.nodes.size].reshape(block.nodes.shape)))
            start += block.nodes.size
    return found


def _alone(edges: np.ndarray) -> np.ndarray:
    """Return which edges (k, 2) are there once, in any direction."""
    _, number, counts = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True, return_counts=True)
    return np.asarray(counts[number.ravel()] == 1)
