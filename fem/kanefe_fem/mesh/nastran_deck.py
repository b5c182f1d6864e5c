"""Grid points and elements of a Nastran deck: cards of small, large and free fields, and their continuations."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from kanefe.errors import FileError
from kanefe.fe_model.shapes import node_count
from kanefe.imports.text import read_text
from kanefe_fem.mesh.grouped import Block, Group, dimension_of, grouped_mesh, rows_of, warn_of_unread
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

_NONE = ("", "0")
"""Fields of nodes that are left out."""

_EXPONENT = re.compile(r"(?<=[\d.])([-+]\d+)$")  # 1.5-3 is 1.5e-3


_BEGIN = re.compile(r"\s*BEGIN +(BULK|SUPER)\b", re.IGNORECASE)


class Card(NamedTuple):
    """A card: its name, its fields after the name, each in its place, and the number of its line."""

    name: str
    fields: list[str]
    at: int

    def field(self, number: int) -> str:
        """Return a field, counted from 2 as in manuals; "" if it was left out."""
        return self.fields[number - 2] if number - 2 < len(self.fields) else ""


def read_nastran_mesh(path: Path, names: Mapping[int, str]) -> Mesh:
    """Return the mesh of a deck; its groups are the properties, by number or as `names` calls them.

    Raises
    ------
    FileError
        If a card is not as it should be, or an element is of a kind that is not read, or a grid point is not in the
        basic system; the message has the line.
    MeshError
        If it has no cells.
    """
    places: dict[int, list[float]] = {}
    found: dict[str, list[list[int]]] = {}
    properties: dict[str, list[int]] = {}
    lines: dict[str, list[int]] = {}
    others: dict[str, int] = {}
    for card in cards(read_text(path, "Nastran deck"), path):
        if card.name in ("GRID", "GRDSET"):
            _check_system(card, path)
        if card.name == "GRID":
            label = _whole(card, 2, path)
            place = [_number(card, i, path) for i in (4, 5, 6)]
            if places.setdefault(label, place) != place:
                raise FileError(f"{path.name} has grid point {label} twice (line {card.at}). Remedy: one of them")
        elif card.name in ELEMENTS:
            kind, nodes = _nodes(card, path)
            found.setdefault(kind, []).append(nodes)
            lines.setdefault(kind, []).append(card.at)
            properties.setdefault(kind, []).append(_whole(card, 3 if card.field(3) else 2, path))
        elif card.name in OTHERS:
            others.setdefault(card.name, card.at)
        elif card.name in UNREAD:
            raise FileError(
                f"{path.name} has an element {card.name} (line {card.at}), which is not read. Remedy: mesh the part "
                f"with {', '.join(ELEMENTS)}"
            )
    warn_of_unread(path, others)
    labels = np.array(list(places), dtype=np.int64)
    blocks = [(kind, _rows(np.array(rows), labels, lines[kind], path)) for kind, rows in found.items()]
    nodes_of_file = np.array(list(places.values()), dtype=float).reshape(-1, 3)
    numbers = [np.array(properties[kind]) for kind, _ in blocks]
    return grouped_mesh(path, nodes_of_file, blocks, _groups(blocks, numbers, names), {}, reader="kanefe, Nastran deck")


def cards(text: str, path: Path) -> Iterator[Card]:
    """Yield the cards of the bulk data of a deck.

    Raises
    ------
    FileError
        If a continuation follows no card, or another than it names; or if a line has too many fields.
    """
    card, mark = Card("", [], 0), ""
    for at, line in _bulk(text, path):
        name, fields, next_mark = _fields(line, at, path)
        if name == "" or name[0] in "+*":
            own = name.lstrip("+*")
            if not card.name or (own and mark.lstrip("+*") and own != mark.lstrip("+*")):
                raise FileError(
                    f"{path.name} goes on with {name or 'a blank field'!r} (line {at}), which the line before does not "
                    "name. Remedy: continuations behind their cards"
                )
            card.fields.extend(fields)
        else:
            if card.name:
                yield card
            card = Card(name.rstrip("*"), fields, at)
        mark = next_mark
    if card.name:
        yield card


def _bulk(text: str, path: Path) -> Iterator[tuple[int, str]]:
    """Yield the lines of the bulk data, without comments, and their numbers."""
    lines = [line.partition("$")[0].rstrip() for line in text.splitlines()]
    begins = [i for i, line in enumerate(lines) if _BEGIN.match(line)]
    if len(begins) > 1:
        raise FileError(
            f"{path.name} has parts of its own (superelements, line {begins[1] + 1}). Remedy: a deck of each"
        )
    first = begins[0] + 1 if begins else 0
    for at, line in enumerate(lines[first:], first + 1):
        first_word = line.lstrip()[:7].upper()
        if first_word == "ENDDATA":
            return
        if first_word == "INCLUDE":
            raise FileError(f"{path.name} includes another file (line {at}), which is not read. Remedy: one deck")
        if first_word:
            yield at, line
    if begins:
        raise FileError(f"{path.name} has no ENDDATA: it ends where more should follow. Remedy: write the whole deck")


def _fields(line: str, at: int, path: Path) -> tuple[str, list[str], str]:
    """Return name, fields and mark of continuation of a line; fields that are left out are blank."""
    if "," in line:
        name, *fields = (part.strip() for part in line.split(","))
        most = 4 if "*" in name else 8
        read = name.upper().rstrip("*")
        if len(fields) > most + 1 and (read in ELEMENTS or read in ("GRID", "GRDSET")):
            raise FileError(
                f"{path.name} has {len(fields)} fields in line {at}, where {most} and a continuation are possible. "
                "Remedy: several lines"
            )
        return name.upper(), fields[:most] + [""] * (most - len(fields)), "".join(fields[most:]).upper()
    line = line.expandtabs(8)
    name = line[:8].strip().upper()
    width = 16 if "*" in name else 8
    return name, [line[i : i + width].strip() for i in range(8, 72, width)], line[72:80].strip().upper()


def _nodes(card: Card, path: Path) -> tuple[str, list[int]]:
    """Return the kind of cell of an element, and the labels of its nodes in VTK's order."""
    kinds = ELEMENTS[card.name]
    counts = {node_count(kind): kind for kind in kinds}
    most = max(counts)
    fields = card.fields[2 : 2 + most]
    given = [_whole(card, 4 + i, path) for i, field in enumerate(fields) if field not in _NONE]
    kind = counts.get(len(given))
    if kind is None or any(field in _NONE for field in fields[: len(given)]):
        raise FileError(
            f"{path.name}: {card.name} {card.field(2)} has {len(given)} nodes (line {card.at}), where "
            f"{' or '.join(map(str, counts))} are read. Remedy: write all nodes of each element"
        )
    return kind, [given[i] for i in _MIDS_LAST.get(kind, range(len(given)))]


