"""Checks of a mesh before assembly; inverted cells are corrected, other faults raise an error.

The finite-element library may abort the interpreter on a bad mesh, or drop a group without a message. The errors raised
here name the fault, its place and the remedy.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from kanefe.errors import MeshError, outside
from kanefe.fe_model.model import Cells
from kanefe.fe_model.shapes import MIDS, Shape, is_supported, quadrature, row_numbers, shape
from kanefe.fe_model.skin import skin
from kanefe_fem.mesh.jacobians import folded_inside

if TYPE_CHECKING:
    from kanefe_fem.mesh.mesh import Mesh

DEGENERATE = 1e-12
"""Jacobian, relative to (longest side of the cell)^dimension, below which it counts as zero."""

STRAIGHT = 1e-12
"""Distance of mid-side nodes from the means of their corners, relative to the body, below which the geometry is
straight."""

_MIXED = {
    1: ("triangle", "quad", "tetra", "hexahedron", "wedge", "pyramid"),
    2: ("triangle6", "quad8", "tetra10", "hexahedron20", "wedge15", "pyramid13"),
}
"""Shapes of each order that fit together: none has nodes inside its faces."""


class MeshWarning(UserWarning):
    """The mesh has a property that is probably not intended."""


def check_mesh(mesh: Mesh) -> Mesh:
    """Return the mesh ready for assembly, with all cells of volumes oriented positively; surfaces keep their sides.

    Raises
    ------
    MeshError
        If the mesh has nodes that are not finite, cells of an unsupported shape, no group of cells, a cell in two
        groups, Jacobians that vanish or change sign, or parts that are not connected.
    """
    check_arrays(mesh)
    if mesh.dimension == 1:
        return mesh
    check_groups(mesh)
    mesh = oriented(mesh, keeps_sides=mesh.dimension == 2)
    if len(mesh.kinds) > 1:
        check_fit(mesh)
    check_connected(mesh)
    return mesh


def check_arrays(mesh: Mesh) -> Mesh:
    """Return the mesh after checking its numbers and shapes, the only checks of a mesh of lines."""
    check_numbers(mesh)
    check_shapes(mesh)
    return mesh


def check_numbers(mesh: Mesh) -> None:
    """Raise a MeshError for coordinates that are not finite and node numbers that do not exist."""
    bad = np.flatnonzero(~np.isfinite(mesh.nodes).all(axis=1))
    if len(bad):
        raise MeshError(
            f"{mesh.source}: node {bad[0]} has the coordinates {mesh.nodes[bad[0]].tolist()} "
            f"({len(bad)} such nodes). Remedy: mesh again, or correct the file; coordinates must be finite"
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
    """Raise a MeshError for shapes that are not supported or cannot be mixed."""
    for label, block in _all_blocks(mesh):
        refuse_shape(block.kind, f"{mesh.source}: {label}")
        if block.nodes.shape[1] != len(shape(block.kind).nodes):
            raise MeshError(
                f"{mesh.source}: {label} has {block.nodes.shape[1]} nodes a cell, "
                f"but {block.kind} has {len(shape(block.kind).nodes)}"
            )
    kinds = mesh.kinds
    for kind in kinds:
        if shape(kind).dimension != mesh.dimension:
            raise MeshError(f"{mesh.source}: {kind} cells cannot be the body of a mesh of dimension {mesh.dimension}")
    if len(kinds) > 1 and not any(set(kinds) <= set(together) for together in _MIXED.values()):
        where = ", ".join(f"{b.kind} in group {g!r}" for g, blocks in mesh.cells.items() for b in blocks)
        raise MeshError(
            f"{mesh.source}: the body mixes shapes that do not fit each other ({where}). Remedy: elements of one "
            "order, and without nodes inside their faces (Mesh.SecondOrderIncomplete = 1)"
        )


def refuse_shape(kind: str, label: str) -> None:
    """Raise a MeshError if a shape is not supported; the message names the supported ones."""
    if not is_supported(kind):
        raise MeshError(
            f"{label} has elements of the shape {kind}, which is not supported. Remedy: tetrahedra, hexahedra, wedges "
            "or pyramids (triangles or quadrilaterals in the plane) of order 1 or 2: Mesh.ElementOrder = 1 or 2"
        )


def check_groups(mesh: Mesh) -> None:
    """Raise a MeshError for a body without a group, and for cells that occur twice, in two groups or in one."""
    what = {2: "surface", 3: "volume"}[mesh.dimension]
    if not mesh.cells or mesh.cell_count == 0:
        raise MeshError(
            f"{mesh.source}: no cell belongs to a physical {what}. Remedy: name the material's {what}, e.g. "
            f'Physical {what.capitalize()}("arm") = {{1}}; and the interfaces, then mesh again'
        )
    corners = np.sort(mesh.corners, axis=1)
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
            f"material: choose the groups that make the body, such as read_mesh(..., cells={names[0]!r}), or put each "
            f"{what} in one physical {what}"
        )
    raise MeshError(
        f"{mesh.source}: {place} of group {which} is there {len(same)} times. Remedy: remove the duplicate {what}s "
        "(Coherence in a .geo) and mesh again"
    )


def is_plane(mesh: Mesh) -> bool:
    """Return whether a 2D body lies in a plane of constant z."""
    z = mesh.nodes[mesh.body_nodes, 2]
    return bool(np.ptp(z) <= 1e-9 * max(extent(mesh), np.abs(z).max()))


def in_plane(mesh: Mesh) -> Mesh:
    """Return a 2D body with its cells oriented to z; raise a MeshError if it is not in a plane of constant z."""
    if not is_plane(mesh):
        z = mesh.nodes[mesh.body_nodes, 2]
        raise MeshError(
            f"{mesh.source}: the mesh has surfaces only, and they do not lie in a plane z = constant (z from "
            f"{z.min():g} to {z.max():g} m). Remedy: for sheet metal and other thin parts use kanefe_fem.shell_body; "
            "for a solid, mesh the volume in 3D and give it a physical volume; an imported geometry whose surfaces do "
            "not close has no volume: heal or sew it (Geometry.OCCSewFaces = 1, gmsh.model.occ.healShapes); for a "
            "plane body, draw it in x and y"
        )
    return oriented(mesh)


def check_fit(mesh: Mesh) -> None:
    """Raise a MeshError if triangles lie on a quadrilateral of another cell: displacements would not be continuous."""
    outer = {n: np.zeros((0, n), dtype=np.int64) for n in (3, 4)}
    for block in skin(mesh.cell_blocks):
        corners = shape(block.kind).corners
        if corners in outer:
            outer[corners] = np.concatenate((outer[corners], block.nodes[:, :corners]))
    triangles, quads = (_incidence(outer[n], len(mesh.nodes)) for n in (3, 4))
    shared = (triangles @ quads.T).tocoo()
    on_quad = shared.row[shared.data == 3]
    if len(on_quad):
        place = mesh.nodes[outer[3][on_quad[0]]].mean(axis=0)
        raise MeshError(
            f"{mesh.source}: the body mixes shapes that do not fit each other: a triangular side of one cell, at "
            f"{_point(place)} m, lies on a quadrilateral of another ({len(np.unique(on_quad))} such sides). Remedy: "
            "pyramids between tetrahedra and hexahedra, or one shape for all"
        )


def oriented(mesh: Mesh, *, keeps_sides: bool = False) -> Mesh:
    """Return the mesh with positive Jacobians: the nodes of inverted cells are reordered.

    Parameters
    ----------
    mesh : Mesh
    keeps_sides : bool
        Whether cells of a plane surface stay as they are, whose normals are along -z: offsets and pressures go by them.

    Raises
    ------
    MeshError
        If a Jacobian vanishes or changes its sign inside a cell.
    """
    cells: dict[str, tuple[Cells, ...]] = {}
    start = 0
    for name, blocks in mesh.cells.items():
        turned = []
        for block in blocks:
            low, high = jacobian_range(mesh, block)
            inverted = (high < 0.0) & (low < 0.0)
            low, high = np.where(inverted, -high, low), np.where(inverted, -low, high)
            bad = np.flatnonzero(low <= 0.0)
            if len(bad):
                centre = mesh.nodes[block.nodes[bad[0]]].mean(axis=0)
                kind = "changes its sign inside" if high[bad[0]] > 0.0 else "vanishes in"
                raise MeshError(
                    f"{mesh.source}: the Jacobian {kind} cell {start + bad[0]} of group {name!r}, at "
                    f"{_point(centre)} m ({len(bad)} such cells in the group). Remedy: mesh again with better cells "
                    "(smaller size, Mesh.HighOrderOptimize = 2 for curved ones), or with order 1"
                )
            nodes = block.nodes
            if inverted.any() and not keeps_sides:
                nodes = nodes.copy()
                nodes[inverted] = nodes[inverted][:, shape(block.kind).reversal()]
            start += len(nodes)
            turned.append(Cells(block.kind, nodes))
        cells[name] = tuple(turned)
    return replace(mesh, cells=cells)


def jacobian_range(mesh: Mesh, block: Cells) -> tuple[np.ndarray, np.ndarray]:
    """Return the least and greatest Jacobian over the nodes of each cell, relative to its longest side.

    Those of a cell that folds between its nodes have both signs; of a pyramid points of quadrature are taken for nodes.
    Of a surface in space they are those of the projection on the mean normal of each cell, never both negative.
    """
    if mesh.dimension == 2 and not is_plane(mesh):
        return _surface_range(mesh.nodes[block.nodes], shape(block.kind))
    element = shape(block.kind)
    d = element.dimension
    coordinates = mesh.nodes[block.nodes][:, :, :d]
    corners = coordinates[:, : element.corners]
    size = np.linalg.norm(corners.max(axis=1) - corners.min(axis=1), axis=1) ** d
    size[size == 0.0] = 1.0
    places = element.nodes[:1] if element.is_simplex and element.order == 1 else element.nodes
    if element.corner_kind == "pyramid":  # at its apex the gradients have no limit
        places = quadrature(block.kind, 2 * element.order)[0]
    low, high = np.full(len(size), np.inf), np.full(len(size), -np.inf)
    for gradient in element.gradients(places):
        jacobian = np.linalg.det(np.swapaxes(coordinates, 1, 2) @ gradient) / size
        jacobian[np.abs(jacobian) < DEGENERATE] = 0.0
        low, high = np.minimum(low, jacobian), np.maximum(high, jacobian)
    if not (element.is_simplex and element.order == 1):
        same = np.flatnonzero((low > 0.0) | (high < 0.0))
        scaled = coordinates[same] / (size[same] ** (1.0 / d))[:, None, None]
        scaled[high[same] < 0.0, :, 0] *= -1.0  # mirrored
        folded = same[folded_inside(block.kind, scaled, DEGENERATE)]
        low[folded], high[folded] = np.minimum(low[folded], -DEGENERATE), np.maximum(high[folded], DEGENERATE)
    return low, high


def _surface_range(x: np.ndarray, element: Shape) -> tuple[np.ndarray, np.ndarray]:
    """Return `jacobian_range` of cells (m, n, 3) of a surface."""
    tangents = np.einsum("pna,mni->mpai", element.gradients(element.nodes), x)
    normals = np.cross(tangents[:, :, 0], tangents[:, :, 1])
    mean = normals.mean(axis=1)
    size = np.linalg.norm(np.ptp(x[:, : element.corners], axis=1), axis=1) ** 2
    size[size == 0.0] = 1.0
    length = np.maximum(np.linalg.norm(mean, axis=1), 1e-300)
    along = np.einsum("mpi,mi->mp", normals, mean / length[:, None]) / size[:, None]
    along[np.abs(along) < DEGENERATE] = 0.0
    return along.min(axis=1), along.max(axis=1)


def check_connected(mesh: Mesh) -> None:
    """Raise a MeshError for a body in several parts; warn of coincident nodes that are not merged."""
    corners = mesh.corners
    m = len(corners)
    incidence = _incidence(corners, len(mesh.nodes))
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
                stacklevel=outside(),
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


def _incidence(corners: np.ndarray, count: int) -> sp.csr_matrix:
    """Return the sparse incidence matrix, shape (cells, count), of cells with the given corners and `count` nodes."""
    starts = np.arange(0, corners.size + 1, corners.shape[1])
    return sp.csr_matrix((np.ones(corners.size, dtype=np.int8), corners.reshape(-1), starts), (len(corners), count))


def _coincident(nodes: np.ndarray, size: float) -> int:
    """Return how many nodes lie within 1e-9 of the body's size of an earlier one."""
    cells = np.round((nodes - nodes.min(axis=0)) / (1e-9 * size)).astype(np.int64)
    return len(cells) - len(np.unique(row_numbers(cells)))


