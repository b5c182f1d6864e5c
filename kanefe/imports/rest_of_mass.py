"""What points that are known do not explain of a mass matrix, distributed equally over the three directions.

Of a body with M, but without shape functions, the points of `kanefe.imports.rigid_parts` are an estimate of the motions
of its points. Their momenta ``P_0 = R^T M_0`` are made those of M, ``P = R^T M``, by a rigid motion
``I^-1 (P - P_0)`` of the whole beside them, with ``I = R^T M R``. Then mass, centre of mass, inertia and the momenta of
every motion are exact, and

    rest = (M - M_0) - P^T I^-1 P + P_0^T I^-1 P_0,

which has no momenta, is a third of the inertia in each direction, so that the energy is exact too. The products of
single components remain estimates. How large what is estimated may be is measured on the motions of second order in X.
"""

from __future__ import annotations

from itertools import combinations_with_replacement

import numpy as np
import scipy.sparse as sp

from kanefe.fe_model.model import COMPONENTS, MassField, rigid_motion
from kanefe.frames import axial, skew

SAME = 1e-10
"""Eigenvalue of the scaled R^T M R, relative to the largest, below which it counts as zero: masses on a line have
no inertia about it."""


def inverse_inertia(rigid: np.ndarray) -> np.ndarray:
    """Return I^-1 (6, 6); zero about the axis of a body without inertia about it."""
    scale = 1.0 / np.sqrt(np.maximum(np.diag(rigid), np.finfo(float).tiny))
    squares, vectors = np.linalg.eigh(rigid * np.outer(scale, scale))
    kept = squares > SAME * squares[-1]
    return np.asarray(scale[:, None] * ((vectors[:, kept] / squares[kept]) @ vectors[:, kept].T) * scale)


def affine_moments(rigid: np.ndarray) -> np.ndarray:
    """Return the inner products (4, 4) of 1 and X, from R^T M R (6, 6) of rigid motions R about the origin of X."""
    second = 0.5 * np.trace(rigid[3:, 3:]) * np.eye(3) - rigid[3:, 3:]
    first = -0.5 * axial(rigid[3:, :3])
    return np.block([[rigid[:1, :1], first[None]], [first[:, None], 0.5 * (second + second.T)]])


def with_rest(field: MassField, M: sp.csr_matrix, R: np.ndarray) -> MassField:
    """Return a mass field with the mass matrix M, whose points move as those of a field as far as M allows it.

    Parameters
    ----------
    field : MassField
    M : csr_matrix, shape (N, N)
    R : ndarray, shape (N, 6)
        Rigid motions about the origin of G.
    """
    middle = field.points.mean(axis=0)
    shifted = np.eye(6)
    shifted[:3, 3:] = skew(middle)  # a turn about the middle
    R = R @ shifted
    known = rigid_motion(field.points, middle)
    weighted = np.asarray(field.mass @ known.reshape(len(field.points), -1)).reshape(known.shape)
    before, momenta = weighted.T @ field.interpolation, R.T @ M
    rigid = momenta @ R
    inverse = inverse_inertia(rigid)
    moved = inverse @ (momenta - before)
    rest = M - field.mass_matrix()
    rest.data[np.abs(rest.data) <= 1e-15 * abs(M).max()] = 0.0
    rest.eliminate_zeros()

    rows = np.flatnonzero(np.diff(rest.indptr))
    own = sp.csr_matrix((np.ones(len(rows)), (np.arange(len(rows)), rows)), shape=(len(rows), M.shape[0]))
    alone = sp.vstack((own, sp.csr_matrix(momenta), sp.csr_matrix(before)))
    third = sp.block_diag((rest[rows][:, rows], -inverse, inverse)) / 3.0
    r = np.column_stack((np.ones(len(field.points)), field.points - middle))
    return _beside(field, middle, _moves(moved, alone), sp.block_diag((affine_moments(rigid), third, third, third)), r)


