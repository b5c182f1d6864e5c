"""Solids: from a mesh and materials to a full-order model."""

from __future__ import annotations

import time
import warnings
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypedDict, Unpack

import numpy as np
import scipy.sparse as sp

from kanefe.arguments import checked
from kanefe.errors import MeshError, ModelError, outside
from kanefe.fe_model.load_pattern import NodalPattern
from kanefe.fe_model.model import TRANSLATIONS, Cells, FiniteElementModel, MassField
from kanefe.fe_model.progress import report_size, stage
from kanefe.fe_model.source import with_source
from kanefe_fem import _fenicsx
from kanefe_fem.lumped.parts import Lumped, attach, groups_of, held_by_number
from kanefe_fem.materials.of_groups import (
    CellMaterials,
    Materials,
    cell_materials,
    materials_by_group,
    warn_of_group_units,
)
from kanefe_fem.mesh.body_source import MeshSource, model_source
from kanefe_fem.mesh.checks import (
    MeshWarning,
    check_groups,
    extent,
    in_plane,
    is_straight,
)
from kanefe_fem.mesh.groups import check_interfaces, node_groups
from kanefe_fem.mesh.mesh import Mesh, to_order
from kanefe_fem.mesh.surfaces import Surfaces, loaded_face, loaded_groups
from kanefe_fem.mesh_files import read_to_assemble
from kanefe_fem.processes.team import Team
from kanefe_fem.solids import on_processes
from kanefe_fem.solids import problem as solid_problem
from kanefe_fem.solids.damping import damping_of_solid
from kanefe_fem.solids.own_forms import Forms, with_forms
from kanefe_fem.solids.preload import Preload, preloaded
from kanefe_fem.solids.quadrature_assembly import assemble_by_quadrature

if TYPE_CHECKING:
    pass

Plane = Literal["stress", "strain"]

OFF_THE_CURVE = 1e-4
"""Distance of straight sides from the geometry, relative to the body, from which it is reported: a disc of 60 sides is
7e-4 off."""


class Additions(TypedDict, total=False):
    """What is added to the mesh and its materials, or replaces them: keywords of `solid_model`."""

    lumped: Sequence[Lumped]
    preload: Preload | None
    forms: Forms | None


class SolidKeywords(Additions, total=False):
    """Keywords of `solid_model` that `solid_body` takes too."""

    order: int
    plane: Plane | None
    thickness: float | None
    surfaces: Surfaces
    cells: str | Sequence[str] | None
    densities: Mapping[str, float] | None


