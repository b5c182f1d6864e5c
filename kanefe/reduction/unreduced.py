"""From a tied full-order model to an unreduced body: the tied coordinates themselves, free ones first.

Rotations about the normals of shells, and others, have no mass. They are coordinates of their own, which the others
move statically (`kanefe.unreduced.mass_solver`): Guyan's condensation, which is exact without mass.
"""

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

NO_MASS = 1e-12
"""Mass along a direction, relative to the largest of its coordinates, below which there is none."""


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
        If the damping is modal or not valid, or some component of an interface has no mass.
    """
    order = np.concatenate((problem.interior, problem.released, problem.fixed))
    count = len(order) - len(problem.fixed)
    turn, massless = massless_coordinates(problem)
    order_to = turn[:, order].tocsr()
    basis = (problem.ties.transformation @ order_to).tocsr()
    masses = np.delete((order_to.T @ problem.mass @ order_to).diagonal()[:count], massless)
    if masses.min(initial=np.inf) <= 1e-14 * masses.max(initial=0.0):
        raise ModelError(
            "some component of an interface of the unreduced body has no mass. Remedy: rotary inertia "
            "(rotary_inertia of beams), or reduction=CraigBampton()"
        )
    factors, matrix = _damping(damping, model, basis[:, :count])
    field = _inertia_field(model, basis, massless)
    return UnreducedBody(
        nodes=np.array(model.nodes, dtype=float),
        components=model.components,
        basis=basis,
        free_count=count,
        stiffness=(order_to.T @ problem.stiffness @ order_to).tocsr().sorted_indices(),
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
        rigid_motions=order_to.T @ problem.rigid_modes,
        massless=massless,
        factorise=factorise,
    )


def massless_coordinates(problem: StaticProblem) -> tuple[sp.csr_matrix, np.ndarray]:
    """Return an orthogonal change of the tied coordinates, and which of the new ones have no mass.

    Coordinates of each node outside of the interfaces, and those of each interface that do not follow its frame, are
    turned so that some of them have all that has no mass; what a positive semidefinite block leaves without mass has
    none in all of M.
    """
    M, largest = problem.mass.tocsr(), problem.largest_masses
    turn, none = sp.identity(problem.size, format="lil"), []
    for members in _neighbours(problem):
        scale = 1.0 / np.sqrt(largest[members])
        squares, axes = np.linalg.eigh(scale[:, None] * M[members][:, members].toarray() * scale)
        lost = axes[:, squares <= NO_MASS]
        if not lost.shape[1]:
            continue
        if lost.shape[1] < len(members):
            turn[np.ix_(members, members)] = np.linalg.qr(scale[:, None] * lost, mode="complete")[0]
        none.append(members[: lost.shape[1]])
    return turn.tocsr(), np.sort(np.concatenate(none)) if none else np.zeros(0, dtype=int)


def _neighbours(problem: StaticProblem) -> list[np.ndarray]:
    """Return the interior coordinates of each node, and of all nodes of an interface together."""
    model, ties = problem.model, problem.ties
    owner = np.arange(len(model.nodes))
    for tie in ties.ties:
        owner[tie.nodes] = tie.nodes.min()
    inner = ties.transformation[: model.nodal_size, : ties.interior_count].tocsc()
    node = owner[inner.indices[inner.indptr[:-1]] // len(model.components)]
    order = np.argsort(node, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(node[order])) + 1)


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
            "Remedy: RayleighDamping.fit(frequencies, ratios), or reduction=CraigBampton()"
        )
    C = checked_damping(damping, model)
    return (0.0, 0.0), (free_basis.T @ C @ free_basis).tocsr()


def _inertia_field(model: FiniteElementModel, basis: sp.csr_matrix, massless: np.ndarray) -> InertiaField:
    field = model.mass_field
    if field is None:
        return InertiaField(
            np.array(model.nodes, dtype=float), sp.csr_matrix(model.mass, copy=True), basis, model.components, False
        )
    has_mass = np.ones(basis.shape[1])
    has_mass[massless] = 0.0
    point_basis = (field.interpolation @ basis @ sp.diags(has_mass)).tocsr()
    point_basis.eliminate_zeros()
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