def _moves(moved: np.ndarray, alone: sp.csr_matrix) -> list[sp.csr_matrix]:
    """Return what functions move along each axis: 1 and X_a a rigid motion (6, N), others along one axis each."""
    affine = np.zeros((3, 4, moved.shape[1]))
    affine[:, 0] = moved[:3]
    for a in range(3):
        affine[:, 1 + a] = np.cross(moved[3:], np.eye(3)[a], axis=0)
    nothing = sp.csr_matrix(alone.shape)
    return [
        sp.vstack([sp.csr_matrix(affine[axis]), *(alone if a == axis else nothing for a in range(3))]).tocsr()
        for axis in range(3)
    ]


def _beside(
    field: MassField, middle: np.ndarray, moves: list[sp.csr_matrix], gram: sp.csr_matrix, r: np.ndarray
) -> MassField:
    """Return a field with further functions, the first of which are 1, X_0, X_1, X_2, of inner products `gram`."""
    count, extra = len(field.points), gram.shape[0]
    across = sp.hstack((sp.csr_matrix(field.mass @ r), sp.csr_matrix((count, extra - 4))))
    whole = sp.bmat([[field.mass, across], [across.T, gram]], format="csr")
    # a last point stands still; its function makes the sum of all that of 1
    one = np.zeros(count + extra)
    one[count] = 1.0
    change = sp.vstack((sp.identity(count + extra), sp.csr_matrix(one - np.ones(count + extra)))).tocsr()
    points = np.tile(middle, (count + extra + 1, 1))
    points[count + 1 : count + 4] += np.eye(3)
    beside = sp.vstack(moves).tocsr()[np.arange(3 * extra).reshape(3, extra).T.ravel()]
    still = sp.csr_matrix((3, beside.shape[1]))
    return MassField(
        points=points,
        mass=(change @ whole @ change.T).tocsr(),
        interpolation=sp.vstack((field.interpolation, beside, still)).tocsr(),
    )


def share_of_rest(M: sp.csr_matrix, explained: sp.csr_matrix, points: np.ndarray, components: tuple[str, ...]) -> float:
    """Return the largest part of the energy of an even strain, bending or twist that M has beside what is explained.

    The motions of each are without their rigid part. The matrices are those of the nodes, (n c, n c).
    """
    middle = points.mean(axis=0)
    x = points - middle
    reach = np.abs(x).max() or 1.0
    motions = _even_motions(x / reach)
    motions[:, 3:] /= reach
    kept = [COMPONENTS.index(name) for name in components]
    V = motions[:, kept].reshape(len(x) * len(kept), -1)
    R = rigid_motion(points, middle, components)
    V -= R @ (inverse_inertia(R.T @ (M @ R)) @ (R.T @ (M @ V)))
    energy, rest = (np.einsum("ik,ik->k", V, A @ V) for A in (M, M - explained))
    moved = energy > 1e-9 * energy.max(initial=0.0)
    return float(np.abs(rest[moved] / energy[moved]).max(initial=0.0))


def _even_motions(x: np.ndarray) -> np.ndarray:
    """Return the motions (n, 6, 15) of points with even strains, or curvatures and twists ``theta_a = x_b``."""
    found = []
    for a, b in combinations_with_replacement(range(3), 2):
        motion = np.zeros((len(x), 6))
        motion[:, a] += x[:, b]
        motion[:, b] += x[:, a]
        found.append(motion)
    for a in range(3):
        c, d = (a + 1) % 3, (a + 2) % 3
        twist = np.zeros((len(x), 6))
        twist[:, c], twist[:, d] = -x[:, a] * x[:, d], x[:, a] * x[:, c]
        twist[:, 3 + a] = x[:, a]
        found.append(twist)
        for along, across, sign in ((c, d, 1.0), (d, c, -1.0)):
            bent = np.zeros((len(x), 6))
            bent[:, across], bent[:, along] = sign * x[:, along] ** 2 / 2, -sign * x[:, along] * x[:, across]
            bent[:, 3 + a] = x[:, along]
            found.append(bent)
    return np.stack(found, axis=2)