@checked("mesh", "order", "cells", "lumped", "preload", "forms")
def solid_model(
    mesh: Mesh | str | Path,
    materials: Materials,
    order: int = 2,
    plane: Plane | None = None,
    thickness: float | None = None,
    surfaces: Surfaces = (),
    *,
    cells: str | Sequence[str] | None = None,
    densities: Mapping[str, float] | None = None,
    **more: Unpack[Additions],
) -> FiniteElementModel:
    """Return the full-order model of a solid (3D) or of a plane body (2D).

    Parameters
    ----------
    mesh : Mesh, str or Path
        The mesh, or the file it is read from (see `kanefe_fem.read_mesh`); m.
    materials : SolidMaterial or dict of str to SolidMaterial
        Material of each group of cells (`Material`, `Orthotropic`, `Anisotropic`, `Laminate`, `UserEnergy`, or one of
        them `Oriented`); one alone if there is one group.
    order : int
        Order of the displacement, 1 or 2. With 2 a source of gmsh (.geo, .py) is meshed with mid-side nodes on its
        curves; in a mesh of order 1 mid-side nodes are added on straight sides. With 1 the mid-side nodes of a mesh of
        order 2 are dropped.
    plane : {"stress", "strain"}, optional
        For 2D meshes only.
    thickness : float, optional
        Thickness of a 2D body in m, where it is required.
    surfaces : sequence of str, or dict of str to Near, OnPlane, InBox, InCylinder, function or LoadShape
        Groups of outer facets that can carry tractions and pressures (lines of a 2D mesh, as faces with the thickness
        of the body); or new ones, by their places; or loads that vary by place on one of these (`LoadShape`).
    cells : str or sequence of str, optional
        The groups of cells that form the body, in a mesh with several bodies. Default: all. Facets between two bodies
        are interfaces of both.
    densities : dict of str to float, optional
        Densities of groups of cells, instead of those of their materials, kg/m3: for distributed masses (cables, fuel,
        paint).
    **more
        The other parameters below.

    Other Parameters
    ----------------
    lumped : sequence of LumpedMass or LumpedSpring
        Masses and springs at nodes and groups; see `kanefe_fem.attach`.
    preload : Preload, optional
        A static load case, whose tangent stiffness is used; see `kanefe_fem.preloaded`.
    forms : Forms, optional
        Forms in UFL for stress, stiffness, mass, damping, geometric stiffness and added mass, instead of those of the
        materials; see `kanefe_fem.Forms`.

    Returns
    -------
    FiniteElementModel
        Nodes in the assembler's numbering; components ("x", "y", "z") or ("x", "y"); exact mass field; groups of
        facets, lines and points by name, mid-side nodes included.

    Raises
    ------
    MeshError, ModelError, FileError, MissingDependency
        If an argument is not valid; the message names it and the remedy.

    Examples
    --------
    >>> from kanefe_fem.materials.isotropic import Material
    >>> steel = Material(E=210e9, nu=0.3, rho=7850.0)
    >>> model = solid_model("meshes/arm.msh", steel)                      # doctest: +SKIP
    >>> model.groups["tip"].position                                     # doctest: +SKIP
    """
    model = assembled_model(
        mesh, materials, order, plane, thickness, surfaces, cells=cells, densities=densities, **more
    )
    options: dict[str, Any] = {
        "materials": materials,
        "order": order,
        "plane": plane,
        "thickness": thickness,
        "surfaces": surfaces,
    }
    options |= {"cells": cells, "densities": densities, **more}
    source = MeshSource(checked_mesh, mesh, options, order, by_number=held_by_number(more.get("lumped", ())))
    return with_source(model, model_source(solid_model, source, model.provenance.get("sha256")))


