"""Nodes, elements, sets and surfaces of an input file of Abaqus (and CalculiX)."""

from __future__ import annotations

import re
import warnings
from pathlib import Path
from typing import NamedTuple

import numpy as np

from kanefe.errors import FileError, outside
from kanefe.fe_model.model import Cells
from kanefe.fe_model.shapes import corner_kind, node_count
from kanefe.fe_model.skin import facet_of
from kanefe.imports.abaqus_input import Keyword, check_places, keywords, members, node_rows, with_includes
from kanefe.imports.text import numbers, read_text
from kanefe_fem.mesh.abaqus_sets import face_corners, section_sets, surfaces
from kanefe_fem.mesh.checks import MeshWarning
from kanefe_fem.mesh.grouped import Block, Group, dimension_of, grouped_mesh, rows_of, warn_of_unread
from kanefe_fem.mesh.mesh import Mesh

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
    "CP[SE]6|STRI65|M3D6|SFM3D6": "triangle6",
    "CP[SE]8|S8|M3D8|SFM3D8": "quad8",
    "S9R5|M3D9": "quad9",
    "T[23]D2|B[23]1": "line",
}
"""Types of elements that are read, as patterns before the letters of their formulation, and the cells that they are."""

OTHERS = (
    *("MASS", "ROTARY INERTIA", "SPRING", "DASHPOT", "TIE", "COUPLING", "MPC", "EQUATION", "RIGID BODY"),
    *("KINEMATIC COUPLING", "DISTRIBUTING COUPLING", "SHELL TO SOLID COUPLING", "MATRIX INPUT", "NONSTRUCTURAL MASS"),
)
"""Keywords that change mass or stiffness and are no part of a mesh."""


class _Elements(NamedTuple):
    """Elements of one kind: their labels (m,), and the labels of their nodes (m, k)."""

    labels: np.ndarray
    nodes: np.ndarray


def read_abaqus_mesh(path: Path, trusted: bool) -> Mesh:
    """Return the mesh of an input file.

    Its groups are the element sets of solid sections (all sets, if there are none), its surfaces and its node sets.

    Raises
    ------
    FileError
        If something is not as it should be, or of a kind that is not read; the message has the line.
    ModelError
        If nodes are placed elsewhere than where their coordinates are.
    MeshError
        If it has no cells.
    """
    blocks = with_includes(keywords(read_text(path, "Abaqus input")), path, path, trusted, reader="read_mesh")
    check_places(blocks, path.name, "or mesh it with gmsh", takes_turned=True)
    of_parts, of_assembly = _scopes(blocks)
    labels, points, point_sets = _nodes(of_parts, path)
    elements, sets = _elements(of_parts, path)
    for block in of_parts:
        if block.name == "NSET":
            made = point_sets.setdefault(block.options.get("NSET", ""), [])
            made += members(block, point_sets, path.name)
            if "ELSET" in block.options:
                made += _nodes_of(elements, _set(sets, block.options["ELSET"], block, path))
    warn_of_unread(path, _others(blocks))
    found = [(kind, _known(some.nodes, labels, f"an element of kind {kind}", path)) for kind, some in elements.items()]
    groups = _groups(blocks, found, elements, sets)
    groups_of_points = {
        name: _known(np.unique(np.array(ids, dtype=np.int64)), labels, f"the set {name}", path)
        for name, ids in point_sets.items()
        if ids
    }
    extra_points, extra_sets = _reference_points(of_assembly, len(points), path)
    return grouped_mesh(
        path,
        np.vstack((points, extra_points)),
        found,
        groups,
        groups_of_points | {name: ids for name, ids in extra_sets.items() if name not in groups_of_points},
        reader="kanefe, Abaqus input",
        facets=_facets(blocks, found, elements, sets, path),
    )


