"""The mesh as plain arrays: nodes, cells, facets, lines and points, with their groups by name.

`read_mesh` reads it from a file. Nothing here depends on the finite-element library.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import MeshError, ModelError
from kanefe.fe_model.model import Cells
from kanefe.fe_model.places import PlaceLike
from kanefe.fe_model.shapes import MIDS, SERENDIPITY, kind_of_order, row_numbers, shape
from kanefe.fe_model.skin import facets_at, sides_at
from kanefe_fem.mesh.summary import summary

Blocks = Mapping[str, tuple[Cells, ...]]
"""Blocks of cells by the name of their group."""


WHOLE_BODY = "body"
"""Name of the group of all cells if a file has no groups of cells."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """A mesh with its groups by name, in metres.

    Attributes
    ----------
    nodes : ndarray, shape (n, 3)
        Reference coordinates in m.
    dimension : int
        3: the body is made of tetrahedra or hexahedra; 2: of triangles or quadrilaterals; 1: only lines (beams).
    cells : dict of str to tuple of Cells
        The body's cells by the group (material) they belong to. Empty if `dimension` is 1.
    facets : dict of str to tuple of Cells
        Groups of facets: surfaces of a 3D mesh, lines of a 2D mesh. A facet may be in several groups.
    lines : dict of str to tuple of Cells
        Groups of line elements ("line" (m, 2) or "line3" (m, 3)), whatever the dimension.
    points : dict of str to ndarray of int
        Groups of single nodes.
    source : str
        File name, or a description of the origin.
    provenance : dict
        Digest of the file, versions.
    sagitta : float
        Largest distance of the straight sides from the curved geometry that was meshed, in m. Zero if the geometry is
        straight, if mid-side nodes follow it, or if it is unknown because the file has a mesh only.
    thickness : dict of str to float
        Of a middle surface by group of cells, m, where its source tells it; `kanefe_fem.shell_body` takes it.

    Notes
    -----
    The node order in a cell is VTK's. `kanefe_fem.mesh.checks.check_mesh` refuses every mesh that would give wrong
    matrices or crash the assembler; `read_mesh` and `solid_model` call it.

    Examples
    --------
    >>> nodes = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    >>> mesh = Mesh(np.array(nodes, float), 3, {"body": (Cells("tetra", np.array([[0, 1, 2, 3]])),)})
    >>> mesh.dimension, mesh.cell_count
    (3, 1)
    """

    nodes: np.ndarray
    dimension: int
    cells: Blocks
    facets: Blocks = field(default_factory=dict)
    lines: Blocks = field(default_factory=dict)
    points: Mapping[str, np.ndarray] = field(default_factory=dict)
    source: str = "arrays"
    provenance: Mapping[str, str] = field(default_factory=dict)
    sagitta: float = 0.0
    thickness: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        nodes = np.array(self.nodes, dtype=float, ndmin=2)
        if nodes.ndim != 2 or nodes.shape[1] not in (2, 3):
            raise MeshError(f"nodes have shape {nodes.shape}. Remedy: give an array of shape (n, 3), in m")
        if nodes.shape[1] == 2:
            nodes = np.column_stack([nodes, np.zeros(len(nodes))])
        freeze = object.__setattr__
        freeze(self, "nodes", _frozen(nodes))
        for name in ("cells", "facets", "lines"):
            freeze(self, name, MappingProxyType({k: tuple(v) for k, v in getattr(self, name).items()}))
        freeze(self, "thickness", MappingProxyType(dict(self.thickness)))
        freeze(self, "points", MappingProxyType({k: _frozen(np.asarray(v)) for k, v in self.points.items()}))

    @property
    def cell_blocks(self) -> tuple[Cells, ...]:
        """All blocks of the body's cells, group by group."""
        return tuple(block for blocks in self.cells.values() for block in blocks)

    @property
    def cell_count(self) -> int:
        """Number of the body's cells."""
        return sum(len(block.nodes) for block in self.cell_blocks)

    @property
    def kind(self) -> str:
        """Shape of the body's cells; the first if there are several."""
        return self.cell_blocks[0].kind if self.cells else "line"

    @property
    def kinds(self) -> tuple[str, ...]:
        """Shapes of the body's cells, each once."""
        return tuple(dict.fromkeys(block.kind for block in self.cell_blocks))

    @property
    def order(self) -> int:
        """Order of the geometry: 1 straight, 2 with mid-side nodes."""
        return shape(self.kind).order

    @property
    def connectivity(self) -> np.ndarray:
        """Nodes of the body's cells, all of one shape, group by group, shape (m, nodes per cell)."""
        return np.concatenate([block.nodes for block in self.cell_blocks])

    @property
    def corners(self) -> np.ndarray:
        """Corners of the body's cells, shape (m, most corners); cells with fewer corners repeat the last one."""
        tables = [block.nodes[:, : shape(block.kind).corners] for block in self.cell_blocks]
        width = max(table.shape[1] for table in tables)
        return np.concatenate([table[:, np.minimum(np.arange(width), table.shape[1] - 1)] for table in tables])

    @property
    def body_nodes(self) -> np.ndarray:
        """Numbers of the nodes of the body's cells, each once."""
        return np.unique(np.concatenate([block.nodes.reshape(-1) for block in self.cell_blocks]))

    @checked
    def with_order(self, order: int) -> Mesh:
        """Return the mesh with geometry of order 1 or 2; see `to_order`."""
        return to_order(self, order)

    @checked
    def with_groups(self, places: Mapping[str, PlaceLike]) -> Mesh:
        """Return the mesh with additional groups of facets: the facets on the body's surface that lie in given places.

        Where no edge of a surface lies in a place, lines between its cells do, for stiffeners and interfaces.

        Parameters
        ----------
        places : dict of str to Near, OnPlane, InBox, InCylinder or function
            Places by the names of the new groups, for a mesh of dimension 2 or 3.

        Raises
        ------
        ModelError
            If a name is taken, or no facet lies in a place.

        Examples
        --------
        >>> from kanefe.fe_model.places import OnPlane
        >>> from kanefe_fem.mesh.simple import box_mesh
        >>> box = box_mesh((1.0, 0.1, 0.1), (10, 2, 2)).with_groups({"upper side": OnPlane((0, 0, 0.1), (0, 0, 1))})
        >>> "upper side" in box.facets
        True
        """
        facets = dict(self.facets)
        for name, place in places.items():
            if not isinstance(name, str) or name in facets:
                raise ModelError(f"{self.source}: there is a group {name!r} already. Remedy: another name")
            where = np.asarray(self.nodes), self.cell_blocks, place, f"group {name!r}"
            found = facets_at(*where) or sides_at(*where)
            if not found:
                raise ModelError(
                    f"{self.source}: no facet of the outside of the body lies at {place!r}, the group {name!r}. "
                    "Remedy: a larger distance, or another place (all corners of a facet have to be in it)"
                )
            facets[name] = found
        return replace(self, facets=facets)

    def __str__(self) -> str:
        """Return a summary: nodes, cells by shape, extent, groups."""
        points = {name: len(ids) for name, ids in self.points.items()}
        lines = {} if self.dimension == 2 else self.lines  # they are its facets
        groups = {"cells": self.cells, "facets": self.facets, "lines": lines}
        thickness = ", ".join(f"{name} {1e3 * t:.4g} mm" for name, t in self.thickness.items())
        told = f"\n  thickness {thickness}" if thickness else ""
        return summary(self.source, np.asarray(self.nodes), groups, points) + told


