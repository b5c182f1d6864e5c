"""M-orthonormal modes of the space that the columns of a reduction span.

Columns are orthonormalised in blocks by the singular vectors of their Gram matrix (Stathopoulos & Wu 2002, "A block
orthogonalization procedure with constant synchronization requirements"). This is repeated for the remainder after each
block, so that directions are distinguished down to `DEPENDENT`, and not only to the root of the round-off.
"""

from __future__ import annotations

import numpy as np
import scipy.linalg
import scipy.sparse as sp

from kanefe.errors import ModelError

DEPENDENT = 1e-9
"""Part of a column outside the span of the others, relative to it, below which it counts as dependent."""

WELL_APART = 1e-3
"""Singular value of normalised columns above which one block is orthonormalised to round-off in two rounds."""


def orthonormal_modes(
    columns: np.ndarray, K: sp.csr_matrix, M: sp.csr_matrix, rigid_modes: np.ndarray | None = None
) -> np.ndarray:
    """Return M-orthonormal modes of (K, M) in the span of columns, without the rigid ones of a floating body.

    Parameters
    ----------
    columns : ndarray, shape (tied, m)
        Of any scale; zero and dependent ones are left out.
    K, M : csr_matrix, shape (tied, tied)
    rigid_modes : ndarray, shape (tied, r), optional
        M-orthonormal rigid motions, which are removed.

    Returns
    -------
    ndarray, shape (tied, k)
        In the order of their frequencies.

    Raises
    ------
    ModelError
        If a column is not finite or has no mass, or the stiffness resists rigid motions or leaves others free.
    """
    R = np.zeros((len(columns), 0)) if rigid_modes is None else rigid_modes
    basis = orthonormal_columns(normalised(columns, M), M, against=R)
    if basis.shape[1] == 0:
        if R.shape[1]:
            raise ModelError(
                f"nothing of the body is left once its {R.shape[1]} rigid motions are taken out: it floats. "
                "Remedy: more modes"
            )
        return basis
    stiffness = basis.T @ (K @ basis)
    squares, vectors = scipy.linalg.eigh(0.5 * (stiffness + stiffness.T))
    if R.shape[1]:
        # eigenvalues below the round-off of the entries of K and M count as zero
        masses = M.diagonal()
        massive = masses > 1e-12 * masses.max()  # rotations have no mass in lumped matrices
        noise = 1e-14 * float(np.max(K.diagonal()[massive] / masses[massive]))
        rigid = float(abs(np.einsum("ij,ij->j", R, K @ R)).max())
        if rigid > 1e-6 * squares[0] or squares[0] < noise:
            raise ModelError(
                f"K does not leave the {R.shape[1]} rigid motions free (w^2 = {rigid:.3g} against "
                f"{squares[0]:.3g} of the first elastic mode), or leaves more free. Remedy: check the "
                "order of the nodes and the mesh for loose parts, or clamp an interface"
            )
    modes = basis @ vectors
    # round-off of a large mesh leaves M some 1e-12 off the identity: one step of Newton's method for its inverse root
    return np.asarray(modes @ (1.5 * np.eye(modes.shape[1]) - 0.5 * modes.T @ (M @ modes)))


def normalised(columns: np.ndarray, M: sp.csr_matrix) -> np.ndarray:
    """Return columns of unit M-norm, without those that are zero.

    Raises
    ------
    ModelError
        If a column is not finite, or has no mass.
    """
    if not np.all(np.isfinite(columns)):
        raise ModelError("the columns of the reduction are not finite. Remedy: check its loads and the matrices")
    largest = abs(columns).max(axis=0, initial=0.0)
    columns = columns[:, largest > 0.0] / largest[largest > 0.0]  # so that squares do not overflow
    squares = np.einsum("ij,ij->j", columns, M @ columns)
    if squares.min(initial=1.0) <= 0.0:
        raise _massless()
    return np.asarray(columns / np.sqrt(squares))


def orthonormal_columns(columns: np.ndarray, M: sp.csr_matrix, against: np.ndarray | None = None) -> np.ndarray:
    """Return an M-orthonormal basis of the part of columns outside the span of others.

    Parameters
    ----------
    columns : ndarray, shape (n, m)
        With M-norms of the order of 1: a part below `DEPENDENT` is neglected.
    M : csr_matrix, shape (n, n)
    against : ndarray, shape (n, r), optional
        M-orthonormal columns.

    Returns
    -------
    ndarray, shape (n, k), k <= m
        M-orthogonal to `against`.
    """
    span = [] if against is None or not against.shape[1] else [(against, M @ against)]
    found: list[np.ndarray] = []
    extent = np.linalg.norm(columns, axis=0).max(initial=0.0)
    left, scale = columns, 1.0
    while left.shape[1]:
        left = _apart_from(span, left)
        squares, vectors = scipy.linalg.eigh(left.T @ (M @ left))
        norms = np.sqrt(np.maximum(squares, 0.0))
        largest = norms[-1]
        if largest * scale < DEPENDENT:
            if np.linalg.norm(left, axis=0).max() * scale > 1e-6 * extent:
                raise _massless()
            break
        apart = norms > WELL_APART * largest
        block = left @ (vectors[:, apart] / norms[apart])
        for _ in range(2):
            block = _apart_from(span, block)
            weighted = M @ block
            turn = np.linalg.inv(scipy.linalg.cholesky(block.T @ weighted))
            block, weighted = block @ turn, weighted @ turn
        span.append((block, weighted))
        found.append(block)
        scale *= WELL_APART * largest
        left = left @ (vectors[:, ~apart] / (WELL_APART * largest))
    return np.hstack([np.zeros((len(columns), 0)), *found])


def _apart_from(span: list[tuple[np.ndarray, np.ndarray]], columns: np.ndarray) -> np.ndarray:
    """Return columns M-orthogonal to blocks, each given with M times it, by two passes against round-off (Kahan)."""
    for _ in range(2):
        for block, weighted in span:
            columns = columns - block @ (weighted.T @ columns)
    return columns


def _massless() -> ModelError:
    return ModelError(
        "the mass matrix of the reduced coordinates is not positive definite: some motion of the body has no mass. "
        "Remedy: give every degree of freedom mass (rotary_inertia of beams), or ask for fewer modes"
    )
