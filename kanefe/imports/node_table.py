"""Nodes of an exporting program: labels, positions, named sets, and the axes of their degrees of freedom."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeAlias

import numpy as np

from kanefe.errors import FileError, ModelError
from kanefe.frames import numbers as checked_numbers
from kanefe.imports.text import numbers, read_text, with_points

Nodes: TypeAlias = str | Path | Mapping[int, Sequence[float]] | np.ndarray
"""A file, a dict of labels to coordinates, or an array (n, 4) of label, x, y, z."""


@dataclass(frozen=True, eq=False)
class NodeTable:
    """Labelled nodes in the units of their program.

    Attributes
    ----------
    labels : ndarray of int, shape (n,)
        Ascending.
    points : ndarray, shape (n, 3)
    sets : dict of str to ndarray of int
        Labels of named nodes.
    axes : ndarray, shape (n, 3, 3), or None
        A_Gd of every node: columns are the axes of its degrees of freedom in G. None: those of G.
    """

    labels: np.ndarray
    points: np.ndarray
    sets: Mapping[str, np.ndarray] = field(default_factory=dict)
    axes: np.ndarray | None = None

    @classmethod
    def of_rows(cls, rows: object, source: str, sets: Mapping[str, np.ndarray] | None = None) -> NodeTable:
        """Return the table of rows (label, x, y, z) in any order.

        Raises
        ------
        ModelError
            If labels are not whole numbers, a label has two positions, or coordinates are not finite.
        """
        table = checked_numbers(rows)
        if table.ndim != 2 or table.shape[1] != 4 or not len(table) or not np.all(np.isfinite(table)):
            raise ModelError(f"the nodes of {source} must be rows of label, x, y, z, not of shape {table.shape}")
        if np.any(table[:, 0] != np.round(table[:, 0])):
            raise ModelError(f"the nodes of {source} must begin with whole labels. Remedy: rows of label, x, y, z")
        table = np.unique(table, axis=0)  # sorted by label, without repetitions
        labels = table[:, 0].astype(np.int64)
        twice = labels[1:][labels[1:] == labels[:-1]]
        if len(twice):
            raise ModelError(f"node {twice[0]} of {source} has two positions. Remedy: keep one of them")
        return cls(labels, np.ascontiguousarray(table[:, 1:]), dict(sets or {}))

    def places(self, labels: np.ndarray, what: str) -> np.ndarray:
        """Return the rows of labels in the table.

        Raises
        ------
        ModelError
            If one is missing; the message lists the first.
        """
        labels = np.asarray(labels, dtype=np.int64)
        places = np.minimum(np.searchsorted(self.labels, labels), len(self.labels) - 1)
        missing = np.unique(labels[self.labels[places] != labels])
        if len(missing):
            named = ", ".join(str(n) for n in missing[:5]) + (", ..." if len(missing) > 5 else "")
            raise ModelError(
                f"{what} {'has' if what.startswith('the') else 'have'} {len(missing)} node(s) that the table of nodes "
                f"does not hold: {named}. Remedy: give the file of the model that was exported, with all its nodes"
            )
        return places


class Labels:
    """Labels in which others are looked for, of each the first; they are sorted once."""

    def __init__(self, known: np.ndarray) -> None:
        self.known, self._order = known, np.argsort(known, kind="stable")

    def rows(self, labels: np.ndarray) -> np.ndarray:
        """Return the rows of some labels; -1: it is none of them."""
        if not len(self.known):
            return np.full(labels.shape, -1)
        places = np.searchsorted(self.known, labels, sorter=self._order)
        where = self._order[np.minimum(places, len(self.known) - 1)]
        return np.where(self.known[where] == labels, where, -1)


def rows_of(labels: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Return the rows of some labels among those that are known, of each the first; -1: it is none of them."""
    return Labels(known).rows(labels)


def given_nodes(nodes: Nodes) -> NodeTable:
    """Return the table of nodes given as a dict, an array (n, 4), or a text file of rows label, x, y, z."""
    if isinstance(nodes, (str, Path)):
        text = with_points(read_text(nodes, "nodes"))
        kept = [line.partition("#")[0] for line in text.splitlines()]
        widths = {len(line.replace(",", " ").split()) for line in kept if line.strip()}
        if widths != {4}:
            raise FileError(
                f"{nodes} is not a table of nodes. Remedy: a row of label, x, y, z for each, # for comments"
            )
        return NodeTable.of_rows(numbers("\n".join(kept), nodes).reshape(-1, 4), str(nodes))
    if isinstance(nodes, Mapping):
        rows = [(label, *checked_numbers(point).reshape(-1)) for label, point in nodes.items()]
        if any(len(row) != 4 for row in rows):
            raise ModelError("nodes must be a dict of labels to three coordinates")
        return NodeTable.of_rows(rows, "the given dict")
    return NodeTable.of_rows(nodes, "the given array")