def to_order(mesh: Mesh, order: int) -> Mesh:
    """Return the mesh with geometry of the given order, without unused nodes.

    From 1 to 2, the new nodes are the means of corners (sides stay straight) and come after the old ones; from 2 to 1,
    the mid-side nodes are dropped, so that curved sides become straight. Facets follow the cells; facets, lines and
    points that are not on the body are left out.

    Parameters
    ----------
    mesh : Mesh
        Mesh of dimension 2 or 3.
    order : int
        1 or 2.
    """
    tables, nodes, mids = _lift_cells(mesh, order)
    used = np.zeros(len(nodes) + 1, dtype=bool)
    for cells in tables:
        used[cells.nodes] = True
    renumber = np.where(used, np.cumsum(used) - 1, -1)
    renumber[-1] = -1
    pieces = iter(tables)
    new_cells = {
        name: tuple(_renumbered(next(pieces), renumber) for _ in blocks) for name, blocks in mesh.cells.items()
    }

    def along(groups: Blocks) -> dict[str, tuple[Cells, ...]]:
        return {
            name: tuple(_renumbered(_lift_along(block, order, mids), renumber) for block in blocks)
            for name, blocks in groups.items()
        }

    points = {name: renumber[ids][renumber[ids] >= 0] for name, ids in mesh.points.items()}
    return replace(
        mesh,
        nodes=nodes[used[:-1]],
        cells=new_cells,
        facets=along(mesh.facets),
        lines=along(mesh.lines),
        points=points,
    )


