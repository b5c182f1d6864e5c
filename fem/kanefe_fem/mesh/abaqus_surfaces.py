"""Element sets and surfaces of an Abaqus input file: the sets of sections become groups of cells, surfaces facets.

Abaqus/CAE writes sets that overlap: all elements, the elements of a picked face, those of a section. The material of an
element is given by its `*Solid Section`. Other sets of solid elements are ignored, because each cell of a mesh belongs
to one group.
"""

from __future__ import annotations

import re
from typing import NamedTuple

from kanefe.imports.abaqus_input import Keyword

_FACES = {
    "tetra": ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)),
    "wedge": ((0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0)),
    "hexahedron": ((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)),
}
"""Corners of the faces S1, S2, ... of solid elements (Abaqus, "Solid (continuum) elements", element faces)."""


def section_sets(blocks: list[Keyword]) -> list[str]:
    """Return the element sets of the solid sections of a file, in its order, each once."""
    named = [block.options.get("ELSET", "") for block in blocks if block.name == "SOLIDSECTION"]
    return list(dict.fromkeys(filter(None, named)))


class Surface(NamedTuple):
    """A surface of elements.

    Attributes
    ----------
    name : str
    faces : list of (str, int, int)
        An element set, or the label of an element, the number of a face, and that of the line.
    others : int
        How many of its lines are no such faces.
    block : Keyword
    """

    name: str
    faces: list[tuple[str, int, int]]
    others: int
    block: Keyword


def surfaces(blocks: list[Keyword]) -> list[Surface]:
    """Return the surfaces of a file."""
    found = []
    for block in blocks:
        if block.name != "SURFACE":
            continue
        faces = []
        if block.options.get("TYPE", "ELEMENT").upper() == "ELEMENT":
            for at, fields in block.rows():
                number = re.fullmatch(r"S(\d+)", fields[1].upper()) if len(fields) > 1 else None
                if number is not None:
                    faces.append((fields[0], int(number[1]), at))
        found.append(Surface(block.option("NAME").strip("\"'"), faces, len(block.numbered) - len(faces), block))
    return found


def face_corners(kind: str, number: int, block: Keyword, at: int) -> tuple[int, ...] | None:
    """Return the corners of a face, numbered from 1 as in Abaqus, of a solid of order 1; None of a pyramid.

    Raises
    ------
    FileError
        If it has no face of that number.
    """
    faces = _FACES.get(kind)
    if faces is not None and not 1 <= number <= len(faces):
        raise block.refused(f"has face S{number} of a {kind}, which has {len(faces)}. Remedy: check the surface", at)
    return faces[number - 1] if faces is not None else None
