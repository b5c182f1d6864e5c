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

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from kanefe.fe_model.block_diagonal import block_diagonal
from kanefe.fe_model.shapes import quadrature, shape
from kanefe.frames import skews
from kanefe.storage.scipy_later import sp

DEGREE = 8
"""Degree of quadrature: exact for curved facets of second order."""


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
        >>> face = pressure_change([PushedFace("quad", np.arange(4)[None], corners, np.ones(1))], 4, 3)
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


@dataclass(frozen=True, eq=False)
class PushedFace:
    """Facets of one shape, and how their points move with the nodes of a model.

    Attributes
    ----------
    kind : str
        Shape of the facets, by meshio's name; a line for plane bodies.
    nodes : ndarray of int, shape (m, n)
    places : ndarray, shape (m, n, 3)
        Undeformed points of the face, m.
    signs : ndarray, shape (m,)
        1 where a pressure pushes along ``x_xi x x_eta`` (of a line: ``x_xi x e_z``), -1 where against it; of a plane
        body times its thickness (m).
    arms : ndarray, shape (m, n, 3), or None
        Points less nodes, m, where the nodes rotate. None: the points are the nodes.
    """

    kind: str
    nodes: np.ndarray
    places: np.ndarray
    signs: np.ndarray
    arms: np.ndarray | None = None


def pressure_change(faces: Sequence[PushedFace], count: int, width: int) -> PressureChange:
    """Return how the forces of a unit pressure on a face change with the displacements of a model.

    Parameters
    ----------
    faces : sequence of PushedFace
    count, width : int
        How many nodes there are, and components of each: x, y; x, y, z; or three rotations too. N is their product.
    """
    forces, across = zip(*(_by_points(face) for face in faces), strict=True)
    pushed = np.concatenate([one.reshape(-1, 3) for one in forces])
    points = np.concatenate([face.places.reshape(-1, 3) for face in faces])
    node = np.concatenate([face.nodes.ravel() for face in faces])
    to_node = sp.csr_matrix((np.ones(len(node)), node, np.arange(len(node) + 1)), (len(node), count))
    motion, second = sp.kron(to_node, sp.eye(3, width), format="csr"), None
    if width > 3:
        arms = np.concatenate([np.zeros_like(f.places) if f.arms is None else f.arms for f in faces]).reshape(-1, 3)
        turns = sp.kron(to_node, sp.eye(3, width, k=3), format="csr")
        motion = motion - block_diagonal(skews(arms)) @ turns
        second = (turns.T @ block_diagonal(turning(pushed, arms)) @ turns).tocsr()
    return PressureChange(points, pushed, sp.block_diag(across, format="csr"), motion.tocsr(), second)


def turning(n: np.ndarray, r: np.ndarray) -> np.ndarray:
    """Return X of ``n . theta x (theta x r) = theta . X theta`` for vectors (m, 3), shape (m, 3, 3)."""
    mixed = r[:, :, None] * n[:, None, :]
    return 0.5 * (mixed + mixed.swapaxes(1, 2)) - np.einsum("mi,mi->m", n, r)[:, None, None] * np.eye(3)


def _by_points(face: PushedFace) -> tuple[np.ndarray, sp.csr_matrix]:
    """Return forces on the points (m, n, 3) of facets and their change with their displacements, (3 m n, 3 m n)."""
    points, weights = quadrature(face.kind, DEGREE)
    element = shape(face.kind)
    values, slopes = element.values(points), element.gradients(points)
    tangents = np.einsum("pna,mni->mpai", slopes, face.places)
    if tangents.shape[2] == 1:
        tangents = np.concatenate((tangents, np.broadcast_to(np.eye(3)[2], tangents.shape)), axis=2)
        slopes = np.concatenate((slopes, np.zeros_like(slopes)), axis=2)
    first, second = tangents[:, :, 0], tangents[:, :, 1]
    forces = np.einsum("m,mpa,pi->mia", face.signs, np.cross(first, second), weights[:, None] * values)
    weighted = np.einsum("p,pi,pja->apij", weights, values, slopes)
    m, n = face.nodes.shape
    by_slopes, by_others = (
        np.tensordot(tangent, one, axes=(1, 0)) for tangent, one in ((second, weighted[0]), (first, weighted[1]))
    )
    v = (face.signs[:, None, None, None] * (by_slopes - by_others)).transpose(0, 2, 3, 1)
    at = np.repeat(n * np.arange(m)[:, None] + np.arange(n), n, axis=0)
    found = sp.bsr_matrix((-skews(v).reshape(-1, 3, 3), at.ravel(), n * np.arange(m * n + 1))).tocsr()
    found.eliminate_zeros()
    return forces, found
