"""From a full-order model to a flexible body: interfaces tied, Craig-Bampton basis, one factorisation.

Craig & Bampton (1968): constraint modes, the static shapes of unit interface displacements, and the normal modes with
all interfaces held. K of the interior is factored once; it serves both. The free coordinates are then made
M-orthonormal, so that stiffness and modal damping are diagonal.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from kanefe.damping import Damping, ModalDamping, RayleighDamping
from kanefe.errors import ModelError
from kanefe.finite_element_model import FiniteElementModel, rigid_motion
from kanefe.flexible import FlexibleBody, InterfaceFrame
from kanefe.interface_ties import Interface, InterfaceTies, tie_interfaces
from kanefe.mass_moments import MassMoments
from kanefe.nodal_moments import NodalMoments

LARGEST_UNREDUCED = 1500
"""Coordinates of an unreduced body above which its dense moments (9 K^2 numbers) would not fit a laptop."""


class Factorisation(Protocol):
    """A factored symmetric positive definite matrix."""

    def solve(self, b: np.ndarray) -> np.ndarray:
        """Return ``A^-1 b`` for b of shape (n,) or (n, m)."""
        ...


Factorise = Callable[[sp.csc_matrix], Factorisation]


@dataclass(frozen=True)
class CraigBampton:
    """Which fixed-interface normal modes to keep beside the constraint modes.

    Parameters
    ----------
    modes : int, optional
        How many.
    up_to_frequency : float, optional
        All those up to this frequency in Hz.

    Raises
    ------
    ModelError
        If not exactly one of the two is given, or it makes no sense.
    """

    modes: int | None = None
    up_to_frequency: float | None = None

    def __post_init__(self) -> None:
        if (self.modes is None) == (self.up_to_frequency is None):
            raise ModelError("Craig-Bampton needs either modes=<number> or up_to_frequency=<Hz>, one of them")
        if self.modes is not None and (self.modes != int(self.modes) or self.modes < 0):
            raise ModelError(f"the number of Craig-Bampton modes must be a whole number >= 0, not {self.modes!r}")
        if self.up_to_frequency is not None and not (np.isfinite(self.up_to_frequency) and self.up_to_frequency > 0):
            raise ModelError(f"up_to_frequency must be above zero Hz and finite, not {self.up_to_frequency!r}")


class _SuperLU:
    def __init__(self, matrix: sp.csc_matrix) -> None:
        self._lu = spla.splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})

    def solve(self, b: np.ndarray) -> np.ndarray:
        return np.asarray(self._lu.solve(np.ascontiguousarray(b)))


def splu_factorise(matrix: sp.csc_matrix) -> Factorisation:
    """Factor a symmetric positive definite matrix by SuperLU, best below some 10,000 rows."""
    return _SuperLU(sp.csc_matrix(matrix))


def flexible_body(
    model: FiniteElementModel,
    interfaces: Mapping[str, str | Interface] | None = None,
    *,
    reduction: CraigBampton | None = None,
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
    reduction : CraigBampton, optional
        None keeps every degree of freedom.
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
    if reduction is not None and not isinstance(reduction, CraigBampton):
        raise ModelError(f"reduction must be CraigBampton(modes=...) or None, not {reduction!r}")
    started = time.perf_counter()
    ties = tie_interfaces(model, interfaces or {})
    K, M = ties.project(model.stiffness), ties.project(model.mass)
    rigid_count = _unrestrained_motions(model, ties)
    if reduction is None:
        free, fixed = _unreduced_basis(ties, K.shape[0])
    else:
        free, fixed = _craig_bampton_basis(reduction, ties, K, M, rigid_count, factorise)
    if reduction is not None or rigid_count:
        free = _orthonormal_modes(free, K, M, rigid_count)
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
        damping=_damping_matrix(damping, model, full_basis[:, :count], stiffness[:count, :count], free.T @ (M @ free)),
        interfaces=_interface_frames(ties, basis, count),
        cells=model.cells,
        load_patterns=tuple(pattern.projected(name, full_basis) for name, pattern in model.load_patterns.items()),
        **_inertia(model, full_basis),
        provenance={**model.provenance, "reduction": repr(reduction), "damping": _damping_name(damping),
                    "reduction_seconds": time.perf_counter() - started},
    )  # fmt: skip


def _unrestrained_motions(model: FiniteElementModel, ties: InterfaceTies) -> int:
    """Return how many rigid motions must be taken out: all of a floating body, none of one held in G."""
    modes = model.rigid_modes(about=model.nodes.mean(axis=0))
    scale = np.linalg.norm(modes, axis=0)
    modes = modes[:, scale > 1e-12 * scale.max()]
    total = int(np.linalg.matrix_rank(modes / np.linalg.norm(modes, axis=0), tol=1e-9))
    if not len(ties.fixed):
        _check_rigid_motions(model, modes / np.linalg.norm(modes, axis=0))
        return total
    held = np.vstack(
        [rigid_motion(t.position[None], model.nodes.mean(axis=0), t.names)[list(t.fixed)] for t in ties.ties]
    )
    length = np.ptp(model.nodes, axis=0).max() or 1.0
    held[:, 3:] /= length
    restrained = int(np.linalg.matrix_rank(held, tol=1e-9))
    if restrained < total:
        names = ", ".join(t.name for t in ties.ties if t.fixed)
        raise ModelError(
            f"the interfaces fixed in G ({names}) leave {total - restrained} rigid motion(s) of the body free. "
            "Remedy: make one of them 'clamped', fix more components, or fix none and give the body a free joint"
        )
    return 0


def _check_rigid_motions(model: FiniteElementModel, modes: np.ndarray) -> None:
    """Check that the stiffness of a floating body does not resist rigid motions (unit columns) of its nodes."""
    resistance = np.linalg.norm(model.stiffness @ modes, axis=0).max() / spla.norm(model.stiffness, np.inf)
    if resistance > 1e-6:  # matrices exported with seven digits pass
        raise ModelError(
            f"K resists rigid motions of the nodes ({resistance:.2g} of its largest row), but the body floats. "
            "Remedy: check the order of the nodes and that the model is unsupported, or clamp an interface"
        )


def _unreduced_basis(ties: InterfaceTies, size: int) -> tuple[np.ndarray, np.ndarray]:
    if size > LARGEST_UNREDUCED:
        raise ModelError(
            f"an unreduced body of {size} degrees of freedom is too large (the limit is {LARGEST_UNREDUCED}). "
            "Remedy: reduction=CraigBampton(modes=20)"
        )
    identity = np.eye(size)
    kept = np.setdiff1d(np.arange(size), ties.fixed)
    return identity[:, kept], identity[:, ties.fixed]


def _craig_bampton_basis(
    reduction: CraigBampton,
    ties: InterfaceTies,
    K: sp.csr_matrix,
    M: sp.csr_matrix,
    rigid_count: int,
    factorise: Factorise,
) -> tuple[np.ndarray, np.ndarray]:
    """Return free columns (constraint modes of free components, normal modes) and fixed ones (constraint modes)."""
    interior, boundary = np.arange(ties.interior_count), np.arange(ties.interior_count, K.shape[0])
    K_ii, M_ii = K[interior][:, interior].tocsc(), M[interior][:, interior].tocsc()
    # Without interfaces K_ii is singular; a shift well below the first elastic mode keeps the same eigenvectors.
    shift = 0.0 if len(boundary) else 1e-6 * K_ii.diagonal().sum() / M_ii.diagonal().sum()
    factors = _factor(K_ii + shift * M_ii if shift else K_ii, factorise)
    constraint = np.zeros((K.shape[0], len(boundary)))
    if len(boundary):
        constraint[interior] = factors.solve(-K[interior][:, boundary].toarray())
        constraint[boundary] = np.eye(len(boundary))
    rigid = 0 if len(boundary) else rigid_count  # with interfaces the constraint modes span the rigid motions
    modes = np.zeros((K.shape[0], 0))
    wanted = reduction.modes if reduction.modes is not None else 12
    while wanted + rigid > 0:
        squares, shapes = _normal_modes(K_ii, M_ii, wanted + rigid, shift, factors)
        modes = np.zeros((K.shape[0], shapes.shape[1]))
        modes[interior] = shapes
        if reduction.up_to_frequency is None:
            break
        limit = (2 * np.pi * reduction.up_to_frequency) ** 2
        if squares[-1] > limit or shapes.shape[1] >= len(interior):
            modes = modes[:, squares <= limit]
            break
        wanted = min(2 * wanted, len(interior))
    fixed = ties.fixed - ties.interior_count
    released = np.setdiff1d(np.arange(len(boundary)), fixed)
    return np.hstack((constraint[:, released], modes)), constraint[:, fixed]


def _factor(matrix: sp.csc_matrix, factorise: Factorise) -> Factorisation:
    """Factor K of the interior and check it on one solve: a mechanism or loose part shows here."""
    remedy = "Remedy: check the mesh for loose parts or hinges, and the interfaces"
    if matrix.shape[0] == 0:
        raise ModelError(
            "all nodes of the body belong to interfaces: nothing is left to deform. Remedy: refine the mesh"
        )
    try:
        factors = factorise(matrix)
    except RuntimeError as error:
        raise ModelError(f"the stiffness matrix of the interior is singular ({error}). {remedy}") from error
    probe = np.cos(np.arange(matrix.shape[0]))  # a fixed vector with a part along every mode
    force = matrix @ probe
    error_size = np.linalg.norm(factors.solve(force) - probe) / np.linalg.norm(probe)
    if not error_size < 1e-3:
        raise ModelError(
            "the stiffness matrix of the interior is singular or nearly so (a solve is wrong by "
            f"{error_size:.1e}). {remedy}"
        )
    return factors


def _normal_modes(
    K: sp.csc_matrix, M: sp.csc_matrix, count: int, shift: float, factors: Factorisation
) -> tuple[np.ndarray, np.ndarray]:
    """Return w^2 and shapes of the lowest modes of (K, M), using the factors of K + shift M."""
    size = K.shape[0]
    if count > size:
        raise ModelError(
            f"{count} modes were asked of a body whose interior has {size} degrees of freedom. Remedy: "
            "fewer modes, or reduction=None"
        )
    if count > size - 2 or size <= 400:  # ARPACK needs room; LAPACK is as fast for small matrices
        squares, shapes = scipy.linalg.eigh(K.toarray(), M.toarray(), subset_by_index=(0, count - 1))
        return squares, shapes
    inverse = spla.LinearOperator(K.shape, matvec=factors.solve, dtype=float)
    start = np.random.default_rng(0).standard_normal(size)  # the same modes in every run
    squares, shapes = spla.eigsh(K, k=count, M=M, sigma=-shift, OPinv=inverse, v0=start)
    order = np.argsort(squares)
    return squares[order], shapes[:, order]


def _orthonormal_modes(free: np.ndarray, K: sp.csr_matrix, M: sp.csr_matrix, rigid_count: int) -> np.ndarray:
    """Return the same space in M-orthonormal modes of (K, M), without the rigid ones of a floating body."""
    if free.shape[1] == 0:
        return free
    stiffness, mass = free.T @ (K @ free), free.T @ (M @ free)
    massless = ModelError(
        "the mass matrix of the reduced coordinates is not positive definite: some motion of the body has no mass. "
        "Remedy: give every degree of freedom mass (rotary_inertia of beams), or ask for fewer modes"
    )
    if np.diag(mass).min() <= 0:
        raise massless
    scale = 1.0 / np.sqrt(np.diag(mass))
    try:
        squares, vectors = scipy.linalg.eigh(stiffness * np.outer(scale, scale), mass * np.outer(scale, scale))
    except np.linalg.LinAlgError as error:
        raise massless from error
    if rigid_count:
        if rigid_count >= len(squares):
            raise ModelError(
                f"the body floats and has {len(squares)} coordinates, {rigid_count} of them rigid: none is "
                "left. Remedy: more modes"
            )
        # Of the eigenvalues of two sparse matrices, those below the round-off of their entries are zeros.
        noise = 1e-14 * float(np.max(K.diagonal() / np.maximum(M.diagonal(), 1e-300)))
        if abs(squares[:rigid_count]).max() > 1e-6 * squares[rigid_count] or squares[rigid_count] < noise:
            raise ModelError(
                f"K does not leave the {rigid_count} rigid motions free (w^2 = {squares[rigid_count - 1]:.3g} against "
                f"{squares[rigid_count]:.3g} of the first elastic mode), or leaves more free. Remedy: check the "
                "order of the nodes and the mesh for loose parts, or clamp an interface"
            )
    modes = free @ (scale[:, None] * vectors[:, rigid_count:])
    # round-off of a large mesh leaves M some 1e-12 off the identity: one step of Newton's method for its root
    return np.asarray(modes @ (1.5 * np.eye(modes.shape[1]) - 0.5 * modes.T @ (M @ modes)))


def _damping_matrix(
    damping: Damping, model: FiniteElementModel, free_basis: np.ndarray, stiffness: np.ndarray, mass: np.ndarray
) -> np.ndarray:
    """Return C of the free coordinates, shape (k, k)."""
    count = len(stiffness)
    if damping is None:
        damping = model.damping
    if damping is None or count == 0:
        return np.zeros((count, count))
    if isinstance(damping, RayleighDamping):
        return damping.mass * mass + damping.stiffness * stiffness
    if isinstance(damping, ModalDamping):
        squares, shapes = scipy.linalg.eigh(stiffness, mass)
        weighted = mass @ shapes
        rates = 2 * damping.ratios(count) * np.sqrt(np.maximum(squares, 0.0))
        return (weighted * rates) @ weighted.T
    if isinstance(damping, (int, float, str)):
        raise ModelError(f"damping={damping!r} is no damping. Remedy: ModalDamping({damping!r}) or RayleighDamping")
    C = sp.csr_matrix(damping)
    if C.shape != (model.size, model.size):
        raise ModelError(f"the damping matrix has shape {C.shape}, the model has {model.size} degrees of freedom")
    if not np.all(np.isfinite(C.data)) or abs(C - C.T).max() > 1e-9 * abs(C).max():
        raise ModelError("the damping matrix is not symmetric or not finite. Remedy: pass its symmetric part")
    reduced = free_basis.T @ (C @ free_basis)
    if np.linalg.eigvalsh(reduced).min() < -1e-9 * abs(reduced).max():
        raise ModelError("the damping matrix feeds energy in (it has a negative eigenvalue). Remedy: check its signs")
    return reduced


def _damping_name(damping: Damping) -> str:
    return "given matrix" if sp.issparse(damping) or isinstance(damping, np.ndarray) else repr(damping)


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
