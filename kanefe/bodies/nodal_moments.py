"""Inertia of a body with only M at the nodes: the paper's nodal form, an approximation where nodes rotate.

The nodal velocities and accelerations of Eq. 24-26 are built from the rigid motion of G and the slopes; the inertia
forces are ``M`` times the nodal accelerations (Eq. 38). For nodes that only translate this is exact for every M. For
nodes that rotate, the angular acceleration of a node is not the second derivative of its slope in space: for a beam
element of length l spun about two axes it gives 0.35 m l^2 w_x w_y instead of m l^2/3 w_x w_y. The error decreases with
the size of the elements. Beams of `kanefe_fem` do not use this form.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from kanefe.bodies.mass_moments import add_quadratic_terms, leading_quadratic
from kanefe.fe_model.model import COMPONENTS
from kanefe.frames import skew
from kanefe.storage.scipy_later import sp


@dataclass(frozen=True, eq=False)
class NodalMoments:
    """Gram matrix of the motions that compose nodal accelerations.

    The motions of all nodes are the columns of F: 3 unit translations e_a; 9 fields e_a X_b; 3 unit rotations e_a of
    every node; 9 K fields e_a psi_b,i (translations of coordinate i) and 9 K fields e_a theta_b,i (its rotations).
    Every velocity and acceleration of Eq. 24-26 is a combination of them.

    Attributes
    ----------
    gram : ndarray, shape (15 + 18 K, 15 + 18 K)
        ``F^T M F``.
    quadratic_first, quadratic_second : ndarray or None
        Moments of the second-order displacement, as in `MassMoments`.
    """

    gram: np.ndarray
    quadratic_first: np.ndarray | None = None
    quadratic_second: np.ndarray | None = None

    @classmethod
    def of_nodes(
        cls, nodes: np.ndarray, components: tuple[str, ...], mass: sp.csr_matrix, basis: np.ndarray
    ) -> NodalMoments:
        """Return the moments from nodes (n, 3), their components, M (N, N) and the basis (N, K)."""
        n, count = len(nodes), basis.shape[1]
        kept = [COMPONENTS.index(c) for c in components]
        motion = np.zeros((n, 6, count))
        motion[:, kept] = basis.reshape(n, len(components), count)
        fields = np.zeros((n, 6, 15 + 18 * count))
        for a in range(3):
            fields[:, a, a] = 1.0
            fields[:, 3 + a, 12 + a] = 1.0
            for b in range(3):
                fields[:, a, 3 + 3 * a + b] = nodes[:, b]
                start = 15 + (3 * a + b) * count
                fields[:, a, start : start + count] = motion[:, b]
                start += 9 * count
                fields[:, 3 + a, start : start + count] = motion[:, 3 + b]
        flat = fields[:, kept].reshape(n * len(components), -1)
        return cls(gram=flat.T @ (mass @ flat))

    @property
    def count(self) -> int:
        """Number of coordinates K."""
        return (self.gram.shape[0] - 15) // 18

    @property
    def elastic_mass(self) -> np.ndarray:
        """Constant elastic block of the mass matrix, shape (K, K)."""
        E = self._elastic_columns()
        return E.T @ self.gram @ E

    @property
    def mass(self) -> np.ndarray:
        """Mass in kg, shape ()."""
        return np.asarray(np.trace(self.gram[:3, :3]) / 3.0)

    def leading(self, count: int) -> NodalMoments:
        """Return the moments of the first `count` coordinates alone."""
        K = self.count
        kept = np.concatenate((np.arange(15), *(15 + block * K + np.arange(count) for block in range(18))))
        quadratic = leading_quadratic(self.quadratic_first, self.quadratic_second, count)
        return NodalMoments(self.gram[np.ix_(kept, kept)], *quadratic)

    def terms(self, eta: np.ndarray, deta: np.ndarray, w: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the generalised mass and velocity-dependent inertia forces (Eq. 24-26, 38); as `MassMoments.terms`."""
        K = len(eta)
        V = np.zeros((15 + 18 * K, 6 + K))
        V[:3, :3] = np.eye(3)
        for axis in range(3):
            V[:, 3 + axis] = self._field(skew(np.eye(3)[axis]), eta)
            V[12 + axis, 3 + axis] = 1.0
        V[:, 6:] = self._elastic_columns()

        W = skew(w)
        Z = self._field(W @ W, eta)
        rate = self._field(2.0 * W, deta)
        rate[3:12] = 0.0  # the reference position has no rate
        Z += rate
        Z[15 + 9 * K :] = np.einsum("ab,i->abi", W, deta).ravel()  # Y_n = w x dtheta
        weighted = V.T @ self.gram
        mass, bias = weighted @ V, weighted @ Z
        if self.quadratic_first is not None and self.quadratic_second is not None:
            add_quadratic_terms(self.quadratic_first, self.quadratic_second, eta, deta, w, mass, bias)
        return mass, bias

    def arrays(self) -> dict[str, np.ndarray]:
        """Return the moments by name, for a file."""
        return {f.name: getattr(self, f.name) for f in fields(self) if getattr(self, f.name) is not None}

    def _field(self, A: np.ndarray, eta: np.ndarray) -> np.ndarray:
        """Return the coefficients of the nodal motion ``A (X + psi eta)`` in the fields."""
        K = self.count
        coefficients = np.zeros(15 + 18 * K)
        coefficients[3:12] = A.ravel()
        coefficients[15 : 15 + 9 * K] = np.einsum("ab,i->abi", A, eta).ravel()
        return coefficients

    def _elastic_columns(self) -> np.ndarray:
        """Return the coefficients of the coordinates' own motions, shape (15 + 18 K, K)."""
        K = self.count
        E = np.zeros((15 + 18 * K, K))
        for a in range(3):
            start = 15 + 4 * a * K  # e_a psi_a
            E[start : start + K] = np.eye(K)
            E[start + 9 * K : start + 10 * K] = np.eye(K)
        return E