def _scopes(blocks: list[Keyword]) -> tuple[list[Keyword], list[Keyword]]:
    """Return the keywords of parts, and those of the assembly alone, whose nodes have labels of their own."""
    of_parts: list[Keyword] = []
    of_assembly: list[Keyword] = []
    has_parts, is_in_assembly = any(block.name == "PART" for block in blocks), False
    for block in blocks:
        if block.name in ("ASSEMBLY", "END ASSEMBLY"):
            is_in_assembly = has_parts and block.name == "ASSEMBLY"
        is_of_part = "INSTANCE" in block.options or any("." in line for line in block.lines)
        alone = block.name == "NODE" or (block.name == "NSET" and not is_of_part)
        (of_assembly if is_in_assembly and alone else of_parts).append(block)
    return of_parts, of_assembly


def _nodes(blocks: list[Keyword], path: Path) -> tuple[np.ndarray, np.ndarray, dict[str, list[int]]]:
    """Return labels (n,), coordinates (n, 3) and the sets that blocks of nodes name."""
    labels: dict[int, tuple[float, ...]] = {}
    sets: dict[str, list[int]] = {}
    for block in blocks:
        if block.name != "NODE":
            continue
        _check_here(block, path)
        rows = node_rows(block, path.name)
        for label, *place in rows.tolist():
            if labels.setdefault(int(label), tuple(place)) != tuple(place):
                raise FileError(
                    f"{path.name} has node {int(label)} twice (*NODE, line {block.at}), at two places. Remedy: "
                    "one part, whose labels are unique"
                )
        if "NSET" in block.options:
            sets.setdefault(block.options["NSET"], []).extend(rows[:, 0].astype(int).tolist())
    return (
        np.array(list(labels), dtype=np.int64),
        np.array(list(labels.values()), dtype=float).reshape(-1, 3),
        sets,
    )


def _elements(blocks: list[Keyword], path: Path) -> tuple[dict[str, _Elements], dict[str, list[int]]]:
    """Return the elements of each kind, and the labels of each element set."""
    found: dict[str, list[np.ndarray]] = {}
    sets: dict[str, list[int]] = {}
    for block in blocks:
        if block.name == "ELEMENT":
            _check_here(block, path)
            kind = _kind(block, path)
            width = 1 + node_count(kind)
            data = numbers(" ".join(block.lines), f"{path.name} (*ELEMENT, line {block.at})")
            if len(data) % width:
                raise FileError(
                    f"{path.name} has elements of {width - 1} nodes (*ELEMENT, line {block.at}), and {len(data)} "
                    f"numbers, which are none of {width} each. Remedy: check that the file is complete"
                )
            rows = data.reshape(-1, width).astype(np.int64)
            found.setdefault(kind, []).append(rows)
            if "ELSET" in block.options:
                sets.setdefault(block.options["ELSET"], []).extend(rows[:, 0].tolist())
        elif block.name == "ELSET":
            sets.setdefault(block.options.get("ELSET", ""), []).extend(members(block, sets, path.name))
    tables = {kind: np.concatenate(rows) for kind, rows in found.items()}
    every = np.concatenate([np.zeros(0, dtype=np.int64), *(table[:, 0] for table in tables.values())])
    labels, counts = np.unique(every, return_counts=True)
    if (counts > 1).any():
        raise FileError(f"{path.name} has element {labels[counts > 1][0]} twice. Remedy: labels that are unique")
    return {kind: _Elements(table[:, 0], table[:, 1:]) for kind, table in tables.items()}, sets


def _kind(block: Keyword, path: Path) -> str:
    """Return the kind of cell of a block of elements."""
    name = block.options.get("TYPE", "").upper()
    for pattern, kind in TYPES.items():
        if re.fullmatch(f"(?:{pattern}){_LETTERS}", name):
            return kind
    raise FileError(
        f"{path.name} has elements of type {name or 'none'} (*ELEMENT, line {block.at}), which are not read. Remedy: "
        "write solids (C3D4 to C3D20), shells, plane elements, or beams and trusses of two nodes"
    )


def _check_here(block: Keyword, path: Path) -> None:
    if "INPUT" in block.options:
        raise FileError(
            f"{path.name} has the data of *{block.name} (line {block.at}) in the file {block.options['INPUT']}, which "
            "is not read. Remedy: write them to the deck, or *INCLUDE it"
        )


