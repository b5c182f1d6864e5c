"""Motions without stiffness and without mass, which no rule of dynamics determines, held so that they stay at zero.

Elements of reduced integration have such motions in stiffness and mass, if the mass is integrated by the same points
(bars of one C3D20R across in CalculiX). A vector z of them is held by a spring on how far one displacement is from the
rigid motion of its neighbours, ``w u`` with ``w R = 0`` for the rigid motions R of the nodes and ``w z != 0``: the
other motions have that energy too, but z, which has no mass, follows them at once so that it vanishes. Frequencies,
mass and the statics of all forces that do no work on z are those of the matrices.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from kanefe.fe_model.factorise import splu_factorise
from kanefe.fe_model.model import rigid_motion
from kanefe.imports.node_table import NodeTable

NOTHING = 1e-11
"""Eigenvalue of K / max K + M / max M, relative to 1, below which a motion has neither: files have 14 digits."""

FIRST_COUNT = 12
"""Number of the lowest eigenvalues that are looked at first."""

DENSE_SIZE = 400
"""Number of rows below which all eigenvalues are found at once."""


def held_null_vectors(
    K: sp.csr_matrix, M: sp.csr_matrix, freedoms: np.ndarray, nodes: NodeTable
) -> tuple[sp.csr_matrix, int]:
    """Return K with what has neither stiffness nor mass held, and the number of such motions.

    Parameters
    ----------
    K, M : csr_matrix, shape (N, N)
    freedoms : ndarray of int, shape (N, 2)
        Node and number (1 to 6) of each row; without rotations only something is looked for.
    nodes : NodeTable
        Places of the nodes.
    """
    if (freedoms[:, 1] > 3).any():
        return K, 0
    Z = _null_vectors((K / abs(K).max() + M / abs(M).max()).tocsc())
    if not Z.shape[1]:
        return K, 0
    places = nodes.points[nodes.places(freedoms[:, 0], "the matrices")]
    R = rigid_motion(places - places.mean(axis=0), np.zeros(3)).reshape(-1, 3, 6)
    R = R[np.arange(len(R)), freedoms[:, 1] - 1]
    W = _functionals(K, R, Z)
    stiffness = float(np.median(K.diagonal()))
    return (K + stiffness * W @ W.T).tocsr(), Z.shape[1]


def _null_vectors(S: sp.csc_matrix) -> np.ndarray:
    """Return orthonormal vectors (N, k) of the eigenvalue zero of a matrix without negative ones."""
    size = S.shape[0]
    count = FIRST_COUNT
    while size > DENSE_SIZE and 2 * count < size:
        shift = 1e-6 * S.diagonal().mean()
        factors = splu_factorise((S + shift * sp.identity(size)).tocsc())
        inverse = spla.LinearOperator(S.shape, matvec=factors.solve, dtype=float)
        start = np.random.default_rng(0).standard_normal(size)
        values, vectors = spla.eigsh(S, k=count, sigma=-shift, OPinv=inverse, v0=start)
        if values.max() > NOTHING:
            return np.linalg.qr(vectors[:, values < NOTHING])[0]
        count *= 4
    values, vectors = np.linalg.eigh(S.toarray())
    return vectors[:, values < NOTHING]


def _functionals(K: sp.csr_matrix, R: np.ndarray, Z: np.ndarray) -> sp.csc_matrix:
    """Return columns (N, k) that are zero on R and independent on Z, each on one row and those that K couples to it."""
    left = Z.copy()
    columns = []
    for _ in range(Z.shape[1]):
        row = int(np.abs(left).sum(axis=1).argmax())
        near = np.setdiff1d(K.indices[K.indptr[row] : K.indptr[row + 1]], [row])
        weights = np.linalg.lstsq(R[near].T, R[row], rcond=1e-10)[0]
        w = np.zeros(len(Z))
        w[row], w[near] = 1.0, -weights
        w /= np.linalg.norm(w)
        columns.append(sp.csc_matrix(w[:, None]))
        # what is left of Z is what the functionals so far do not see
        seen = w @ left
        if np.linalg.norm(seen) > 0.0:
            left = left - np.outer(left @ seen, seen) / (seen @ seen)
    return sp.hstack(columns, format="csc")
