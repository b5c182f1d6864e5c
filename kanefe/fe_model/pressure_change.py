"""How the forces of a pressure change as the face that it acts on deforms: points move, normals turn, areas grow.

A face with coordinates xi, eta, of which the points are at ``x = sum N_i x_i``, has ``n dA = x_xi x x_eta``. So to
first order in the displacements u_j of its points, with sign s,

    dF_i = s sum_j u_j x v_ij,    v_ij = int N_i (N_j,xi x_eta - N_j,eta x_xi) dxi deta

on the point i (Hibbitt, Some follower forces and load stiffness, Int. J. Numer. Meth. Engng 14 (1979) 937-941). A point
at an arm a from its node, as on a face of a shell, moves by ``u + theta x a + 1/2 theta x (theta x a)``, by rotation
vectors. The force F at the undeformed face does work on the last term, of second order, so that the force on the
rotation changes by ``(1/2 (a F^T + F a^T) - (a . F) 1) theta`` too.

The change is symmetric where the edge of the face is held or there is none. A free edge adds ``1/2 int p u x du . dl``,
which no potential has.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from kanefe.storage.scipy_later import sp


@dataclass(frozen=True, eq=False)
class PressureChange:
    """A face of P points on which a unit pressure acts, and what its forces change by as the points move.

    Attributes
    ----------
    points : ndarray, shape (P, 3)
        Undeformed places, m.
    forces : ndarray, shape (P, 3)
        N/Pa.
    across : csr_matrix, shape (3 P, 3 P)
        Change of the forces with the displacements of the points, point-major, N/Pa per m.
    motion : csr_matrix, shape (3 P, N)
        Displacements of the points from the components of a model.
    second : csr_matrix, shape (N, N), or None
        Work of the forces on the motion of second order of the points, 1/2 of it being ``u^T second u``. None: there is
        no such motion.
    """

    points: np.ndarray
    forces: np.ndarray
    across: sp.csr_matrix
    motion: sp.csr_matrix
    second: sp.csr_matrix | None = None

    @property
    def on_components(self) -> np.ndarray:
        """Forces of a unit pressure on the components of the model, shape (N,), N/Pa and N m/Pa."""
        return np.asarray(self.motion.T @ self.forces.ravel())

    def moved_by(self, motion: sp.csr_matrix) -> PressureChange:
        """Return the change over other coordinates, by which the components of this one move, (N, others)."""
        second = None if self.second is None else (motion.T @ self.second @ motion).tocsr()
        return replace(self, motion=(self.motion @ motion).tocsr(), second=second)

    def over(self, basis: np.ndarray) -> np.ndarray:
        """Return the change of resultant, moment about the origin and forces on coordinates with these, (6 + K, K).

        Parameters
        ----------
        basis : ndarray, shape (N, K)

        Examples
        --------
        A square of 1 m2 that grows along x by 1 % is pushed on more:

        >>> corners = np.array([[[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]], float)
        >>> from kanefe.fe_model.loaded_face import FacetBlock, LoadedFace
        >>> square = LoadedFace((FacetBlock("quad", np.arange(4)[None], corners, np.ones(1)),), 4, 3)
        >>> face = square.pressure_change(*square.sums()[1:])
        >>> stretch = np.array([[0, 0, 0], [0.01, 0, 0], [0.01, 0, 0], [0, 0, 0]]).reshape(12, 1)
        >>> face.over(stretch)[:3, 0].round(12).tolist()
        [0.0, 0.0, 0.01]
        """
        count, moved = basis.shape[1], self.motion @ basis
        changed = self.across @ moved
        by_point = changed.reshape(-1, 3, count)
        moment = np.cross(self.points[..., None], by_point, axis=1).sum(axis=0)
        moment += np.cross(moved.reshape(-1, 3, count), self.forces[..., None], axis=1).sum(axis=0)
        on_coordinates = moved.T @ changed
        if self.second is not None:
            on_coordinates += basis.T @ (self.second @ basis)
        return np.vstack((by_point.sum(axis=0), moment, on_coordinates))


def turning(n: np.ndarray, r: np.ndarray) -> np.ndarray:
    """Return X of ``n . theta x (theta x r) = theta . X theta`` for vectors (m, 3), shape (m, 3, 3)."""
    mixed = r[:, :, None] * n[:, None, :]
    return 0.5 * (mixed + mixed.swapaxes(1, 2)) - np.einsum("mi,mi->m", n, r)[:, None, None] * np.eye(3)
