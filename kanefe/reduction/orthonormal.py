"""M-orthonormal modes of the space that the columns of a reduction span.

Columns are orthonormalised in blocks by the singular vectors of their Gram matrix (Stathopoulos & Wu 2002, "A block
orthogonalization procedure with constant synchronization requirements"). This is repeated for the remainder after each
block, so that directions are distinguished down to `DEPENDENT`, and not only to the root of the round-off.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.linalg
import scipy.sparse as sp

from kanefe.errors import ModelError
from kanefe.frames import Vector
from kanefe.reduction.signs import with_fixed_signs

DEPENDENT = 1e-9
"""Part of a column outside the span of the others, relative to it, below which it counts as dependent."""

MOVES = 1e-6
"""Part of a motion that is left once all that has mass is taken out, relative to the largest, from which it counts."""

NO_MASS = 1e-14
"""Mass of a motion, relative to that by the largest masses of its coordinates, up to which it has none: above
round-off."""

NO_STIFFNESS = 1e-12
"""Energy of a motion without mass, relative to others, below which it has none: a rigid motion about a straight bar."""

WELL_APART = 1e-3
"""Singular value of normalised columns above which one block is orthonormalised to round-off in two rounds."""


class Orthonormal(NamedTuple):
    """Modes of the motions that have mass, and those that have none.

    Attributes
    ----------
    modes : ndarray, shape (tied, k)
        M-orthonormal, in the order of their frequencies.
    squares : ndarray, shape (k,)
        Their w^2.
    massless : ndarray, shape (tied, m)
        Motions in the span of the columns that have stiffness and no mass.
    """

    modes: np.ndarray
    squares: Vector
    massless: np.ndarray


def orthonormal_modes(
    columns: np.ndarray, K: sp.csr_matrix, M: sp.csr_matrix, rigid_modes: np.ndarray, largest: Vector
) -> np.ndarray:
    """Return the modes of `modes_by_mass` alone, shape (tied, k)."""
    return modes_by_mass(columns, K, M, rigid_modes, largest).modes


def modes_by_mass(
    columns: np.ndarray, K: sp.csr_matrix, M: sp.csr_matrix, rigid_modes: np.ndarray, largest: Vector
) -> Orthonormal:
    """Return M-orthonormal modes of (K, M) in the span of columns, without the rigid ones of a floating body.

    Motions without mass, of lumped matrices, follow the others statically, so that no mode deforms them by itself
    (Guyan; exact without loads on them).

    Parameters
    ----------
    columns : ndarray, shape (tied, m)
        Of any scale; zero and dependent ones are left out.
    K, M : csr_matrix, shape (tied, tied)
    rigid_modes : ndarray, shape (tied, r)
        M-orthonormal rigid motions, which are removed.
    largest : ndarray, shape (tied,)
        Largest mass of each coordinate: `StaticProblem.largest_masses`.

    Raises
    ------
    ModelError
        If a column is not finite, no column has mass, or the stiffness resists rigid motions or leaves others free.
    """
    R = rigid_modes
    massive, weighted, none = _by_mass(columns, M, largest)
    basis, rest = _orthonormal(massive, M, R, largest, weighted)
    free, massless = stiff_and_free(np.hstack((none, rest)), K, largest)
    if basis.shape[1] == 0:
        if massless.shape[1] or (free.shape[1] and not R.shape[1]):
            raise _massless()
        if R.shape[1]:
            raise ModelError(
                f"nothing of the body is left once its {R.shape[1]} rigid motions are taken out: it floats. "
                "Remedy: more modes"
            )
        return Orthonormal(basis, np.zeros(0), massless)
    if massless.shape[1]:
        pulled = K @ massless
        basis = basis - massless @ np.linalg.solve(massless.T @ pulled, pulled.T @ basis)
    stiffness = basis.T @ (K @ basis)
    squares, vectors = scipy.linalg.eigh(0.5 * (stiffness + stiffness.T))
    if R.shape[1]:
        # the lowest square counts as zero below the round-off of the sum that gives it
        lowest = np.abs(basis @ vectors[:, 0])
        noise = 1e-14 * float(lowest @ (abs(K) @ lowest))
        rigid = float(abs(np.einsum("ij,ij->j", R, K @ R)).max())
        if rigid > 1e-6 * squares[0] or squares[0] < noise:
            raise ModelError(
                f"K does not leave the {R.shape[1]} rigid motions free (w^2 = {rigid:.3g} against "
                f"{squares[0]:.3g} of the first elastic mode), or leaves more free. Remedy: check the "
                "order of the nodes and the mesh for loose parts and springs to ground (PARAM,K6ROT), or clamp an "
                "interface"
            )
    modes = with_fixed_signs(basis @ vectors, squares)
    # round-off of a large mesh leaves M some 1e-12 off the identity: one step of Newton's method for its inverse root
    root = 1.5 * np.eye(modes.shape[1]) - 0.5 * modes.T @ (M @ modes)
    return Orthonormal(np.asarray(modes @ root), squares, massless)


def stiff_and_free(motions: np.ndarray, K: sp.csr_matrix, largest: Vector) -> tuple[np.ndarray, np.ndarray]:
    """Return the span of motions without mass as independent columns: those without stiffness, and the others.

    `largest` is that of `modes_by_mass`.
    """
    if not motions.shape[1]:
        return motions, motions
    scale = np.sqrt(largest)[:, None]
    span, sizes, _ = np.linalg.svd(scale * motions, full_matrices=False)
    span = span[:, sizes > MOVES * sizes[0]] / scale
    diagonal = np.maximum(np.einsum("ij,ij->j", span, K @ span), 0.0)
    scale = 1.0 / np.sqrt(np.maximum(diagonal, 1e-300 + NO_STIFFNESS * diagonal.max()))
    stiffness = span.T @ (K @ span) * np.outer(scale, scale)
    squares, vectors = scipy.linalg.eigh(0.5 * (stiffness + stiffness.T))
    is_stiff = squares > NO_STIFFNESS
    turned = span @ (scale[:, None] * vectors)
    return turned[:, ~is_stiff], turned[:, is_stiff]


def normalised(columns: np.ndarray, M: sp.csr_matrix, largest: Vector) -> np.ndarray:
    """Return columns of unit M-norm, without those that are zero or have no mass: see `modes_by_mass`.

    Raises
    ------
    ModelError
        If a column is not finite.
    """
    return _by_mass(columns, M, largest)[0]


def _by_mass(columns: np.ndarray, M: sp.csr_matrix, largest: Vector) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return columns of unit M-norm, M times them, and those without mass; zero ones are left out."""
    if not np.all(np.isfinite(columns)):
        raise ModelError("the columns of the reduction are not finite. Remedy: check its loads and the matrices")
    sizes = abs(columns).max(axis=0, initial=0.0)
    columns = columns[:, sizes > 0.0] / sizes[sizes > 0.0]  # so that squares do not overflow
    weighted = M @ columns
    squares = np.einsum("ij,ij->j", columns, weighted)
    has_mass = squares > NO_MASS * (largest @ columns**2)
    norms = np.sqrt(squares[has_mass])
    return columns[:, has_mass] / norms, weighted[:, has_mass] / norms, columns[:, ~has_mass]


