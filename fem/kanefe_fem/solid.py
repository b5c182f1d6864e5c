"""Solid bodies: from a mesh and materials to a full-order model, or to a `FlexibleBody`."""

from __future__ import annotations

import time
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import scipy.sparse as sp

from kanefe.errors import MeshError, ModelError
from kanefe.finite_element_model import TRANSLATIONS, Cells, FiniteElementModel, MassField, NodeGroup
from kanefe.load_pattern import NodalPattern
from kanefe_fem.material import LOCKING_NU, AccuracyWarning, Material, warn_of_units
from kanefe_fem.mesh import Mesh, read_mesh, to_order
from kanefe_fem.mesh_checks import check_groups, check_mesh, extent
from kanefe_fem.shapes import MIDS, measures, shape
from kanefe_fem.surfaces import check_surfaces, facet_integrals

if TYPE_CHECKING:
    from kanefe.flexible import FlexibleBody

Plane = Literal["stress", "strain"]
Materials = Material | Mapping[str, Material]

STRAIGHT = 1e-12
"""Mid-side nodes this close (relative to the body) to the means of their corners make a straight geometry."""


def solid_model(
    mesh: Mesh | str | Path,
    materials: Materials,
    order: int = 2,
    plane: Plane | None = None,
    thickness: float | None = None,
    surfaces: Sequence[str] = (),
) -> FiniteElementModel:
    """Return the full-order model of a solid (3D) or of a plane body (2D).

    Parameters
    ----------
    mesh : Mesh, str or Path
        The mesh, or the file it is read from (see `kanefe_fem.read_mesh`); m.
    materials : Material or dict of str to Material
        Material of each group of cells; one alone if there is one group.
    order : int
        Order of the displacement, 1 or 2. With 2 on a mesh of order 1 the sides stay straight and mid-side nodes are
        added; with 1 on a mesh of order 2 the mid-side nodes are dropped.
    plane : {"stress", "strain"}, optional
        For 2D meshes, and only there.
    thickness : float, optional
        Of a 2D body in m; required there.
    surfaces : sequence of str
        Groups of outer facets that can carry tractions and pressures (lines of a 2D mesh: their faces, as wide as the
        body is thick).

    Returns
    -------
    FiniteElementModel
        Nodes in the assembler's numbering; components ("x", "y", "z") or ("x", "y"); exact mass field; groups of
        facets, lines and points by name, mid-side nodes included.

    Raises
    ------
    MeshError, ModelError, FileError, MissingDependency
        Each names the thing at fault and the remedy.

    Examples
    --------
    >>> steel = Material(E=210e9, nu=0.3, rho=7850.0)
    >>> model = solid_model("meshes/arm.msh", steel)                      # doctest: +SKIP
    >>> model.groups["tip"].position                                     # doctest: +SKIP
    """
    from kanefe_fem import _fenicsx

    start = time.perf_counter()
    mesh = _as_mesh(mesh)
    by_group = _materials_by_group(mesh, materials, order)
    scale = _thickness(mesh, plane, thickness)
    check_surfaces(mesh, surfaces)
    lifted = to_order(mesh, order)
    integrals = {name: facet_integrals(lifted, name, scale) for name in surfaces}
    lame, shear, density = _fields(lifted, by_group, plane, scale)
    _warn_of_units(lifted, by_group, scale)
    read = time.perf_counter()
    assembly = _fenicsx.assemble(
        lifted.nodes,
        lifted.connectivity,
        lifted.kind,
        straight=is_straight(lifted),
        lame=lame,
        shear=shear,
        density=density,
    )
    assembled = time.perf_counter()
    numbered = _renumber(lifted, assembly.order_of_nodes)
    components = TRANSLATIONS[: mesh.dimension]
    field = MassField(numbered.nodes, assembly.mass, _interpolation(len(numbered.nodes), mesh.dimension))
    blocks = sp.identity(mesh.dimension, format="csr")
    model = FiniteElementModel(
        nodes=numbered.nodes,
        components=components,
        stiffness=assembly.stiffness,
        mass=sp.kron(assembly.mass, blocks, format="csr"),
        mass_field=field,
        cells=numbered.cell_blocks,
        groups=_node_groups(numbered),
        load_patterns={
            name: NodalPattern.of_nodes(
                numbered.nodes,
                components,
                found.shares[assembly.order_of_nodes],
                found.pressure[assembly.order_of_nodes],
            )
            for name, found in integrals.items()
        },
        provenance={
            "source": mesh.source,
            **mesh.provenance,
            "element": f"{lifted.kind}, displacement of order {order}",
            "plane": plane,
            "thickness_m": thickness,
            "materials": {name: {"E": m.E, "nu": m.nu, "rho": m.rho, "name": m.name} for name, m in by_group.items()},
            "nodes": len(numbered.nodes),
            "cells": numbered.cell_count,
            "dofs": len(numbered.nodes) * len(components),
            "versions": assembly.versions,
            "seconds": {
                "read and check": read - start,
                **assembly.seconds,
                "number and group": time.perf_counter() - assembled,
            },
        },
    )
    return model


