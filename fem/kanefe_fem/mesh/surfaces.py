"""Surfaces of a solid that carry distributed loads: their facets, and which side of them is outside.

The outward side follows from the cell that a facet bounds, because mesh generators order the nodes of facets
arbitrarily.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np
import scipy.sparse as sp

from kanefe.errors import MeshError, ModelError
from kanefe.fe_model.loaded_face import FacetBlock, LoadedFace
from kanefe.fe_model.model import Cells
from kanefe.fe_model.place_field import LoadShape, PlaceField, field_of
from kanefe.fe_model.places import PlaceLike
from kanefe.fe_model.shapes import FACES, corner_kind, row_numbers, shape
from kanefe_fem.mesh.mesh import Mesh

Surfaces = Sequence[str] | Mapping[str, str | PlaceLike | LoadShape]
"""Surfaces, as `surfaces=` of a solid takes them."""


def loaded_groups(mesh: Mesh, surfaces: Surfaces) -> tuple[Mesh, dict[str, tuple[str, PlaceField | None]]]:
    """Return the mesh with groups for new surfaces, and of each surface its group and by what its load varies.

    Raises
    ------
    ModelError, MeshError
        As `check_surfaces`; if no facet lies in a place.
    """
    if not isinstance(surfaces, Mapping):
        check_surfaces(mesh, surfaces)
        return mesh, {name: (name, None) for name in surfaces}
    loaded: dict[str, tuple[str, PlaceField | None]] = {}
    places: dict[str, PlaceLike] = {}
    for name, what in surfaces.items():
        of: Any = what.of if isinstance(what, LoadShape) else what
        over = field_of(what, name) if isinstance(what, LoadShape) else None
        if not isinstance(of, str):
            places[name] = of
        loaded[name] = (name if name in places else of, over)
    mesh = mesh.with_groups(places)
    check_surfaces(mesh, list(dict.fromkeys(group for group, _ in loaded.values())))
    return mesh, loaded


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


def loaded_face(mesh: Mesh, name: str, thickness: float = 1.0) -> LoadedFace:
    """Return a checked group of facets as a face that carries loads.

    Parameters
    ----------
    mesh : Mesh
        Of the order of the displacement.
    name : str
        Name of the group.
    thickness : float
        Thickness of a plane body, whose facets are lines, in m.
    """
    blocks = [
        FacetBlock(block.kind, block.nodes, mesh.nodes[block.nodes], -thickness * _outward_signs(mesh, name, block))
        for block in mesh.facets[name]
    ]
    return LoadedFace(tuple(blocks), len(mesh.nodes), mesh.dimension)


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
