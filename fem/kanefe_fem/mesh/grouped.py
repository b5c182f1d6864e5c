"""Meshes from blocks of cells and the groups that these are in."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from kanefe.errors import MeshError, outside
from kanefe.fe_model.model import Cells
from kanefe_fem.mesh.checks import MeshWarning
from kanefe_fem.mesh.claimed_counts import check_all_read
from kanefe_fem.mesh.mesh import WHOLE_BODY, Mesh

Block = tuple[str, np.ndarray]
"""Kind of some cells, and the nodes of each, (m, k)."""

Group = tuple[str, Sequence[np.ndarray | None]]
"""Name of a group, and its rows of each block; None: none."""

_DIMENSIONS = {"vertex": 0, "line": 1, "triangle": 2, "quad": 2, "tetra": 3, "hexahedron": 3, "wedge": 3, "pyramid": 3}


def dimension_of(kind: str) -> int:
    """Return the dimension of a cell by meshio's name."""
    bare = kind.replace("VTK_LAGRANGE_", "").lower()
    for stem, dimension in _DIMENSIONS.items():
        if bare.startswith(stem):
            return dimension
    return 3  # polyhedra and others, which are refused by name later


def grouped_mesh(
    path: Path,
    nodes: np.ndarray,
    blocks: Sequence[Block],
    groups: Sequence[Group],
    points: Mapping[str, np.ndarray],
    *,
    reader: str,
    facets: Mapping[str, list[Cells]] | None = None,
) -> Mesh:
    """Return the mesh of a file; without groups of cells all cells are the group `WHOLE_BODY`.

    Cells of the body that are in no group, beside others that are, are left out, which a warning tells; another one
    tells of nodes that are in no cell and no group.

    Parameters
    ----------
    path : Path
        For messages.
    nodes : ndarray, shape (n, 3)
        m.
    blocks : sequence of (str, ndarray)
    groups : sequence of (str, rows of each block)
    points : mapping of str to ndarray of int
        Groups of nodes.
    reader : str
        What read it.
    facets : mapping of str to list of Cells, optional
        Groups of facets that are not among the blocks; a group among the blocks comes first.

    Raises
    ------
    FileError
        If the file states another number of cells.
    MeshError
        If it has no cells.
    """
    check_all_read(path, len(nodes), sum(len(ids) for _, ids in blocks))
    if not blocks:
        raise MeshError(f"{path.name} has no cells. Remedy: mesh the geometry before saving it")
    dimension = max(dimension_of(kind) for kind, _ in blocks)
    found: dict[int, dict[str, list[Cells]]] = {d: {} for d in range(4)}
    for name, members in groups:
        for (kind, ids), rows in zip(blocks, members, strict=True):
            if rows is not None and len(rows):
                found[dimension_of(kind)].setdefault(name, []).append(Cells(kind, ids[rows]))
    found[2] = dict(facets or {}) | found[2]
    if dimension > 1 and not found[dimension]:
        found[dimension][WHOLE_BODY] = [Cells(kind, ids) for kind, ids in blocks if dimension_of(kind) == dimension]
    elif dimension > 1:
        _warn_left_out(path, dimension, blocks, groups)
    all_points = dict(points)
    all_points.update({name: np.concatenate([b.nodes.reshape(-1) for b in bs]) for name, bs in found[0].items()})
    _warn_of_apart(path, len(nodes), [ids for _, ids in blocks], all_points)
    frozen = {d: {name: tuple(bs) for name, bs in by_name.items()} for d, by_name in found.items()}
    lines = frozen[1]
    if dimension == 1 and not lines:
        lines = {"": tuple(Cells(kind, ids) for kind, ids in blocks if dimension_of(kind) == 1)}
    return Mesh(
        nodes=nodes,
        dimension=dimension,
        cells=frozen[dimension] if dimension > 1 else {},
        facets=frozen[dimension - 1] if dimension > 1 else {},
        lines=lines,
        points=all_points,
        source=path.name,
        provenance={"reader": reader},
    )


def warn_of_unread(path: Path, unread: Mapping[str, int]) -> None:
    """Warn of masses, springs and connections of a deck, which are no part of its mesh: name -> first line."""
    if unread:
        listed = ", ".join(f"{name} (line {at})" for name, at in unread.items())
        warnings.warn(
            f"{path.name} has what is no part of a mesh and is left out: {listed}. Remedy: add masses and springs to "
            "the body (kanefe_fem.LumpedMass and others), or import its matrices",
            MeshWarning,
            stacklevel=outside(),
        )


def _warn_of_apart(path: Path, count: int, cells: Sequence[np.ndarray], points: Mapping[str, np.ndarray]) -> None:
    """Warn of nodes in no cell and no group: cells that a program could not write leave them."""
    is_apart = np.ones(count, dtype=bool)
    for rows in (*cells, *points.values()):
        is_apart[rows] = False
    if is_apart.any():
        warnings.warn(
            f"{path.name}: {np.count_nonzero(is_apart)} of {count} nodes are in no cell and no group, first node "
            f"{int(np.argmax(is_apart))} (from 0). Remedy: none, if they are reference points; else check that the "
            "program has written cells of all shapes (gmsh writes no wedges and pyramids into .mesh)",
            MeshWarning,
            stacklevel=outside(),
        )


def rows_of(labels: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Return the rows of some labels among those that are known; -1: it is none of them."""
    if not len(known):
        return np.full(labels.shape, -1)
    order = np.argsort(known, kind="stable")
    where = order[np.minimum(np.searchsorted(known, labels, sorter=order), len(known) - 1)]
    rows: np.ndarray = np.where(known[where] == labels, where, -1)
    return rows


def _warn_left_out(path: Path, dimension: int, blocks: Sequence[Block], groups: Sequence[Group]) -> None:
    total = kept = 0
    for i, (kind, ids) in enumerate(blocks):
        if dimension_of(kind) == dimension:
            is_kept = np.zeros(len(ids), dtype=bool)
            for _, members in groups:
                rows = members[i]
                if rows is not None:
                    is_kept[rows] = True
            total, kept = total + len(ids), kept + int(is_kept.sum())
    if kept < total:
        warnings.warn(
            f"{path.name}: {total - kept} of {total} cells belong to no group and are left out. Remedy: add them to a "
            "group if they are part of the body",
            MeshWarning,
            stacklevel=outside(),
        )
