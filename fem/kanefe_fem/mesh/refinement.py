"""Meshes with smaller cells: each cell is split, and its groups keep their parts.

A new node is identified by the corners between which it lies, with their weights in the functions of order 1: two cells
that share a side or a face have the same ones there. It is where the functions of its cell put it, so that curved cells
keep their shape, and a mesh that fits stays one that fits.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import MeshError, ModelError
from kanefe.fe_model.model import Cells
from kanefe.fe_model.shapes import corner_kind, row_numbers, shape
from kanefe_fem.machine.memory import check_size
from kanefe_fem.mesh.cell_splits import DIAGONALS, Split, split_cell
from kanefe_fem.mesh.checks import check_arrays
from kanefe_fem.mesh.mesh import Mesh

PARTS = 192
"""Parts of a weight: at quarters of the sides of a cube they are multiples of 1/64, of a pyramid of 1/48."""

SAME = 1e-9
"""Distance of what two cells have for one node, relative to the size of the mesh, that is round-off."""

MOST_TIMES = 12
"""Largest number of times: a single cube then has 7e10 cells."""


@checked
def refined_mesh(mesh: Mesh, times: int = 1) -> Mesh:
    """Return the mesh with each cell split into halves along each of its sides.

    A line gives 2 cells, a triangle or quadrangle 4, a solid 8, a pyramid 6 and 4 tetrahedra. Old nodes keep their
    numbers, and new ones follow them. The parts of a cell follow each other in its group; groups of points stay.

    Parameters
    ----------
    mesh : Mesh
        Of any dimension and order.
    times : int
        How many times this is done.

    Returns
    -------
    Mesh
        Of the same order. Straight sides stay straight, and those of second order keep their curves: the error of the
        geometry stays that of the mesh given. A curved source is better meshed anew, with smaller cells.

    Raises
    ------
    ModelError
        If the number is not valid.
    MeshError
        If a node or a cell of the mesh is not valid, or a file's worth of memory would not hold it.

    Examples
    --------
    >>> from kanefe_fem import box_mesh
    >>> fine = refined_mesh(box_mesh((1.0, 0.1, 0.1), (10, 1, 1)))
    >>> fine.cell_count, len(fine.facets["root"][0].nodes)
    (80, 4)
    """
    if isinstance(times, bool) or not 0 <= times <= MOST_TIMES:
        raise ModelError(f"refined_mesh: times={times!r}. Remedy: a whole number from 0 to {MOST_TIMES}")
    check_arrays(mesh)
    factor = 2**mesh.dimension
    check_size(len(mesh.nodes) * factor**times, f"refined_mesh: {mesh.source} with cells split {times} times")
    for _ in range(times):
        mesh = _split(mesh)
    return mesh


class _Parents(NamedTuple):
    """Cells of one block that are split alike.

    Attributes
    ----------
    kind : str
    nodes : ndarray of int, shape (cells, nodes per cell)
    at : ndarray of int
        Their places in the block.
    split : Split
    """

    kind: str
    nodes: np.ndarray
    at: np.ndarray
    split: Split


def _split(mesh: Mesh) -> Mesh:
    groups = [mesh.cells, mesh.facets, mesh.lines]
    parents = [
        [(name, [_parents(mesh.nodes, block) for block in blocks]) for name, blocks in group.items()]
        for group in groups
    ]
    every = [one for group in parents for _, blocks in group for block in blocks for one in block]
    nodes, numbered = _numbered(np.asarray(mesh.nodes), every, mesh.source)
    tables = iter(numbered)
    cells, facets, lines = (
        {name: tuple(part for block in blocks for part in _parts(block, tables)) for name, blocks in group}
        for group in parents
    )
    splits = str(int(mesh.provenance.get("splits", "0")) + 1)
    provenance = {**mesh.provenance, "splits": splits}
    return replace(mesh, nodes=nodes, cells=cells, facets=facets, lines=lines, provenance=provenance)


def _parents(nodes: np.ndarray, block: Cells) -> list[_Parents]:
    """Return the cells of a block by how they are split: tetrahedra by the shortest diagonal of their middle."""
    if corner_kind(block.kind) != "tetra":
        return [_Parents(block.kind, block.nodes, np.arange(len(block.nodes)), split_cell(block.kind))]
    element, corners = shape(block.kind), shape("tetra").nodes
    lengths = []
    for diagonal in DIAGONALS:
        one, other = element.values(np.array([corners[list(side)].mean(axis=0) for side in diagonal]))
        lengths.append(np.linalg.norm(np.einsum("n,mnx->mx", other - one, nodes[block.nodes]), axis=1))
    shortest = np.argmin(lengths, axis=0)
    return [
        _Parents(block.kind, block.nodes[shortest == i], np.flatnonzero(shortest == i), split_cell(block.kind, i))
        for i in range(len(DIAGONALS))
    ]


def _parts(parents: list[_Parents], tables: Iterator[np.ndarray]) -> list[Cells]:
    """Return the parts of the cells of a block, those of one cell after each other."""
    by_kind: dict[str, list[tuple[np.ndarray, np.ndarray]]] = {}
    for one in parents:
        numbers = next(tables)  # (cells, places)
        for kind, table in one.split.parts:
            own = numbers[:, table].reshape(-1, table.shape[1])
            by_kind.setdefault(kind, []).append((np.repeat(one.at, len(table)), own))
    found = []
    for kind, pieces in by_kind.items():
        order = np.argsort(np.concatenate([at for at, _ in pieces]), kind="stable")
        found.append(Cells(kind, np.concatenate([own for _, own in pieces])[order]))
    return found


def _numbered(nodes: np.ndarray, every: list[_Parents], source: str) -> tuple[np.ndarray, list[np.ndarray]]:
    """Return all nodes, the old ones first, and the node at each place of each cell, (cells, places)."""
    numbers, count, added = [], len(nodes), [nodes]
    on_sides: dict[int, list[tuple[int, int, np.ndarray]]] = {}  # by how many corners they lie between
    positions = [np.einsum("pn,mnx->mpx", shape(p.kind).values(p.split.places), nodes[p.nodes]) for p in every]
    for which, one in enumerate(every):
        m, known = len(one.nodes), one.nodes.shape[1]
        numbers.append(np.full((m, len(one.split.places)), -1))
        numbers[which][:, :known] = one.nodes
        weights = shape(corner_kind(one.kind)).values(one.split.places)
        weights = np.rint(PARTS * weights).astype(np.int64)
        for column in range(known, len(one.split.places)):
            between = np.flatnonzero(weights[column])
            if shape(one.kind).dimension == 3 and len(between) == weights.shape[1]:  # inside, and in no other cell
                numbers[which][:, column] = count + np.arange(m)
                added.append(positions[which][:, column])
                count += m
            else:
                key = one.nodes[:, between] * PARTS + weights[column, between] - 1
                on_sides.setdefault(len(between), []).append((which, column, np.sort(key, axis=1)))
    size = float(np.ptp(nodes, axis=0).max())
    for found in on_sides.values():
        keys = row_numbers(np.concatenate([key for _, _, key in found]))
        _, first, number = np.unique(keys, return_index=True, return_inverse=True)
        number = number.reshape(-1)
        where = np.concatenate([positions[which][:, column] for which, column, _ in found])
        apart = np.abs(where - where[first][number]).max(axis=1)
        if apart.max(initial=0.0) > SAME * size:
            place = ", ".join(f"{x:.4g}" for x in where[int(apart.argmax())])
            raise MeshError(
                f"{source}: cells that share corners do not share the side between them, near ({place}) m: its nodes "
                "are not the same. Remedy: merge them where the mesh is made"
            )
        ends = np.cumsum([len(key) for _, _, key in found])[:-1]
        for (which, column, _), given in zip(found, np.split(count + number, ends), strict=True):
            numbers[which][:, column] = given
        added.append(where[first])
        count += len(first)
    return np.concatenate(added), numbers
