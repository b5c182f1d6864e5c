"""The linear equations of a scene with unreduced bodies: large sparse blocks, factored separately, and a small border.

For every unreduced body S = M + c C + k K is factored, or M alone for accelerations. Its coupling to the rest of the
scene is narrow: the six motions of G, the p coordinates d of the frames it carries, and for a floating body its mean
motions, which G follows. Let z be the speeds of the condensed scene (its small twin, see `condensed.py`), A its matrix,
Gamma z the motion of G, M_re the inertia between G and the coordinates, N the rows of d and of the mean motions, and
E z their values (d, zero). Then

    S x + M_re^T Gamma z + N^T psi = f
    A z + Gamma^T (M_rr Gamma z + M_re x) - E^T psi = f_z
    N x = E z

With ``X = S^-1 (M_re^T, N^T)``, computed once, x and psi are eliminated, and a matrix of the size of the twin remains.
A solution costs one solve with S of each body, whatever it carries.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from kanefe.frames import Matrix, Vector
from kanefe.states.constrained_solver import constrained_solver, singular_mass
from kanefe.storage.scipy_later import scipy

if TYPE_CHECKING:
    from kanefe.fe_model.factorise import Factorisation
    from kanefe.states.constrained_solver import ConstrainedSolver
    from kanefe.states.kinematics import FrameMotion
    from kanefe.tree.row_rates import Rates
    from kanefe.unreduced.condensed import Condensed, Substructure

NO_MULTIPLIERS = np.zeros(0)


class BodyBorder(NamedTuple):
    """The border of one body.

    Attributes
    ----------
    factors : Factorisation
        Factors of S.
    rows : ndarray, shape (6 + r, k)
        M_re and N.
    columns : ndarray, shape (k, 6 + r)
        X.
    rigid : ndarray, shape (6, 6)
        ``M_rr - M_re S^-1 M_re^T``.
    mixed : ndarray, shape (6, r)
        ``M_re S^-1 N^T``.
    inverse : ndarray, shape (r, r)
        ``(N S^-1 N^T)^-1``.
    """

    factors: Factorisation
    rows: Matrix
    columns: Matrix
    rigid: Matrix
    mixed: Matrix
    inverse: Matrix


def border(substructure: Substructure, eta: Vector, factors: Factorisation) -> BodyBorder:
    """Return the border of a body at coordinates eta, (k,): one solve for each of its columns."""
    rigid, between = substructure.body.inertia_field.rigid_inertia(eta)
    rows = np.vstack((between, substructure.carried.toarray(), substructure.body.mean_motions))
    columns = factors.solve(np.ascontiguousarray(rows.T))
    gram = rows @ columns
    return BodyBorder(factors, rows, columns, rigid - gram[:6, :6], gram[:6, 6:], _inverse(gram[6:, 6:]))


def _inverse(H: Matrix) -> Matrix:
    """Return the inverse of a symmetric positive definite matrix whose rows may have different units."""
    if not len(H):
        return H
    scale = 1.0 / np.sqrt(np.diag(H))
    inverse = np.linalg.inv(0.5 * (H + H.T) * np.outer(scale, scale))
    return np.asarray(inverse * np.outer(scale, scale))


class Solution(NamedTuple):
    """Twin speeds z (free of the twin), coordinates of the substructures, and multipliers of the constraints."""

    z: Vector
    parts: list[Vector]
    multipliers: Vector


class Bordered:
    """The eliminated equations of a scene.

    Parameters
    ----------
    condensed : Condensed
    borders : sequence of BodyBorder
        One for each substructure.
    matrix : ndarray, shape (free of the twin, free of the twin)
        A.
    motions : sequence of FrameMotion
        Motions of the frames of the twin, for Gamma.
    rows : Rates, optional
        Constraints over all speeds of the twin.
    """

    def __init__(
        self,
        condensed: Condensed,
        borders: Sequence[BodyBorder],
        matrix: Matrix,
        motions: Sequence[FrameMotion],
        rows: Rates | None = None,
    ) -> None:
        n = condensed.small.free_count
        A = np.array(matrix)
        self.borders, self._couplings = borders, list[Matrix]()
        for substructure, own in zip(condensed.substructures, borders, strict=True):
            G = motions[substructure.number]
            gamma = np.vstack((G.V[:, :n], G.W[:, :n]))
            Y_t = own.mixed.T @ gamma
            Y_t[range(substructure.carried_count), range(substructure.rates.start, substructure.rates.stop)] += 1.0
            pull = own.inverse @ Y_t
            A += gamma.T @ own.rigid @ gamma + Y_t.T @ pull
            self._couplings.append(np.vstack((gamma, -pull)))
        self._solve_twin = _twin_solver(condensed, A, rows)

    def solve(self, right: Vector, parts: Sequence[Vector] | None, known: Vector | None = None) -> Solution:
        """Return the solution.

        Parameters
        ----------
        right : ndarray, shape (free of the twin,)
            f_z.
        parts : sequence of ndarray, each (k,), or None
            f of every substructure; None: zero, which needs no solve with S.
        known : ndarray, shape (rows,), optional
            c of the constraints ``J z + c = 0``.
        """
        if parts is None:
            z, multipliers = self._solve_twin(right, known)
            pairs = zip(self.borders, self._couplings, strict=True)
            return Solution(z, [-(own.columns @ (C @ z)) for own, C in pairs], multipliers)
        free, pulled = [], []
        for f, own, C in zip(parts, self.borders, self._couplings, strict=True):
            w = own.factors.solve(f)
            y = own.rows @ w
            right = right - y @ C
            free.append(w)
            pulled.append(y[6:])
        z, multipliers = self._solve_twin(right, known)
        for w, y, own, C in zip(free, pulled, self.borders, self._couplings, strict=True):
            share = C @ z
            if len(y):
                share[6:] += own.inverse @ y
            w -= own.columns @ share
        return Solution(z, free, multipliers)


TwinSolver = Callable[[Vector, Vector | None], tuple[Vector, Vector]]


def _twin_solver(condensed: Condensed, A: Matrix, rows: Rates | None) -> TwinSolver:
    if rows is not None:
        return partial(_constrained, constrained_solver(condensed.small, A, rows.over(slice(len(A)))))
    if not len(A):
        return lambda right, known: (right, NO_MULTIPLIERS)
    factors, pivots, failed_at = scipy.linalg.lapack.dgetrf(A)
    if failed_at:
        raise singular_mass(condensed.small, A)
    return partial(_solved, factors, pivots)


def _solved(factors: Matrix, pivots: Vector, right: Vector, known: Vector | None) -> tuple[Vector, Vector]:
    # scipy.linalg.lu_solve takes twice as long because of its checks
    return scipy.linalg.lapack.dgetrs(factors, pivots, right)[0], NO_MULTIPLIERS


def _constrained(solver: ConstrainedSolver, right: Vector, known: Vector | None) -> tuple[Vector, Vector]:
    return solver.solve(right, np.zeros(solver.row_count) if known is None else known)
