"""Surfaces of a solid that carry distributed loads: the integrals over their facets.

The outward side follows from the cell that a facet bounds, because mesh generators order the nodes of facets
arbitrarily.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp

from kanefe.errors import MeshError, ModelError
from kanefe.fe_model.load_pattern import NodalPattern
from kanefe.fe_model.model import Cells
from kanefe.fe_model.pressure_change import PressureChange, PushedFace, pressure_change
from kanefe.fe_model.shapes import FACES, corner_kind, quadrature, row_numbers, shape
from kanefe_fem.mesh.mesh import Mesh

DEGREE = 6
"""Degree of the quadrature: exact for pressures (at most 5 in each direction); the area of a curved facet is not a
polynomial."""


@dataclass(frozen=True, eq=False)
class FacetIntegrals:
    """Integrals over a group of facets of a mesh of n nodes.

    Attributes
    ----------
    shares : ndarray, shape (n,)
        int N_i dA in m2.
    pressure : ndarray, shape (n, 3)
        -int N_i n dA in m2, n the outward normal.
    change : PressureChange
        Change of the forces of a unit pressure with the displacements of the nodes.
    nodes : ndarray, shape (n, 3)
        Coordinates, m.
    """

    shares: np.ndarray
    pressure: np.ndarray
    change: PressureChange
    nodes: np.ndarray

    def in_order(self, order: np.ndarray, components: tuple[str, ...]) -> NodalPattern:
        """Return the pattern of loads over nodes in another order, given the present number of each, (n,)."""
        width = len(components)
        dofs = (width * order[:, None] + np.arange(width)).ravel()
        change = replace(self.change, motion=self.change.motion[:, dofs])
        of_nodes = (self.nodes[order], components, self.shares[order], self.pressure[order])
        return NodalPattern.of_nodes(*of_nodes, pressure_change=change)


def check_surfaces(mesh: Mesh, names: Sequence[str]) -> None:
    """Raise an error for surfaces that cannot carry a load.

    Raises
    ------
    ModelError
        If a name is unknown; the message lists the groups of facets.
    MeshError
        If a group has no facets, or a facet twice, not on the body, or inside it.
    """
    if isinstance(names, str) or not (isinstance(names, Collection) and all(isinstance(name, str) for name in names)):
        raise ModelError(
            f"surfaces={names!r} is not a list of names. Remedy: names of groups of facets, such as ['top']"
        )
    known = sorted(set(mesh.facets) - {""})
    for name in names:
        if name not in mesh.facets or name == "":
            also = f"; {name!r} is a group of cells" if name in mesh.cells else ""
            raise ModelError(
                f"{mesh.source} has no group of facets called {name!r}{also}. Remedy: use one of those it has "
                f"({', '.join(known) or 'none'}), or give the facets a physical group of this name"
            )
        if not any(len(block.nodes) for block in mesh.facets[name]):
            raise MeshError(
                f"{mesh.source}: the group {name!r} has no facets. Remedy: mesh its surfaces, and save all elements"
            )
        _refuse_doubles(mesh, name)
        for block in mesh.facets[name]:
            _outward_signs(mesh, name, block)


def facet_integrals(mesh: Mesh, name: str, thickness: float = 1.0) -> FacetIntegrals:
    """Return the integrals over a checked group of facets.

    Parameters
    ----------
    mesh : Mesh
        Of the order of the displacement.
    name : str
        Name of the group.
    thickness : float
        Thickness of a plane body, whose facets are lines, in m.
    """
    shares, pressure, deforming = np.zeros(len(mesh.nodes)), np.zeros((len(mesh.nodes), 3)), []
    for block in mesh.facets[name]:
        signs = thickness * _outward_signs(mesh, name, block)
        element, x = shape(block.kind), mesh.nodes[block.nodes]
        points, weights = quadrature(block.kind, DEGREE)
        for value, gradient, weight in zip(element.values(points), element.gradients(points), weights, strict=True):
            normal = weight * _normals(np.einsum("mnx,na->mxa", x, gradient))
            area = thickness * np.linalg.norm(normal, axis=1)
            np.add.at(shares, block.nodes, area[:, None] * value)
            np.add.at(pressure, block.nodes, -(signs[:, None] * normal)[:, None, :] * value[:, None])
        deforming.append(PushedFace(block.kind, block.nodes, x, -signs))
    change = pressure_change(deforming, len(mesh.nodes), mesh.dimension)
    return FacetIntegrals(shares, pressure, change, mesh.nodes)


def _normals(tangents: np.ndarray) -> np.ndarray:
    """Return the normal of each facet, with the length of the facet's measure, from tangents (m, 3, d - 1)."""
    if tangents.shape[2] == 1:
        t = tangents[:, :, 0]
        return np.column_stack((t[:, 1], -t[:, 0], np.zeros(len(t))))
    return np.cross(tangents[:, :, 0], tangents[:, :, 1])


