"""Parts of an input file of Abaqus, their instances where the assembly has them, and the assembly's own nodes and sets.

A file without instances is one part; CalculiX has no others.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from kanefe.imports.abaqus_elements import OTHER, Elements, elements_of
from kanefe.imports.abaqus_input import Keyword
from kanefe.imports.abaqus_nodes import NodeBlocks, line_of, moved, refuse_elsewhere
from kanefe.imports.abaqus_sets import SetPiece, Sets, key_of
from kanefe.imports.node_table import Labels

_CLOSES = {"PART": "ENDPART", "ASSEMBLY": "ENDASSEMBLY", "INSTANCE": "ENDINSTANCE"}

_WITHIN = {"PART": ("",), "ASSEMBLY": ("",), "INSTANCE": ("", "ASSEMBLY")}


class Scope(NamedTuple):
    """Keywords whose labels and sets are of one place: a part in one instance, or the assembly.

    Attributes
    ----------
    name : str
        Of the instance; "": the assembly, or a file without instances.
    blocks : list of Keyword
    placed : Keyword or None
        Whose data move its nodes.
    """

    name: str
    blocks: list[Keyword]
    placed: Keyword | None


@dataclass
class DeckPart:
    """Nodes, elements and sets of a scope.

    Attributes
    ----------
    name : str
        Of the instance; "": the assembly, or a file without instances.
    blocks : list of Keyword
    labels : ndarray of int, shape (n,)
        Of nodes.
    points : ndarray, shape (n, 3)
        Where the assembly has them.
    node_sets, element_sets : Sets
    elements : list of Elements
    told : list of str
        What is to be told of its nodes.
    """

    name: str
    blocks: list[Keyword]
    labels: np.ndarray
    points: np.ndarray
    node_sets: Sets
    element_sets: Sets
    elements: list[Elements]
    told: list[str]

    @cached_property
    def node_table(self) -> Labels:
        """Labels of its nodes."""
        return Labels(self.labels)

    @cached_property
    def element_table(self) -> Labels:
        """Labels of its elements."""
        return Labels(self.element_labels)

    @cached_property
    def element_labels(self) -> np.ndarray:
        """Labels of all its elements, in their order."""
        return np.concatenate([np.zeros(0, dtype=np.int64), *(some.labels for some in self.elements)])

    def nodes_of(self, elements: np.ndarray) -> np.ndarray:
        """Return the labels of the nodes of elements by their labels."""
        found = [np.zeros(0, dtype=np.int64)]
        for some in self.elements:
            rows = some.nodes[np.isin(some.labels, elements)]
            found += list(rows) if some.kind == OTHER else [rows.ravel()]
        return np.unique(np.concatenate(found))


def parts_of(blocks: Sequence[Keyword], *, takes_any: bool) -> list[DeckPart]:
    """Return the part of each instance, and last that of the assembly; without instances one part.

    Parameters
    ----------
    blocks : sequence of Keyword
    takes_any : bool
        Whether elements may be of types that are not read.

    Raises
    ------
    FileError
        If a keyword or a line is not as it should be; the message has the line.
    """
    scopes = _scopes(blocks)
    instances = [_part(scope, takes_any, None) for scope in scopes[:-1]]
    return [*instances, _part(scopes[-1], takes_any, instances)]


def _scopes(blocks: Sequence[Keyword]) -> list[Scope]:
    """Return the scopes of a file, the assembly last."""
    if not any(block.name == "INSTANCE" for block in blocks):
        return [Scope("", list(blocks), None)]
    parts: dict[str, list[Keyword]] = {}
    instances: dict[str, Scope] = {}
    rest: list[Keyword] = []
    opened: list[tuple[Keyword, list[Keyword]]] = []
    for block in blocks:
        if block.name in _CLOSES:
            _check_place(block, opened)
            inside = rest
            if block.name == "PART":
                inside = parts.setdefault(key_of(block.option("NAME")), [])
            elif block.name == "INSTANCE":
                name = block.option("NAME")
                inside = list(_of_part(block, parts))
                if key_of(name) in instances:
                    raise block.refused(f"has the name {name} again. Remedy: names that differ")
                instances[key_of(name)] = Scope(name.strip("\"'"), inside, block)
            opened.append((block, inside))
        elif block.name in _CLOSES.values():
            if not opened or _CLOSES[opened[-1][0].name] != block.name:
                still = f"*{opened[-1][0].name} of line {opened[-1][0].at} is open" if opened else "nothing is open"
                raise block.refused(f"is where {still}. Remedy: check that the file is complete")
            opened.pop()
        else:
            (opened[-1][1] if opened else rest).append(block)
    if opened:
        raise opened[-1][0].refused(f"has no *{_CLOSES[opened[-1][0].name]}. Remedy: check that the file is complete")
    return [*instances.values(), Scope("", rest, None)]


def _check_place(block: Keyword, opened: list[tuple[Keyword, list[Keyword]]]) -> None:
    within = opened[-1][0].name if opened else ""
    if within not in _WITHIN[block.name]:
        raise block.refused(
            f"is within *{within}, which begins in line {opened[-1][0].at}. Remedy: check that the file is complete"
        )


def _of_part(block: Keyword, parts: dict[str, list[Keyword]]) -> list[Keyword]:
    if "LIBRARY" in block.options or "INSTANCE" in block.options:
        raise block.refused("is taken from another job, which is not read. Remedy: write its part to the deck")
    name = block.option("PART")
    if key_of(name) not in parts:
        raise block.refused(f"is of part {name}, which is not there before it. Remedy: write the whole deck")
    return parts[key_of(name)]


def _part(scope: Scope, takes_any: bool, instances: list[DeckPart] | None) -> DeckPart:
    """Return nodes, elements and sets of a scope; of the assembly with its instances."""
    nodes, elements = NodeBlocks(), []
    by_key = {key_of(part.name): part for part in instances or ()}
    node_sets = Sets({key: part.node_sets for key, part in by_key.items()})
    element_sets = Sets({key: part.element_sets for key, part in by_key.items()})
    for block in scope.blocks:
        if block.name in ("NODE", "ELEMENT"):
            refuse_elsewhere(block)
        if block.name == "SYSTEM":
            nodes.place_system(block)
        elif block.name == "NODE" and block.pieces:
            _into(node_sets, block, "NSET", nodes.read(block))
        elif block.name == "NGEN":
            _into(node_sets, block, "NSET", nodes.generate(block))
        elif block.name == "NCOPY":
            _into(node_sets, block, "NEW SET", nodes.copy(block, _old_set(node_sets, block)))
        elif block.name == "NSET":
            node_sets.read(block, block.option("NSET"))
            if "ELSET" in block.options:
                _add_nodes_of(node_sets, element_sets, block)
        elif block.name == "ELEMENT" and block.pieces:
            elements.append(elements_of(block, takes_any))
            _into(element_sets, block, "ELSET", elements[-1].labels)
        elif block.name == "ELSET":
            element_sets.read(block, block.option("ELSET"))
    labels, points, told = nodes.table()
    points = points if scope.placed is None else moved(points, scope.placed)
    part = DeckPart(scope.name, scope.blocks, labels, points, node_sets, element_sets, elements, told)
    _check_once(part)
    return part


def _into(sets: Sets, block: Keyword, option: str, labels: np.ndarray) -> None:
    if option in block.options:
        sets.add(block.option(option), [SetPiece(labels, block, block.at)])


def _old_set(sets: Sets, block: Keyword) -> np.ndarray:
    found = sets.named(block.option("OLD SET"))
    pieces = found[1].pieces if found is not None else []
    if not pieces or any(piece.elements or piece.instance for piece in pieces):
        raise block.refused(
            f"copies the set {block.options['OLD SET']}, which is no set of labels before it. Remedy: its *NSET"
        )
    return np.unique(np.concatenate([piece.labels for piece in pieces]))


def _add_nodes_of(node_sets: Sets, element_sets: Sets, block: Keyword) -> None:
    name = block.option("ELSET")
    instance = key_of(block.options.get("INSTANCE", ""))
    empty = np.zeros(0, dtype=np.int64)
    node_sets.add(block.option("NSET"), [SetPiece(empty, block, block.at, instance, elements=name)])


def _check_once(part: DeckPart) -> None:
    """Refuse elements with the label of another one."""
    every = part.element_labels
    labels, first = np.unique(every, return_index=True)
    if len(labels) < len(every):
        row = int(np.setdiff1d(np.arange(len(every)), first)[0])
        for some in part.elements:
            if row < len(some.labels):
                raise some.block.refused(
                    f"has element {every[row]} again. Remedy: labels that are unique",
                    line_of(int(every[row]), some.block),
                )
            row -= len(some.labels)
