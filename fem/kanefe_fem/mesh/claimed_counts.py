"""Counts of nodes and cells that mesh files state, against what they can hold and what was read of them.

meshio trusts the counts in headers, and leaves out what it does not know, with a line on the terminal at most. Formats
that state no counts (decks of Abaqus and Nastran) have readers that refuse each line which they do not know.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

from kanefe.errors import FileError, outside
from kanefe_fem.mesh.checks import MeshWarning
from kanefe_fem.mesh.msh_file import has_parts, msh_version, stated_counts
from kanefe_fem.mesh.named_files import xml_elements

LONGEST_HEAD = 1 << 16
"""Largest size of the header of a .ply file, bytes."""

STL_HEAD, STL_TRIANGLE = 84, 50
"""Sizes of the head and of a triangle of a binary .stl file, bytes."""

MEDIT = rb"Edges|Triangles|Quadrilaterals|Tetrahedra|Prisms|Pyramids|Hexahedra|Hexaedra"
"""Keywords of cells in files of Medit."""


class Counts(NamedTuple):
    """Numbers of nodes and of cells of all dimensions; None: not stated."""

    nodes: int | None
    cells: int | None


def check_counts(path: Path) -> None:
    """Refuse a file whose header claims more than the file holds: meshio would leave the rest uninitialised.

    Raises
    ------
    FileError
        If a count is larger than the file can hold; the message names both numbers.
    """
    for what, claimed, found in _limits(path):
        if claimed > found:
            raise FileError(
                f"{path.name} claims {claimed} of {what}, and has {found} at most: it is cut or damaged. Remedy: write "
                "it again"
            )


def check_all_read(path: Path, nodes: int, cells: int) -> None:
    """Compare what was read of a file with the counts that it states.

    Parameters
    ----------
    path : Path
    nodes, cells : int
        Numbers that were read, cells of all dimensions.

    Raises
    ------
    FileError
        If cells are missing, or there are more.

    Warns
    -----
    MeshWarning
        If the number of nodes is another: nodes that are in no cell may be left out.
    """
    read = _STATED.get(path.suffix.lower())
    stated = Counts(None, None) if read is None else read(path)
    if stated.cells not in (None, cells):
        raise FileError(
            f"{path.name} states {stated.cells} cells, and {cells} were read: others are of shapes that its reader "
            "does not know, or the file is damaged. Remedy: write it in another format, such as .msh of gmsh"
        )
    if stated.nodes not in (None, nodes):
        warnings.warn(
            f"{path.name} states {stated.nodes} nodes, and {nodes} were read. Remedy: none, if the others are in no "
            "cell; else write it again",
            MeshWarning,
            stacklevel=outside(),
        )


def _limits(path: Path) -> Iterator[tuple[str, int, int]]:
    """Yield what is counted, the number that the file claims, and the largest number that it can hold."""
    suffix = path.suffix.lower()
    if suffix == ".ply":
        for name, count in _ply_elements(path):
            yield name, count, path.stat().st_size  # each takes a byte at least
    elif suffix == ".stl":
        triangles = _stl_head(path)
        if triangles is not None:
            yield "triangles", triangles, (path.stat().st_size - STL_HEAD) // STL_TRIANGLE
    elif suffix == ".xml":
        for tag in ("vertices", "cells"):
            for element in xml_elements(path, tag):
                yield tag, _whole(element.get("size")) or 0, len(element)


def _ply_elements(path: Path) -> list[tuple[str, int]]:
    with path.open("rb") as file:
        head = file.read(LONGEST_HEAD).partition(b"end_header")[0]
    return [(name.decode(), int(count)) for name, count in re.findall(rb"^element +(\w+) +(\d+)", head, re.MULTILINE)]


def _whole(text: str | None) -> int | None:
    return int(text) if text is not None and text.isdecimal() else None


def _ply(path: Path) -> Counts:
    found = dict(_ply_elements(path))
    return Counts(found.get("vertex"), found.get("face", 0))


def _dolfin(path: Path) -> Counts:
    sizes = {tag: [_whole(one.get("size")) for one in xml_elements(path, tag)] for tag in ("vertices", "cells")}
    return Counts(*(found[0] if len(found) == 1 else None for found in sizes.values()))


def _vtu(path: Path) -> Counts:
    content = path.read_bytes().partition(b"<AppendedData")[0]
    pieces = re.findall(rb"<Piece\b([^>]*)>", content)
    numbers = [
        sum(int(count) for piece in pieces for count in re.findall(rb"%b\s*=\s*[\"']\s*(\d+)" % name, piece))
        for name in (b"NumberOfPoints", b"NumberOfCells")
    ]
    return Counts(*numbers) if pieces else Counts(None, None)


def _vtk(path: Path) -> Counts:
    content = path.read_bytes()
    if not re.search(rb"^DATASET\s+UNSTRUCTURED_GRID", content[:1000], re.MULTILINE | re.IGNORECASE):
        return Counts(None, None)
    points = re.search(rb"^POINTS\s+(\d+)", content, re.MULTILINE)
    cells = re.search(rb"^CELLS\s+(\d+)\s+\d+\s*?\n(OFFSETS)?", content, re.MULTILINE)
    return Counts(
        int(points[1]) if points else None,
        int(cells[1]) - (cells[2] is not None) if cells else None,  # of offsets there is one more than of cells
    )


def _su2(path: Path) -> Counts:
    text = path.read_text(encoding="latin-1")
    points = re.findall(r"^\s*NPOIN\s*=\s*(\d+)", text, re.MULTILINE)
    cells = re.findall(r"^\s*(?:NELEM|MARKER_ELEMS)\s*=\s*(\d+)", text, re.MULTILINE)
    return Counts(int(points[0]) if len(points) == 1 else None, sum(map(int, cells)))


def _medit(path: Path) -> Counts:
    content = re.sub(rb"#[^\n]*", b"", path.read_bytes())
    points = re.findall(rb"^\s*Vertices\s+(\d+)", content, re.MULTILINE)
    cells = re.findall(rb"^\s*(?:%b)(?:P2|Q2)?\s+(\d+)" % MEDIT, content, re.MULTILINE)
    return Counts(int(points[0]) if len(points) == 1 else None, sum(map(int, cells)))


def _stl(path: Path) -> Counts:
    triangles = _stl_head(path)
    if triangles is None:
        triangles = len(re.findall(rb"^\s*facet\s+normal", path.read_bytes(), re.MULTILINE | re.IGNORECASE))
    return Counts(None, triangles)


def _stl_head(path: Path) -> int | None:
    """Return the number of triangles in the head of a binary file; None of a text."""
    with path.open("rb") as file:
        head = file.read(STL_HEAD + STL_TRIANGLE)
    return int.from_bytes(head[80:84], "little") if b"\0" in head and len(head) >= STL_HEAD else None


def _off(path: Path) -> Counts:
    numbers = re.match(r"\s*OFF\s+(\d+)\s+(\d+)", re.sub(r"#[^\n]*", "", path.read_text(encoding="latin-1")))
    return Counts(int(numbers[1]), int(numbers[2])) if numbers else Counts(None, None)


def _xdmf(path: Path) -> Counts:
    found = [one for one in xml_elements(path, "Topology") if one.get("TopologyType") or one.get("Type")]
    counts = {_whole(one.get("NumberOfElements")) for one in found}
    return Counts(None, counts.pop() if len(counts) == 1 and len(found) == 1 else None)


def _tetgen(path: Path) -> Counts:
    heads = []
    for suffix in (".node", ".ele"):
        own = path.with_suffix(suffix)
        text = re.sub(r"#[^\n]*", "", own.read_text(encoding="latin-1")) if own.is_file() else ""
        heads.append(_whole(text.split()[0]) if text.split() else None)
    return Counts(*heads)


def _msh(path: Path) -> Counts:
    nodes, cells = stated_counts(path)
    # gmsh makes copies of facets between parts when it reads format 2
    return Counts(nodes, None if msh_version(path).startswith("2") and has_parts(path) else cells)


_STATED: dict[str, Callable[[Path], Counts]] = {
    ".msh": _msh,
    ".ply": _ply,
    ".xml": _dolfin,
    ".vtu": _vtu,
    ".vtk": _vtk,
    ".su2": _su2,
    ".mesh": _medit,
    ".stl": _stl,
    ".off": _off,
    ".xdmf": _xdmf,
    ".xmf": _xdmf,
    ".node": _tetgen,
    ".ele": _tetgen,
}
"""Functions that read the counts which a format states, by its suffix."""
