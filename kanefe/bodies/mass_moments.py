"""Inertia of a flexible body from constants of its mesh, computed once.

With the position ``r = X + Psi eta`` of every mass point linear in the coordinates eta, all inertia terms of a body in
its floating frame G are polynomials in eta, deta and the angular velocity. Their coefficients are the mass moments
below, so that a step costs O(k^2) whatever the mesh. They are exact if the displacement field is (Zwoelfer & Gerstmayr
2020, "A concise nodal-based derivation of the floating frame of reference formulation").
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from kanefe.frames import axial, skew
from kanefe.storage.scipy_later import sp


@dataclass(frozen=True, eq=False)
class MassMoments:
    """Mass moments of a body with K coordinates, about the origin of G, in components of G.

    Attributes
    ----------
    mass : ndarray, shape ()
        int rho, kg.
    first : ndarray, shape (3,)
        int rho X, kg m.
    second : ndarray, shape (3, 3)
        int rho X_a X_b, kg m2.
    shape_first : ndarray, shape (3, K)
        S_a,i = int rho Psi_a,i.
    shape_second : ndarray, shape (3, 3, K)
        D_ab,i = int rho X_a Psi_b,i.
    shape_product : ndarray, shape (3, 3, K, K)
        M_ab,ij = int rho Psi_a,i Psi_b,j.
    quadratic_first : ndarray, shape (3, K, K), or None
        G_a = int rho H_a of the second-order displacement ``u_a = 1/2 eta^T H_a eta``; None: without stiffening.
    quadratic_second : ndarray, shape (3, 3, K, K), or None
        N_ab = int rho X_a H_b.
    """

    mass: np.ndarray
    first: np.ndarray
    second: np.ndarray
    shape_first: np.ndarray
    shape_second: np.ndarray
    shape_product: np.ndarray
    quadratic_first: np.ndarray | None = None
    quadratic_second: np.ndarray | None = None

    @classmethod
    def of_points(cls, points: np.ndarray, point_mass: sp.csr_matrix, point_basis: np.ndarray) -> MassMoments:
        """Return the moments of a mass field.

        Parameters
        ----------
        points : ndarray, shape (P, 3)
            X in m.
        point_mass : csr_matrix, shape (P, P)
            Scalar mass matrix in kg.
        point_basis : ndarray, shape (3 P, K)
            Psi at the points, point-major.
        """
        count = point_basis.shape[1]
        basis = [np.ascontiguousarray(point_basis[a::3]) for a in range(3)]
        weighted = [point_mass @ psi for psi in basis]
        weighted_points = point_mass @ points
        product = np.empty((3, 3, count, count))
        for a in range(3):
            for b in range(a, 3):
                product[a, b] = basis[a].T @ weighted[b]
                product[b, a] = product[a, b].T
        return cls(
            mass=np.asarray(point_mass.sum()),
            first=weighted_points.sum(axis=0),
            second=points.T @ weighted_points,
            shape_first=np.array([w.sum(axis=0) for w in weighted]),
            shape_second=np.array([[points[:, a] @ weighted[b] for b in range(3)] for a in range(3)]),
            shape_product=product,
        )

    @property
    def elastic_mass(self) -> np.ndarray:
        """Constant elastic block of the mass matrix: sum_a M_aa, shape (K, K)."""
        return np.einsum("aaij->ij", self.shape_product)

    def first_moments(self, eta: np.ndarray) -> np.ndarray:
        """Return int rho r at some coordinates eta (T, K), in G, kg m, shape (T, 3)."""
        found = self.first + eta @ self.shape_first.T
        if self.quadratic_first is not None:
            found = found + 0.5 * np.einsum("ti,aij,tj->ta", eta, self.quadratic_first, eta)
        return np.asarray(found)

    def leading(self, count: int) -> MassMoments:
        """Return the moments of the first `count` coordinates alone."""
        if count == self.shape_first.shape[1]:
            return self
        return MassMoments(
            self.mass,
            self.first,
            self.second,
            np.ascontiguousarray(self.shape_first[:, :count]),
            np.ascontiguousarray(self.shape_second[:, :, :count]),
            np.ascontiguousarray(self.shape_product[:, :, :count, :count]),
            *leading_quadratic(self.quadratic_first, self.quadratic_second, count),
        )

    def terms(self, eta: np.ndarray, deta: np.ndarray, w: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the generalised mass and the velocity-dependent inertia forces of the body in G (Eq. 29, 38).

        The inertia forces on (translation of G, rotation of G, eta) are ``-(mass @ (a_G, alpha_G, ddeta) + bias)``.

        Parameters
        ----------
        eta, deta : ndarray, shape (K,)
            Coordinates and their rates.
        w : ndarray, shape (3,)
            Angular velocity of G in N, components of G, rad/s.

        Returns
        -------
        mass : ndarray, shape (6 + K, 6 + K)
        bias : ndarray, shape (6 + K,)
        """
        count = len(eta)
        flat = self.shape_product.reshape(9 * count, count) @ np.column_stack((eta, deta))
        M_eta = flat[:, 0].reshape(3, 3, count)  # (M_ab eta)_i
        M_deta = flat[:, 1].reshape(3, 3, count)
        P = self.shape_second + M_eta.transpose(1, 0, 2)  # int rho r_a Psi_b,i: (M_ab^T eta) = (M_ba eta)
        c = self.first + self.shape_first @ eta
        P_eta = P @ eta
        B = self.second + (self.shape_second @ eta).T + P_eta  # int rho r_a r_b
        B = 0.5 * (B + B.T)  # symmetric by definition, also in round-off

        mass = np.empty((6 + count, 6 + count))
        c_skew = skew(c)
        mass[:3, :3] = float(self.mass) * np.eye(3)
        mass[:3, 3:6] = -c_skew
        mass[3:6, :3] = c_skew
        mass[3:6, 3:6] = np.trace(B) * np.eye(3) - B
        mass[:3, 6:] = self.shape_first
        mass[6:, :3] = self.shape_first.T
        mass[3, 6:] = P[1, 2] - P[2, 1]
        mass[4, 6:] = P[2, 0] - P[0, 2]
        mass[5, 6:] = P[0, 1] - P[1, 0]
        mass[6:, 3:6] = mass[3:6, 6:].T
        mass[6:, 6:] = self.elastic_mass

        W = skew(w)
        W2 = W @ W
        bias = np.empty(6 + count)
        bias[:3] = W2 @ c + 2.0 * (W @ (self.shape_first @ deta))
        bias[3:6] = axial(B @ W2.T + 2.0 * ((P @ deta) @ W.T))
        bias[6:] = np.tensordot(W2.T, P, axes=2) + 2.0 * np.tensordot(W, M_deta, axes=2)
        if self.quadratic_first is not None and self.quadratic_second is not None:
            add_quadratic_terms(self.quadratic_first, self.quadratic_second, eta, deta, w, mass, bias)
        return mass, bias

    def arrays(self) -> dict[str, np.ndarray]:
        """Return the moments by name, for a file."""
        return {f.name: getattr(self, f.name) for f in fields(self) if getattr(self, f.name) is not None}


