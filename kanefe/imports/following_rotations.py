"""Rotations that nothing holds: those of solid nodes in a model which has rotations elsewhere.

A model of solids and beams or shells carries six degrees of freedom at some nodes and three at others. The missing
rotations are defined as what they are in a continuum, the mean rotation of the neighbourhood,

    theta_n = J^-1 sum_j r_j x (u_j - u_n),    r_j = x_j - x_n,    J = sum_j (r_j.r_j I - r_j r_j^T),

over the nodes j that K couples to n, and held to it by a spring, ``k/2 |theta_n - A_n u|^2``. No other force acts on
theta_n, so in every equilibrium and every motion the spring is relaxed, and nothing else feels it: K gains rows for
the rotations, the displacements of the model stay what they are, and rigid motions stay free.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from kanefe.errors import ModelError
from kanefe.finite_element_model import COMPONENTS, ROTATIONS, TRANSLATIONS
from kanefe.frames import skew


def following_rotations(
    points: np.ndarray, components: tuple[str, ...], stiffness: sp.csr_matrix, labels: np.ndarray
) -> tuple[sp.csr_matrix, int]:
    """Return K in which every empty rotation follows the neighbours of its node, and how many do.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        m.
    components : tuple of str
    stiffness : csr_matrix, shape (n * components, same)
    labels : ndarray of int, shape (n,)
        Names of the nodes for messages.

    Raises
    ------
    ModelError
        If a translation is empty, or an empty rotation cannot be told from the neighbours (all on one line).
    """
    width = len(components)
    empty = np.asarray(abs(stiffness).sum(axis=1)).reshape(-1, width) == 0
    turning = np.array([c in ROTATIONS for c in components])
    if not np.any(empty & turning):
        return stiffness, 0
    if not set(TRANSLATIONS) <= set(components):
        raise ModelError("nodes without rotations can stand beside nodes with them in space only, not in plane models")
    translations = [components.index(c) for c in TRANSLATIONS]
    typical = float(np.median(stiffness.diagonal().reshape(-1, width)[:, translations]))
    rows: list[int] = []
    columns: list[int] = []
    values: list[float] = []
    weights: list[float] = []
    for node in np.flatnonzero((empty & turning).any(axis=1)):
        near = np.unique(
            stiffness.indices[stiffness.indptr[node * width] : stiffness.indptr[node * width + 3]] // width
        )
        near = near[near != node]
        r = points[near] - points[node]
        J = np.einsum("ja,ja->", r, r) * np.eye(3) - r.T @ r
        if not len(near) or np.linalg.cond(J) > 1e8:
            raise ModelError(
                f"node {labels[node]} has no stiffness against rotation, and its neighbours lie on one line, so that "
                "they show none. Remedy: export without this node, or give its element rotational stiffness"
            )
        inverse = np.linalg.inv(J)
        of_neighbours = np.array([inverse @ skew(x) for x in r])
        for place in np.flatnonzero(empty[node] & turning):
            axis = COMPONENTS.index(components[place]) - 3
            equation = len(weights)
            weights.append(typical * np.einsum("ja,ja->", r, r) / len(near))
            terms = [(int(node * width + place), 1.0)]
            terms += [(j * width + t, -A[axis, a]) for j, A in zip(near, of_neighbours, strict=True)
                      for a, t in enumerate(translations)]  # fmt: skip
            terms += [(node * width + t, of_neighbours[:, axis, a].sum()) for a, t in enumerate(translations)]
            rows += [equation] * len(terms)
            columns += [c for c, _ in terms]
            values += [v for _, v in terms]
    gap = sp.csr_matrix((values, (rows, columns)), (len(weights), stiffness.shape[0]))
    return (stiffness + gap.T @ sp.diags(weights) @ gap).tocsr(), len(weights)
