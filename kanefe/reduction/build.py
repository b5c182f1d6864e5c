"""From a full-order model to a flexible body: interfaces tied, basis computed, matrices projected, one factorisation.

The free coordinates are M-orthonormal, so that stiffness and modal damping are diagonal.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Literal

import numpy as np
import scipy.sparse as sp

from kanefe.arguments import checked
from kanefe.bodies.flexible import FlexibleBody, InterfaceFrame
from kanefe.bodies.mass_moments import MassMoments
from kanefe.bodies.nodal_moments import NodalMoments
from kanefe.bodies.source import sourced
from kanefe.bodies.wet_moments import WetMoments
from kanefe.errors import ModelError
from kanefe.fe_model.damping import Damping, damping_matrix, damping_name
from kanefe.fe_model.factorise import Factorise, splu_factorise
from kanefe.fe_model.grounded import ground_springs, resisted_turns
from kanefe.fe_model.interface import Interface
from kanefe.fe_model.model import FiniteElementModel
from kanefe.fe_model.node_shares import NodeShares
from kanefe.fe_model.progress import stage
from kanefe.fe_model.rigid_patch_error import tie_errors
from kanefe.fe_model.skin import with_places
from kanefe.fe_model.statics import StaticProblem
from kanefe.fe_model.ties import InterfaceTies, tie_interfaces
from kanefe.reduction.basis import Reduction
from kanefe.reduction.craig_bampton import CraigBampton
from kanefe.reduction.massless import has_massless, tell_massless, tell_of_frames_without_inertia
from kanefe.reduction.orthonormal import modes_by_mass
from kanefe.reduction.record import reduction_record, told_of_choice
from kanefe.reduction.relaxation import loss_shapes, reduced_losses, refuse_losses
from kanefe.reduction.source import source_of_model
from kanefe.reduction.stiffening import StiffeningLevel, check_stiffening, second_order_motion, stiffened
from kanefe.reduction.stress_modes import stress_modes

LARGEST_DENSE = 300
"""Number of coordinates of an unreduced body above which it is kept in sparse matrices, and needs an implicit
integrator."""


@checked("model")
def flexible_body(
    model: FiniteElementModel,
    interfaces: Mapping[str, str | Interface] | None = None,
    *,
    reduction: Reduction | Literal["auto"] | None = None,
    damping: Damping = None,
    stiffening: StiffeningLevel = "none",
    factorise: Factorise = splu_factorise,
) -> FlexibleBody:
    """Return the flexible body of a full-order model.

    Parameters
    ----------
    model : FiniteElementModel
    interfaces : dict of str to "clamped", "rigid", "hinged", "average", "node" or Interface
        By the names of the model's groups. "clamped": a rigid patch fixed in G; "rigid": a rigid patch whose frame
        moves and can carry other bodies; "hinged": a rigid patch whose point is fixed in G and which can turn;
        "average": a frame that moves with the mean of a patch, without stiffening it; "node": a single node.
        Without an interface fixed in G the body floats: its rigid modes are removed, and it needs a free joint.
    reduction : Reduction or "auto", optional
        Such as `CraigBampton`; "auto" is `CraigBampton()`, a choice derived from the body. None keeps every degree of
        freedom; above `LARGEST_DENSE` of them in sparse matrices, as an `UnreducedBody`, for
        method="generalised-alpha" or "hht".
    damping : RayleighDamping, ModalDamping, matrix (N, N) or None
        Acts on the rate of deformation in G. None takes the model's own C, if it has one.
    stiffening : "none", "inertial" or "full"
        Which loads contribute geometric stiffness: none; inertia and gravity, as in a rotating blade; those, and the
        loads on interfaces and load patterns. With "full" the frames of the interfaces also move by the foreshortening
        of the body. See `kanefe.reduction.stiffening`.
    factorise : callable
        Factors a symmetric positive definite sparse matrix.

    Returns
    -------
    FlexibleBody

    Raises
    ------
    ModelError
        If an interface, the supports, the reduction or the matrices are not valid; the message names which.
    """
    method = _checked_reduction(reduction)
    check_stiffening(stiffening, model)
    specs = {} if interfaces is None else interfaces
    body = _made_body(model, specs, method, damping, stiffening, factorise)
    options = {"reduction": method, "damping": damping, "stiffening": stiffening, "factorise": factorise}
    return sourced(body, source_of_model(flexible_body, model, specs, options))


def _made_body(
    model: FiniteElementModel,
    interfaces: Mapping[str, str | Interface],
    method: Reduction | None,
    damping: Damping,
    stiffening: StiffeningLevel,
    factorise: Factorise,
) -> FlexibleBody:
    started = time.perf_counter()
    with stage("tie the interfaces"):
        model, interfaces = with_places(model, interfaces)
        ties = tie_interfaces(model, interfaces)
        rigid_count = unrestrained_motions(model, ties)
        problem = StaticProblem(_with_fluid(model), ties, rigid_count, factorise)
    if method is None and problem.size > LARGEST_DENSE:
        return _unreduced(problem, damping, stiffening, factorise, started)
    free, fixed, record = _whole(problem) if method is None else _reduced(problem, method)
    count, basis = free.shape[1], np.hstack((free, fixed))
    stiffness = basis.T @ (problem.stiffness @ basis)
    stiffness = 0.5 * (stiffness + stiffness.T)
    full_basis = ties.transformation @ basis
    body = FlexibleBody(
        nodes=np.array(model.nodes, dtype=float),
        components=model.components,
        basis=np.ascontiguousarray(full_basis[: model.nodal_size]),
        free_count=count,
        stiffness=stiffness,
        **reduced_losses(model, full_basis[:, :count], stiffness[:count, :count]),
        damping=damping_matrix(damping, problem.model, full_basis[:, :count], stiffness[:count, :count]),
        interfaces=_interface_frames(ties, basis, count),
        cells=model.cells,
        load_patterns=tuple(pattern.projected(name, full_basis) for name, pattern in model.load_patterns.items()),
        **_recovery(model, full_basis),
        groups=tuple(NodeShares.of(name, group) for name, group in model.groups.items()),
        **_inertia(model, full_basis),
        provenance={
            **model.provenance,
            "reduction": record,
            **_told(model, record),
            "damping": damping_name(damping),
            "tie_errors": {} if method is None else tie_errors(problem, interfaces),
            "stiffening": stiffening,
            "reduction_seconds": time.perf_counter() - started,
        },
    )
    return body if stiffening == "none" else stiffened(body, second_order_motion(problem, basis, stiffening))


def _checked_reduction(reduction: Reduction | str | None) -> Reduction | None:
    """Return a method of reduction, None for none; refuse anything else."""
    if isinstance(reduction, str) and reduction == "auto":
        return CraigBampton()
    if isinstance(reduction, str) or (reduction is not None and not hasattr(reduction, "basis")):
        raise ModelError(
            f'reduction must be "auto", CraigBampton(modes=...), FreeInterface, Krylov or None, not {reduction!r}'
        )
    return reduction


def _unreduced(
    problem: StaticProblem, damping: Damping, stiffening: StiffeningLevel, factorise: Factorise, started: float
) -> FlexibleBody:
    """Return the body in sparse matrices; raise a ModelError where that is not possible."""
    if problem.model.added_mass is not None or problem.model.stresses is not None:
        raise ModelError(
            f"a body of {problem.size} coordinates with added mass or stresses of its own cannot be kept whole. "
            "Remedy: reduction=CraigBampton(modes=...)"
        )
    if problem.model.generalised:
        raise ModelError(
            f"a superelement of {problem.size} coordinates cannot be kept whole. Remedy: "
            "reduction=CraigBampton(modes=...)"
        )
    if stiffening != "none":
        raise ModelError(
            f"stiffening={stiffening!r} of an unreduced body of {problem.size} coordinates is not possible. "
            f"Remedy: reduction=CraigBampton(modes=...), or fewer than {LARGEST_DENSE} coordinates"
        )
    refuse_losses(problem.model)
    from kanefe.reduction.unreduced import unreduced_body

    return unreduced_body(problem.model, problem, damping, factorise, started)


def _whole(problem: StaticProblem) -> tuple[np.ndarray, np.ndarray, dict[str, Any]]:
    """Return free and fixed columns of all coordinates, and the record of that."""
    K, M, at_rest = problem.stiffness, problem.mass, problem.ties.fixed
    identity = np.eye(K.shape[0])
    free, fixed = np.delete(identity, at_rest, axis=1), identity[:, at_rest]
    massless, moving = free[:, :0], np.delete(np.arange(K.shape[0]), at_rest)
    R, largest = problem.rigid_modes, problem.largest_masses
    if problem.rigid_count or has_massless(M[moving][:, moving], largest[moving]):
        free, _, massless = modes_by_mass(free, K, M, R, largest)
        if not problem.rigid_count:
            tell_of_frames_without_inertia(problem, free)
    return free, fixed, {"method": "None", "kept": free.shape[1]} | _lost(problem, massless, statics=False)


def _reduced(problem: StaticProblem, reduction: Reduction) -> tuple[np.ndarray, np.ndarray, dict[str, Any]]:
    """Return the free columns that a reduction keeps, the fixed ones, and the record of that."""
    chosen, ties = reduction.basis(problem), problem.ties
    columns = np.hstack((chosen.columns, loss_shapes(problem, chosen.columns)))
    with stage("orthonormal modes"):
        found = modes_by_mass(columns, problem.stiffness, problem.mass, problem.rigid_modes, problem.largest_masses)
    record = reduction_record(reduction, problem, chosen, found)
    fixed = problem.constraint_modes[:, ties.fixed - ties.interior_count]
    return found.modes, fixed, record | _lost(problem, found.massless, statics=True)


def _told(model: FiniteElementModel, record: Mapping[str, Any]) -> dict[str, Any]:
    """Return what is told of a model and of the choice of its modes, for the provenance."""
    lines = [*model.provenance.get("told", ()), *told_of_choice(record)]
    return {"told": lines} if lines else {}


def _lost(problem: StaticProblem, massless: np.ndarray, *, statics: bool) -> dict[str, Any]:
    """Return what a record tells of shapes without mass."""
    lost = tell_massless(problem, massless, statics=statics)
    return {"without_mass": lost} if lost else {}


def _interface_frames(ties: InterfaceTies, basis: np.ndarray, free_count: int) -> tuple[InterfaceFrame, ...]:
    frames, column = [], free_count
    for tie in ties.ties:
        motion = tie.directions @ basis[tie.rows]
        columns = tuple(range(column, column + len(tie.fixed)))
        column += len(tie.fixed)
        components = tuple(tie.components[i] for i in tie.fixed)
        frames.append(InterfaceFrame(tie.name, tie.position, motion, components, columns, axes=tie.axes))
    return tuple(frames)


def _recovery(model: FiniteElementModel, basis: np.ndarray) -> dict[str, Any]:
    return {"elasticity": model.elasticity, "stress_modes": stress_modes(model, basis)}


def _with_fluid(model: FiniteElementModel) -> FiniteElementModel:
    """Return the model with the fluid around it in its mass matrix, whose modes are those of both."""
    if model.added_mass is None:
        return model
    if model.mass_field is None:
        raise ModelError(
            "an added mass needs a body with exact inertia, and this one has only M of its nodes. Remedy: give its "
            "mass_field, or leave the added mass out"
        )
    return replace(model, mass=sp.csr_matrix(model.mass + model.added_mass))


def _inertia(model: FiniteElementModel, basis: np.ndarray) -> dict[str, Any]:
    field = model.mass_field
    if field is None:
        return {
            "moments": NodalMoments.of_nodes(model.nodes, model.components, model.mass, basis),
            "inertia_points": np.array(model.nodes, dtype=float),
            "inertia_mass": sp.csr_matrix(model.mass, copy=True),
            "inertia_basis": basis.copy(),
        }
    point_basis = field.interpolation @ basis
    moments = MassMoments.of_points(field.points, field.mass, point_basis)
    if model.added_mass is not None:
        motions = np.hstack((model.rigid_modes(), basis))
        fluid = motions.T @ (model.added_mass @ motions)
        moments = WetMoments.around(moments, 0.5 * (fluid + fluid.T))
    return {
        "moments": moments,
        "inertia_points": np.array(field.points, dtype=float),
        "inertia_mass": sp.csr_matrix(field.mass, copy=True),
        "inertia_basis": point_basis,
    }


def unrestrained_motions(model: FiniteElementModel, ties: InterfaceTies) -> int:
    """Return the number of rigid motions to be removed: all of a floating body, none of one held in G."""
    modes, _ = model.unit_rigid_modes()
    total = int(np.linalg.matrix_rank(modes, tol=1e-9))
    if not len(ties.fixed):
        _check_rigid_motions(model, modes)
        _check_interfaces_hold(ties, modes, total)
        return total
    held = ties.coordinates(model.rigid_modes(about=model.nodes.mean(axis=0)))[ties.fixed]
    held[:, 3:] /= np.ptp(model.nodes, axis=0).max() or 1.0
    restrained = int(np.linalg.matrix_rank(held, tol=1e-9))
    if restrained < total:
        names = ", ".join(t.name for t in ties.ties if t.fixed)
        raise ModelError(
            f"the interfaces fixed in G ({names}) leave {total - restrained} rigid motion(s) of the body free. "
            "Remedy: make one of them 'clamped', fix more components, or fix none and give the body a free joint"
        )
    return 0


def _check_interfaces_hold(ties: InterfaceTies, modes: np.ndarray, total: int) -> None:
    """Check that the interfaces of a floating body, all held, leave none of its rigid motions (unit columns)."""
    if not ties.ties:
        return
    frames = ties.coordinates(modes)[ties.interior_count :]
    held = int(np.linalg.matrix_rank(frames / np.maximum(np.linalg.norm(frames, axis=0), 1e-300), tol=1e-9))
    if held < total:
        raise ModelError(
            f"the body floats, and its interfaces ({', '.join(tie.name for tie in ties.ties)}) follow only {held} of "
            f"its {total} rigid motions. Remedy: add an interface of facets; loads and springs need none, they go to "
            "member.node(number)"
        )


def _check_rigid_motions(model: FiniteElementModel, modes: np.ndarray) -> None:
    """Check that the stiffness of a floating body does not resist rigid motions (unit columns) of its nodes."""
    largest_row = float((abs(model.stiffness) @ np.ones(model.size)).max())
    resistance = np.linalg.norm(model.stiffness @ modes, axis=0).max() / largest_row
    if resistance > 1e-6:  # matrices exported with seven digits pass
        springs = ground_springs(model)
        if springs is not None:
            raise ModelError(f"the body floats, and K holds it: {springs}, or clamp an interface")
        turns = resisted_turns(model).square
        raise ModelError(
            f"K resists rigid motions of the nodes ({resistance:.2g} of its largest row; a turn would swing at "
            f"{np.sqrt(max(turns, 0.0)) / (2.0 * np.pi):.2g} Hz), but the body floats. Remedy: check the order of the "
            "nodes and that the model is unsupported, or clamp an interface"
        )