def assembled_model(
    mesh: Mesh | str | Path,
    materials: Materials,
    order: int,
    plane: Plane | None,
    thickness: float | None,
    surfaces: Surfaces,
    *,
    cells: str | Sequence[str] | None,
    densities: Mapping[str, float] | None,
    team: Team | None = None,
    **more: Unpack[Additions],
) -> FiniteElementModel:
    """Return the model of `solid_model`, with matrices on a team of processes if there is one."""
    from kanefe_fem._petsc import factorise

    lumped, preload, forms = more.get("lumped", ()), more.get("preload"), more.get("forms")
    start = time.perf_counter()
    mesh = checked_mesh(mesh, order, cells)
    mesh, loaded = loaded_groups(mesh, surfaces)
    by_group = materials_by_group(mesh, materials, order, plane, densities)
    scale = _thickness(mesh, plane, thickness)
    if preload is not None:
        loaded |= loaded_groups(mesh, [name for name in preload.surfaces if name not in loaded])[1]
        check_interfaces(mesh, dict.fromkeys(preload.groups))
    check_interfaces(mesh, dict.fromkeys(groups_of(lumped)))
    _warn_of_straight_sides(mesh, order)
    lifted = to_order(mesh, order)
    of_cells = cell_materials(lifted, by_group, plane, scale, densities)
    warn_of_group_units(lifted, by_group, scale, densities)
    read = time.perf_counter()
    report_size(mesh.dimension * len(lifted.nodes))
    with stage("assemble"):
        assembly = _assembly(lifted, of_cells, team)
    assembled = time.perf_counter()
    numbered = _renumber(lifted, assembly.order_of_nodes)
    components = TRANSLATIONS[: mesh.dimension]
    in_space = sp.kron(sp.identity(len(numbered.nodes)), sp.eye(3, mesh.dimension), format="csr")
    field = MassField(numbered.nodes, assembly.mass, in_space)
    blocks = sp.identity(mesh.dimension, format="csr")
    model = FiniteElementModel(
        nodes=numbered.nodes,
        components=components,
        stiffness=assembly.stiffness,
        mass=sp.kron(assembly.mass, blocks, format="csr") if team is None else assembly.vector_mass,
        mass_field=field,
        cells=numbered.cell_blocks,
        groups=node_groups(numbered),
        load_patterns={
            name: NodalPattern.of_face(loaded_face(numbered, group, scale), over)
            for name, (group, over) in loaded.items()
        },
        elasticity=of_cells.elasticity,
        stress_stiffness=assembly.stress_stiffness,
        **(damping_of_solid(assembly, of_cells, mesh.dimension) if team is None else {}),
        provenance={
            "source": mesh.source,
            **mesh.provenance,
            "element": f"{' and '.join(lifted.kinds)}, displacement of order {order}",
            "plane": plane,
            "thickness_m": thickness,
            "materials": {name: material.describe() for name, material in by_group.items()},
            "densities": dict(densities or {}),
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
    if forms is not None:
        model = with_forms(model, forms, assembly, lifted, of_cells, scale)
    if lumped:
        model = attach(model, lumped)
    return model if preload is None else preloaded(model, preload, factorise)


def _warn_of_straight_sides(mesh: Mesh, order: int) -> None:
    size = extent(mesh)
    if order == 2 and mesh.sagitta > OFF_THE_CURVE * size:
        warnings.warn(
            f"the sides of {mesh.source} are straight and up to {mesh.sagitta:.2g} m off its curves, "
            f"{mesh.sagitta / size:.1e} of its size, which quadratic elements keep: displacements and stresses near "
            "curves are off by that order. Remedy: read_mesh(..., order=2), or give the source itself; with cells fine "
            "enough to follow the curves",
            MeshWarning,
            stacklevel=outside(),
        )


def _assembly(mesh: Mesh, materials: CellMaterials, team: Team | None) -> Any:
    """Return the matrices by dolfinx, alone or on a team, or by numpy for cells that it does not support."""
    if team is not None:
        on_processes.refuse_assembly(mesh, materials.losses)
    if mesh.kind not in _fenicsx.SHAPES or len(mesh.kinds) > 1:
        return assemble_by_quadrature(
            np.asarray(mesh.nodes), mesh.cell_blocks, materials.long_term_moduli, materials.density
        )
    assemble: Any = solid_problem.assemble
    if team is not None:
        assemble = partial(on_processes.assemble, team, groups=on_processes.nodes_of_facets(mesh))
    return assemble(
        mesh.nodes,
        mesh.connectivity,
        mesh.kind,
        straight=is_straight(mesh),
        moduli=materials.long_term_moduli,
        density=materials.density,
    )


def checked_mesh(mesh: Mesh | str | Path, order: int, cells: str | Sequence[str] | None) -> Mesh:
    """Return a checked mesh of dimension 2 or 3 for elements of this order, of all or some groups of cells."""
    mesh = read_to_assemble(mesh, order, cells)
    if mesh.dimension == 1:
        raise MeshError(
            f"{mesh.source} has only lines. Remedy: mesh the volume (or the plane surface) and give it a physical "
            "group; for a frame of beams use kanefe_fem.beam_model_from_mesh"
        )
    check_groups(mesh)
    if mesh.dimension == 2:
        mesh = in_plane(mesh)
    return mesh


def _thickness(mesh: Mesh, plane: str | None, thickness: float | None) -> float:
    """Return the thickness of a 2D body, 1 for a solid; raise a ModelError if plane or thickness do not fit."""
    if mesh.dimension == 3:
        if plane is not None or thickness is not None:
            raise ModelError(
                f"{mesh.source} has volumes: plane and thickness are for 2D meshes. Remedy: leave them out"
            )
        return 1.0
    if plane not in ("stress", "strain"):
        raise ModelError(
            f"{mesh.source} is a mesh of surfaces, and plane={plane!r}. Remedy: give plane='stress' (thin) or "
            "plane='strain' (long) and a thickness; for sheet metal that bends, kanefe_fem.shell_body; for a "
            "solid, mesh the volume in 3D and give it a physical volume"
        )
    if thickness is None or not np.isfinite(thickness) or thickness <= 0.0:
        raise ModelError(f"thickness={thickness!r} of a plane body. Remedy: give a positive number of metres")
    return float(thickness)


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