def _lift_cells(mesh: Mesh, order: int) -> tuple[list[Cells], np.ndarray, dict[int, tuple[np.ndarray, np.ndarray]]]:
    """Return the blocks of cells of the given order, all nodes, and the mid-side nodes by their corners."""
    nodes = np.asarray(mesh.nodes)
    table: dict[int, tuple[np.ndarray, np.ndarray]] = {}
    mixed = len(mesh.kinds) > 1
    targets = [kind_of_order(block.kind, order) for block in mesh.cell_blocks]
    targets = [SERENDIPITY.get(target, target) if mixed else target for target in targets]
    corners = [block.nodes[:, : shape(block.kind).corners] for block in mesh.cell_blocks]
    columns = [[own] for own in corners]
    for size in sorted({len(mid) for target in targets for mid in MIDS[target]}):
        where = [[i for i, mid in enumerate(MIDS[target]) if len(mid) == size] for target in targets]
        of_blocks = [
            np.sort(own[:, [list(MIDS[target][i]) for i in places]].reshape(-1, size), axis=1)
            for own, target, places in zip(corners, targets, where, strict=True)
        ]
        keys = np.concatenate(of_blocks)
        if mesh.order == 2:
            given = [
                block.nodes[:, [own.shape[1] + i for i in places]].reshape(-1)
                for block, own, places in zip(mesh.cell_blocks, corners, where, strict=True)
            ]
            mids = np.concatenate(given)
            table[size] = (keys, mids)
        else:
            _, first, inverse = np.unique(row_numbers(keys), return_index=True, return_inverse=True)
            mids = len(nodes) + inverse.reshape(-1)
            table[size] = (keys[first], len(nodes) + np.arange(len(first)))
            nodes = np.vstack([nodes, nodes[keys[first]].mean(axis=1)])
        parts = np.split(mids, np.cumsum([len(own) for own in of_blocks])[:-1])
        for own, part, places in zip(columns, parts, where, strict=True):
            own.append(part.reshape(len(own[0]), len(places)))
    # MIDS lists edges, faces and the centre in this order, so the columns are in the order of the nodes
    return [Cells(target, np.hstack(own)) for target, own in zip(targets, columns, strict=True)], nodes, table


def _lift_along(block: Cells, order: int, table: dict[int, tuple[np.ndarray, np.ndarray]]) -> Cells:
    """Return facets or lines of the given order with the mid-side nodes of the cells, -1 where not on the body."""
    element = shape(block.kind)
    target = kind_of_order(block.kind, order)
    if 4 not in table:
        target = SERENDIPITY.get(target, target)
    corners = block.nodes[:, : element.corners]
    columns = [corners]
    for mid in MIDS[target]:
        keys, mids = table.get(len(mid), (np.zeros((0, len(mid)), dtype=int), np.zeros(0, dtype=int)))
        wanted = np.sort(corners[:, list(mid)], axis=1)
        numbers = row_numbers(np.vstack([keys, wanted]))
        known, sought = numbers[: len(keys)], numbers[len(keys) :]
        position = np.full(numbers.max(initial=0) + 1, -1)
        position[known] = mids
        columns.append(position[sought][:, None])
    return Cells(target, np.hstack(columns))


def _renumbered(block: Cells, renumber: np.ndarray) -> Cells:
    """Return the cells with new node numbers, without those that touch a dropped node."""
    nodes = renumber[block.nodes]
    return Cells(block.kind, nodes[(nodes >= 0).all(axis=1)])


def _frozen(array: np.ndarray) -> np.ndarray:
    """Return the array, read-only."""
    array.setflags(write=False)
    return array


def part_of(mesh: Mesh, cells: str | Sequence[str] | None) -> Mesh:
    """Return the mesh of some groups of cells, with the facets, lines and points that are on them.

    The facets between two bodies are in the parts of both, with separate nodes, and can be interfaces by which a scene
    joins the bodies.

    Parameters
    ----------
    mesh : Mesh
        Its node numbers must be valid.
    cells : str, sequence of str, or None
        Names of groups of cells. None: the whole mesh.

    Raises
    ------
    ModelError
        If the mesh has no such group of cells.

    Examples
    --------
    >>> rotor = part_of(mesh, "rotor")                                   # doctest: +SKIP
    """
    if cells is None:
        return mesh
    names = [cells] if isinstance(cells, str) else list(cells)
    unknown = [name for name in names if name not in mesh.cells]
    if unknown or not names:
        raise ModelError(
            f"{mesh.source} has no group of cells called {unknown[0] if unknown else None!r}. Remedy: cells= some of "
            f"{', '.join(map(repr, mesh.cells)) or 'none'}"
        )
    kept = {name: mesh.cells[name] for name in mesh.cells if name in names}
    used = np.zeros(len(mesh.nodes), dtype=bool)
    for blocks in kept.values():
        for block in blocks:
            used[block.nodes] = True
    number = np.cumsum(used) - 1

    def inside(groups: Blocks) -> dict[str, tuple[Cells, ...]]:
        found = {
            name: tuple(Cells(b.kind, number[b.nodes[used[b.nodes].all(axis=1)]]) for b in blocks)
            for name, blocks in groups.items()
        }
        return {name: blocks for name, blocks in found.items() if any(len(block.nodes) for block in blocks)}

    points = {name: number[ids[used[ids]]] for name, ids in mesh.points.items() if used[ids].any()}
    return replace(
        mesh,
        nodes=mesh.nodes[used],
        cells=inside(kept),
        facets=inside(mesh.facets),
        lines=inside(mesh.lines),
        points=points,
        thickness={name: t for name, t in mesh.thickness.items() if name in kept},
        source=mesh.source if len(kept) == len(mesh.cells) else f"{mesh.source} ({', '.join(kept)})",
    )
