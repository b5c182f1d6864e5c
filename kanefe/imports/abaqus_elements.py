"""Elements of an input file of Abaqus or CalculiX: their types, labels and nodes."""

from __future__ import annotations

import re
from typing import NamedTuple

import numpy as np

from kanefe.fe_model.shapes import node_count
from kanefe.imports.abaqus_input import Keyword

_LETTERS = r"(?:[A-Z]\w*)?"  # C3D8R, C3D10MH, S4R5: the same nodes

TYPES = {
    "D?C3D4": "tetra",
    "D?C3D5": "pyramid",
    "D?C3D6": "wedge",
    "D?C3D8": "hexahedron",
    "D?C3D10": "tetra10",
    "D?C3D15": "wedge15",
    "D?C3D20": "hexahedron20",
    "CP[SE]3|S3|STRI3|M3D3|R3D3|SFM3D3": "triangle",
    "CP[SE]4|S4|M3D4|R3D4|SFM3D4|CAX4P": "quad",  # the last is what meshio writes for any of four nodes
    "CP[SE]6|S6|STRI65|M3D6|SFM3D6": "triangle6",
    "CP[SE]8|S8|M3D8|SFM3D8": "quad8",
    "S9R5|M3D9": "quad9",
    "T[23]D2|B[23]1": "line",
}
"""Types of elements that are read, as patterns before the letters of their formulation, and the cells that they are."""

_PATTERNS = [(re.compile(f"(?:{pattern}){_LETTERS}"), kind) for pattern, kind in TYPES.items()]

_NO_CELLS = re.compile(
    r"MASS|ROTARYI|HEATCAP|(?:SPRING|DASHPOT)[A12]|GAP\w*|CONN[23]D2|D?COUP[23]D|DGAP|JOINT[C23]\w*|ITS\w*|PSI\w*|MCL\w*"
)
"""Types of elements that are masses, springs and connections, and no cells."""

OTHER = "other"
"""Kind of elements that are no cells."""


class Elements(NamedTuple):
    """Elements of one keyword.

    Attributes
    ----------
    kind : str
        Of their cells, or `OTHER`.
    labels : ndarray of int, shape (m,)
    nodes : ndarray of int, shape (m, k), or (m,) arrays of `OTHER`
        Labels of nodes.
    block : Keyword
    """

    kind: str
    labels: np.ndarray
    nodes: np.ndarray
    block: Keyword


def kind_of(block: Keyword, takes_any: bool) -> str:
    """Return the kind of cell of a block of elements; of a type that is not known it is `OTHER` or an error."""
    name = block.option("TYPE").upper().replace(" ", "")
    for pattern, kind in _PATTERNS:
        if pattern.fullmatch(name):
            return kind
    if takes_any or _NO_CELLS.fullmatch(name):
        return OTHER
    raise block.refused(
        f"has elements of type {name}, which are not read. Remedy: write solids (C3D4 to C3D20), shells, plane "
        "elements, or beams and trusses of two nodes"
    )


def elements_of(block: Keyword, takes_any: bool) -> Elements:
    """Return the elements of a block.

    An element goes on in the next line where it has too few nodes, whether or not a comma ends the line (CalculiX).

    Parameters
    ----------
    block : Keyword
    takes_any : bool
        Whether types that are not read are `OTHER`, since only the labels of their nodes matter.
    """
    kind = kind_of(block, takes_any)
    if kind == OTHER:
        return _others(block)
    width = 1 + node_count(kind)
    table = block.table()
    if table is not None:
        ends = np.cumsum(table.counts)
        whole = ends[-1] % width == 0 and ((ends - table.counts) // width == (ends - 1) // width).all()
        if whole and (table.values == np.floor(table.values)).all() and (table.values > 0).all():
            rows = table.values.reshape(-1, width).astype(np.int64)
            return Elements(kind, rows[:, 0], rows[:, 1:], block)
    rows = np.array(_slowly(block, width), dtype=np.int64).reshape(-1, width)
    return Elements(kind, rows[:, 0], rows[:, 1:], block)


def _slowly(block: Keyword, width: int) -> list[list[int]]:
    """Return the numbers of each element, line by line: an error has its line."""
    rows: list[list[int]] = []
    open_row: list[int] = []
    begins = block.at
    for at, fields in block.rows():
        begins = begins if open_row else at
        open_row += [block.label(text, at) for text in fields]
        if len(open_row) > width:
            raise block.refused(
                f"has {len(open_row)} numbers of element {open_row[0]}, which begins in line {begins}, where {width} "
                "are possible. Remedy: check that the file is complete",
                at,
            )
        if len(open_row) == width:
            rows.append(open_row)
            open_row = []
    if open_row:
        raise block.refused(
            f"has element {open_row[0]} with {len(open_row) - 1} nodes, where {width - 1} are needed. Remedy: check "
            "that the file is complete",
            begins,
        )
    return rows


def _others(block: Keyword) -> Elements:
    """Return elements of any number of nodes, which go on where a comma ends the line."""
    rows: list[list[int]] = []
    goes_on = False
    for at, line in block.numbered:
        numbers = [block.label(text.strip(), at) for text in line.rstrip(", \t").split(",")]
        if goes_on:
            rows[-1] += numbers
        else:
            rows.append(numbers)
        goes_on = line.endswith(",")
    nodes = np.empty(len(rows), dtype=object)
    nodes[:] = [np.array(row[1:], dtype=np.int64) for row in rows]
    return Elements(OTHER, np.array([row[0] for row in rows], dtype=np.int64), nodes, block)