def solid_body(
    mesh: Mesh | str | Path,
    materials: Materials,
    interfaces: Mapping[str, Any],
    reduction: Any = None,
    damping: Any = None,
    order: int = 2,
    plane: Plane | None = None,
    thickness: float | None = None,
    surfaces: Sequence[str] = (),
) -> FlexibleBody:
    """Return a flexible body made from a mesh: `solid_model`, then `kanefe.reduction.flexible_body`.

    Parameters
    ----------
    mesh, materials, order, plane, thickness, surfaces
        As for `solid_model`.
    interfaces : dict of str to str
        How each named group of facets carries the body's frame or another body: "clamped", "rigid", ...
    reduction : CraigBampton, optional
        None keeps every degree of freedom.
    damping : optional
        None, RayleighDamping, ModalDamping or a matrix.

    Examples
    --------
    >>> import kanefe as kf
    >>> arm = solid_body("meshes/arm.msh", Material(E=70e9, nu=0.33, rho=2700.0),
    ...                  interfaces={"root": "clamped", "tip": "rigid"},
    ...                  reduction=kf.CraigBampton(modes=12))              # doctest: +SKIP
    """
    from kanefe.reduction import flexible_body
    from kanefe_fem._petsc import factorise

    mesh = _as_mesh(mesh)
    check_interfaces(mesh, interfaces)
    model = solid_model(mesh, materials, order, plane, thickness, surfaces)
    return flexible_body(model, interfaces, reduction=reduction, damping=damping, factorise=factorise)


def check_interfaces(mesh: Mesh, interfaces: Mapping[str, Any]) -> None:
    """Refuse interfaces that the mesh does not have, before anything is assembled.

    Raises
    ------
    ModelError
        Unknown name.
    MeshError
        The group has no facets, or facets that are not on the body.
    """
    known = sorted({*mesh.facets, *mesh.lines, *mesh.points} - {""})
    body = np.zeros(len(mesh.nodes), dtype=bool)
    body[mesh.connectivity] = True
    for name in interfaces:
        if name not in known:
            also = f"; {name!r} is a group of cells, an interface is a group of facets" if name in mesh.cells else ""
            raise ModelError(
                f"{mesh.source} has no group of facets called {name!r}{also}. Remedy: use one of those it has "
                f"({', '.join(known) or 'none'}), or give the facets a physical group of this name"
            )
        nodes = _group_nodes(mesh, name)
        if not len(nodes):
            raise MeshError(
                f"{mesh.source}: the group {name!r} has no facets. Remedy: mesh its surfaces, and save all elements"
            )
        if not body[nodes].all():
            raise MeshError(
                f"{mesh.source}: the group {name!r} has {np.count_nonzero(~body[nodes])} nodes that are not on the "
                "body. Remedy: choose faces of the meshed body only"
            )


def is_straight(mesh: Mesh) -> bool:
    """Tell whether all mid-side nodes are the means of their corners."""
    mids = MIDS[mesh.kind]
    corners = shape(mesh.kind).corners
    connectivity = mesh.connectivity
    tolerance = STRAIGHT * extent(mesh)
    for i, mid in enumerate(mids):
        mean = sum(mesh.nodes[connectivity[:, c]] for c in mid) / len(mid)
        if np.abs(mesh.nodes[connectivity[:, corners + i]] - mean).max() > tolerance:
            return False
    return True


def _as_mesh(mesh: Mesh | str | Path) -> Mesh:
    """Return a checked mesh of dimension 2 or 3."""
    mesh = check_mesh(mesh) if isinstance(mesh, Mesh) else read_mesh(mesh)
    if mesh.dimension == 1:
        raise MeshError(
            f"{mesh.source} has only lines. Remedy: mesh the volume (or the plane surface) and give it a physical "
            "group; for a frame of beams use kanefe_fem.beam_model_from_mesh"
        )
    check_groups(mesh)
    return mesh


def _materials_by_group(mesh: Mesh, materials: Materials, order: int) -> dict[str, Material]:
    """Return a material for every group of cells."""
    if order not in (1, 2):
        raise ModelError(f"order={order!r} of the displacement is not possible. Remedy: give 1 or 2")
    groups = list(mesh.cells)
    if isinstance(materials, Material):
        if len(groups) > 1:
            raise ModelError(
                f"one material is given, but {mesh.source} has the groups {', '.join(map(repr, groups))}. "
                f"Remedy: materials={{{groups[0]!r}: Material(...), ...}}"
            )
        materials = {groups[0]: materials}
    for name, material in materials.items():
        if not isinstance(material, Material):
            raise ModelError(f"the material of {name!r} is {material!r}. Remedy: Material(E=..., nu=..., rho=...)")
        if name not in mesh.cells:
            raise ModelError(
                f"a material is given for {name!r}, but {mesh.source} has no such group of cells. "
                f"Remedy: use the names of its groups, {', '.join(map(repr, groups))}"
            )
    for name in groups:
        if name not in materials:
            raise ModelError(
                f"{mesh.source}: the group {name!r} has no material. Remedy: add {name!r}: Material(...) to materials"
            )
        if order == 1 and materials[name].nu >= LOCKING_NU:
            warnings.warn(
                f"group {name!r}: nu = {materials[name].nu:g} with elements of order 1 is much too stiff (locking). "
                "Use order=2",
                AccuracyWarning,
                stacklevel=3,
            )
    return {name: materials[name] for name in groups}


