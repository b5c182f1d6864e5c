"""Thickness of shells that varies, in decks: at corners of elements (T1 to T4 of Nastran), or at nodes (Abaqus)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from kanefe.fe_model.shapes import shape
from kanefe.imports.abaqus_elements import OTHER
from kanefe.imports.abaqus_input import Keyword
from kanefe.imports.abaqus_members import element_rows, node_rows
from kanefe.imports.abaqus_parts import DeckPart, parts_of
from kanefe.imports.abaqus_sets import NamedSet, SetPiece
from kanefe.imports.card import Card
from kanefe.imports.grid_points import GridPoints
from kanefe.imports.node_table import rows_of

EVEN = 1e-9
"""Largest difference of two thicknesses of one grid point, relative to them."""


@dataclass(frozen=True, eq=False)
class ThicknessOfNodes:
    """A function of points (n, 3) in m that returns the thickness at the nearest known one, shape (n,), m.

    Parameters
    ----------
    points : ndarray, shape (k, 3)
        Corners of elements, the middles of their sides and their centres, m.
    values : ndarray, shape (k,)
        m.
    """

    points: np.ndarray
    values: np.ndarray

    def __call__(self, x: np.ndarray) -> np.ndarray:
        """Return the thickness at points."""
        return np.asarray(self.values[cKDTree(self.points).query(x)[1]])


def thickness_of_corners(
    elements: Sequence[Card], places: Sequence[tuple[int, ...]], flags: Sequence[int], usual: float, grids: GridPoints
) -> float | ThicknessOfNodes:
    """Return the thickness of the elements of a property, m: a number if none gives its own at its corners.

    Parameters
    ----------
    elements : sequence of Card
    places, flags : sequence
        Their fields of T1 to T4, and of TFLAG: 1 if these are relative to `usual`.
    usual : float
        Of the property, where a corner has none, m.
    grids : GridPoints

    Raises
    ------
    FileError
        If a thickness is not positive, or a grid point has two; the message has the line.
    """
    if not any(card.field(place) for card, own in zip(elements, places, strict=True) for place in own):
        return usual
    of_grid: dict[int, float] = {}
    points, values = [], []
    for card, own, flag in zip(elements, places, flags, strict=True):
        scale = usual if card.field(flag) and card.whole(flag) == 1 else 1.0
        t = np.array([scale * card.number(place) if card.field(place) else usual for place in own])
        labels = [card.whole(4 + i) for i in range(len(own))]
        if not (t > 0.0).all():
            raise card.refused(f"has the thickness {t.min():g} at a corner. Remedy: positive ones")
        for label, one in zip(labels, t.tolist(), strict=True):
            known = of_grid.setdefault(label, one)
            if abs(known - one) > EVEN * known:
                raise card.refused(
                    f"has the thickness {one:g} at grid point {label}, where another element of its property has "
                    f"{known:g}. Remedy: a property for each, or one thickness"
                )
        x = grids.points[rows_of(np.array([labels]), grids.labels)[0]]
        points += [x, (x + np.roll(x, -1, axis=0)) / 2.0, x.mean(axis=0)[None]]
        values += [t, (t + np.roll(t, -1)) / 2.0, t.mean()[None]]
    return ThicknessOfNodes(np.concatenate(points), np.concatenate(values))


def thickness_of_nodes(section: Keyword, blocks: Sequence[Keyword]) -> ThicknessOfNodes:
    """Return the thickness of the elements of a section of Abaqus by its NODAL THICKNESS, m.

    Parameters
    ----------
    section : Keyword
        A ``*SHELL SECTION`` with NODAL THICKNESS.
    blocks : sequence of Keyword
        The whole deck.

    Raises
    ------
    FileError
        If a node of its elements has no thickness, or one that is not positive; the message has the line.
    """
    parts = parts_of(blocks, takes_any=False)
    points = np.concatenate([part.points for part in parts])
    given = _at_nodes(parts, len(points))
    found_points, values = [], []
    for part in parts:
        if not any(block is section for block in part.blocks):
            continue
        named = part.element_sets.named(section.option("ELSET"))
        members = element_rows(parts, part, named[1])[0] if named else np.zeros(0, dtype=np.int64)
        for kind, nodes in _cells_of(parts, members):
            t = given[nodes]
            if np.isnan(t).any():
                x = ", ".join(f"{c:g}" for c in points[nodes[np.isnan(t)][0]])
                raise section.refused(
                    f"has NODAL THICKNESS, and the node at ({x}) has none. Remedy: *NODAL THICKNESS of all its nodes"
                )
            corners = shape(kind).corners
            x, ends = points[nodes[:, :corners]], t[:, :corners]
            found_points += [points[nodes].reshape(-1, 3), x.mean(axis=1)]
            values += [t.ravel(), ends.mean(axis=1)]
            if nodes.shape[1] == corners:  # the middles of sides are made when it is read
                found_points.append(((x + np.roll(x, -1, axis=1)) / 2.0).reshape(-1, 3))
                values.append(((ends + np.roll(ends, -1, axis=1)) / 2.0).ravel())
    if not values:
        raise section.refused("has no elements, or belongs to no part. Remedy: check the name of its set")
    return ThicknessOfNodes(np.concatenate(found_points), np.concatenate(values))


def _at_nodes(parts: Sequence[DeckPart], count: int) -> np.ndarray:
    """Return what ``*NODAL THICKNESS`` gives each node of all parts, m; NaN: nothing."""
    found = np.full(count, np.nan)
    for part in parts:
        for block in part.blocks:
            if block.name != "NODALTHICKNESS":
                continue
            if block.options.get("GENERATE") is not None:
                raise block.refused("has GENERATE, which is not read. Remedy: a line for each node or set")
            for at, fields in block.rows():
                thickness = block.number(fields[1], at) if len(fields) > 1 and fields[1] else 0.0
                if not thickness > 0.0:
                    raise block.refused(f"has the thickness {thickness:g}. Remedy: a positive one", at)
                set_of = part.node_sets.named(fields[0])
                if set_of is None:
                    piece = SetPiece(np.array([block.label(fields[0], at)]), block, at)
                    named = NamedSet(fields[0], [piece])
                else:
                    pieces = [p if p.instance else p._replace(instance=set_of[0]) for p in set_of[1].pieces]
                    named = NamedSet(set_of[1].name, pieces)
                found[node_rows(parts, part, named)[0]] = thickness
    return found


def _cells_of(parts: Sequence[DeckPart], members: np.ndarray) -> list[tuple[str, np.ndarray]]:
    """Return kind and rows of nodes of the elements whose rows are members, among those of all parts."""
    found, first_node, first_element = [], 0, 0
    for part in parts:
        for some in part.elements:
            own = np.isin(first_element + np.arange(len(some.labels)), members)
            if some.kind != OTHER and own.any():
                found.append((some.kind, first_node + rows_of(some.nodes[own], part.labels)))
            first_element += len(some.labels)
        first_node += len(part.labels)
    return found
