"""Lowest modes of (K, M) by the block Lanczos method with the inverse of K.

Golub & Underwood (1977); Grimes, Lewis & Simon (1994), "A shifted block Lanczos algorithm for solving sparse symmetric
generalized eigenproblems". The cost of a solve with the factors of a large K is that of reading them from memory: with
eight right-hand sides at once, each costs a fifth. scipy's eigsh (ARPACK) solves for one at a time, and takes twice as
long for the modes of a body of 100,000 degrees of freedom.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy.linalg
import scipy.sparse as sp

from kanefe.errors import ModelError

BLOCK = 8
"""Number of right-hand sides of a solve: with more, each becomes cheaper, but more of them are needed."""

TOLERANCE = 1e-9
"""Residual of a mode relative to its K-norm. The error of frequencies is its square."""

LARGEST_PART = 4
"""Ratio of the number of directions to that of requested modes from which the method gives up."""

_NEAR, _DEPENDENT = 1e-4, 1e-15
"""Squared norms of the part of a direction independent of the others, relative to it: below the first it is
orthonormalised again, below the second it is round-off."""


def lowest_modes(
    M: sp.spmatrix, count: int, solve: Callable[[np.ndarray], np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """Return w^2 and M-orthonormal shapes of the lowest modes, ascending.

    Parameters
    ----------
    M : sparse matrix, shape (n, n)
        Symmetric, positive semi-definite.
    count : int
        Number of modes; less than n and the rank of M.
    solve : callable
        Returns the static displacements (n, m) of loads (n, m), without rigid motions if the body is free.

    Returns
    -------
    squares : ndarray, shape (count,)
    shapes : ndarray, shape (n, count)

    Raises
    ------
    ModelError
        If the modes do not converge, or M has fewer.

    Notes
    -----
    ``A = K^-1 M`` is symmetric in the inner product of M. Its Krylov space is small, and is fully reorthogonalised. The
    shapes get one more product with A, available from the last step; it removes stiff motions and, where M is singular,
    motions without mass.

    Examples
    --------
    >>> K, M = sp.diags(np.arange(1.0, 101.0)), sp.identity(100, format="csr")
    >>> lowest_modes(M, 3, lambda f: f / np.arange(1.0, 101.0)[:, None])[0].round(9).tolist()
    [1.0, 2.0, 3.0]
    """
    size = M.shape[0]
    width = min(BLOCK, count, size)
    most = min(size, max(LARGEST_PART * count, count + 20 * width))
    Q, MQ = (np.empty((size, most + width), order="F") for _ in range(2))
    H = np.zeros((most + width, most + width))  # Q^T M A Q
    # a fixed seed for the same modes in every run; a product with A removes motions without mass
    left = solve(M @ np.random.default_rng(0).standard_normal((size, width)))
    weighted = M @ left
    done = 0
    while done <= most:
        block, weighted = _orthonormal(left, weighted, Q[:, :done], MQ[:, :done], M)
        start, done = done, done + block.shape[1]
        if done > most:
            break
        Q[:, start:done], MQ[:, start:done] = block, weighted
        left = solve(weighted)
        H[:done, start:done] = MQ[:, :done].T @ left
        H[start:done, :start] = H[:start, start:done].T
        left = left - Q[:, :done] @ H[:done, start:done]
        weighted = M @ left
        inverses, vectors = scipy.linalg.eigh(0.5 * (H[:done, :done] + H[:done, :done].T))
        inverses, vectors = inverses[::-1][:count], vectors[:, ::-1][:, :count]
        if done < count or inverses[-1] <= 0.0:
            continue
        last = vectors[start:]
        errors = np.sqrt(np.maximum(np.einsum("ij,ik,kj->j", last, left.T @ weighted, last), 0.0)) / inverses
        if errors.max() < TOLERANCE:
            shapes = Q[:, :done] @ vectors + left @ (last / inverses)
            return 1.0 / inverses, shapes / np.sqrt(np.einsum("ij,ij->j", shapes, M @ shapes))
    raise ModelError(
        f"{count} normal modes were not found in {done} directions of the body. Remedy: ask for fewer modes, and check "
        "that every part of the body has mass and is held"
    )


def _orthonormal(
    left: np.ndarray, weighted: np.ndarray, Q: np.ndarray, MQ: np.ndarray, M: sp.spmatrix
) -> tuple[np.ndarray, np.ndarray]:
    """Return an M-orthonormal basis of the part of columns outside of Q, and M times it; `weighted` is M times them."""
    for _ in range(3):
        overlap = MQ.T @ left
        left, weighted = left - Q @ overlap, weighted - MQ @ overlap
        gram = left.T @ weighted
        scale = 1.0 / np.sqrt(np.maximum(np.diag(gram), np.finfo(float).tiny))
        squares, vectors = scipy.linalg.eigh(gram * np.outer(scale, scale))
        kept = squares > _DEPENDENT * squares[-1]
        turn = scale[:, None] * vectors[:, kept] / np.sqrt(squares[kept])
        left, weighted = left @ turn, weighted @ turn
        if squares[0] > _NEAR:
            break
        weighted = M @ left
    return left, weighted
