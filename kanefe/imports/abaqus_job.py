"""Nodes, node sets and axes of the input file of a job, which the rows of its matrices refer to."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from kanefe.errors import FileError, ModelError, outside
from kanefe.imports.abaqus_cards import check_places, unknown
from kanefe.imports.abaqus_input import Keyword, deck_keywords
from kanefe.imports.abaqus_members import rows_of_node_sets, several
from kanefe.imports.abaqus_parts import DeckPart, parts_of
from kanefe.imports.abaqus_sets import key_of
from kanefe.imports.coordinate_systems import CoordinateSystem, axes_at, right_handed
from kanefe.imports.included import DeckWarning
from kanefe.imports.node_table import NodeTable

OTHERWISE = "or give the nodes as a dict of labels to coordinates"
"""Remedy, in words of `read_abaqus`, for a deck whose nodes are not read."""


class Job(NamedTuple):
    """What an input file says of the rows of matrices.

    Attributes
    ----------
    nodes, turned : NodeTable
        Nodes with degrees of freedom in global axes, and in those of *TRANSFORM.
    used : ndarray of int
        Ascending labels of the nodes of elements; all, if the file has no elements.
    blocks : sequence of Keyword
    parts : sequence of DeckPart
    """

    nodes: NodeTable
    turned: NodeTable
    used: np.ndarray
    blocks: Sequence[Keyword] = ()
    parts: Sequence[DeckPart] = ()


def job_of(path: Path, trusted: bool, reader: str = "read_abaqus", otherwise: str = OTHERWISE) -> Job:
    """Return nodes and node sets of an input file for a `reader`; if `trusted`, it may include any file.

    What the reader takes instead of a deck that is not flat is `otherwise`, for messages.

    Raises
    ------
    FileError
        If a file does not exist or has no nodes, is included from elsewhere without being trusted, or has a line that
        is not as it should be, or places nodes in a way that is not read.
    ModelError
        If it has nodes of several instances, whose labels the rows of a matrix do not tell.
    """
    blocks = deck_keywords(path, trusted=trusted, reader=reader)
    check_places(blocks, otherwise)
    parts = parts_of(blocks, takes_any=True)
    if several(parts):
        at = [block.at for block in blocks if block.name == "INSTANCE"]
        raise ModelError(
            f"{path} is an assembly of {len(at)} instances that share labels (lines {', '.join(map(str, at))}). "
            f"Remedy: export a flat input file (no parts and assemblies), {otherwise}"
        )
    rows = np.concatenate([np.column_stack((part.labels, part.points)) for part in parts])
    if not len(rows):
        raise FileError(f"{path} has no *NODE. Remedy: give the input file of the job that wrote the matrices")
    told = [line for part in parts for line in part.told]
    labels = rows[:, 0].astype(np.int64)
    sets = {name: np.unique(labels[own]) for name, own in rows_of_node_sets(parts, told).items()}
    nodes = NodeTable.of_rows(rows, str(path), sets)
    told += [f"{name} (line {at}) is not known, and left out" for name, at in unknown(blocks).items()]
    if told:
        warnings.warn(f"{path.name}: {'; '.join(told)}", DeckWarning, stacklevel=outside())
    axes = _axes(nodes, blocks, sets)
    turned = nodes if axes is None else NodeTable(nodes.labels, nodes.points, nodes.sets, axes)
    return Job(nodes, turned, _used(parts, nodes.labels), blocks, parts)


def _used(parts: Sequence[DeckPart], labels: np.ndarray) -> np.ndarray:
    """Return the ascending labels of the nodes of elements; all, without elements."""
    found = [part.nodes_of(part.element_labels) for part in parts if part.elements]
    return np.unique(np.concatenate(found)) if found else labels


def _axes(nodes: NodeTable, blocks: Iterable[Keyword], sets: dict[str, np.ndarray]) -> np.ndarray | None:
    """Return A_Gd of every node (n, 3, 3) by the keywords *TRANSFORM; None without one."""
    axes = np.broadcast_to(np.eye(3), (len(nodes.labels), 3, 3)).copy()
    is_turned = False
    by_key = {key_of(name): labels for name, labels in sets.items()}
    for block in blocks:
        if block.name == "TRANSFORM":
            name = block.option("NSET")
            labels = by_key.get(key_of(name))
            if labels is None:
                raise block.refused(f"is of set {name}, which is not there. Remedy: check the names of its sets")
            rows = nodes.places(labels, f"*TRANSFORM (line {block.at})")
            axes[rows] = axes_at(_system(block), nodes.points[rows])
            is_turned = True
    return axes if is_turned else None


def _system(block: Keyword) -> CoordinateSystem:
    """Return the system of *TRANSFORM: two points, of R in its plane 1-2 from the origin, of C on its axis."""
    kind = block.options.get("TYPE", "R").upper()
    values = [block.number(text, at) for at, fields in block.rows() for text in fields]
    if kind not in ("R", "C") or len(values) != 6:
        raise block.refused("is no system R or C of two points, and others are not read. Remedy: those, or global axes")
    a, b = np.array(values[:3]), np.array(values[3:])
    if kind == "R":
        axes, origin = right_handed(a, b), np.zeros(3)
    else:
        along, origin = b - a, a
        beside = np.eye(3)[np.argmin(np.abs(along))]
        turned = right_handed(along, beside)
        axes = None if turned is None else turned[:, [1, 2, 0]]
    if axes is None:
        raise block.refused("has points that give no direction. Remedy: two points that differ")
    return CoordinateSystem(kind, origin, axes)
