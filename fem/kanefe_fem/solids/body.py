"""Solid bodies: from a mesh and materials to a `FlexibleBody`, by one process or by many."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack, overload

from kanefe.arguments import checked
from kanefe.bodies.source import sourced
from kanefe.fe_model.model import FiniteElementModel
from kanefe.fe_model.progress import stage, stages
from kanefe_fem.lumped.parts import held_by_number
from kanefe_fem.materials.of_groups import Materials
from kanefe_fem.mesh.body_source import MeshSource, body_source
from kanefe_fem.mesh.groups import check_interfaces, has_groups
from kanefe_fem.mesh.mesh import Mesh
from kanefe_fem.multigrid.choice import BodySolver, Solver, check_solver
from kanefe_fem.processes.team import Communicator, Team, checked_communicator, led
from kanefe_fem.solids.model import SolidKeywords, assembled_model, checked_mesh, solid_model
from kanefe_fem.solids.on_processes import refuse_one_process

if TYPE_CHECKING:
    from kanefe.bodies.flexible import FlexibleBody
    from kanefe.reduction.stiffening import StiffeningLevel

STAGES = 8
"""Number of stages in making a body."""


class BodyKeywords(SolidKeywords, total=False):
    """More keywords of `solid_body`."""

    solver: Solver


@overload
def solid_body(
    mesh: Mesh | str | Path,
    materials: Materials,
    interfaces: Mapping[str, Any],
    reduction: Any = "auto",
    damping: Any = None,
    *,
    stiffening: StiffeningLevel = "none",
    cache: bool = True,
    progress: bool | None = None,
    comm: None = None,
    **model: Unpack[BodyKeywords],
) -> FlexibleBody: ...


@overload
def solid_body(
    mesh: Mesh | str | Path,
    materials: Materials,
    interfaces: Mapping[str, Any],
    reduction: Any = "auto",
    damping: Any = None,
    *,
    stiffening: StiffeningLevel = "none",
    cache: bool = True,
    progress: bool | None = None,
    comm: Communicator,
    **model: Unpack[BodyKeywords],
) -> FlexibleBody | None: ...


@checked("mesh", "order", "cells", "lumped", "preload", "forms", "cache", "progress")
def solid_body(
    mesh: Mesh | str | Path,
    materials: Materials,
    interfaces: Mapping[str, Any],
    reduction: Any = "auto",
    damping: Any = None,
    *,
    stiffening: StiffeningLevel = "none",
    cache: bool = True,
    progress: bool | None = None,
    comm: Communicator | None = None,
    **model: Unpack[BodyKeywords],
) -> FlexibleBody | None:
    """Return a flexible body made from a mesh: `solid_model`, then `kanefe.reduction.flexible_body`.

    Parameters
    ----------
    mesh, materials
        As for `solid_model`.
    interfaces : dict of str to str or Interface
        Interface for each named group of facets: "clamped", "rigid", "hinged", "average", "node", or a
        `kanefe.Interface`, which may also define the place of the facets.
    reduction : CraigBampton or another reduction, or None
        "auto" is `CraigBampton()`: modes and static shapes that follow from the body; `print(body)` tells which, and
        the error. None keeps every degree of freedom: milliseconds a step, where a reduction takes microseconds.
    damping : optional
        RayleighDamping, ModalDamping or a matrix in the place of the damping that materials bring. None: that alone.
    stiffening : "none", "inertial" or "full"
        Motion-induced stiffening, as in `kanefe.reduction.flexible_body`.
    cache : bool
        Whether to take the body, or else its assembled model, from the cache, and to store both there (see
        `kanefe.bodies.cache`). A preload or stiffening needs more than the matrices: then the model is assembled again.
    progress : bool, optional
        Whether to show the stages. Default: on a terminal, for a large body.
    comm : mpi4py communicator, optional
        All its processes call this function, with the same arguments, and make the body together: the mesh, the
        matrices and their factors are spread over them. The first process reads the mesh and gets the body, which is
        the same for any number of processes; the others get None, or end quietly if there is an error. See "Large
        meshes".
    **model
        order, plane, thickness, surfaces, cells, densities, lumped, preload and forms, as for `solid_model`; and the
        other parameter below.

    Other Parameters
    ----------------
    solver : "auto", "direct" or "multigrid"
        How static shapes and modes are found: by the factors of the stiffness (MUMPS), or without them, for meshes
        whose factors do not fit into memory. "auto" compares memory and time before, and tells its choice; see "Large
        meshes".

    Examples
    --------
    >>> import kanefe as kf                                              # doctest: +SKIP
    >>> arm = solid_body("meshes/arm.msh", Material(E=70e9, nu=0.33, rho=2700.0),
    ...                  interfaces={"root": "clamped", "tip": "rigid"},
    ...                  reduction=kf.CraigBampton(modes=12))              # doctest: +SKIP
    """
    from kanefe_fem.body_cache import cached_body

    # with all defaults, so that a default that is given explicitly is the same body in the cache
    defaults = {
        name: one.default for name, one in signature(solid_model).parameters.items() if one.default is not one.empty
    }
    of_model: dict[str, Any] = {**defaults, "lumped": (), "preload": None, "forms": None, **model}
    of_model["materials"] = materials
    solver: Solver = of_model.pop("solver", "auto")
    check_solver(solver, reduction)
    of_body = {"reduction": reduction, "damping": damping, "stiffening": stiffening}
    of_both = {**of_body, "interfaces": interfaces}

    def whole(team: Team | None = None) -> FlexibleBody:
        def make(mesh: Mesh | str | Path) -> FlexibleBody:
            with stages(STAGES, progress) as done:
                body = _made_body(mesh, of_model, of_both, cache, team, solver)
            return replace(body, provenance={**body.provenance, "stages": done.seconds, "solver": done.told})

        return cached_body(mesh, {**of_model, **of_both, "solver": solver}, make) if cache else make(mesh)

    if comm is None or checked_communicator(comm).size == 1:
        options = {**of_model, "solver": solver, "cache": cache, "progress": progress}
        source = MeshSource(
            checked_mesh, mesh, options, of_model["order"], by_number=held_by_number(of_model["lumped"])
        )
        return sourced(whole(), body_source(solid_body, source, of_body, interfaces))
    body: FlexibleBody | None = led(comm, whole)
    return body


def _made_body(
    mesh: Mesh | str | Path,
    of_model: Mapping[str, Any],
    of_body: Mapping[str, Any],
    cache: bool,
    team: Team | None,
    solver: Solver,
) -> FlexibleBody:
    """Return the body with the options of `flexible_body`, from a new model or one in the cache, alone or on a team."""
    from kanefe.reduction import flexible_body
    from kanefe_fem.body_cache import cached_model
    from kanefe_fem.multigrid.factor import Discretisation

    def read_and_checked() -> Mesh:
        with stage("read the mesh"):
            read = checked_mesh(mesh, of_model["order"], of_model["cells"])
        check_interfaces(read, of_body["interfaces"])
        return read

    def assembled() -> FiniteElementModel:
        return solid_model(read_and_checked(), **of_model)

    if team is not None:
        refuse_one_process(of_model, of_body)
        return _on_team(assembled_model(read_and_checked(), **of_model, team=team), of_body, solver)
    if cache and of_body["stiffening"] == "none" and of_model["preload"] is None:
        model = cached_model(mesh, of_model, assembled)
        is_found = model.stress_stiffness is None
        if is_found and not has_groups(model, of_body["interfaces"]):
            read_and_checked()
    else:
        model = assembled()
    mesh_of_model = Discretisation(model.nodes, model.components, model.cells)
    return flexible_body(model, **of_body, factorise=BodySolver(mesh_of_model, solver))


def _on_team(model: FiniteElementModel, of_body: Mapping[str, Any], solver: Solver) -> FlexibleBody:
    """Return the body of a model with matrices on a team, and what its solvers tell of themselves."""
    from kanefe.reduction import flexible_body
    from kanefe_fem.multigrid.factor import Discretisation
    from kanefe_fem.processes.matrices import TeamMatrix
    from kanefe_fem.processes.solvers import TeamSolver

    mesh = Discretisation(model.nodes, model.components, model.cells)
    body = flexible_body(model, **of_body, factorise=TeamSolver(mesh, solver))
    matrix: TeamMatrix = model.stiffness
    return replace(body, provenance={**body.provenance, "processes": matrix.about()})
