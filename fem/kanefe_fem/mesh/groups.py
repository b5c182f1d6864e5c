"""Groups of facets, lines and points of a mesh as candidates for interfaces."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import scipy.sparse as sp

from kanefe.errors import MeshError, ModelError
from kanefe.fe_model.interface import as_interface
from kanefe.fe_model.model import COMPONENTS, TRANSLATIONS, Cells, FiniteElementModel, NodeGroup
from kanefe.fe_model.shapes import shape
from kanefe.fe_model.skin import facet_group, with_places
from kanefe.fe_model.ties import separate_patches
from kanefe_fem.mesh.mesh import Mesh


def check_interfaces(mesh: Mesh, interfaces: Mapping[str, Any], *, is_shell: bool = False) -> None:
    """Check, before assembly, that the mesh has the groups of the interfaces and that their nodes can follow them.

    Parameters
    ----------
    mesh : Mesh
    interfaces : dict of str to str, Interface or None
        None: only the group is checked.
    is_shell : bool
        Whether its nodes rotate, and groups of cells of surfaces can be interfaces.

    Raises
    ------
    ModelError
        If a name or kind is unknown, or as `kanefe.fe_model.ties.tie_interfaces`.
    MeshError
        If a group has no facets, or facets that are not on the body.
    """
    if not isinstance(interfaces, Mapping):
        raise ModelError(
            f"interfaces must be a dict of names to kinds, such as {{'root': 'clamped'}}, not {interfaces!r}"
        )
    specs = {name: None if given is None else as_interface(name, given) for name, given in interfaces.items()}
    body = np.zeros(len(mesh.nodes), dtype=bool)
    body[mesh.body_nodes] = True
    for name, spec in specs.items():
        groups = (name,) if spec is None else spec.group_names(name)
        for group in groups:
            _check_group(mesh, group, body, is_shell)
        if len({_measure_dimension(mesh, group, is_shell) for group in groups}) > 1:
            raise ModelError(
                f"the groups {', '.join(map(repr, groups))} of interface {name!r} are facets, lines and points mixed. "
                "Remedy: groups of one sort"
            )
    by_group = {group for name, spec in specs.items() if spec is not None for group in spec.group_names(name)}
    components = COMPONENTS if is_shell else TRANSLATIONS[: mesh.dimension]
    empty = sp.csr_matrix((len(mesh.nodes) * len(components),) * 2)
    bare = FiniteElementModel(
        nodes=mesh.nodes,
        components=components,
        stiffness=empty,
        mass=empty,
        cells=mesh.cell_blocks,
        groups={group: node_group(mesh, group, is_shell) for group in by_group},
    )
    bare, placed = with_places(bare, {name: spec for name, spec in specs.items() if spec is not None})
    # a single node that is found by its position may be a mid-side node, which this mesh does not have yet
    known = {name: as_interface(name, spec) for name, spec in placed.items()}
    patches = {name: spec for name, spec in known.items() if spec.group_names(name)}
    separate_patches(bare, patches)


def has_surfaces_beside(mesh: Mesh) -> bool:
    """Return whether some facets of a mesh of volumes are not on these, but shells beside them."""
    body = np.zeros(len(mesh.nodes), dtype=bool)
    body[mesh.body_nodes] = True
    facets = mesh.facets if mesh.dimension == 3 else {}
    return any(not body[block.nodes].all() for blocks in facets.values() for block in blocks)


def has_groups(model: FiniteElementModel, interfaces: Any) -> bool:
    """Return whether every interface is one group of the model or found by its place, so that no mesh is needed.

    All other faults are found by `kanefe.fe_model.ties.tie_interfaces` without the mesh. An interface of several groups
    needs the mesh, which has the dimension of each.

    Parameters
    ----------
    model : FiniteElementModel
    interfaces : dict of str to str or Interface

    Raises
    ------
    ModelError
        If an interface is of no known kind.
    """
    if not isinstance(interfaces, Mapping):
        return False
    names = [as_interface(name, given).group_names(name) for name, given in interfaces.items()]
    return all(len(groups) <= 1 and all(group in model.groups for group in groups) for groups in names)


def node_groups(mesh: Mesh, is_shell: bool = False) -> dict[str, NodeGroup]:
    """Return the groups of facets, lines and points, and of the surfaces of a shell.

    If a name occurs twice, facets precede lines, lines points, and these surfaces.
    """
    groups: dict[str, NodeGroup] = {}
    for name in [*mesh.facets, *mesh.lines, *mesh.points, *(mesh.cells if is_shell else ())]:
        if name and name not in groups and len(group_nodes(mesh, name, is_shell)):
            groups[name] = node_group(mesh, name, is_shell)
    return groups


def node_group(mesh: Mesh, name: str, is_shell: bool = False) -> NodeGroup:
    """Return one group with its reference point and its measure: the area of facets, the length of lines."""
    blocks = [block for block in _blocks(mesh, name, is_shell) if len(block.nodes)]
    if blocks:
        return facet_group(np.asarray(mesh.nodes), blocks)
    nodes = group_nodes(mesh, name, is_shell)
    return NodeGroup(nodes, mesh.nodes[nodes].mean(axis=0))


def group_nodes(mesh: Mesh, name: str, is_shell: bool = False) -> np.ndarray:
    """Return the nodes of a group of facets, lines or points, or of cells of a shell."""
    blocks = _blocks(mesh, name, is_shell)
    if any(len(b.nodes) for b in blocks):
        return np.unique(np.concatenate([b.nodes.reshape(-1) for b in blocks]))
    return np.unique(np.asarray(mesh.points.get(name, ()), dtype=np.int64))


def _blocks(mesh: Mesh, name: str, is_shell: bool) -> tuple[Cells, ...]:
    named = mesh.facets.get(name) or mesh.lines.get(name) or ()
    return mesh.cells.get(name, ()) if is_shell and not named and name not in mesh.points else named


def _measure_dimension(mesh: Mesh, name: str, is_shell: bool) -> int:
    return max((shape(block.kind).dimension for block in _blocks(mesh, name, is_shell)), default=0)


def _check_group(mesh: Mesh, name: str, body: np.ndarray, is_shell: bool) -> None:
    """Raise an error for a group that the mesh does not have, that is empty or that is not on the body."""
    known = sorted({*mesh.facets, *mesh.lines, *mesh.points, *(mesh.cells if is_shell else ())} - {""})
    if name not in known:
        also = f"; {name!r} is a group of cells, an interface is a group of facets" if name in mesh.cells else ""
        raise ModelError(
            f"{mesh.source} has no group of facets called {name!r}{also}. Remedy: use one of those it has "
            f"({', '.join(known) or 'none'}), or give the facets a physical group of this name"
        )
    nodes = group_nodes(mesh, name, is_shell)
    if not len(nodes):
        raise MeshError(
            f"{mesh.source}: the group {name!r} has no facets. Remedy: mesh its surfaces, and save all elements"
        )
    if not body[nodes].all():
        raise MeshError(
            f"{mesh.source}: the group {name!r} has {np.count_nonzero(~body[nodes])} nodes that are not on the "
            "body. Remedy: choose faces of the meshed body only"
        )