def _thickness(mesh: Mesh, plane: str | None, thickness: float | None) -> float:
    """Return the thickness of a 2D body, 1 for a solid; refuse what does not fit the mesh."""
    if mesh.dimension == 3:
        if plane is not None or thickness is not None:
            raise ModelError(
                f"{mesh.source} has volumes: plane and thickness are for 2D meshes. Remedy: leave them out"
            )
        return 1.0
    if plane not in ("stress", "strain"):
        raise ModelError(
            f"{mesh.source} is a mesh of surfaces, and plane={plane!r}. Remedy: give plane='stress' (thin) or "
            "plane='strain' (long) and a thickness; for a solid, mesh the volume in 3D and give it a physical volume"
        )
    if thickness is None or not np.isfinite(thickness) or thickness <= 0.0:
        raise ModelError(f"thickness={thickness!r} of a plane body. Remedy: give a positive number of metres")
    return float(thickness)


def _fields(
    mesh: Mesh, materials: Mapping[str, Material], plane: str | None, scale: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return lambda, mu and rho of every cell, times the thickness."""
    table = [materials[name] for name in mesh.cells]
    counts = [sum(len(block.nodes) for block in blocks) for blocks in mesh.cells.values()]
    lame = [m.plane_stress_lame if plane == "stress" else m.lame for m in table]
    shear = [m.shear_modulus for m in table]
    density = [m.rho for m in table]
    return scale * np.repeat(lame, counts), scale * np.repeat(shear, counts), scale * np.repeat(density, counts)


def _warn_of_units(mesh: Mesh, materials: Mapping[str, Material], scale: float) -> None:
    """Warn when a group's material, or the size and mass of the body, are not those of a solid in SI units."""
    size = extent(mesh)
    volumes = {
        name: scale * sum(float(measures(b.kind, mesh.nodes[b.nodes], degree=2)[0].sum()) for b in blocks)
        for name, blocks in mesh.cells.items()
    }
    mass = sum(materials[name].rho * volume for name, volume in volumes.items())
    for name, material in materials.items():
        warn_of_units(f"group {name!r} of {mesh.source}", material, size, mass)


def _interpolation(nodes: int, dimension: int) -> sp.csr_matrix:
    """Return the displacements of the nodes in space from the degrees of freedom, shape (3 nodes, dimension nodes)."""
    return sp.kron(sp.identity(nodes), sp.eye(3, dimension), format="csr")


def _renumber(mesh: Mesh, order_of_nodes: np.ndarray) -> Mesh:
    """Return the mesh with its nodes in the given order."""
    place = np.empty(len(order_of_nodes), dtype=np.int64)
    place[order_of_nodes] = np.arange(len(order_of_nodes))

    def moved(groups: Mapping[str, tuple[Cells, ...]]) -> dict[str, tuple[Cells, ...]]:
        return {name: tuple(Cells(b.kind, place[b.nodes]) for b in blocks) for name, blocks in groups.items()}

    return Mesh(
        nodes=mesh.nodes[order_of_nodes],
        dimension=mesh.dimension,
        cells=moved(mesh.cells),
        facets=moved(mesh.facets),
        lines=moved(mesh.lines),
        points={name: place[ids] for name, ids in mesh.points.items()},
        source=mesh.source,
        provenance=mesh.provenance,
    )


def _node_groups(mesh: Mesh) -> dict[str, NodeGroup]:
    """Return the groups of facets, lines and points; of equal names, facets go before lines and points."""
    groups: dict[str, NodeGroup] = {}
    for name in [*mesh.facets, *mesh.lines, *mesh.points]:
        nodes = _group_nodes(mesh, name)
        if name == "" or name in groups or not len(nodes):
            continue
        blocks = mesh.facets.get(name) or mesh.lines.get(name) or ()
        position = mesh.nodes[nodes].mean(axis=0)
        pieces = [measures(b.kind, mesh.nodes[b.nodes]) for b in blocks]
        area = sum(float(size.sum()) for size, _ in pieces)
        if area > 0.0:
            position = sum(moment.sum(axis=0) for _, moment in pieces) / area
        groups[name] = NodeGroup(nodes, np.asarray(position))
    return groups


def _group_nodes(mesh: Mesh, name: str) -> np.ndarray:
    """Return the nodes of a group of facets, lines or points."""
    blocks = mesh.facets.get(name) or mesh.lines.get(name) or ()
    if any(len(b.nodes) for b in blocks):
        return np.unique(np.concatenate([b.nodes.reshape(-1) for b in blocks]))
    return np.unique(np.asarray(mesh.points.get(name, ()), dtype=np.int64))
