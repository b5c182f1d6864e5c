"""Element sets of an Abaqus input file: those that sections name are the parts of the body, surfaces are its facets.

Abaqus/CAE writes sets that overlap: all elements, the elements of a picked face, those of a section. What a cell is
made of says its `*Solid Section`; the other sets of solid elements are no groups of a mesh whose cells have one
material.
"""

from __future__ import annotations

import re

from kanefe.imports.abaqus_input import Keyword

_FACES = {
    "tetra": ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)),
    "wedge": ((0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0)),
    "hexahedron": ((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)),
}
"""Corners of the faces S1, S2, ... of solid elements (Abaqus, "Solid (continuum) elements", element faces)."""


def section_sets(blocks: list[Keyword]) -> list[str]:
    """Return the element sets that the solid sections of a file name, in its order, each once."""
    named = [block.options.get("ELSET", "") for block in blocks if " ".join(block.name.split()) == "SOLID SECTION"]
    return list(dict.fromkeys(filter(None, named)))


def surfaces(blocks: list[Keyword]) -> dict[str, list[tuple[str, int]]]:
    """Return, of each surface made of faces of element sets, the names of the sets and the numbers of the faces."""
    found: dict[str, list[tuple[str, int]]] = {}
    for block in blocks:
        if block.name != "SURFACE" or block.options.get("TYPE", "ELEMENT").upper() != "ELEMENT":
            continue
        members = []
        for line in block.lines:
            name, face = ([part.strip() for part in line.split(",")] + [""])[:2]
            number = re.fullmatch(r"S(\d+)", face.upper())
            if number is not None:
                members.append((name, int(number[1])))
        found[block.options.get("NAME", "")] = members
    return found


def face_corners(kind: str, number: int) -> tuple[int, ...] | None:
    """Return the corners of a face of a solid element of order 1, by Abaqus' number from 1; None if there is none."""
    faces = _FACES.get(kind, ())
    return faces[number - 1] if 1 <= number <= len(faces) else None
