"""Members of the sets of an input file of Abaqus among its nodes and elements, of all instances and the assembly."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kanefe.imports.abaqus_parts import DeckPart
from kanefe.imports.abaqus_sets import NamedSet, SetPiece, key_of


def node_rows(parts: Sequence[DeckPart], part: DeckPart, named: NamedSet) -> tuple[np.ndarray, list[str]]:
    """Return the rows of a set of nodes among those of all parts, and what is to be told of it.

    Raises
    ------
    FileError
        If it has nodes that are not there.
    """
    found, told = [np.zeros(0, dtype=np.int64)], []
    first = _firsts([len(other.labels) for other in parts])
    for piece in named.pieces:
        of = _part_of(parts, part, piece)
        labels = piece.labels
        if piece.elements:
            labels, of = _nodes_of_set(parts, part, piece)
        rows = of.node_table.rows(labels)
        told += _check_members(rows, labels, piece, named, "node")
        found.append(first[_place(parts, of)] + rows[rows >= 0])
    return np.unique(np.concatenate(found)), told


def rows_of_node_sets(parts: Sequence[DeckPart], told: list[str]) -> dict[str, np.ndarray]:
    """Return the rows, as `node_rows`, of each set of nodes that has some, by its name; add what is to be told."""
    found: dict[str, np.ndarray] = {}
    for part in parts:
        for named in part.node_sets.by_key.values():
            rows, more = node_rows(parts, part, named)
            told += more
            if len(rows):
                found[shown_name(parts, part, named, of_nodes=True)] = rows
    return found


def element_rows(parts: Sequence[DeckPart], part: DeckPart, named: NamedSet) -> tuple[np.ndarray, list[str]]:
    """Return the rows of a set of elements among those of all parts, and what is to be told of it; see `node_rows`."""
    found, told = [np.zeros(0, dtype=np.int64)], []
    first = _firsts([len(other.element_labels) for other in parts])
    for piece in named.pieces:
        of = _part_of(parts, part, piece)
        rows = of.element_table.rows(piece.labels)
        told += _check_members(rows, piece.labels, piece, named, "element")
        found.append(first[_place(parts, of)] + rows[rows >= 0])
    return np.unique(np.concatenate(found)), told


def _firsts(counts: list[int]) -> np.ndarray:
    return np.cumsum([0, *counts[:-1]])


def _place(parts: Sequence[DeckPart], part: DeckPart) -> int:
    return next(i for i, other in enumerate(parts) if other is part)


def _part_of(parts: Sequence[DeckPart], part: DeckPart, piece: SetPiece) -> DeckPart:
    """Return the part that the labels of a piece are of."""
    if not piece.instance:
        return part
    for other in parts:
        if key_of(other.name) == piece.instance:
            return other
    raise piece.block.refused(f"is of instance {piece.instance}, which is not there. Remedy: its name", piece.at)


def _nodes_of_set(parts: Sequence[DeckPart], part: DeckPart, piece: SetPiece) -> tuple[np.ndarray, DeckPart]:
    found = part.element_sets.named(piece.elements, piece.instance)
    if found is None:
        raise piece.block.refused(
            f"has no element set {piece.elements!r}. Remedy: check the names of its sets", piece.at
        )
    of, named = found
    owner = next((other for other in parts if of and key_of(other.name) == of), part)
    inner = [_part_of(parts, owner, own) for own in named.pieces]
    if any(other is not inner[0] for other in inner):
        raise piece.block.refused(
            "is of elements of several instances, which is not read. Remedy: a set of each", piece.at
        )
    labels = np.concatenate([own.labels for own in named.pieces]) if named.pieces else piece.labels
    return inner[0].nodes_of(labels) if inner else labels, inner[0] if inner else owner


def _check_members(rows: np.ndarray, labels: np.ndarray, piece: SetPiece, named: NamedSet, what: str) -> list[str]:
    missing = labels[rows < 0]
    if not len(missing):
        return []
    if piece.is_range:
        return [f"set {named.name!r} (line {piece.at}) has a range with {len(missing)} labels of no {what}"]
    at = next((at for at, fields in piece.block.rows() if str(missing[0]) in fields), piece.at)
    raise piece.block.refused(
        f"has {what} {missing[0]} in set {named.name!r}, which is not there. Remedy: check that the file is complete",
        at,
    )


def several(parts: Sequence[DeckPart]) -> bool:
    """Return whether nodes of a file are of more than one instance."""
    return sum(len(part.labels) > 0 for part in parts[:-1]) > 1


def shown_name(parts: Sequence[DeckPart], part: DeckPart, named: NamedSet, of_nodes: bool) -> str:
    """Return the name of a set of a part: with its instance before, where there are others that it could be."""
    sets = parts[-1].node_sets if of_nodes else parts[-1].element_sets
    is_other = part is not parts[-1] and key_of(named.name) in sets.by_key
    return f"{part.name}.{named.name}" if part.name and (several(parts) or is_other) else named.name