def cell_owners(mesh: Mesh) -> list[str]:
    """Return the group of each of the body's cells, in the order of `Mesh.cell_blocks`."""
    return [name for name, blocks in mesh.cells.items() for block in blocks for _ in range(len(block.nodes))]


def extent(mesh: Mesh) -> float:
    """Return the diagonal of the bounding box of the body, in m."""
    return float(np.linalg.norm(np.ptp(mesh.nodes[mesh.body_nodes], axis=0)))


def is_straight(mesh: Mesh) -> bool:
    """Return whether all mid-side nodes are the means of their corners."""
    tolerance = STRAIGHT * extent(mesh)
    for block in mesh.cell_blocks:
        corners = shape(block.kind).corners
        for i, mid in enumerate(MIDS[block.kind]):
            mean = sum(mesh.nodes[block.nodes[:, c]] for c in mid) / len(mid)
            if np.abs(mesh.nodes[block.nodes[:, corners + i]] - mean).max() > tolerance:
                return False
    return True


def _all_blocks(mesh: Mesh) -> Iterator[tuple[str, Cells]]:
    """Yield a label for messages and the cells of every block."""
    for what, groups in (("cell group", mesh.cells), ("facet group", mesh.facets), ("line group", mesh.lines)):
        for name, blocks in groups.items():
            for block in blocks:
                yield f"{what} {name!r}", block


def _point(x: np.ndarray) -> str:
    """Return coordinates as text for a message."""
    return f"({', '.join(f'{value:.4g}' for value in x)})"