def _others(blocks: list[Keyword]) -> dict[str, int]:
    """Return what changes mass or stiffness and is no part of a mesh: name -> first line."""
    others: dict[str, int] = {}
    for block in blocks:
        if (name := " ".join(block.name.split())) in OTHERS:
            others.setdefault(f"*{name}", block.at)
    return others


def _set(sets: dict[str, list[int]], name: str, block: Keyword, path: Path) -> list[int]:
    bare = name.strip('"').upper()
    for known, labels in sets.items():
        if known.strip('"').upper() in (bare, bare.rpartition(".")[2]):
            return labels
    raise FileError(
        f"{path.name} has no element set {name!r} (*{block.name}, line {block.at}). Remedy: check the names of its sets"
    )


def _nodes_of(elements: dict[str, _Elements], labels: list[int]) -> list[int]:
    """Return the labels of the nodes of some elements."""
    return [label for some in elements.values() for label in some.nodes[np.isin(some.labels, labels)].ravel().tolist()]


def _known(nodes: np.ndarray, labels: np.ndarray, whose: str, path: Path) -> np.ndarray:
    rows = rows_of(nodes, labels)
    if (rows < 0).any():
        raise FileError(
            f"{path.name} has no node {nodes[rows < 0][0]}, which {whose} has. Remedy: check that the file is complete"
        )
    return rows


def _groups(
    blocks: list[Keyword], found: list[Block], elements: dict[str, _Elements], sets: dict[str, list[int]]
) -> list[Group]:
    """Return the element sets; of solids those of sections only, where there are any."""
    named = {name.upper() for name in section_sets(blocks)}
    rows = {
        name: [np.flatnonzero(np.isin(elements[kind].labels, labels)) for kind, _ in found]
        for name, labels in sets.items()
    }
    is_solid = [dimension_of(kind) == 3 for kind, _ in found]
    with_solids = {name.upper() for name, of_blocks in rows.items() if any(map(len, _where(of_blocks, is_solid)))}
    if not named & with_solids:
        return list(rows.items())
    return [
        (
            name,
            [
                None if solid and name.upper() not in named else own
                for solid, own in zip(is_solid, of_blocks, strict=True)
            ],
        )
        for name, of_blocks in rows.items()
    ]


def _where(rows: list[np.ndarray], is_wanted: list[bool]) -> list[np.ndarray]:
    return [own for own, wanted in zip(rows, is_wanted, strict=True) if wanted]


def _facets(
    blocks: list[Keyword], found: list[Block], elements: dict[str, _Elements], sets: dict[str, list[int]], path: Path
) -> dict[str, list[Cells]]:
    """Return the surfaces that are faces of solid elements, and warn of others."""
    facets: dict[str, list[Cells]] = {}
    left: list[str] = []
    for surface in surfaces(blocks):
        tables: dict[str, list[np.ndarray]] = {}
        for name, number in surface.faces:
            labels = [int(name)] if name.isdigit() else _set(sets, name, surface.block, path)
            for kind, nodes in found:
                face = face_corners(corner_kind(kind), number) if dimension_of(kind) == 3 else None
                rows = np.isin(elements[kind].labels, labels)
                if face is not None and rows.any():
                    facet, columns = facet_of(kind, face)
                    tables.setdefault(facet, []).append(nodes[rows][:, list(columns)])
        if tables:
            facets[surface.name] = [Cells(facet, np.concatenate(some)) for facet, some in tables.items()]
        if not tables or surface.others:
            left.append(f"{surface.name!r} (line {surface.block.at})")
    if left:
        warnings.warn(
            f"{path.name}: surfaces that are not faces S1 to S6 of solid elements are left out: {', '.join(left)}",
            MeshWarning,
            stacklevel=outside(),
        )
    return facets


def _reference_points(blocks: list[Keyword], first: int, path: Path) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Return the nodes of the assembly alone, and their sets, as rows from `first` on."""
    labels, points, sets = _nodes(blocks, path)
    for block in blocks:
        if block.name == "NSET":
            sets.setdefault(block.options.get("NSET", ""), []).extend(members(block, sets, path.name))
    return points, {
        name: first + _known(np.unique(np.array(ids, dtype=np.int64)), labels, f"the set {name}", path)
        for name, ids in sets.items()
        if ids
    }
