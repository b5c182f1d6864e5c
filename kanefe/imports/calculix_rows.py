"""What the rows of matrices of CalculiX are: translations of nodes, turns of rigid bodies, incompatible modes.

A node that the deck does not have was made by CalculiX: for a ``*RIGID BODY`` or a kinematic ``*COUPLING`` without
ROT NODE (its rows are rotations) or REF NODE (translations of the point that is at the origin), in the order of their
cards; and behind these three for each element with incompatible modes. Rows that lack are held or depend on others.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from kanefe.errors import ModelError
from kanefe.imports.abaqus_cards import DEPENDENT
from kanefe.imports.abaqus_elements import OTHER
from kanefe.imports.abaqus_input import Keyword
from kanefe.imports.abaqus_job import Job
from kanefe.imports.abaqus_parts import DeckPart
from kanefe.imports.abaqus_sets import key_of
from kanefe.imports.node_table import NodeTable

INCOMPATIBLE = "C3D8I"
"""Type of the elements with incompatible modes: nine rows, at three nodes of their own."""

INNER_NODES = 3
"""Number of nodes that CalculiX makes for the incompatible modes of an element."""

_EXPANDED = ("S", "M3D", "B", "T")
"""First letters of the types of elements that CalculiX expands to solids."""

_PLANE = ("CPS", "CPE", "CAX")
"""First letters of the types of plane elements."""


class CellBlock(NamedTuple):
    """Cells of one kind: labels of their elements (m,), and of their nodes (m, k)."""

    kind: str
    elements: np.ndarray
    nodes: np.ndarray


class StoredRows(NamedTuple):
    """Rows of stored matrices.

    Attributes
    ----------
    freedoms : ndarray of int, shape (N, 2)
        Node and number of each row.
    is_inner : ndarray of bool, shape (N,)
        Whether a row is one of an incompatible mode.
    table : NodeTable
        The nodes with their places and sets.
    cells : list of CellBlock
    lost : list of int
        Nodes of masses that have no rows.
    """

    freedoms: np.ndarray
    is_inner: np.ndarray
    table: NodeTable
    cells: list[CellBlock]
    lost: list[int]


def type_of(block: Keyword) -> str:
    """Return the type of the elements of a block, in capitals."""
    return block.option("TYPE").upper().replace(" ", "")


def is_expanded(parts: Sequence[DeckPart]) -> bool:
    """Return whether a deck has shells, beams, membranes or trusses; refuse plane elements."""
    blocks = [some.block for part in parts for some in part.elements]
    for block in blocks:
        if type_of(block).startswith(_PLANE):
            raise block.refused("is of plane elements, whose third rows are thickness. Remedy: solids or shells")
    return any(type_of(block).startswith(_EXPANDED) and not type_of(block).startswith("SPRING") for block in blocks)


def rows_of_deck(job: Job, freedoms: np.ndarray, path: Path) -> StoredRows:
    """Return what rows (node, direction) of a deck of solids are.

    Raises
    ------
    ModelError
        If rows are twice, a node is neither of the deck nor one that CalculiX makes, or a support or a constraint
        takes rows of a node.
    """
    if len(np.unique(freedoms, axis=0)) < len(freedoms):
        raise ModelError(f"{path.with_suffix('.dof')} names rows twice: they are not those of solids. Remedy: its deck")
    made = np.setdiff1d(freedoms[:, 0], job.nodes.labels)
    turning, origins, rest = _rigid_bodies(job.blocks, made.tolist())
    count = sum(len(some.labels) for part in job.parts for some in part.elements if type_of(some.block) == INCOMPATIBLE)
    if len(rest) != INNER_NODES * count:
        raise unknown_nodes(path, rest, count)
    _check_missing(job, freedoms, turning)
    table = job.nodes
    if origins:
        rows = np.column_stack((table.labels, table.points))
        table = NodeTable.of_rows(np.vstack((rows, [(n, 0.0, 0.0, 0.0) for n in origins])), str(path), table.sets)
    named = freedoms.copy()
    for turn, reference in turning.items():
        is_turn = freedoms[:, 0] == turn
        named[is_turn] = np.column_stack((np.full(is_turn.sum(), reference), freedoms[is_turn, 1] + 3))
    return StoredRows(named, np.isin(freedoms[:, 0], rest), table, cells_of(job.parts), _lost(job, freedoms))


def cells_of(parts: Sequence[DeckPart]) -> list[CellBlock]:
    """Return the cells of a deck."""
    return [
        CellBlock(some.kind, some.labels, some.nodes) for part in parts for some in part.elements if some.kind != OTHER
    ]


def unknown_nodes(path: Path, labels: Sequence[int], count: int) -> ModelError:
    """Return the error of nodes that the deck does not explain."""
    named = f"{labels[0]} to {labels[-1]} ({len(labels)} in all)" if len(labels) else "none"
    return ModelError(
        f"{path.with_suffix('.dof')} has rows of nodes that the deck does not have: {named}, and its {count} elements "
        f"with incompatible modes would make {INNER_NODES * count}. Remedy: the deck of the job that stored them"
    )


def _rigid_bodies(blocks: Sequence[Keyword], made: list[int]) -> tuple[dict[int, int], list[int], list[int]]:
    """Return the reference of each node that turns, references that are made at the origin, and what is left."""
    turning: dict[int, int] = {}
    origins: list[int] = []
    for i, block in enumerate(blocks):
        follows = blocks[i + 1].name if i + 1 < len(blocks) else ""
        if block.name != "RIGIDBODY" and not (block.name == "COUPLING" and follows == "KINEMATIC"):
            continue
        given = [
            block.label(block.options[name], block.at) if name in block.options else None
            for name in ("REF NODE", "ROT NODE")
        ]
        if len(made) < given.count(None):
            raise block.refused("has no rows in the matrices. Remedy: the deck of the job that stored them")
        if given[0] is None:
            origins.append(made[0])
        reference, turn = (made.pop(0) if label is None else label for label in given)
        turning[turn] = reference
    return turning, origins, made


def _check_missing(job: Job, freedoms: np.ndarray, turning: dict[int, int]) -> None:
    """Refuse supports, and constraints that take some but not all rows of a node of an element."""
    used = np.setdiff1d(_solid_nodes(job.parts), list(turning))
    has = np.zeros((len(used), 3), dtype=bool)
    is_used = np.isin(freedoms[:, 0], used)
    has[np.searchsorted(used, freedoms[is_used, 0]), freedoms[is_used, 1] - 1] = True
    lacking = np.argwhere(~has)
    if not len(lacking):
        return
    pairs = {(int(used[row]), int(axis) + 1) for row, axis in lacking}
    for (label, axis), at in _supports(job).items():
        if (label, axis) in pairs:
            raise ModelError(
                f"node {label} has no row {axis}: *BOUNDARY (line {at}) holds it. Remedy: store the matrices of the "
                "free body, without *BOUNDARY; interfaces hold it in kanefe"
            )
    cards = {block.name: block.at for block in reversed(job.blocks) if block.name in DEPENDENT}
    named = ", ".join(f"*{name} (line {at})" for name, at in cards.items())
    partly = lacking[has[lacking[:, 0]].any(axis=1)]
    if not cards:
        row, axis = lacking[0]
        raise ModelError(
            f"node {used[row]} has no row {axis + 1}, and no support or constraint of the deck says why. Remedy: the "
            "deck of the job that stored the matrices"
        )
    if len(partly):
        row, axis = partly[0]
        raise ModelError(
            f"node {used[row]} has no row {axis + 1}, which a constraint takes: {named}. Remedy: interfaces "
            "of kanefe in its place"
        )


def _solid_nodes(parts: Sequence[DeckPart]) -> np.ndarray:
    """Return the labels of the nodes of cells, ascending."""
    found = [block.nodes.ravel() for block in cells_of(parts)]
    return np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *found]))


def _supports(job: Job) -> dict[tuple[int, int], int]:
    """Return the line that holds each node in each direction."""
    sets = {key_of(name): labels for name, labels in job.nodes.sets.items()}
    found: dict[tuple[int, int], int] = {}
    for block in job.blocks:
        if block.name != "BOUNDARY":
            continue
        for at, fields in block.rows():
            labels = [int(fields[0])] if fields[0].isdigit() else sets.get(key_of(fields[0]), np.zeros(0, int)).tolist()
            axes = [int(text) for text in fields[1:3] if text.isdigit()] or [1, 3]
            pairs = ((label, axis) for label in labels for axis in range(axes[0], axes[-1] + 1))
            found |= dict.fromkeys(pairs, at)
    return found


def _lost(job: Job, freedoms: np.ndarray) -> list[int]:
    """Return the nodes of masses that have no rows, and are in no cell."""
    nodes = [
        row
        for part in job.parts
        for some in part.elements
        if some.kind == OTHER and type_of(some.block) == "MASS"
        for row in some.nodes
    ]
    found = np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *nodes]))
    return np.setdiff1d(found, np.union1d(freedoms[:, 0], _solid_nodes(job.parts))).tolist()
