"""Nodes, elements, sets and surfaces of an input file of Abaqus or CalculiX as a mesh."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from kanefe.errors import FileError, outside
from kanefe.fe_model.model import Cells
from kanefe.fe_model.shapes import corner_kind
from kanefe.fe_model.skin import facet_of
from kanefe.imports.abaqus_cards import adding, check_places, unknown
from kanefe.imports.abaqus_elements import OTHER, Elements
from kanefe.imports.abaqus_input import Keyword, deck_keywords
from kanefe.imports.abaqus_members import element_rows, rows_of_node_sets, shown_name
from kanefe.imports.abaqus_nodes import line_of
from kanefe.imports.abaqus_parts import DeckPart, parts_of
from kanefe.imports.abaqus_sets import NamedSet, SetPiece, key_of
from kanefe.imports.node_table import rows_of
from kanefe_fem.mesh.abaqus_surfaces import face_corners, section_sets, surfaces
from kanefe_fem.mesh.checks import MeshWarning
from kanefe_fem.mesh.grouped import Group, dimension_of, grouped_mesh, warn_of_unread
from kanefe_fem.mesh.mesh import Mesh


class _Cells(NamedTuple):
    """Cells of one kind: rows of their nodes (m, k), and their own rows among the elements of all parts (m,)."""

    nodes: np.ndarray
    rows: np.ndarray


def read_abaqus_mesh(path: Path, trusted: bool) -> Mesh:
    """Return the mesh of an input file.

    Its groups are the element sets of solid sections (all sets, if there are none), its surfaces and its node sets.

    Raises
    ------
    FileError
        If something is not as it should be, or of a kind that is not read; the message has the line.
    MeshError
        If it has no cells.
    """
    keywords = deck_keywords(path, trusted=trusted, reader="read_mesh")
    check_places(keywords, "or mesh it with gmsh")
    parts = parts_of(keywords, takes_any=False)
    told = [line for part in parts for line in part.told]
    cells = _cells(parts)
    found = [(kind, some.nodes) for kind, some in cells.items()]
    points = rows_of_node_sets(parts, told)
    groups, facets = _groups(parts, cells, told), _facets(parts, cells, told)
    warn_of_unread(path, adding(keywords) | _no_cells(parts))
    told += [f"{name} (line {at}) is not known, and left out" for name, at in unknown(keywords).items()]
    if told:
        warnings.warn(f"{path.name}: {'; '.join(told)}", MeshWarning, stacklevel=outside())
    return grouped_mesh(
        path,
        np.concatenate([part.points for part in parts]),
        found,
        groups,
        points,
        reader="kanefe, Abaqus input",
        facets=facets,
    )


def _cells(parts: Sequence[DeckPart]) -> dict[str, _Cells]:
    """Return the cells of each kind, by rows of the nodes of all parts."""
    found: dict[str, list[_Cells]] = {}
    first_node = first_element = 0
    for part in parts:
        for some in part.elements:
            if some.kind != OTHER:
                nodes = first_node + _known(some, part)
                rows = first_element + np.arange(len(nodes))
                found.setdefault(some.kind, []).append(_Cells(nodes, rows))
            first_element += len(some.labels)
        first_node += len(part.labels)
    return {kind: _Cells(*map(np.concatenate, zip(*some, strict=True))) for kind, some in found.items()}


def _known(some: Elements, part: DeckPart) -> np.ndarray:
    """Return the rows (m, k) of the nodes of elements among those of their part."""
    rows = rows_of(some.nodes, part.labels)
    if (rows < 0).any():
        row, column = np.argwhere(rows < 0)[0]
        label = int(some.labels[row])
        raise FileError(
            f"{some.block.file} has no node {some.nodes[row, column]}, which element {label} has (line "
            f"{line_of(label, some.block)}). Remedy: check that the file is complete"
        )
    return rows


def _no_cells(parts: Sequence[DeckPart]) -> dict[str, int]:
    """Return the types of elements that are no cells: name -> first line."""
    found: dict[str, int] = {}
    for part in parts:
        for some in part.elements:
            if some.kind == OTHER:
                found.setdefault(f"*ELEMENT of type {some.block.options['TYPE']}", some.block.at)
    return found


def _groups(parts: Sequence[DeckPart], cells: dict[str, _Cells], told: list[str]) -> list[Group]:
    """Return the element sets; of solids those of sections only, where there are any."""
    kinds = list(cells)
    is_solid = [dimension_of(kind) == 3 for kind in kinds]
    found: list[tuple[str, bool, list[np.ndarray]]] = []
    for part in parts:
        of_sections = {key_of(name) for name in section_sets(part.blocks)}
        for key, named in part.element_sets.by_key.items():
            members, more = element_rows(parts, part, named)
            told += more
            rows = [np.flatnonzero(np.isin(cells[kind].rows, members)) for kind in kinds]
            found.append((shown_name(parts, part, named, of_nodes=False), key in of_sections, rows))
    has_sections = any(
        named and any(len(own) for own, solid in zip(rows, is_solid, strict=True) if solid) for _, named, rows in found
    )
    return [
        (
            name,
            [None if solid and has_sections and not named else own for solid, own in zip(is_solid, rows, strict=True)],
        )
        for name, named, rows in found
    ]


def _facets(parts: Sequence[DeckPart], cells: dict[str, _Cells], told: list[str]) -> dict[str, list[Cells]]:
    """Return the surfaces that are faces of solid elements, and tell of others."""
    facets: dict[str, list[Cells]] = {}
    for part in parts:
        for surface in surfaces(part.blocks):
            tables: dict[str, list[np.ndarray]] = {}
            for number in dict.fromkeys(number for _, number, _ in surface.faces):
                own = [(name, at) for name, other, at in surface.faces if other == number]
                pieces = [p for name, at in own for p in _faces_of(part, name, surface.block, at)]
                members, _ = element_rows(parts, part, NamedSet(surface.name, pieces))
                at = own[0][1]
                for kind, some in cells.items():
                    rows = np.isin(some.rows, members)
                    if dimension_of(kind) < 3 or not rows.any():
                        continue
                    face = face_corners(corner_kind(kind), number, surface.block, at)
                    if face is not None:
                        facet, columns = facet_of(kind, face)
                        tables.setdefault(facet, []).append(some.nodes[rows][:, list(columns)])
            named = NamedSet(surface.name)
            if tables:
                name = shown_name(parts, part, named, of_nodes=True)
                blocks = [Cells(facet, np.concatenate(some)) for facet, some in tables.items()]
                facets[name] = facets.get(name, []) + blocks
            if not tables or surface.others:
                told.append(
                    f"surface {surface.name!r} (line {surface.block.at}) is not of faces S1 to S6 of solid elements "
                    "alone; others are left out"
                )
    return facets


def _faces_of(part: DeckPart, text: str, block: Keyword, at: int) -> list[SetPiece]:
    """Return the elements that a line of a surface names: a set, or a label, perhaps of an instance."""
    sets = part.element_sets
    found = sets.named(text)
    if found is not None:
        of, named = found
        return [p if p.instance else p._replace(instance=of) for p in named.pieces]
    of, _, bare = key_of(text).rpartition(".")
    if not bare.isdigit() or (of and of not in sets.others):
        raise block.refused(f"has no element set {text!r}. Remedy: check the names of its sets", at)
    return [SetPiece(np.array([int(bare)]), block, at, of)]
