"""From a tied full-order model to an unreduced body: the tied coordinates themselves, free ones first."""

from __future__ import annotations

import time

import numpy as np
import scipy.sparse as sp

from kanefe.bodies.flexible import InterfaceFrame
from kanefe.bodies.inertia_field import InertiaField
from kanefe.bodies.unreduced import UnreducedBody
from kanefe.errors import ModelError
from kanefe.fe_model.damping import Damping, ModalDamping, RayleighDamping, checked_damping, damping_name
from kanefe.fe_model.factorise import Factorise
from kanefe.fe_model.model import TRANSLATIONS, FiniteElementModel
from kanefe.fe_model.node_shares import NodeShares
from kanefe.fe_model.statics import StaticProblem


def unreduced_body(
    model: FiniteElementModel, problem: StaticProblem, damping: Damping, factorise: Factorise, started: float
) -> UnreducedBody:
    """Return the body of a tied model with all its degrees of freedom, in sparse matrices.

    Parameters
    ----------
    model : FiniteElementModel
    problem : StaticProblem
        Its tied K and M.
    damping : RayleighDamping, matrix (N, N) or None
    factorise : callable
    started : float
        Start of the computation by time.perf_counter(), for the provenance.

    Raises
    ------
    ModelError
        If the damping is modal or not valid, or some degree of freedom has no mass.
    """
    order = np.concatenate((problem.interior, problem.released, problem.fixed))
    count = len(order) - len(problem.fixed)
    basis = problem.ties.transformation[:, order].tocsr()
    masses = problem.mass.diagonal()[order[:count]]
    if count and masses.min() <= 1e-14 * masses.max():
        raise ModelError(
            "some degree of freedom of the unreduced body has no mass. Remedy: give every degree of freedom mass "
            "(rotary_inertia of beams), or reduction=CraigBampton(modes=20)"
        )
    factors, matrix = _damping(damping, model, basis[:, :count])
    field = _inertia_field(model, basis)
    return UnreducedBody(
        nodes=np.array(model.nodes, dtype=float),
        components=model.components,
        basis=basis,
        free_count=count,
        stiffness=problem.stiffness[order][:, order].tocsr().sorted_indices(),
        damping=matrix,
        moments=field,
        interfaces=_interface_frames(problem, order),
        inertia_points=field.points,
        inertia_mass=field.mass,
        inertia_basis=field.basis,
        cells=model.cells,
        load_patterns=tuple(pattern.projected(name, basis) for name, pattern in model.load_patterns.items()),
        elasticity=model.elasticity,
        groups=tuple(NodeShares.of(name, group) for name, group in model.groups.items()),
        provenance={
            **model.provenance,
            "reduction": {"method": "None"},
            "damping": damping_name(damping),
            "reduction_seconds": time.perf_counter() - started,
        },
        damping_factors=factors,
        rigid_motions=problem.rigid_modes[order],
        factorise=factorise,
    )


def _damping(
    damping: Damping, model: FiniteElementModel, free_basis: sp.csr_matrix
) -> tuple[tuple[float, float], sp.csr_matrix]:
    """Return the factors of M and K in C, and the contribution of a given matrix."""
    count = free_basis.shape[1]
    none = sp.csr_matrix((count, count))
    if damping is None:
        damping = model.damping
    if damping is None:
        return (0.0, 0.0), none
    if isinstance(damping, RayleighDamping):
        return (damping.mass, damping.stiffness), none
    if isinstance(damping, ModalDamping):
        raise ModelError(
            f"an unreduced body of {count} degrees of freedom has no modes that {damping!r} could damp one by one. "
            "Remedy: RayleighDamping.fit(frequencies, ratios), or reduction=CraigBampton(modes=20)"
        )
    C = checked_damping(damping, model)
    return (0.0, 0.0), (free_basis.T @ C @ free_basis).tocsr()


def _inertia_field(model: FiniteElementModel, basis: sp.csr_matrix) -> InertiaField:
    field = model.mass_field
    if field is None:
        return InertiaField(
            np.array(model.nodes, dtype=float), sp.csr_matrix(model.mass, copy=True), basis, model.components, False
        )
    point_basis = (field.interpolation @ basis).tocsr()
    points = np.array(field.points, dtype=float)
    return InertiaField(points, sp.csr_matrix(field.mass, copy=True), point_basis, TRANSLATIONS, True)


def _interface_frames(problem: StaticProblem, order: np.ndarray) -> tuple[InterfaceFrame, ...]:
    place = np.empty(len(order), dtype=int)
    place[order] = np.arange(len(order))
    frames = []
    for tie in problem.ties.ties:
        columns = place[tie.rows]
        motion = np.zeros((6, len(order)))
        motion[:, columns] = tie.directions
        held = tuple(int(columns[i]) for i in tie.fixed)
        components = tuple(tie.components[i] for i in tie.fixed)
        frames.append(InterfaceFrame(tie.name, tie.position, motion, components, held, axes=tie.axes))
    return tuple(frames)
