"""Inertia of an unreduced body from the accelerations of its mass points (Eq. 24-26, 38), without moments of any basis.

Where the displacement is linear in the coordinates, ``r = X + N eta``, velocity and acceleration of every mass point
are known exactly, and the inertia forces are a sparse mass matrix times accelerations (Zwoelfer & Gerstmayr 2020): one
product with three columns, whatever the motion. The nodal form uses M of the nodes instead, with their rotations.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from kanefe.fe_model.model import COMPONENTS, TRANSLATIONS, rigid_motion
from kanefe.frames import Matrix, Vector, skew
from kanefe.storage.pickled import PickledByFields
from kanefe.storage.scipy_later import sp


@dataclass(frozen=True, eq=False)
class InertiaField(PickledByFields):
    """Mass points of a body with K coordinates, or its nodes in the nodal form.

    Attributes
    ----------
    points : ndarray, shape (P, 3)
        Reference coordinates X in m, about the origin of G.
    mass : csr_matrix
        Scalar mass matrix (P, P) in kg; in the nodal form M (c P, c P).
    basis : csr_matrix, shape (c P, K)
        N: motion of the points, point-major.
    components : tuple of str
        The c components of each point's motion: "x", "y", "z" of a mass field.
    is_exact : bool
        Whether `mass` is that of a mass field.
    """

    points: np.ndarray
    mass: sp.csr_matrix
    basis: sp.csr_matrix
    components: tuple[str, ...]
    is_exact: bool

    @cached_property
    def _motion(self) -> Selection:
        return Selection(self.basis)

    @cached_property
    def _moves(self) -> tuple[tuple[int, int], ...]:
        """Place among the components, and axis, of each translation."""
        return tuple((at, COMPONENTS.index(c)) for at, c in enumerate(self.components) if c in TRANSLATIONS)

    @cached_property
    def _turns(self) -> tuple[tuple[int, int], ...]:
        """Place among the components, and axis, of each rotation."""
        return tuple((at, COMPONENTS.index(c) - 3) for at, c in enumerate(self.components) if c not in TRANSLATIONS)

    @property
    def elastic_mass(self) -> sp.csr_matrix:
        """Constant elastic block of the mass matrix ``N^T M N``, shape (K, K)."""
        full = sp.kron(self.mass, sp.identity(3), format="csr") if self.is_exact else self.mass
        return (self.basis.T @ full @ self.basis).tocsr()

    def leading(self, count: int) -> InertiaField:
        """Return the field of the first `count` coordinates alone."""
        return InertiaField(self.points, self.mass, self.basis[:, :count].tocsr(), self.components, self.is_exact)

    def arrays(self) -> dict[str, np.ndarray]:
        """Return the numbers by name."""
        return {"points": self.points, "mass": self.mass.data, "basis": self.basis.data}

    def forces(
        self, eta: Vector, deta: Vector, ddeta: Vector, a: Vector, alpha: Vector, w: Vector
    ) -> tuple[Vector, Vector, Vector]:
        """Return mass times acceleration on (translation of G, rotation of G, coordinates).

        Parameters
        ----------
        eta, deta, ddeta : ndarray, shape (K,)
            Coordinates, their rates and accelerations.
        a, alpha : ndarray, shape (3,)
            Acceleration of the origin of G, less gravity, and angular acceleration of G, in components of G.
        w : ndarray, shape (3,)
            Angular velocity of G in its components, rad/s.

        Returns
        -------
        force, moment : ndarray, shape (3,)
            N, and N m about the origin of G.
        elastic : ndarray, shape (K,)
        """
        moved, rates, changes = self._of_points(eta), self._of_points(deta), self._of_points(ddeta)
        W = skew(w)
        r = self.points + self._translations(moved)
        field = r @ (skew(alpha) + W @ W).T
        field += self._translations(rates) @ (2.0 * W.T)
        field += self._translations(changes)
        field += a
        return self._weighted(field, r, self._rotations(rates, changes, alpha, W))

    def momenta(self, eta: Vector, deta: Vector, v: Vector, w: Vector) -> tuple[Vector, Vector, Vector]:
        """Return mass times velocity on (translation of G, rotation of G, coordinates), as `forces`."""
        rates = self._of_points(deta)
        r = self.points + self._translations(self._of_points(eta))
        field = r @ skew(w).T + self._translations(rates) + v
        turns = np.column_stack([w[c] + rates[:, at] for at, c in self._turns]) if self._turns else None
        return self._weighted(field, r, turns)

    def rigid_inertia(self, eta: Vector) -> tuple[Matrix, Matrix]:
        """Return the inertia of (translation, rotation of G), (6, 6), and between it and the coordinates, (6, K)."""
        r = self.points + self._translations(self._of_points(eta))
        columns = rigid_motion(r, (0.0, 0.0, 0.0), self.components)
        weighted = self._mass_times(columns)
        return columns.T @ weighted, np.ascontiguousarray((self.basis.T @ weighted).T)

    def total(self) -> tuple[float, Vector, Matrix]:
        """Return mass (kg), first moment (kg m) and inertia about the origin of G (kg m2), undeformed."""
        M = self.rigid_inertia(np.zeros(self.basis.shape[1]))[0]
        mass = float(np.trace(M[:3, :3]) / max(len(self._moves), 1))
        return mass, np.array((M[5, 1], M[3, 2], M[4, 0])), M[3:, 3:]

    def first_moment(self, eta: Vector) -> Vector:
        """Return int rho r in G, shape (3,), kg m."""
        M = self.rigid_inertia(eta)[0]
        return np.array((M[5, 1], M[3, 2], M[4, 0]))

    def _mass_times(self, columns: np.ndarray) -> np.ndarray:
        if not self.is_exact:
            return np.asarray(self.mass @ columns)
        return np.asarray((self.mass @ columns.reshape(len(self.points), -1)).reshape(columns.shape))

    def _of_points(self, x: Vector) -> np.ndarray:
        """Return the motion of the points from coordinates or their rates, shape (P, c)."""
        return self._motion.times(x).reshape(len(self.points), len(self.components))

    def _translations(self, motion: np.ndarray) -> np.ndarray:
        if self.components == TRANSLATIONS:
            return motion
        full = np.zeros((len(motion), 3))
        for at, c in self._moves:
            full[:, c] = motion[:, at]
        return full

    def _rotations(self, rates: np.ndarray, changes: np.ndarray, alpha: Vector, W: Matrix) -> np.ndarray | None:
        """Return ``alpha + w x dtheta + ddtheta`` of nodes that rotate (Eq. 26), in the order of their components."""
        if not self._turns:
            return None
        turning = np.zeros((len(rates), 3))
        for at, c in self._turns:
            turning[:, c] = rates[:, at]
        bent = turning @ W.T
        return np.column_stack([alpha[c] + bent[:, c] + changes[:, at] for at, c in self._turns])

    def _weighted(self, field: np.ndarray, r: np.ndarray, turns: np.ndarray | None) -> tuple[Vector, Vector, Vector]:
        if self.is_exact:
            f = self.mass @ field
            elastic = self._motion.transposed_times(f.reshape(-1))
        else:
            flat = np.empty((len(self.points), len(self.components)))
            for at, c in self._moves:
                flat[:, at] = field[:, c]
            if turns is not None:
                flat[:, [at for at, _ in self._turns]] = turns
            weighted = self.mass @ flat.reshape(-1)
            elastic = self._motion.transposed_times(weighted)
            weighted = weighted.reshape(flat.shape)
            f = self._translations(weighted)
        gram = f.T @ r
        moment = np.array((gram[2, 1] - gram[1, 2], gram[0, 2] - gram[2, 0], gram[1, 0] - gram[0, 1]))
        if turns is not None:
            for at, c in self._turns:
                moment[c] += weighted[:, at].sum()
        return f.sum(axis=0), moment, elastic


NOTHING = np.zeros(1)


class Selection:
    """A sparse matrix A for products: a gather for rows of the identity, a sparse matrix for the other rows.

    For Lagrange elements the points are the nodes, and only those of interfaces depend on more than their own
    coordinates. A gather is several times faster than a sparse product.

    Parameters
    ----------
    matrix : csr_matrix, shape (m, n)

    Examples
    --------
    >>> A = Selection(sp.csr_matrix([[0.0, 1.0], [0.0, 0.0], [1.0, 0.0]]))
    >>> A.times(np.array([3.0, 5.0])), A.transposed_times(np.array([1.0, 2.0, 4.0]))
    (array([5., 0., 3.]), array([4., 1.]))
    """

    def __init__(self, matrix: sp.csr_matrix) -> None:
        matrix = sp.csr_matrix(matrix, copy=True)
        matrix.eliminate_zeros()
        rows, columns = matrix.shape
        entries = np.diff(matrix.indptr)
        single = np.flatnonzero(entries == 1)
        single = single[matrix.data[matrix.indptr[single]] == 1.0]
        # of several rows with the same column only the first: the transposed product is a sum
        places, first = np.unique(matrix.indices[matrix.indptr[single]], return_index=True)
        single = single[first]
        self._from = np.full(rows, columns)
        self._from[single] = places
        self._to = np.full(columns, rows)
        self._to[places] = single
        self._others = np.setdiff1d(np.flatnonzero(entries), single)
        self._rest = matrix[self._others]
        self._rest_transposed = self._rest.T.tocsr()
        self._has_rest = self._others.size > 0

    def times(self, x: np.ndarray) -> np.ndarray:
        """Return ``A x``, shape (m,)."""
        found = np.concatenate((x, NOTHING))[self._from]
        if self._has_rest:
            found[self._others] = self._rest @ x
        return found

    def transposed_times(self, y: np.ndarray) -> np.ndarray:
        """Return ``A^T y``, shape (n,)."""
        found = np.concatenate((y, NOTHING))[self._to]
        if self._has_rest:
            found += self._rest_transposed @ y[self._others]
        return found
