"""Averages over a patch: the weighted mean motion of its nodes, and sparse coordinates of the deviation from it.

The mean motion q of a patch with displacements u and weights W is the rigid motion R q closest to u,

    q = (R^T W R)^-1 R^T W u,    so that    u = R q + Z y    with    R^T W Z = 0

(RBE3; least squares). The coordinates y of the deviation must not be a choice of six dependent degrees of freedom,
which would couple every node of the patch to every other. Here Z is orthonormal and built on a tree that halves the
patch recursively: in each half, all motions whose moment R^T W vanishes become coordinates, and at most six moments are
passed on (the construction of Alpert's wavelets with vanishing moments: Alpert 1993, SIAM J. Math. Anal. 24, 246). A
patch of m nodes then takes O(m log m) numbers, and K of the interior stays sparse.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

LEAF = 12
"""Number of degrees of freedom below which a part of a patch is not divided again."""


def moment_free_columns(moments: np.ndarray, places: np.ndarray) -> sp.csr_matrix:
    """Return an orthonormal sparse basis Z of the motions without moments, shape (n, n - r).

    Parameters
    ----------
    moments : ndarray, shape (r, n)
        P = R^T W, of full rank: ``P Z = 0``.
    places : ndarray, shape (n, 3)
        Position of each degree of freedom, m: those close together share columns.
    """
    count = moments.shape[1]
    rows: list[np.ndarray] = []
    columns: list[np.ndarray] = []
    values: list[np.ndarray] = []
    used = 0

    def split(chosen: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the degrees of freedom of a part, its motions with moments, and these moments."""
        nonlocal used
        if len(chosen) <= LEAF:
            kept, basis = chosen, np.eye(len(chosen))
            passed = moments[:, chosen]
        else:
            axis = int(np.argmax(np.ptp(places[chosen], axis=0)))
            order = chosen[np.argsort(places[chosen, axis], kind="stable")]
            first, second = split(order[: len(order) // 2]), split(order[len(order) // 2 :])
            kept = np.concatenate((first[0], second[0]))
            basis = np.zeros((len(kept), first[1].shape[1] + second[1].shape[1]))
            basis[: len(first[0]), : first[1].shape[1]] = first[1]
            basis[len(first[0]) :, first[1].shape[1] :] = second[1]
            passed = np.hstack((first[2], second[2]))
        rank = min(moments.shape)
        if basis.shape[1] <= rank:
            return kept, basis, passed
        Q, triangle = np.linalg.qr(passed.T, mode="complete")
        free = basis @ Q[:, rank:]
        at, column = np.nonzero(free)
        rows.append(kept[at])
        columns.append(used + column)
        values.append(free[at, column])
        used += free.shape[1]
        return kept, basis @ Q[:, :rank], triangle[:rank].T

    split(np.arange(count))
    if not used:
        return sp.csr_matrix((count, 0))
    entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
    return sp.csr_matrix(entries, shape=(count, used))
