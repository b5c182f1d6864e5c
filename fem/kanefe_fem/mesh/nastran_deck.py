"""Grid points and elements of a Nastran deck: cards of small, large and free fields, and their continuations."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from kanefe.errors import FileError
from kanefe.fe_model.shapes import node_count
from kanefe.imports.bulk_data import bulk_cards
from kanefe.imports.bulk_names import ELEMENTS, OTHERS, UNREAD_ELEMENTS, warn_of_unknown
from kanefe.imports.card import Card, CardTable
from kanefe.imports.grid_points import grid_points
from kanefe.imports.node_table import rows_of
from kanefe_fem.mesh.checks import MeshWarning
from kanefe_fem.mesh.grouped import Block, Group, dimension_of, grouped_mesh, warn_of_unread
from kanefe_fem.mesh.mesh import Mesh

_MIDS_LAST = {  # Nastran has mid-side nodes of the bottom, the sides and the top; VTK of the sides last
    "hexahedron20": (*range(12), *range(16, 20), *range(12, 16)),
    "wedge15": (*range(9), *range(12, 15), *range(9, 12)),
}

_COUNTS = {name: {node_count(kind): kind for kind in kinds} for name, kinds in ELEMENTS.items()}


def read_nastran_mesh(path: Path, names: Mapping[int, str], trusted: bool = False) -> Mesh:
    """Return the mesh of a deck; its groups are the properties, by number or as `names` calls them.

    Raises
    ------
    FileError
        If a card is not as it should be, or an element is of a kind that is not read; the message has the line.
    MeshError
        If it has no cells.
    """
    elements: dict[str, list[Card]] = {}
    others: dict[str, int] = {}
    cards = bulk_cards(path, trusted=trusted, reader="read_mesh")
    for card in cards:
        if card.name in ELEMENTS:
            elements.setdefault(card.name, []).append(card)
        elif card.name in OTHERS:
            others.setdefault(card.name, card.at)
        elif card.name in UNREAD_ELEMENTS:
            raise FileError(
                f"{card.file} has an element {card.name} (line {card.at}), which is not read. Remedy: mesh the part "
                f"with {', '.join(ELEMENTS)}"
            )
    warn_of_unread(path, others)
    warn_of_unknown(path.name, cards, MeshWarning)
    grids = grid_points(cards)
    blocks: list[Block] = []
    properties: list[np.ndarray] = []
    for some in elements.values():
        for kind, own, nodes, numbers in _cells(some):
            blocks.append((kind, _rows(nodes, grids.labels, own)))
            properties.append(numbers)
    return grouped_mesh(
        path, grids.points, blocks, _groups(blocks, properties, names), {}, reader="kanefe, Nastran deck"
    )


def _cells(cards: list[Card]) -> Iterator[tuple[str, list[Card], np.ndarray, np.ndarray]]:
    """Yield each kind of cell that elements of one name are, and of those elements cards, nodes and properties.

    Nodes are labels in VTK's order; the number of a property that is left out is that of its element.
    """
    counts, table = _COUNTS[cards[0].name], CardTable(cards)
    if all(dimension_of(kind) == 3 for kind in counts.values()):
        table.refuse_more(2 + max(counts))
    most = max(min(max(counts), max(table.counts) - 2), 1)
    nodes = table.wholes(4, most).values
    has = nodes != 0
    count = most - np.argmax(has[:, ::-1], axis=1)
    is_whole = np.isin(count, list(counts)) & (has.sum(axis=1) == count)
    if not is_whole.all():
        row = int(np.flatnonzero(~is_whole)[0])
        card = cards[row]
        raise FileError(
            f"{card.file}: {card.name} {card.field(2)} has {has[row].sum()} nodes (line {card.at}), where "
            f"{' or '.join(map(str, counts))} are read. Remedy: write all nodes of each element"
        )
    given = table.wholes(2, 2)
    properties = np.where(given.is_blank[:, 1], given.values[:, 0], given.values[:, 1])
    if (count == most).all():
        yield counts[most], cards, _in_order(nodes, counts[most]), properties
        return
    for number in np.unique(count).tolist():
        rows = np.flatnonzero(count == number)
        own = _in_order(nodes[rows, :number], counts[number])
        yield counts[number], [cards[row] for row in rows], own, properties[rows]


def _in_order(nodes: np.ndarray, kind: str) -> np.ndarray:
    """Return the nodes of cells in VTK's order."""
    return nodes[:, list(_MIDS_LAST[kind])] if kind in _MIDS_LAST else nodes


def _rows(nodes: np.ndarray, labels: np.ndarray, cards: list[Card]) -> np.ndarray:
    """Return the rows of labels (m, k) of nodes among those of the deck."""
    rows = rows_of(nodes, labels)
    if (rows < 0).any():
        row, column = np.argwhere(rows < 0)[0]
        raise FileError(
            f"{cards[row].file} has no grid point {nodes[row, column]}, which an element has (line {cards[row].at}). "
            "Remedy: write the whole deck"
        )
    return rows


def _groups(blocks: list[Block], numbers: list[np.ndarray], names: Mapping[int, str]) -> list[Group]:
    """Return the group of each property in each dimension."""
    groups: list[Group] = []
    for number in np.unique(np.concatenate(numbers)) if numbers else ():
        for dimension in sorted({dimension_of(kind) for kind, _ in blocks}):
            rows = [
                np.flatnonzero(of_block == number) if dimension_of(kind) == dimension else None
                for (kind, _), of_block in zip(blocks, numbers, strict=True)
            ]
            groups.append((names.get(int(number)) or str(number), rows))
    return groups