def orthonormal_columns(columns: np.ndarray, M: sp.csr_matrix, against: np.ndarray, largest: Vector) -> np.ndarray:
    """Return an M-orthonormal basis of the part of columns outside the span of others.

    Parameters
    ----------
    columns : ndarray, shape (n, m)
        With M-norms of the order of 1: a part below `DEPENDENT` is neglected, and so is what has no mass.
    M : csr_matrix, shape (n, n)
    against : ndarray, shape (n, r)
        M-orthonormal columns.
    largest : ndarray, shape (n,)
        That of `modes_by_mass`.

    Returns
    -------
    ndarray, shape (n, k), k <= m
        M-orthogonal to `against`.
    """
    return _orthonormal(columns, M, against, largest)[0]


def _orthonormal(
    columns: np.ndarray, M: sp.csr_matrix, against: np.ndarray, largest: Vector, weighted: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Return that basis, and the motions without mass that are left of the columns; `weighted` is M times them."""
    span = [(against, M @ against)] if against.shape[1] else []
    found: list[np.ndarray] = []
    extent = np.sqrt((largest @ columns**2).max(initial=0.0))
    left, scale = columns, 1.0
    rest = [np.zeros((len(columns), 0))]
    while left.shape[1]:
        left = _apart_from(span, left)
        if weighted is None or span:
            weighted = M @ left
        squares, vectors = scipy.linalg.eigh(left.T @ weighted)
        left = left @ vectors
        extents = largest @ left**2
        massless = squares <= NO_MASS * extents
        rest.append(left[:, massless & (np.sqrt(extents) * scale > MOVES * extent)])
        left, norms = left[:, ~massless], np.sqrt(squares[~massless])
        longest = norms.max(initial=0.0)
        if longest * scale < DEPENDENT:
            break
        apart = norms > WELL_APART * longest
        block = left[:, apart] / norms[apart]
        for _ in range(2 if span else 1):  # once more where what was taken out leaves round-off
            block = _apart_from(span, block)
            weighted = M @ block
            turn = np.linalg.inv(scipy.linalg.cholesky(block.T @ weighted))
            block, weighted = block @ turn, weighted @ turn
        span.append((block, weighted))
        found.append(block)
        scale *= WELL_APART * longest
        left = left[:, ~apart] / (WELL_APART * longest)
    return np.hstack([np.zeros((len(columns), 0)), *found]), np.hstack(rest)


def _apart_from(span: list[tuple[np.ndarray, np.ndarray]], columns: np.ndarray) -> np.ndarray:
    """Return columns M-orthogonal to blocks, each given with M times it, by two passes against round-off (Kahan)."""
    for _ in range(2):
        for block, weighted in span:
            columns = columns - block @ (weighted.T @ columns)
    return columns


def _massless() -> ModelError:
    return ModelError(
        "no motion that the reduction keeps has mass. Remedy: interfaces that leave nodes with mass free, more modes, "
        "or a mass matrix with rotary inertia"
    )