def leading_quadratic(
    first: np.ndarray | None, second: np.ndarray | None, count: int
) -> tuple[np.ndarray | None, np.ndarray | None]:
    """Return the second-order moments of the first `count` coordinates alone."""
    if first is None or second is None:
        return None, None
    return np.ascontiguousarray(first[:, :count, :count]), np.ascontiguousarray(second[:, :, :count, :count])


def add_quadratic_terms(
    G: np.ndarray,
    N: np.ndarray,
    eta: np.ndarray,
    deta: np.ndarray,
    w: np.ndarray,
    mass: np.ndarray,
    bias: np.ndarray,
) -> None:
    """Add the inertia of the second-order displacement: motion-induced stiffening, to the order of K eta.

    The points of a bent beam approach its root. This displacement, ``u_a = 1/2 eta^T H_a eta``, is small, but its
    *work* is not: under an acceleration or in a spin it gives forces linear in eta, as K does. All its terms of second
    order in (eta, deta) are added to the first and second moments of mass, their rates and their derivatives with
    respect to eta, so that the equations remain those of a Lagrangian, and energy and momenta are conserved exactly.

    Parameters
    ----------
    G, N : ndarray, shape (3, k, k) and (3, 3, k, k)
        `MassMoments.quadratic_first` and `quadratic_second`.
    eta, deta, w, mass, bias
        As in `MassMoments.terms`; the last two are added to.
    """
    G_eta, N_eta = G @ eta, N @ eta
    c = 0.5 * (G_eta @ eta)
    B = 0.5 * (N_eta @ eta)
    B = B + B.T
    c_skew = skew(c)
    mass[:3, 3:6] -= c_skew
    mass[3:6, :3] += c_skew
    mass[3:6, 3:6] += np.trace(B) * np.eye(3) - B
    mass[:3, 6:] += G_eta
    mass[6:, :3] += G_eta.T
    turning = np.array((N_eta[1, 2] - N_eta[2, 1], N_eta[2, 0] - N_eta[0, 2], N_eta[0, 1] - N_eta[1, 0]))
    mass[3:6, 6:] += turning
    mass[6:, 3:6] += turning.T
    W = skew(w)
    W2 = W @ W
    bias[:3] += W2 @ c + 2.0 * (W @ (G_eta @ deta)) + (G @ deta) @ deta
    bias[3:6] += axial(B @ W2.T + 2.0 * ((N_eta @ deta) @ W.T) + (N @ deta) @ deta)
    bias[6:] += np.tensordot(W2.T, N_eta, axes=2)
