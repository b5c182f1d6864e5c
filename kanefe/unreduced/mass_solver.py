"""Solution with a sparse mass matrix by conjugate gradients, for several right-hand sides at once.

A mass matrix scaled by its diagonal is well conditioned whatever the mesh (Wathen 1987), so that ten to fifty products
are enough. They are needed only at the start of a run, where factors of M would cost as much as those of a step.
"""

from __future__ import annotations

import numpy as np

from kanefe.errors import SimulationError
from kanefe.storage.scipy_later import sp

TOLERANCE = 1e-13
LARGEST_ITERATIONS = 2000


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
            "every degree of freedom mass (rotary_inertia of beams), or reduction=CraigBampton(modes=20)"
        )


def _ratio(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.divide(a, b, out=np.zeros_like(a), where=b > 0)
