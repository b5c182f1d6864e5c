"""What is refused, and what is mended, before the assembler sees a mesh.

The finite-element library may abort the whole interpreter on a bad mesh, or lose a group without a word; so every fault
is looked for here, and named with its place and its remedy.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from kanefe.errors import MeshError
from kanefe.fe_model.model import Cells
from kanefe_fem.mesh.shapes import is_supported, row_numbers, shape

if TYPE_CHECKING:
    from kanefe_fem.mesh.mesh import Mesh

DEGENERATE = 1e-12
"""A Jacobian below this part of (longest side of the cell)^dimension counts as zero."""

_SERENDIPITY = {"hexahedron20": "hexahedron27", "quad8": "quad9"}
_PRISMS = ("wedge", "pyramid")
_CELL_KINDS = {2: ("triangle", "quad", "triangle6", "quad9"), 3: ("tetra", "hexahedron", "tetra10", "hexahedron27")}


class MeshWarning(UserWarning):
    """Something in the mesh that is probably not what the user means."""


def check_mesh(mesh: Mesh) -> Mesh:
    """Return the mesh fit for assembly: cells turned the right way round; or raise.

    Raises
    ------
    MeshError
        If the mesh has nodes that are not finite, cells of an unsupported shape, no group of cells, a cell in two
        groups, Jacobians that vanish or change sign, or parts that do not hang together.
    """
    check_arrays(mesh)
    if mesh.dimension == 1:
        return mesh
    check_groups(mesh)
    if mesh.dimension == 2:
        check_plane(mesh)
    mesh = oriented(mesh)
    check_connected(mesh)
    return mesh


def check_arrays(mesh: Mesh) -> Mesh:
    """Return the mesh if its numbers and shapes can be used at all; what is asked of a mesh of lines."""
    check_numbers(mesh)
    check_shapes(mesh)
    return mesh


def check_numbers(mesh: Mesh) -> None:
    """Refuse coordinates that are not finite and node numbers that do not exist."""
    bad = np.flatnonzero(~np.isfinite(mesh.nodes).all(axis=1))
    if len(bad):
        raise MeshError(
            f"{mesh.source}: node {bad[0]} has the coordinates {mesh.nodes[bad[0]].tolist()} "
            f"({len(bad)} such nodes). Remedy: mesh again, or mend the file; coordinates must be finite"
        )
    for label, block in _all_blocks(mesh):
        if block.nodes.ndim != 2 or not np.issubdtype(block.nodes.dtype, np.integer):
            raise MeshError(f"{mesh.source}: the nodes of {label} are not an integer array of shape (cells, nodes)")
        if block.nodes.size and (block.nodes.min() < 0 or block.nodes.max() >= len(mesh.nodes)):
            raise MeshError(
                f"{mesh.source}: {label} names node {block.nodes.max()}, but there are only {len(mesh.nodes)} nodes "
                "(numbered from 0). Remedy: the file may be damaged; write it again"
            )


def check_shapes(mesh: Mesh) -> None:
    """Refuse prisms, pyramids, serendipity elements and mixtures, each by its name."""
    for label, block in _all_blocks(mesh):
        refuse_shape(block.kind, f"{mesh.source}: {label}")
        if block.nodes.shape[1] != len(shape(block.kind).nodes):
            raise MeshError(
                f"{mesh.source}: {label} has {block.nodes.shape[1]} nodes a cell, "
                f"but {block.kind} has {len(shape(block.kind).nodes)}"
            )
    kinds = sorted({block.kind for block in mesh.cell_blocks})
    for kind in kinds:
        if kind not in _CELL_KINDS[mesh.dimension]:
            raise MeshError(f"{mesh.source}: {kind} cells cannot be the body of a mesh of dimension {mesh.dimension}")
    if len(kinds) > 1:
        where = ", ".join(f"{b.kind} in group {g!r}" for g, blocks in mesh.cells.items() for b in blocks)
        raise MeshError(
            f"{mesh.source}: the body mixes shapes ({where}), which is not supported. Remedy: mesh all of it with "
            "tetrahedra (remove Recombine and transfinite volumes), or all of it with hexahedra"
        )


def refuse_shape(kind: str, label: str) -> None:
    """Raise MeshError if `kind` is not a supported shape; the message says how to get a supported one."""
    if is_supported(kind):
        return
    if kind in _SERENDIPITY:
        raise MeshError(
            f"{label} is made of serendipity elements ({kind}), which are not supported. Remedy: mesh again with "
            f"Mesh.SecondOrderIncomplete = 0 to get {_SERENDIPITY[kind]}, or with Mesh.ElementOrder = 1"
        )
    if kind.startswith(_PRISMS):
        raise MeshError(
            f"{label} has prisms or pyramids ({kind}), which are not supported. Remedy: mesh with tetrahedra only "
            "(no Recombine in the extrusion, no transfinite surfaces that meet a free volume) or hexahedra only"
        )
    raise MeshError(
        f"{label} has elements of the shape {kind}, which is not supported. Remedy: use tetrahedra or hexahedra "
        "(triangles or quadrilaterals in the plane) of order 1 or 2: Mesh.ElementOrder = 1 or 2"
    )


def check_groups(mesh: Mesh) -> None:
    """Refuse a body without a group, and cells that are there twice (in two groups, or in one)."""
    what = {2: "surface", 3: "volume"}[mesh.dimension]
    if not mesh.cells or mesh.cell_count == 0:
        raise MeshError(
            f"{mesh.source}: no cell belongs to a physical {what}. Remedy: name the material's {what}, e.g. "
            f'Physical {what.capitalize()}("arm") = {{1}}; and the interfaces, then mesh again'
        )
    connectivity = mesh.connectivity
    corners = np.sort(connectivity[:, : shape(mesh.kind).corners], axis=1)
    numbers = row_numbers(corners)
    twice = np.flatnonzero(np.bincount(numbers)[numbers] > 1)
    if not len(twice):
        return
    owners = cell_owners(mesh)
    same = np.flatnonzero(numbers == numbers[twice[0]])
    names = list(dict.fromkeys(owners[i] for i in same))
    centre = mesh.nodes[corners[same[0]]].mean(axis=0)
    which = " and ".join(repr(name) for name in names)
    place = f"the cell at {_point(centre)} m"
    if len(names) > 1:
        raise MeshError(
            f"{mesh.source}: {place} is in two groups, {which} ({len(twice)} cells in all). Remedy: a cell has one "
            f"material, so put each {what} in one physical {what}"
        )
    raise MeshError(
        f"{mesh.source}: {place} of group {which} is there {len(same)} times. Remedy: remove the duplicate {what}s "
        "(Coherence in a .geo) and mesh again"
    )


def check_plane(mesh: Mesh) -> None:
    """Refuse surfaces in space: a 2D body lies in a plane of constant z."""
    z = mesh.nodes[np.unique(mesh.connectivity), 2]
    if np.ptp(z) > 1e-9 * max(extent(mesh), np.abs(z).max()):
        raise MeshError(
            f"{mesh.source}: the mesh has surfaces only, and they do not lie in a plane z = constant (z from "
            f"{z.min():g} to {z.max():g} m). Shells are not supported. Remedy: for a solid, mesh the volume in 3D and "
            "give it a physical volume; for a plane body, draw it in x and y"
        )


def oriented(mesh: Mesh) -> Mesh:
    """Return the mesh with positive Jacobians; cells that are merely inside out are turned round.

    Raises
    ------
    MeshError
        A Jacobian vanishes or changes its sign inside a cell.
    """
    element = shape(mesh.kind)
    owners = None
    cells: dict[str, tuple[Cells, ...]] = {}
    start = 0
    for name, blocks in mesh.cells.items():
        turned = []
        for block in blocks:
            low, high = _jacobian_range(mesh, block)
            inverted = (high < 0.0) & (low < 0.0)
            low, high = np.where(inverted, -high, low), np.where(inverted, -low, high)
            bad = np.flatnonzero(low <= 0.0)
            if len(bad):
                owners = start + bad[0]
                centre = mesh.nodes[block.nodes[bad[0]]].mean(axis=0)
                kind = "changes its sign inside" if high[bad[0]] > 0.0 else "vanishes in"
                raise MeshError(
                    f"{mesh.source}: the Jacobian {kind} cell {owners} of group {name!r}, at {_point(centre)} m "
                    f"({len(bad)} such cells in the group). Remedy: mesh again with better cells (smaller size, "
                    "Mesh.HighOrderOptimize = 2 for curved ones), or with order 1"
                )
            nodes = block.nodes
            if inverted.any():
                nodes = nodes.copy()
                nodes[inverted] = nodes[inverted][:, element.reversal()]
            start += len(nodes)
            turned.append(Cells(block.kind, nodes))
        cells[name] = tuple(turned)
    return replace(mesh, cells=cells)


def _jacobian_range(mesh: Mesh, block: Cells) -> tuple[np.ndarray, np.ndarray]:
    """Return the least and greatest Jacobian over the nodes of each cell, relative to its longest side."""
    element = shape(block.kind)
    d = element.dimension
    coordinates = mesh.nodes[block.nodes][:, :, :d]
    corners = coordinates[:, : element.corners]
    size = np.linalg.norm(corners.max(axis=1) - corners.min(axis=1), axis=1) ** d
    size[size == 0.0] = 1.0
    places = element.nodes[:1] if element.is_simplex and element.order == 1 else element.nodes
    low, high = np.full(len(size), np.inf), np.full(len(size), -np.inf)
    for gradient in element.gradients(places):
        jacobian = np.linalg.det(np.swapaxes(coordinates, 1, 2) @ gradient) / size
        jacobian[np.abs(jacobian) < DEGENERATE] = 0.0
        low, high = np.minimum(low, jacobian), np.maximum(high, jacobian)
    return low, high


def check_connected(mesh: Mesh) -> None:
    """Refuse a body in several parts; warn of nodes that coincide without being one."""
    connectivity = mesh.connectivity
    corners = connectivity[:, : shape(mesh.kind).corners]
    n, m = len(mesh.nodes), len(corners)
    incidence = sp.csr_matrix(
        (np.ones(corners.size, dtype=np.int8), corners.reshape(-1), np.arange(0, corners.size + 1, corners.shape[1])),
        shape=(m, n),
    )
    graph = sp.bmat([[None, incidence], [incidence.T, None]], format="csr")
    labels = connected_components(graph, directed=False)[1][:m]
    parts, counts = np.unique(labels, return_counts=True)
    used = np.unique(corners)
    coincident = _coincident(mesh.nodes[used], extent(mesh))
    if len(parts) == 1:
        if coincident:
            warnings.warn(
                f"{mesh.source}: {coincident} nodes lie on another one without being joined to it. If this is not a "
                "crack on purpose, merge them (Coherence in a .geo, removeDuplicateNodes in gmsh's API)",
                MeshWarning,
                stacklevel=2,
            )
        return
    places = []
    for part, count in sorted(zip(parts, counts, strict=True), key=lambda pair: -pair[1])[:5]:
        centre = mesh.nodes[corners[labels == part]].mean(axis=(0, 1))
        places.append(f"{count} cells around {_point(centre)} m")
    more = ", ..." if len(parts) > 5 else ""
    hint = (
        f"{coincident} nodes lie on another one without being joined: merge them (Coherence or BooleanFragments in a "
        ".geo, removeDuplicateNodes in gmsh's API)"
        if coincident
        else "join them, or make each part a body of its own"
    )
    raise MeshError(
        f"{mesh.source}: the body has {len(parts)} parts that are not connected: {'; '.join(places)}{more}. "
        f"Remedy: {hint}"
    )


def _coincident(nodes: np.ndarray, size: float) -> int:
    """Return how many nodes lie within 1e-9 of the body's size of an earlier one."""
    cells = np.round((nodes - nodes.min(axis=0)) / (1e-9 * size)).astype(np.int64)
    return len(cells) - len(np.unique(row_numbers(cells)))


def cell_owners(mesh: Mesh) -> list[str]:
    """Return the group of each of the body's cells, in the order of `Mesh.connectivity`."""
    return [name for name, blocks in mesh.cells.items() for block in blocks for _ in range(len(block.nodes))]


def extent(mesh: Mesh) -> float:
    """Return the diagonal of the bounding box of the body, in m."""
    used = mesh.nodes[np.unique(mesh.connectivity)]
    return float(np.linalg.norm(np.ptp(used, axis=0)))


def _all_blocks(mesh: Mesh) -> Iterator[tuple[str, Cells]]:
    """Yield every block with words that say which it is."""
    for what, groups in (("cell group", mesh.cells), ("facet group", mesh.facets), ("line group", mesh.lines)):
        for name, blocks in groups.items():
            for block in blocks:
                yield f"{what} {name!r}", block


def _point(x: np.ndarray) -> str:
    """Return coordinates for a message."""
    return f"({', '.join(f'{value:.4g}' for value in x)})"