def _refuse_doubles(mesh: Mesh, name: str) -> None:
    for kind in {block.kind for block in mesh.facets[name]}:
        facets = np.concatenate([block.nodes for block in mesh.facets[name] if block.kind == kind])
        _, counts = np.unique(row_numbers(np.sort(facets[:, : shape(kind).corners], axis=1)), return_counts=True)
        if counts.max() > 1:
            raise MeshError(
                f"{mesh.source}: {np.count_nonzero(counts > 1)} facets of the surface {name!r} are twice in it, and "
                "would carry a load twice. Remedy: remove the duplicate surfaces (Coherence in a .geo) and mesh again"
            )


def _outward_signs(mesh: Mesh, name: str, block: Cells) -> np.ndarray:
    """Return +1 for each facet whose nodes are ordered about the outward normal, -1 for the others.

    The order on the reference cell decides: it is valid for every cell with a positive Jacobian.
    """
    corners = block.nodes[:, : shape(block.kind).corners]
    cells = mesh.corners
    owner = _owners(mesh, name, corners, cells)
    local = (cells[owner][:, None, :] == corners[:, :, None]).argmax(axis=2)
    kinds = np.repeat([corner_kind(b.kind) for b in mesh.cell_blocks], [len(b.nodes) for b in mesh.cell_blocks])[owner]
    signs = np.zeros(len(corners))
    for kind in np.unique(kinds):
        turns = {}
        for face in FACES[str(kind)]:
            for first in range(len(face) if len(face) > 2 else 1):  # an edge has one direction
                turned = face[first:] + face[:first]
                turns[turned], turns[turned[::-1]] = 1.0, -1.0
        own = kinds == kind
        signs[own] = [turns.get(tuple(row), 0.0) for row in local[own].tolist()]
    if not signs.all():
        raise MeshError(f"{mesh.source}: a facet of the surface {name!r} is not a side of a cell. Remedy: mesh again")
    return signs


def _owners(mesh: Mesh, name: str, corners: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """Return the one cell that each facet bounds."""
    count = len(mesh.nodes)
    on_facet, on_cell = (
        sp.csr_matrix(
            (np.ones(table.size), (np.repeat(np.arange(len(table)), table.shape[1]), table.ravel())),
            shape=(len(table), count),
        )
        for table in (corners, cells)
    )
    on_cell.sum_duplicates()
    on_cell.data[:] = 1.0  # a corner that is repeated counts once
    shared = (on_facet @ on_cell.T).tocoo()
    bounds = shared.data == corners.shape[1]
    facet, owner = shared.row[bounds], shared.col[bounds]
    owners = np.bincount(facet, minlength=len(corners))
    for wrong, what in ((owners == 0, "not on the body"), (owners > 1, "inside the body, where no side is outside")):
        if wrong.any():
            raise MeshError(
                f"{mesh.source}: {np.count_nonzero(wrong)} facets of the surface {name!r} are {what}. "
                "Remedy: choose outer faces of the meshed body only"
            )
    result = np.empty(len(corners), dtype=np.int64)
    result[facet] = owner
    return result
