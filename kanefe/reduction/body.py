"""From a full-order model to a flexible body: interfaces tied, basis made, matrices projected, one factorisation.

The free coordinates are made M-orthonormal, so that stiffness and modal damping are diagonal.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any

import numpy as np
import scipy.sparse as sp

from kanefe.damping import Damping
from kanefe.errors import ModelError
from kanefe.factorise import Factorise, splu_factorise
from kanefe.finite_element_model import FiniteElementModel
from kanefe.flexible import FlexibleBody, InterfaceFrame
from kanefe.interface_ties import Interface, InterfaceTies, tie_interfaces
from kanefe.mass_moments import MassMoments
from kanefe.nodal_moments import NodalMoments
from kanefe.reduction.damping_matrix import damping_matrix, damping_name
from kanefe.reduction.methods import Reduction
from kanefe.reduction.orthonormal import orthonormal_modes
from kanefe.reduction.supports import unrestrained_motions
from kanefe.statics import StaticProblem

LARGEST_UNREDUCED = 1500
"""Coordinates of an unreduced body above which its dense moments (9 K^2 numbers) would not fit a laptop."""


def flexible_body(
    model: FiniteElementModel,
    interfaces: Mapping[str, str | Interface] | None = None,
    *,
    reduction: Reduction | None = None,
    damping: Damping = None,
    factorise: Factorise = splu_factorise,
) -> FlexibleBody:
    """Return the flexible body of a full-order model.

    Parameters
    ----------
    model : FiniteElementModel
    interfaces : dict of str to "clamped", "rigid", "hinged" or Interface
        By the names of the model's groups. "clamped": a rigid patch fixed in G; "rigid": a rigid patch whose frame
        moves and can carry other bodies; "hinged": a rigid patch whose point is fixed in G and which can turn.
        Without an interface fixed in G the body floats: its rigid modes are taken out, and it needs a free joint.
    reduction : Reduction, optional
        Such as `CraigBampton`. None keeps every degree of freedom.
    damping : RayleighDamping, ModalDamping, matrix (N, N) or None
        Acts on the rate of deformation in G. None takes the model's own C, if it has one.
    factorise : callable
        Factors a symmetric positive definite sparse matrix.

    Returns
    -------
    FlexibleBody

    Raises
    ------
    ModelError
        If an interface, the supports, the reduction or the matrices make no sense; the message names which.
    """
    if reduction is not None and not hasattr(reduction, "basis"):
        raise ModelError(f"reduction must be CraigBampton(modes=...) or None, not {reduction!r}")
    started = time.perf_counter()
    ties = tie_interfaces(model, interfaces or {})
    rigid_count = unrestrained_motions(model, ties)
    problem = StaticProblem(model, ties, rigid_count, factorise)
    K, M = problem.stiffness, problem.mass
    if reduction is None:
        free, fixed = _unreduced_basis(ties, K.shape[0])
    else:
        free = reduction.basis(problem)
        fixed = problem.constraint_modes[:, ties.fixed - ties.interior_count]
    if reduction is not None or rigid_count:
        free = orthonormal_modes(free, K, M, rigid_count)
    basis = np.hstack((free, fixed))
    stiffness = basis.T @ (K @ basis)
    stiffness = 0.5 * (stiffness + stiffness.T)
    count = free.shape[1]
    full_basis = ties.transformation @ basis
    return FlexibleBody(
        nodes=np.array(model.nodes, dtype=float),
        components=model.components,
        basis=full_basis,
        free_count=count,
        stiffness=stiffness,
        damping=damping_matrix(damping, model, full_basis[:, :count], stiffness[:count, :count], free.T @ (M @ free)),
        interfaces=_interface_frames(ties, basis, count),
        cells=model.cells,
        load_patterns=tuple(pattern.projected(name, full_basis) for name, pattern in model.load_patterns.items()),
        **_inertia(model, full_basis),
        provenance={**model.provenance, "reduction": repr(reduction), "damping": damping_name(damping),
                    "reduction_seconds": time.perf_counter() - started},
    )  # fmt: skip


def _unreduced_basis(ties: InterfaceTies, size: int) -> tuple[np.ndarray, np.ndarray]:
    if size > LARGEST_UNREDUCED:
        raise ModelError(
            f"an unreduced body of {size} degrees of freedom is too large (the limit is {LARGEST_UNREDUCED}). "
            "Remedy: reduction=CraigBampton(modes=20)"
        )
    identity = np.eye(size)
    kept = np.setdiff1d(np.arange(size), ties.fixed)
    return identity[:, kept], identity[:, ties.fixed]


def _interface_frames(ties: InterfaceTies, basis: np.ndarray, free_count: int) -> tuple[InterfaceFrame, ...]:
    frames, column = [], free_count
    for tie in ties.ties:
        motion = np.zeros((6, basis.shape[1]))
        motion[list(tie.components)] = basis[tie.rows]
        columns = tuple(range(column, column + len(tie.fixed)))
        column += len(tie.fixed)
        components = tuple(tie.components[i] for i in tie.fixed)
        frames.append(InterfaceFrame(tie.name, tie.position, motion, components, columns))
    return tuple(frames)


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
    return {
        "moments": MassMoments.of_points(field.points, field.mass, point_basis),
        "inertia_points": np.array(field.points, dtype=float),
        "inertia_mass": sp.csr_matrix(field.mass, copy=True),
        "inertia_basis": point_basis,
    }
