"""Shell bodies: from a mesh of a surface, materials and thicknesses to a full-order model, or to a `FlexibleBody`."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence, Sized
from dataclasses import replace
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypedDict, Unpack, cast

import numpy as np

from kanefe.arguments import checked
from kanefe.bodies.source import sourced
from kanefe.errors import MeshError, ModelError
from kanefe.fe_model.model import COMPONENTS, Cells, Elasticity, FiniteElementModel
from kanefe.fe_model.progress import report_size, stage, stages
from kanefe.fe_model.shell_stack import ShellStack
from kanefe.fe_model.skin import skin
from kanefe.fe_model.source import with_source
from kanefe_fem import _fenicsx
from kanefe_fem.lumped.parts import Lumped, attach, held_by_number
from kanefe_fem.materials.laminate import Laminate
from kanefe_fem.materials.of_groups import Materials, materials_by_group
from kanefe_fem.mesh.body_source import MeshSource, body_source, model_source
from kanefe_fem.mesh.checks import check_arrays, check_groups, oriented
from kanefe_fem.mesh.groups import check_interfaces, node_groups
from kanefe_fem.mesh.mesh import Mesh, to_order
from kanefe_fem.mesh_files import read_to_assemble
from kanefe_fem.shells.checks import check_surface, tell_of_turned
from kanefe_fem.shells.directors import Directors, directors
from kanefe_fem.shells.faces import Surfaces, checked_surfaces, shell_patterns
from kanefe_fem.shells.joined import with_solid, with_stiffeners
from kanefe_fem.shells.mass import mass_field
from kanefe_fem.shells.measures import shell_measures, told, told_of_waves
from kanefe_fem.shells.of_groups import ShellGroup, Thickness, shell_groups
from kanefe_fem.shells.orientation import consistent
from kanefe_fem.shells.pairs import of_nine_nodes
from kanefe_fem.shells.problem import ShellCells, ShellProblem
from kanefe_fem.shells.seams import seams_of
from kanefe_fem.shells.stack import BlockOfGroup, shell_stack
from kanefe_fem.shells.stiffener import Stiffener, checked_stiffeners
from kanefe_fem.shells.stiffeners import stiffener_lines
from kanefe_fem.shells.stress_stiffness import stress_stiffness
from kanefe_fem.solids.model import solid_model

if TYPE_CHECKING:
    from kanefe.bodies.flexible import FlexibleBody
    from kanefe.reduction.stiffening import StiffeningLevel

FOLD = math.radians(20.0)
"""Angle between the normals of neighbouring cells from which they make a fold, rad."""


ONE_ORDER = "shells have displacements of second order"

STAGES = 8
"""Number of stages in making a body."""


class ShellKeywords(TypedDict, total=False):
    """Keywords of `shell_model` that `shell_body` takes too."""

    offset: float | Mapping[str, float]
    fold: float
    shear_factor: float | None
    cells: str | Sequence[str] | None
    surfaces: Surfaces
    beams: Mapping[str, Stiffener] | None
    lumped: Sequence[Lumped]


@checked("mesh", "fold", "cells", "lumped")
def shell_model(
    mesh: Mesh | str | Path,
    materials: Materials,
    thickness: Thickness | Mapping[str, Thickness] | None = None,
    *,
    offset: float | Mapping[str, float] = 0.0,
    fold: float = FOLD,
    shear_factor: float | None = None,
    cells: str | Sequence[str] | None = None,
    surfaces: Surfaces = (),
    beams: Mapping[str, Stiffener] | None = None,
    lumped: Sequence[Lumped] = (),
) -> FiniteElementModel:
    """Return the full-order model of a shell: sheet metal, a panel, a blade, a hull; with beams and solids.

    Parameters
    ----------
    mesh : Mesh, str or Path
        A mesh of triangles and quadrangles, curved, folded or branched, or the file it is read from; m. A mesh of order
        1 gets mid-side nodes on straight sides. In a mesh of volumes the groups of facets that have a material are
        shells, and the volumes solids; they are tied where edges or cells of the shell lie on a solid.
    materials : SolidMaterial or dict of str to SolidMaterial
        Of each group of cells: `Material`, `Orthotropic`, `Laminate` (its plies from the bottom to the top of the
        shell, each at its height), or one of them `Oriented`: the part of its axis 1 in the surface is axis 1 of the
        shell. Without, it is that of x.
    thickness : float, function or dict of str to these
        In m, of all cells or by group; a function of points (n, 3) in m returns that at the nodes. Default: that of
        the mesh (a middle surface of a STEP file), or of the laminate.
    offset : float or dict of str to float
        Height of the middle of the thickness above the mesh, along its normal, as a fraction of the thickness: 0.5 if
        the mesh is the bottom of the sheet, -0.5 if it is the top.
    fold : float
        Angle between the normals of neighbouring cells from which they make a fold, rad.
    shear_factor : float, optional
        Shear correction. Default: that of the stack of layers, 5/6 if it is homogeneous.
    cells : str or sequence of str, optional
        The groups of cells that form the body. Default: all.
    surfaces : sequence of str, or dict of str to str, Place, function or ShellFace
        What carries distributed loads: groups of cells, on whose top tractions and pressures act, and groups of lines,
        for loads per length; or new names, for faces (`ShellFace`: top or bottom) and places.
    beams : dict of str to Stiffener, optional
        Beams along groups of lines of the mesh.
    lumped : sequence of LumpedMass or LumpedSpring
        Masses and springs at nodes and groups; see `kanefe_fem.attach`.

    Returns
    -------
    FiniteElementModel
        Six components a node, exact mass field, geometric stiffness.

    Raises
    ------
    MeshError, ModelError, FileError, MissingDependency
        If an argument is not valid; the message names it and the remedy.

    Notes
    -----
    Two triangles make a quadrangle of nine nodes where their angles allow it; the node between them moves to its
    middle.

    Examples
    --------
    >>> from kanefe_fem.materials.isotropic import Material
    >>> steel = Material(E=210e9, nu=0.3, rho=7850.0)
    >>> model = shell_model("panel.msh", steel, thickness=2e-3)          # doctest: +SKIP
    """
    start = time.perf_counter()
    options: dict[str, Any] = {
        "materials": materials,
        "thickness": thickness,
        "offset": offset,
        "fold": fold,
        "beams": beams,
    }
    options |= {"shear_factor": shear_factor, "cells": cells, "surfaces": surfaces, "lumped": lumped}
    given_source = MeshSource(read_to_assemble, mesh, options, 2, ONE_ORDER, held_by_number(lumped))
    if not 0.0 < fold <= math.pi:
        raise ModelError(
            f"fold={fold:g} rad of a shell is no angle between 0 and pi. Remedy: radians, np.radians(20.0)"
        )
    beams = checked_stiffeners(beams)
    mesh, of_solids = _parts(mesh, materials, cells)
    solids = set() if of_solids is None else set(of_solids.cells)
    if mesh.thickness and not isinstance(materials, Mapping):  # one part, whose groups differ in their thickness
        materials = dict.fromkeys(mesh.cells, materials)
    own = {k: v for k, v in materials.items() if k not in solids} if isinstance(materials, Mapping) else materials
    by_group = materials_by_group(mesh, own, 2, "stress")
    loaded = checked_surfaces(mesh, surfaces)
    groups = shell_groups(mesh, by_group, thickness, offset, shear_factor)
    mesh, turned = _ready(check_surface(mesh, is_whole=of_solids is None))
    tell_of_turned(mesh.source, turned, _with_sides(list(groups.values()), loaded, beams))
    nodes = np.asarray(mesh.nodes)
    found = directors(nodes, mesh.cell_blocks, fold)
    blocks = _blocks(mesh, groups, found)
    given = _shell_cells(blocks, groups)
    read = time.perf_counter()
    count = len(nodes)
    report_size(6 * count)
    with stage("assemble"), _fenicsx.quiet():
        fx = _fenicsx.load()
        with _fenicsx.compiling(fx):
            problems = [ShellProblem(nodes, found, one) for one in given]
            stiffness = sum(one.stiffness(count) for one in problems).tocsr()
    field = mass_field(nodes, found, given)
    model = FiniteElementModel(
        nodes=nodes,
        components=COMPONENTS,
        stiffness=stiffness,
        mass=field.mass_matrix(),
        mass_field=field,
        cells=mesh.cell_blocks,
        groups=node_groups(mesh, is_shell=True),
        load_patterns=shell_patterns(mesh, loaded, groups, blocks, found),
        elasticity=_elasticity(shell_stack(list(groups.values()), blocks, found)),
        stress_stiffness=stress_stiffness(problems, count),
        provenance={
            "source": mesh.source,
            **mesh.provenance,
            "element": f"shell of {', '.join(f'{len(one.cells.nodes)} {one.cells.kind}' for one in given)}",
            "materials": {name: group.material.describe() for name, group in groups.items()},
            "thickness_m": {name: group.described for name, group in groups.items()},
            "cells turned": turned,
            "nodes on folds": len(found.folded),
            "shell": shell_measures(nodes, found, given, list(groups.values()), field),
            "nodes": count,
            "cells": mesh.cell_count,
            "dofs": 6 * count,
            "versions": fx.versions,
            "seconds": {"read and check": read - start, "assemble": time.perf_counter() - read},
        },
    )
    if beams:
        model = with_stiffeners(model, stiffener_lines(mesh, beams, found, given))
    if of_solids is not None:
        solid = solid_model(of_solids, {k: v for k, v in cast(Any, materials).items() if k in solids})
        model = with_solid(model, solid, seams_of(nodes, found, given, solid.nodes, skin(solid.cells)))
    model = replace(model, provenance={**model.provenance, "told": told(model.provenance)})
    model = attach(model, lumped) if lumped else model
    return with_source(model, model_source(shell_model, given_source, model.provenance.get("sha256")))


@checked("mesh", "cells", "cache", "progress")
def shell_body(
    mesh: Mesh | str | Path,
    materials: Materials,
    interfaces: Mapping[str, Any],
    thickness: Thickness | Mapping[str, Thickness] | None = None,
    reduction: Any = "auto",
    damping: Any = None,
    *,
    stiffening: StiffeningLevel = "none",
    cache: bool = True,
    progress: bool | None = None,
    **model: Unpack[ShellKeywords],
) -> FlexibleBody:
    """Return a flexible body made from a mesh of a surface: `shell_model`, then `kanefe.reduction.flexible_body`.

    Parameters
    ----------
    mesh, materials, thickness
        As for `shell_model`.
    interfaces : dict of str to str or Interface
        Interface for each named group of lines: "clamped", "rigid", "hinged", "average", "node", or a
        `kanefe.Interface`, which may also define the place.
    reduction : CraigBampton or another reduction, or None
        "auto" is `CraigBampton()`: modes and static shapes that follow from the body; `print(body)` tells which, and
        the error. None keeps every degree of freedom: milliseconds a step, where a reduction takes microseconds.
    damping : optional
        None, RayleighDamping, ModalDamping or a matrix.
    stiffening : "none", "inertial" or "full"
        Motion-induced stiffening, as in `kanefe.reduction.flexible_body`.
    cache : bool
        Whether to take the body from the cache, and to store it there (see `kanefe.bodies.cache`).
    progress : bool, optional
        Whether to show the stages. Default: on a terminal, for a large body.
    **model
        offset, fold, shear_factor, cells, surfaces, beams and lumped, as for `shell_model`.

    Examples
    --------
    >>> import kanefe as kf                                              # doctest: +SKIP
    >>> panel = shell_body("panel.msh", Material(E=70e9, nu=0.33, rho=2700.0), {"root": "clamped"}, thickness=2e-3,
    ...                    reduction=kf.CraigBampton(modes=12))           # doctest: +SKIP
    """
    from kanefe_fem.body_cache import cached_body

    of_model: dict[str, Any] = {
        name: model.get(name, one.default) for name, one in signature(shell_model).parameters.items() if name != "mesh"
    } | {"materials": materials, "thickness": thickness}
    of_body = {"reduction": reduction, "damping": damping, "stiffening": stiffening}

    def make(mesh: Mesh | str | Path) -> FlexibleBody:
        from kanefe.reduction import flexible_body
        from kanefe_fem._petsc import factorise

        with stages(STAGES, progress) as done:
            with stage("read the mesh"):
                read = read_to_assemble(mesh, 2, of_model["cells"])
            if read.dimension == 2:
                check_interfaces(read, interfaces, is_shell=True)
            full = shell_model(read, **{name: value for name, value in of_model.items() if name != "cells"})
            body = flexible_body(full, interfaces, **of_body, factorise=factorise)
        lines = [*body.provenance.get("told", ()), *told_of_waves(body.provenance)]
        return replace(body, provenance={**body.provenance, "stages": done.seconds, "solver": done.told, "told": lines})

    of_all = {**of_model, "interfaces": interfaces, **of_body, "kind": "shell", "order": 2}
    body = cached_body(mesh, of_all, make) if cache else make(mesh)
    options = {**of_model, "cache": cache, "progress": progress}
    source = MeshSource(read_to_assemble, mesh, options, 2, ONE_ORDER, held_by_number(of_model["lumped"]))
    return sourced(body, body_source(shell_body, source, of_body, interfaces))


def _parts(
    mesh: Mesh | str | Path, materials: Materials, cells: str | Sequence[str] | None
) -> tuple[Mesh, Mesh | None]:
    """Return checked meshes of the surfaces and of the volumes, None if there are none."""
    mesh = read_to_assemble(mesh, 2, cells)
    if mesh.dimension == 1:
        raise MeshError(f"{mesh.source} has lines only, and a shell is a surface. Remedy: beam_model_from_mesh")
    if mesh.dimension == 2:
        return mesh, None
    named = [name for name in mesh.facets if isinstance(materials, Mapping) and name in materials]
    if not named:
        raise MeshError(
            f"{mesh.source} has volumes, and a shell is a surface. Remedy: solid_body, or a mesh of the middle "
            "surface; for both in one body, a material for the groups of facets that are shells"
        )
    empty = [name for name in named if not any(len(block.nodes) for block in mesh.facets[name])]
    if empty:
        raise MeshError(
            f"{mesh.source}: the group {empty[0]!r} of facets is empty: read_mesh(order=) leaves out what is not on "
            "the volumes. Remedy: leave order out; shell_body makes cells of order 2"
        )
    surfaces = Mesh(
        nodes=mesh.nodes,
        dimension=2,
        cells={name: mesh.facets[name] for name in named},
        facets=mesh.lines,
        lines=mesh.lines,
        points=mesh.points,
        source=mesh.source,
        provenance=mesh.provenance,
    )
    check_arrays(surfaces)
    check_groups(surfaces)
    return oriented(surfaces, keeps_sides=True), replace(
        mesh, facets={k: v for k, v in mesh.facets.items() if k not in named}
    )


def _with_sides(groups: Sequence[ShellGroup], loaded: Sized, beams: Sized) -> list[str]:
    """Return what of a shell goes by its normals."""
    found = {
        "offset=": any(group.offset for group in groups),
        "plies": any(isinstance(group.plain, Laminate) for group in groups),
        "surfaces=": bool(loaded),
        "beams=": bool(beams),
    }
    return [what for what, is_there in found.items() if is_there]


def _ready(mesh: Mesh) -> tuple[Mesh, int]:
    """Return the mesh of second order with consistent normals and paired triangles, and how many cells were turned."""
    lifted = to_order(mesh, 2)
    blocks, turned = consistent(lifted.cell_blocks, mesh.source)
    lines = [block.nodes[:, 2] for own in (*lifted.facets.values(), *lifted.lines.values()) for block in own]
    kept = np.concatenate([np.zeros(0, dtype=np.int64), *lines, *lifted.points.values()])
    nodes, pieces = np.asarray(lifted.nodes), iter(blocks)
    made: dict[str, tuple[Cells, ...]] = {}
    for name, own in lifted.cells.items():
        parts: list[Cells] = []
        for _ in own:
            nodes, cells = of_nine_nodes(nodes, next(pieces), kept)
            parts += cells
        made[name] = tuple(parts)
    return replace(lifted, nodes=nodes, cells=made), turned


def _elasticity(stack: ShellStack) -> Elasticity:
    return Elasticity(np.zeros((0, 6, 6)), stack.of_cell, shell=stack)


def _blocks(mesh: Mesh, groups: Mapping[str, ShellGroup], found: Directors) -> list[BlockOfGroup]:
    """Return the blocks of cells of all groups with what they are made of."""
    sides, own, made = iter(found.of_cells), list(groups.values()), []
    for number, blocks in enumerate(mesh.cells.values()):
        for block in blocks:
            x = mesh.nodes[block.nodes]
            thickness, along = own[number].at_nodes(x), own[number].along(x, block.kind)
            made.append(BlockOfGroup(number, block, next(sides), thickness, along))
    return made


def _shell_cells(blocks: Sequence[BlockOfGroup], groups: Mapping[str, ShellGroup]) -> list[ShellCells]:
    """Return the cells of each shape, of all groups."""
    sections, made = tuple(group.section for group in groups.values()), []
    for kind in dict.fromkeys(one.cells.kind for one in blocks):
        own = [one for one in blocks if one.cells.kind == kind]
        made.append(
            ShellCells(
                cells=Cells(kind, np.concatenate([one.cells.nodes for one in own])),
                sides=np.concatenate([one.sides for one in own]),
                thickness=np.concatenate([one.thickness for one in own]),
                along=np.concatenate([one.along for one in own]),
                sections=sections,
                of_cell=np.concatenate([np.full(len(one.sides), one.group) for one in own]),
            )
        )
    return made
