"""Solution with a sparse mass matrix by conjugate gradients, for several right-hand sides at once.

A mass matrix scaled by its diagonal is well conditioned whatever the mesh (Wathen 1987), so that ten to fifty products
are enough. They are needed only at the start of a run, where factors of M would cost as much as those of a step.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kanefe.errors import SimulationError
from kanefe.storage.scipy_later import sp

if TYPE_CHECKING:
    from kanefe.bodies.unreduced import UnreducedBody
    from kanefe.fe_model.factorise import Factorisation

TOLERANCE = 1e-13
LARGEST_ITERATIONS = 2000


class StaticallyMoved:
    """Solution with a mass matrix, of which some coordinates have no mass and are moved statically by the others.

    With ``x_c = -K_cc^-1 K_cr x_r`` of the former, ``M_rr x_r = b_r - K_rc K_cc^-1 b_c``; a
    `kanefe.fe_model.factorise.Factorisation`.

    Parameters
    ----------
    body : UnreducedBody
    """

    def __init__(self, body: UnreducedBody) -> None:
        self._none = body.massless
        self._has = np.setdiff1d(np.arange(body.free_count), body.massless)
        K = body.free_stiffness
        self._between = K[self._none][:, self._has].tocsr()
        self._static = body.factorise(K[self._none][:, self._none].tocsc())
        self._mass = MassSolver(body.free_mass[self._has][:, self._has].tocsr())

    def solve(self, b: np.ndarray) -> np.ndarray:
        """Return the accelerations of forces b of shape (n,) or (n, m)."""
        b = np.asarray(b, dtype=float)
        x = np.empty(b.shape)
        moved = self._static.solve(np.ascontiguousarray(b[self._none]))
        x[self._has] = self._mass.solve(b[self._has] - self._between.T @ moved)
        x[self._none] = -self._static.solve(self._between @ x[self._has])
        return x


def mass_solver(body: UnreducedBody) -> Factorisation:
    """Return the solver with the mass matrix of a body."""
    return StaticallyMoved(body) if len(body.massless) else MassSolver(body.free_mass)


class MassSolver:
    """Conjugate gradients, preconditioned by the diagonal; a `kanefe.fe_model.factorise.Factorisation`.

    Parameters
    ----------
    matrix : csr_matrix, shape (n, n)
        Symmetric positive definite.
    """

    def __init__(self, matrix: sp.csr_matrix) -> None:
        self._matrix, self._inverse = matrix, 1.0 / matrix.diagonal()

    def solve(self, b: np.ndarray) -> np.ndarray:
        """Return ``M^-1 b`` for b of shape (n,) or (n, m).

        Raises
        ------
        SimulationError
            If the iteration does not converge: the matrix is not positive definite.
        """
        right = np.asarray(b, dtype=float).reshape(len(b), -1)
        D = self._inverse[:, None]
        x = D * right
        r = right - self._matrix @ x
        z = D * r
        p, rho = z.copy(), np.einsum("ij,ij->j", r, z)
        limits = TOLERANCE**2 * np.einsum("ij,ij->j", right, D * right)
        for _ in range(LARGEST_ITERATIONS):
            if not np.any(rho > limits):
                return x.reshape(np.shape(b))
            Mp = self._matrix @ p
            step = _ratio(rho, np.einsum("ij,ij->j", p, Mp))
            x += step * p
            r -= step * Mp
            z = D * r
            new = np.einsum("ij,ij->j", r, z)
            p = z + _ratio(new, rho) * p
            rho = new
        raise SimulationError(
            "the mass matrix of an unreduced body cannot be solved with: some motion of it has no mass. Remedy: give "
            "every degree of freedom mass (rotary_inertia of beams), or reduction=CraigBampton()"
        )


def _ratio(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.divide(a, b, out=np.zeros_like(a), where=b > 0)
