"""Lowest modes of (K, M) by the block Lanczos method with the inverse of K.

Golub & Underwood (1977); Grimes, Lewis & Simon (1994), "A shifted block Lanczos algorithm for solving sparse symmetric
generalized eigenproblems". The cost of a solve with the factors of a large K is that of reading them from memory: with
eight right-hand sides at once, each costs a fifth. scipy's eigsh (ARPACK) solves for one at a time, and takes twice as
long for the modes of a body of 100,000 degrees of freedom.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
import scipy.linalg
import scipy.sparse as sp

from kanefe.errors import ModelError
from kanefe.fe_model.progress import tell
from kanefe.storage.unfinished import keep, kept

BLOCK = 8
"""Number of right-hand sides of a solve: with more, each becomes cheaper, but more of them are needed."""

TOLERANCE = 1e-7
"""Residual of a mode relative to its K-norm. The error of frequencies is its square."""

UNBALANCED = 1e-8
"""Forces that the last product with A leaves unbalanced relative to ``w^2 M x``, a hundredth of what is told."""

ROUND_OFF = 1e-6
"""Part of a block along earlier directions, relative to it, that is taken out of M times it in single precision."""

LARGEST_PART = 6
"""Ratio of the number of directions to that of requested modes from which the method gives up: those of a compact body
(a cube) need up to 6.5 for 32, and 4.8 for 64."""

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
    space = _Space(M, count)
    space.begin(solve)
    progress: list[tuple[float, float]] = []
    while space.grow(solve):
        inverses, vectors = space.largest(count)
        keep(space.name, **space.arrays())
        if space.done < count or inverses[-1] <= 0.0:
            continue
        errors = space.errors(vectors) / inverses
        if errors.max() < TOLERANCE and space.unbalanced(inverses, vectors) < UNBALANCED:
            shapes = _times(space.Q[:, : space.done], vectors)
            shapes += _times(space.left, vectors[space.start :] / inverses)
            return 1.0 / inverses, shapes / np.sqrt(np.einsum("ij,ij->j", shapes, M @ shapes))
        progress.append((time.perf_counter(), float(np.log(errors.max() / TOLERANCE))))
        tell(f"{np.count_nonzero(errors < TOLERANCE)} of {count} found{_time_left(progress)}", is_noted=False)
    raise ModelError(
        f"{count} normal modes were not found in {space.done} directions of the body. Remedy: ask for fewer modes, and "
        "check that every part of the body has mass and is held"
    )


class _Space:
    """A Krylov space of A: directions Q, M-orthonormal, and ``H = Q^T M A Q``.

    `left` is what A makes of the last directions, from number `start` on, outside of the space, and `weighted` M times
    it. But for round-off, A leads from a block only to itself and its neighbours: these are taken out first, with M
    times them (`near`), then the round-off along all.
    """

    def __init__(self, M: sp.spmatrix, count: int) -> None:
        size = M.shape[0]
        self.M, self.width = M, min(BLOCK, count, size)
        self.most = min(size, max(LARGEST_PART * count, count + 40 * self.width))
        self.Q, self.MQ = (np.empty((size, self.most + self.width), kind, order="F") for kind in (float, np.float32))
        self.H = np.zeros((self.most + self.width,) * 2)
        self.start = self.done = 0
        self.near = np.zeros((size, 0), order="F")
        self.name = f"{count} normal modes of {size}"

    def begin(self, solve: Callable[[np.ndarray], np.ndarray]) -> None:
        """Take up the space of a run that was ended, or start from a block of random numbers."""
        found = kept(self.name)
        if found is None:
            # a fixed seed for the same modes in every run; a product with A removes motions without mass
            seed = np.random.default_rng(0).standard_normal((self.M.shape[0], self.width))
            self.left = solve(self.M @ seed)
        else:
            self.done = found["Q"].shape[1]
            self.Q[:, : self.done], self.H[: self.done, : self.done] = found["Q"], found["H"]
            self.near = self.M @ found["Q"]
            self.MQ[:, : self.done] = self.near
            self.left = found["left"]
            tell(f"{self.done} directions of a run that was ended are taken up")
        self.weighted = self.M @ self.left

    def arrays(self) -> dict[str, np.ndarray]:
        """Return what `begin` takes up."""
        return {"Q": self.Q[:, : self.done], "H": self.H[: self.done, : self.done], "left": self.left}

    def grow(self, solve: Callable[[np.ndarray], np.ndarray]) -> bool:
        """Add a block of directions; return whether there was room."""
        block, weighted = self._orthonormal()
        start, done = self.done, self.done + block.shape[1]
        if done > self.most:
            return False
        self.Q[:, start:done], self.MQ[:, start:done] = block, weighted
        self.near = np.hstack((self.near, weighted))
        self.left = solve(weighted)
        beside, new = self.near.T @ self.left, slice(start, done)
        self.left = self.left - _times(self.Q[:, done - len(beside) : done], beside)
        self.weighted = self.M @ self.left
        self.start, self.done, self.near = start, done, weighted
        self.H[:done, new] = self._apart()
        self.H[done - len(beside) : done, new] += beside
        self.H[new, :start] = self.H[:start, new].T
        return True

    def _apart(self) -> np.ndarray:
        """Take what is along the directions out of `left` and `weighted`; return how much that was."""
        Q, MQ = self.Q[:, : self.done], self.MQ[:, : self.done]
        along = Q.T @ self.weighted
        self.left = self.left - _times(Q, along)
        squares = np.abs(np.einsum("ij,ij->j", self.left, self.weighted))
        if np.square(along).max(initial=0.0) < ROUND_OFF**2 * squares.min():
            self.weighted = self.weighted - _times(MQ, along.astype(np.float32))
        else:
            self.weighted = self.M @ self.left
        return np.asarray(along)

    def _orthonormal(self) -> tuple[np.ndarray, np.ndarray]:
        """Return an M-orthonormal basis of `left`, as far as it is independent, and M times it."""
        for _ in range(3):
            gram = self.left.T @ self.weighted
            scale = 1.0 / np.sqrt(np.maximum(np.diag(gram), np.finfo(float).tiny))
            squares, vectors = scipy.linalg.eigh(gram * np.outer(scale, scale))
            kept = squares > _DEPENDENT * squares[-1]
            turn = scale[:, None] * vectors[:, kept] / np.sqrt(squares[kept])
            self.left, self.weighted = _times(self.left, turn), _times(self.weighted, turn)
            if squares[0] > _NEAR:
                break
            self.weighted = self.M @ self.left
            self._apart()
        return self.left, self.weighted

    def largest(self, count: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the largest eigenvalues of H, ``1 / w^2``, and their vectors, as many as there are up to a number."""
        H = self.H[: self.done, : self.done]
        inverses, vectors = scipy.linalg.eigh(0.5 * (H + H.T))
        return inverses[::-1][:count], vectors[:, ::-1][:, :count]

    def errors(self, vectors: np.ndarray) -> np.ndarray:
        """Return the M-norms of the residuals of A in the shapes of vectors."""
        last = vectors[self.start :]
        return np.sqrt(np.maximum(np.einsum("ij,ik,kj->j", last, self.left.T @ self.weighted, last), 0.0))

    def unbalanced(self, inverses: np.ndarray, vectors: np.ndarray) -> float:
        """Return the largest unbalanced part of ``w^2 M x`` after one more product with A: M times its residual."""
        moved = _times(self.MQ[:, : self.done], vectors.astype(np.float32))
        left = _times(self.weighted, vectors[self.start :] / inverses)
        squares = (np.einsum("ij,ij->j", forces, forces, dtype=float) for forces in (left, moved))
        return float(np.sqrt(np.divide(*squares).max()))


def _time_left(progress: list[tuple[float, float]]) -> str:
    """Return the time left as text, as far as residuals fall as they fell, from times and logarithms of residuals."""
    (first, high), (last, low) = progress[max(0, len(progress) - 4)], progress[-1]
    if low >= high:
        return ""
    return f", about {low * (last - first) / (high - low):.2g} s left"


def _times(columns: np.ndarray, small: np.ndarray) -> np.ndarray:
    """Return a product of long columns, stored one after the other: several times faster this way round."""
    return np.asarray((small.T @ columns.T).T)
