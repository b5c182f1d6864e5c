"""Lowest modes of (K, M) with a preconditioner in the place of factors.

Knyazev (2001), "Toward the optimal preconditioned eigensolver: locally optimal block preconditioned conjugate gradient
method": in each step the modes are the best of the span of the last ones, of their preconditioned residuals, and of the
last changes. The changes are kept M-orthonormal to the modes by their coefficients (Hetmaniuk & Lehoucq 2006, "Basis
selection in LOBPCG"), so that only K times each block is stored. On several processes all arrays have their own rows.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import scipy.linalg

from kanefe.errors import ModelError

TOLERANCE = 5e-7
"""Residual ``|K x - w^2 M x| / |K x|`` of a mode. The relative error of its frequency is of the order of the square."""

STEPS = 150
"""Number of steps from which the method gives up; 15 to 30 are usual."""

_ROWS = 50_000
"""Number of rows of which blocks are combined at once, so that no second copy of them is needed."""

_DEPENDENT = 1e-14
"""Squared norm of a direction of a block relative to its largest, below which it is round-off."""

_NEAR = 1e-8
"""Squared norm of a direction of a block relative to its largest, below which it is made orthonormal twice."""

Product = Callable[[np.ndarray], np.ndarray]
"""Function of columns (n, m)."""


class Block(NamedTuple):
    """Directions and K times them, shape (n, m) each, in the order of Fortran."""

    X: np.ndarray
    KX: np.ndarray


def lowest_modes(
    K: Product,
    M: Product,
    precondition: Product,
    start: np.ndarray,
    count: int,
    *,
    together: Product = lambda own: own,
    step_done: Callable[[np.ndarray, np.ndarray, float], None] = lambda shapes, residuals, seconds: None,
) -> tuple[np.ndarray, np.ndarray]:
    """Return w^2 and M-orthonormal shapes of the lowest modes, ascending; (count,) and (n, count).

    Parameters
    ----------
    K, M, precondition : callable
        Products with K, M and an approximation of ``K^-1``, symmetric and positive definite.
    start : ndarray, shape (n, m)
        Independent shapes, some more than modes are sought: with them the last ones converge as fast as the others.
    count : int
        Number of modes.
    together : callable
        Sum of an array over all processes.
    step_done : callable
        Is given all shapes, the residuals of the sought ones and the time after each step.

    Raises
    ------
    ModelError
        If they do not converge.

    Examples
    --------
    >>> d = np.arange(1.0, 101.0)[:, None]
    >>> start = np.random.default_rng(0).standard_normal((100, 5))
    >>> lowest_modes(lambda x: d * x, lambda x: x, lambda x: x / (d + 0.5), start, 2)[0].round(9).tolist()
    [1.0, 2.0]
    """
    began = time.perf_counter()
    X = np.asfortranarray(start)
    X = X @ _orthonormal(together(X.T @ M(X)))
    KX = K(X)
    squares, turn = scipy.linalg.eigh(_symmetric(together(X.T @ KX)))
    last, changes = Block(np.asfortranarray(X @ turn), np.asfortranarray(KX @ turn)), None
    for _ in range(STEPS):
        R = M(last.X) * -squares
        R += last.KX
        sizes = together(np.stack([np.einsum("ij,ij->j", part, part) for part in (R, last.KX)]))
        residuals = np.sqrt(sizes[0] / sizes[1])
        step_done(last.X, residuals[:count], time.perf_counter() - began)
        if residuals[:count].max() <= TOLERANCE:
            return squares[:count], last.X[:, :count]
        moving = np.flatnonzero(residuals > TOLERANCE)
        W = precondition(R[:, moving])
        del R
        known = [last] if changes is None else [last, changes]
        W = _apart(W, known, M, together)
        blocks = [*known, Block(W, K(W))]
        del W
        squares, shapes, changed = _best(blocks, last.X.shape[1], moving, together)
        last, changes = _combined(blocks, shapes, changed)
    raise ModelError(
        f"{count} normal modes were not found in {STEPS} steps: their residuals are up to "
        f'{residuals[:count].max():.1e}. Remedy: solver="direct", or ask for fewer modes; check the mesh for slivers'
    )


def _apart(W: np.ndarray, known: list[Block], M: Product, together: Product) -> np.ndarray:
    """Return the M-orthonormal part of columns that is M-orthogonal to blocks, by passes against round-off."""
    for number in range(3):
        MW = M(W)
        for block in known:
            W -= block.X @ together(block.X.T @ MW)
        if number == 0:
            continue  # what is left of the blocks is round-off of columns that were far larger
        gram = together(W.T @ MW)
        W = np.asfortranarray(W @ _orthonormal(gram))
        sizes = np.linalg.eigvalsh(_symmetric(gram / np.sqrt(np.outer(np.diag(gram), np.diag(gram)))))
        if sizes[0] > _NEAR * sizes[-1]:
            break
    return W


def _orthonormal(gram: np.ndarray) -> np.ndarray:
    """Return the columns that make directions with a Gram matrix orthonormal, without dependent ones."""
    scale = 1.0 / np.sqrt(np.maximum(np.diag(gram), np.finfo(float).tiny))
    squares, vectors = scipy.linalg.eigh(_symmetric(gram) * np.outer(scale, scale))
    kept = squares > _DEPENDENT * squares[-1]
    return np.asarray(scale[:, None] * vectors[:, kept] / np.sqrt(squares[kept]))


def _best(
    blocks: list[Block], width: int, moving: np.ndarray, together: Product
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return w^2, and coefficients of the best shapes in the span of blocks and of the changes of some of them."""
    H = together(np.vstack([np.hstack([one.X.T @ other.KX for other in blocks]) for one in blocks]))
    squares, vectors = scipy.linalg.eigh(_symmetric(H))
    shapes = vectors[:, :width]
    changed = shapes[:, moving].copy()
    changed[:width] = 0.0
    changed -= shapes @ (shapes.T @ changed)
    return squares[:width], shapes, changed @ _orthonormal(changed.T @ changed)


def _combined(blocks: list[Block], first: np.ndarray, second: np.ndarray) -> list[Block]:
    """Return two combinations of the columns of blocks by coefficients; the first is written over the first block."""
    size = len(blocks[0].X)
    made = [blocks[0], Block(*(np.empty((size, second.shape[1]), order="F") for _ in range(2)))]
    for part in range(2):
        for start in range(0, size, _ROWS):
            rows = slice(start, start + _ROWS)
            together = np.hstack([block[part][rows] for block in blocks])
            made[0][part][rows], made[1][part][rows] = together @ first, together @ second
    return made


def _symmetric(matrix: np.ndarray) -> np.ndarray:
    return 0.5 * (matrix + matrix.T)
