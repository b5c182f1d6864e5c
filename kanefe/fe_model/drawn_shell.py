"""A shell with the solids and the beams in one mesh with it as points that move with nodes, and cells between these."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from kanefe.fe_model.model import Cells
from kanefe.fe_model.ribs import Ribs
from kanefe.fe_model.shapes import shape
from kanefe.fe_model.thick_shell import ThickShell

HALVES = np.array([(0, 2), (2, 1)])
"""Nodes at the ends of the two straight beams by which a line of three nodes is drawn."""


class DrawnShell(NamedTuple):
    """Points of a shell, then those of solids, then those of beams.

    Attributes
    ----------
    nodes : ndarray of int, shape (p,)
        Node with which each point moves and turns.
    arms : ndarray, shape (p, 3)
        From the node to the point, m.
    cells : tuple of Cells
        Of the points of shells and solids.
    ends : ndarray of int, shape (b, 2)
        Nodes at the ends of the straight beams.
    fibres : int
        Number of points around each end of these.
    """

    nodes: np.ndarray
    arms: np.ndarray
    cells: tuple[Cells, ...]
    ends: np.ndarray
    fibres: int

    @property
    def first(self) -> int:
        """Number of the first point of the beams."""
        return len(self.nodes) - self.ends.size * self.fibres

    @property
    def all_cells(self) -> tuple[Cells, ...]:
        """Cells of the points of shells, solids and beams."""
        if not len(self.ends):
            return self.cells
        sides, caps = tubes(len(self.ends), self.fibres)
        return (*self.cells, Cells("quad", self.first + sides), Cells("triangle", self.first + caps))


def drawn_shell(
    nodes: np.ndarray, cells: Sequence[Cells], ribs: Ribs | None, thick: ThickShell, solids: Sequence[Cells]
) -> DrawnShell:
    """Return what is drawn of a body that is a shell, with solids and beams.

    Parameters
    ----------
    nodes : ndarray, shape (n, 3)
    cells : sequence of Cells
        Of the body.
    ribs : Ribs or None
        The beams.
    thick : ThickShell
        The shell.
    solids : sequence of Cells
        Of the solids, or of their skin.
    """
    used = nodes_of(solids)
    after = [Cells(block.kind, len(thick.nodes) + np.searchsorted(used, block.nodes)) for block in solids]
    moving, arms = np.append(thick.nodes, used), np.concatenate((thick.arms, np.zeros((len(used), 3))))
    if ribs is None:
        return DrawnShell(moving, arms, (*thick.cells, *after), np.zeros((0, 2), dtype=int), 0)
    lines = np.concatenate([block.nodes for block in cells if shape(block.kind).dimension == 1])
    around = ribs.outlines(nodes[lines])
    ends = lines[:, HALVES].reshape(-1, 2)
    return DrawnShell(
        np.append(moving, np.repeat(ends, around.shape[2])),
        np.concatenate((arms, around[:, HALVES].reshape(-1, 3))),
        (*thick.cells, *after),
        ends,
        around.shape[2],
    )


def nodes_of(cells: Sequence[Cells]) -> np.ndarray:
    """Return the nodes of cells, ascending."""
    return np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *(block.nodes.ravel() for block in cells)]))


def tubes(count: int, fibres: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the sides (s, 4) and the ends (t, 3) of straight beams, facing outward.

    Their points are ordered by beams, ends and fibres.
    """
    around = np.arange(fibres)
    after = np.roll(around, -1)
    sides = np.column_stack((around, after, after + fibres, around + fibres))
    fan = np.column_stack((np.zeros(fibres - 2, dtype=int), around[1:-1], around[2:]))
    first = 2 * fibres * np.arange(count)[:, None, None]
    caps = np.concatenate((fan[:, ::-1], fan + fibres))
    return (first + sides).reshape(-1, 4), (first + caps).reshape(-1, 3)
