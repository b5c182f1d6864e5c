"""The linear equations of constrained motion, with rows that may depend on each other.

    M x = F + P^T y,     J x + c = 0

The multipliers of least norm are taken, which leaves the motion as it is.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from kanefe.errors import SimulationError
from kanefe.frames import Matrix, Vector
from kanefe.storage.scipy_later import scipy
from kanefe.tree.model_data import ModelData
from kanefe.tree.row_groups import groups_of_rows
from kanefe.tree.row_rates import PIVOT_TOLERANCE, RANK_TOLERANCE, ROUND_OFF, Rates

LEAST_KEPT = 1e-3
"""Eigenvalue, relative to the smallest that counts (1), below which it is left out; above it its inverse fades."""


class ConstrainedSolver:
    """The linear equations ``M x = F + P^T y, J x + c = 0`` for one M, J and P, and the rank of J; most often P is J.

    Dependent rows: y has the least norm with each row scaled by its reach, and where their parts of c contradict each
    other x meets them best. M may be singular where J holds what has no inertia.

    Parameters
    ----------
    M : ndarray, shape (n, n)
        Symmetric.
    rates : Rates
        J (m, n) and its reach.
    forces : ndarray, shape (m, n), optional
        P, where it is not J.

    Raises
    ------
    numpy.linalg.LinAlgError
        If M is singular along a motion that J leaves free.
    """

    def __init__(self, M: Matrix, rates: Rates, forces: Matrix | None = None) -> None:
        J, reach = rates.J, rates.reach
        self._J, self._weights = J, np.zeros(len(J))
        factor = _cholesky(M)
        if factor is None:
            # adding J^T w (J x + c) = 0 changes nothing but the matrix
            self._weights = _augmentation(M, J)
            M = M + J.T @ (self._weights[:, None] * J)
            factor = _cholesky(M)
            if factor is None:
                raise np.linalg.LinAlgError("nothing has inertia along a motion that the constraints leave free")
        self._factor = factor
        self._B = _solve_lower(factor, J.T)
        A = self._B.T @ self._B
        self._scale = _row_scales(np.diag(A), J, reach, np.diag(M))
        self._scaled = A * np.outer(self._scale, self._scale)
        if not np.all(np.isfinite(self._scaled)):
            raise np.linalg.LinAlgError("the rows are not numbers")
        self._pushed = None if forces is None else _solve_lower(factor, forces.T)

    def gained(self, which: Sequence[int], held: int) -> tuple[Vector, Vector]:
        """Return the rates of some rows of J for a unit of their own force, that in P and that in J, (k,) each.

        The first so many rows hold on, and answer to the force.
        """
        moved = pushed = self._B[:, which]
        if self._pushed is not None:
            pushed = self._pushed[:, which]
        if held:
            holds = self._B[:, :held] * self._scale[:held]
            moved = moved - holds @ np.linalg.lstsq(holds, moved, rcond=RANK_TOLERANCE**0.5)[0]
        return np.einsum("ij,ij->j", moved, pushed), np.einsum("ij,ij->j", moved, moved)

    @property
    def scaled_rows(self) -> Matrix:
        """Scaled rows of ``J L^-T``, M = L L^T, shape (m, n), of length up to one: dependent where those of J are."""
        return np.asarray(self._scale[:, None] * self._B.T)

    @property
    def row_count(self) -> int:
        """Number of rows."""
        return len(self._J)

    @property
    def weakest(self) -> float:
        """Least eigenvalue that is not round-off against the largest: it falls to zero towards a singular position."""
        return self._spectrum.weakest

    @property
    def rank(self) -> int:
        """Number of rows that do not depend on others."""
        return self._spectrum.rank

    @cached_property
    def _spectrum(self) -> _Spectrum:
        return _spectrum(self._scaled, RANK_TOLERANCE)

    def solve(self, F: Vector, c: Vector, least: float = RANK_TOLERANCE) -> tuple[Vector, Vector]:
        """Return x (n,) and y (m,).

        `least`: eigenvalue, relative to the largest, below which rows depend on each other, if it is more than that of
        round-off.
        """
        y0 = _solve_lower(self._factor, F - self._J.T @ (self._weights * c))
        open_rows = self._scale * (self._B.T @ y0 + c)
        if self._pushed is not None:
            A = self._scale[:, None] * (self._B.T @ self._pushed) * self._scale
            if not (np.all(np.isfinite(A)) and np.all(np.isfinite(open_rows))):  # of a state too far ahead
                return np.full(len(F), np.nan), np.full(len(open_rows), np.nan)
            y = -self._scale * np.linalg.lstsq(A, open_rows, rcond=RANK_TOLERANCE)[0]
            return _solve_lower(self._factor, y0 + self._pushed @ y, transposed=True), y
        spectrum = _spectrum(self._scaled, least) if least > RANK_TOLERANCE else self._spectrum
        vectors, inverses = spectrum.vectors, spectrum.inverses
        y = -self._scale * (vectors @ (inverses * (vectors.T @ open_rows)))
        return _solve_lower(self._factor, y0 + self._B @ y, transposed=True), y


class _Spectrum(NamedTuple):
    """Eigenvectors of the scaled ``J M^-1 J^T`` that are not round-off, inverses of their eigenvalues, and the rank."""

    vectors: Matrix
    inverses: Vector
    weakest: float
    rank: int


def _spectrum(A: Matrix, tolerance: float) -> _Spectrum:
    groups = groups_of_rows(A)
    found = [np.linalg.eigh(A[np.ix_(rows, rows)]) for rows in groups]
    values = np.concatenate([np.zeros(0), *(own for own, _ in found)])
    largest = float(values.max(initial=0.0))
    least = tolerance * max(largest, ROUND_OFF)
    vectors, place = np.zeros(A.shape), 0
    for rows, (own, among) in zip(groups, found, strict=True):
        vectors[rows, place : place + len(own)] = among
        place += len(own)
    # down to the root of the smallest number a row of round-off has no inverse at all
    kept = values > LEAST_KEPT * least
    weakest = float(values[kept].min()) / largest if kept.any() else 1.0
    # a cut would be a jump of the accelerations, on which error control gets stuck: this falls to zero smoothly
    inverses = 1.0 / (values[kept] * (1.0 + (least / values[kept]) ** 4))
    return _Spectrum(vectors[:, kept], inverses, weakest, int(np.count_nonzero(values > least)))


def _solve_lower(factor: Matrix, right: np.ndarray, transposed: bool = False) -> np.ndarray:
    """Return ``L^-1 right`` or ``L^-T right``; of a scene without free speeds too, which scipy refuses."""
    if not len(right):
        return right
    # scipy's own function takes three times the time, for checks; L in the order of C is L^T in that of Fortran
    return np.asarray(scipy.linalg.lapack.dtrtrs(factor.T, right, lower=0, trans=0 if transposed else 1)[0])


def _cholesky(M: Matrix) -> Matrix | None:
    """Return L of M = L L^T, or None if M is singular to round-off."""
    if not len(M):
        return np.zeros((0, 0))
    factor, failed_at = scipy.linalg.lapack.dpotrf(M, lower=1)
    if failed_at or np.any(np.diag(factor) ** 2 <= PIVOT_TOLERANCE * np.diag(M)):
        return None
    return np.asarray(np.tril(factor))


def _row_scales(squares: Vector, J: Matrix, reach: Matrix, masses: Vector) -> Vector:
    """Return a factor for each row: of unit length if it points along the motion of its ends, 0 if it is round-off.

    Its own length would be no measure: a row that falls to zero is a singular position. `squares` are the lengths in
    the metric of M^-1, whose ratio to the reach is taken with the diagonal of M.
    """
    own, full = ((J**2) / masses).sum(axis=1), (reach / masses).sum(axis=1)
    product = squares * full
    moves = own > LEAST_KEPT * RANK_TOLERANCE * ROUND_OFF * full
    return np.sqrt(np.divide(own, product, out=np.zeros_like(own), where=moves & (product > 0)))


def _augmentation(M: Matrix, J: Matrix) -> Vector:
    """Return weights of the rows with which ``J^T w J`` is of the size of M."""
    mass = float(np.abs(np.diag(M)).max(initial=0.0)) or 1.0
    squares = np.einsum("ij,ij->i", J, J)
    return np.divide(mass, squares, out=np.zeros_like(squares), where=squares > 0)


def constrained_solver(model: ModelData, M: Matrix, rates: Rates, forces: Matrix | None = None) -> ConstrainedSolver:
    """Return the solver for M and rows over the free speeds; an error names speeds that nothing has inertia along."""
    try:
        return ConstrainedSolver(M, rates, forces)
    except np.linalg.LinAlgError:
        raise singular_mass(model, M) from None


def solve_positive_definite(model: ModelData, M: Matrix, F: Vector) -> Vector:
    """Return ``M^-1 F``; a singular mass matrix is an error that names the speeds without inertia."""
    if not len(F):
        return F
    factor, solution, failed_at = scipy.linalg.lapack.dposv(M, F)  # scipy's own solve takes twice the time, for checks
    if failed_at or np.any(np.diag(factor) ** 2 <= PIVOT_TOLERANCE * np.diag(M)):
        raise singular_mass(model, M)
    return np.asarray(solution)


def singular_mass(model: ModelData, M: Matrix) -> SimulationError:
    """Return the error that a mass matrix without an inverse deserves: it names the speeds without inertia."""
    if not np.all(np.isfinite(M)):
        return SimulationError("the motion has grown without bound. Remedy: check the loads, or tighten rtol")
    _, vectors = np.linalg.eigh(M)
    names = model.speed_names()
    guilty = ", ".join(names[i] for i in np.argsort(-abs(vectors[:, 0]))[:3] if abs(vectors[i, 0]) > 0.1)
    return SimulationError(
        f"the mass matrix is singular: nothing has inertia along {guilty}. "
        "Remedy: give a body there a mass or inertia, or fix the joint"
    )