def _rows(nodes: np.ndarray, labels: np.ndarray, lines: list[int], path: Path) -> np.ndarray:
    """Return the rows of labels (m, k) of nodes among those of the deck."""
    rows = rows_of(nodes, labels)
    if (rows < 0).any():
        row, column = np.argwhere(rows < 0)[0]
        raise FileError(
            f"{path.name} has no grid point {nodes[row, column]}, which an element has (line {lines[row]}). Remedy: "
            "write the whole deck"
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


def _check_system(card: Card, path: Path) -> None:
    if card.field(3) not in ("", "0"):
        raise FileError(
            f"{path.name} has points in coordinate system {card.field(3)} (line {card.at}), and is read in the basic "
            "one alone. Remedy: write the deck with all points in the basic system"
        )


def _whole(card: Card, number: int, path: Path) -> int:
    try:
        return int(card.field(number))
    except ValueError:
        raise _no_number(card, number, path, "a whole number") from None


def _number(card: Card, number: int, path: Path) -> float:
    text = card.field(number)
    if text == "":
        return 0.0
    try:
        return float(text)
    except ValueError:
        pass
    try:
        return float(_EXPONENT.sub(r"e\1", text.upper().replace("D", "E")))
    except ValueError:
        raise _no_number(card, number, path, "a number") from None


def _no_number(card: Card, number: int, path: Path, what: str) -> FileError:
    return FileError(
        f"{path.name}: field {number} of {card.name} (line {card.at}) is {card.field(number)!r}, and should be {what}. "
        "Remedy: check that the file is complete, and the columns of its fields"
    )
