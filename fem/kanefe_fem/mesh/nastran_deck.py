"""Grid points and elements of a Nastran deck: cards of small, large and free fields, and their continuations."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from kanefe.errors import FileError
from kanefe.fe_model.shapes import node_count
from kanefe.imports.bulk_data import Card, bulk_cards
from kanefe.imports.grid_points import grid_points
from kanefe.imports.node_table import rows_of
from kanefe_fem.mesh.grouped import Block, Group, dimension_of, grouped_mesh, warn_of_unread
from kanefe_fem.mesh.mesh import Mesh

_MIDS_LAST = {  # Nastran has mid-side nodes of the bottom, the sides and the top; VTK of the sides last
    "hexahedron20": (*range(12), *range(16, 20), *range(12, 16)),
    "wedge15": (*range(9), *range(12, 15), *range(9, 12)),
}

ELEMENTS: dict[str, tuple[str, ...]] = {
    "CTETRA": ("tetra", "tetra10"),
    "CPYRAM": ("pyramid", "pyramid13"),
    "CPYRA": ("pyramid", "pyramid13"),
    "CPENTA": ("wedge", "wedge15"),
    "CHEXA": ("hexahedron", "hexahedron20"),
    "CTRIA3": ("triangle",),
    "CTRIAR": ("triangle",),
    "CTRIA6": ("triangle6",),
    "CQUAD4": ("quad",),
    "CQUADR": ("quad",),
    "CQUAD8": ("quad8",),
    "CSHEAR": ("quad",),
    "CROD": ("line",),
    "CTUBE": ("line",),
    "CBAR": ("line",),
    "CBEAM": ("line",),
    "CBUSH": ("line",),
    "CGAP": ("line",),
}
"""Cards of elements that are read, and the kinds of cells that they are, by their number of nodes."""

UNREAD = (
    *("CBEND", "CBEAM3", "CONROD", "CBUSH1D", "CBUSH2D", "CWELD", "CFAST"),
    *("CQUAD", "CQUAD9", "CQUADX", "CQUADX4", "CQUADX8", "CTRIAX", "CTRIAX6", "CTRAX3", "CTRAX6"),
    *("CHEXA1", "CHEXA2", "CTETRA4", "CHEXCZ", "CPENTCZ", "CIFHEX", "CIFPENT", "CIFQDX", "CSEAM"),
    *("CPLSTN3", "CPLSTN4", "CPLSTN6", "CPLSTN8", "CPLSTS3", "CPLSTS4", "CPLSTS6", "CPLSTS8"),
)
"""Cards of elements that would be cells and are not read."""

OTHERS = (
    *("CONM1", "CONM2", "CMASS1", "CMASS2", "CMASS3", "CMASS4", "CELAS1", "CELAS2", "CELAS3", "CELAS4"),
    *("CDAMP1", "CDAMP2", "CDAMP3", "CDAMP4", "CVISC", "RBE1", "RBE2", "RBE3", "RBAR", "RROD", "RJOINT", "RSPLINE"),
    *("RSSCON", "RTRPLT", "MPC", "DMIG", "GENEL", "SPOINT"),
)
"""Cards that change mass or stiffness and are no part of a mesh."""

_COUNTS = {name: {node_count(kind): kind for kind in kinds} for name, kinds in ELEMENTS.items()}

_NONE = ("", "0")
"""Fields of nodes that are left out."""


def read_nastran_mesh(path: Path, names: Mapping[int, str], trusted: bool = False) -> Mesh:
    """Return the mesh of a deck; its groups are the properties, by number or as `names` calls them.

    Raises
    ------
    FileError
        If a card is not as it should be, or an element is of a kind that is not read; the message has the line.
    MeshError
        If it has no cells.
    """
    found: dict[str, list[list[int]]] = {}
    properties: dict[str, list[int]] = {}
    lines: dict[str, list[Card]] = {}
    others: dict[str, int] = {}
    cards = bulk_cards(path, trusted=trusted, reader="read_mesh")
    for card in cards:
        if card.name in ELEMENTS:
            kind, nodes = _nodes(card)
            found.setdefault(kind, []).append(nodes)
            lines.setdefault(kind, []).append(card)
            properties.setdefault(kind, []).append(card.whole(3 if card.field(3) else 2))
        elif card.name in OTHERS:
            others.setdefault(card.name, card.at)
        elif card.name in UNREAD:
            raise FileError(
                f"{card.file} has an element {card.name} (line {card.at}), which is not read. Remedy: mesh the part "
                f"with {', '.join(ELEMENTS)}"
            )
    warn_of_unread(path, others)
    grids = grid_points(cards)
    blocks = [(kind, _rows(np.array(rows), grids.labels, lines[kind])) for kind, rows in found.items()]
    numbers = [np.array(properties[kind]) for kind, _ in blocks]
    return grouped_mesh(path, grids.points, blocks, _groups(blocks, numbers, names), {}, reader="kanefe, Nastran deck")


def _nodes(card: Card) -> tuple[str, list[int]]:
    """Return the kind of cell of an element, and the labels of its nodes in VTK's order."""
    counts = _COUNTS[card.name]
    most = max(counts)
    fields = card.fields[2 : 2 + most]
    while fields and fields[-1] in _NONE:
        fields = fields[:-1]
    kind = counts.get(len(fields))
    if kind is None or "" in fields or "0" in fields:
        given = [field for field in fields if field not in _NONE]
        raise FileError(
            f"{card.file}: {card.name} {card.field(2)} has {len(given)} nodes (line {card.at}), where "
            f"{' or '.join(map(str, counts))} are read. Remedy: write all nodes of each element"
        )
    nodes = card.wholes(4, len(fields))
    return kind, [nodes[i] for i in _MIDS_LAST[kind]] if kind in _MIDS_LAST else nodes


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
