"""Rotations without stiffness of their own, made to follow the neighbourhood of their node.

A model of solids and beams or shells has six degrees of freedom at some nodes and three at others, and flat shells
without drilling stiffness leave the turn about their normal free, whatever its direction. Such rotations are defined as
in a continuum, by the mean rotation of the neighbourhood,

    theta_n = J^+ sum_j r_j x (u_j - u_n),    r_j = x_j - x_n,    J = sum_j (r_j.r_j I - r_j r_j^T),

over the nodes j that K couples to n, and are coupled to it by a spring, ``k/2 |v.(theta_n - A_n u)|^2`` along each
direction v without stiffness. The spring is relaxed in every equilibrium and every motion, as long as no other force
acts on the rotation. Therefore the model lists these directions as `following`, no interface holds them
(`kanefe.fe_model.patches`), and what mass they have goes to the nodes that they follow. Then K gains rows for the
rotations, the displacements of the model do not change, and rigid motions stay free.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from kanefe.errors import ModelError
from kanefe.fe_model.model import COMPONENTS, ROTATIONS, TRANSLATIONS

EMPTY = 1e-9
"""Part of a column of K, relative to the largest of the three rotations of its node, below which a turn has no
stiffness: files have nine digits or more."""

ALONG = 1e-8
"""Part of a unit axis outside of the turns that the places of the neighbours define, below which it is defined."""


class Following(NamedTuple):
    """Matrices with rotations that follow.

    Attributes
    ----------
    matrices : dict of str to csr_matrix, shape (N, N)
    directions : csr_matrix, shape (f, N)
        Unit directions of the rotations that follow, one a row, each of one node.
    carried : csr_matrix, shape (N, N)
        Motions of nodes with those rotations in place of their own: what has mass moves so.
    """

    matrices: dict[str, sp.csr_matrix]
    directions: sp.csr_matrix
    carried: sp.csr_matrix


def with_following_rotations(
    points: np.ndarray, components: tuple[str, ...], matrices: dict[str, sp.csr_matrix], labels: np.ndarray
) -> Following:
    """Return matrices in which every rotation without stiffness follows the neighbours of its node.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        m.
    components : tuple of str
    matrices : dict of str to csr_matrix, shape (N, N)
        "stiffness", "mass" and others, of all components of the nodes, followed by generalised coordinates if any.
    labels : ndarray of int, shape (n,)
        Names of the nodes for messages.

    Raises
    ------
    ModelError
        If a node has no stiffness at all, or the neighbours of a node do not define a rotation that has none.
    """
    K = sp.csr_matrix(matrices["stiffness"], copy=True)
    K.eliminate_zeros()
    width = len(components)
    turning = [i for i, c in enumerate(components) if c in ROTATIONS]
    free = _without_stiffness(K, len(points), width, turning)
    if not free:
        return Following(dict(matrices), sp.csr_matrix((0, K.shape[0])), sp.identity(K.shape[0], format="csr"))
    if not set(TRANSLATIONS) <= set(components):
        raise ModelError("nodes with and without rotations can be combined in space only, not in plane models")
    _check_held(K, len(points), width, labels)
    mean, directions, weights = _means(points, components, K, free, labels)
    gap = directions - mean
    carried = (sp.identity(K.shape[0], format="csr") - directions.T @ gap).tocsr()
    found = {name: (carried.T @ m @ carried).tocsr() for name, m in matrices.items() if name != "stiffness"}
    found["stiffness"] = (K + gap.T @ sp.diags(weights) @ gap).tocsr()
    return Following(found, directions, carried)


def _means(
    points: np.ndarray, components: tuple[str, ...], K: sp.csr_matrix, free: dict[int, np.ndarray], labels: np.ndarray
) -> tuple[sp.csr_matrix, sp.csr_matrix, list[float]]:
    """Return the mean rotations of the neighbours about directions without stiffness, these directions, and weights.

    Both have a row for each direction, over all coordinates; the weights are rotational stiffnesses.
    """
    width, turning = len(components), [i for i, c in enumerate(components) if c in ROTATIONS]
    axes = [COMPONENTS.index(components[place]) - 3 for place in turning]
    columns: list[np.ndarray] = []
    values: list[np.ndarray] = []
    own: list[np.ndarray] = []
    weights: list[float] = []
    typical = float(np.median(K.diagonal()[: len(points) * width].reshape(-1, width)[:, :3]))
    for node, directions in free.items():
        near = np.unique(K.indices[K.indptr[node * width] : K.indptr[node * width + 3]] // width)
        near = near[(near != node) & (near < len(points))]
        r = points[near] - points[node]
        for v in directions:
            axis = np.zeros(3)
            axis[axes] = v
            about = _defined(axis, r, labels[node])
            lever = np.cross(about, r)  # about . (r x u) = (about x r) . u
            columns.append(np.append((near[:, None] * width + np.arange(3)).ravel(), node * width + np.arange(3)))
            values.append(np.append(lever.ravel(), -lever.sum(axis=0)))
            own.append(np.column_stack((node * width + np.array(turning), v)))
            weights.append(typical * np.einsum("ja,ja->", r, r) / len(near))
    count, shape = np.arange(len(own)), (len(own), K.shape[0])
    at = np.repeat(count, [len(row) for row in columns])
    mean = sp.csr_matrix((np.concatenate(values), (at, np.concatenate(columns))), shape)
    whole = np.vstack(own)
    found = sp.csr_matrix((whole[:, 1], (np.repeat(count, len(turning)), whole[:, 0].astype(int))), shape)
    found.eliminate_zeros()
    return mean, found, weights


def _without_stiffness(K: sp.csr_matrix, count: int, width: int, turning: list[int]) -> dict[int, np.ndarray]:
    """Return unit directions (m, rotations) without stiffness of the nodes that have some."""
    if not turning:
        return {}
    rows = (np.arange(count)[:, None] * width + turning).ravel()
    turns = K[rows].tocsr()
    size = len(turning)
    blocks = np.zeros((count, size, size))
    entries = turns[:, rows].tocoo()
    same = entries.row // size == entries.col // size
    blocks[entries.row[same] // size, entries.row[same] % size, entries.col[same] % size] = entries.data[same]
    squares = np.linalg.eigvalsh(blocks)
    found: dict[int, np.ndarray] = {}
    # of a matrix without negative energies, a direction without energy has an empty column
    for node in np.flatnonzero(squares[:, 0] <= 1e-6 * squares[:, -1]):
        part = turns[node * size : (node + 1) * size]
        used = np.unique(part.indices)
        dense = part[:, used].toarray()
        empty = ~dense.any(axis=1)
        exact = np.eye(size)[empty]
        if not empty.all():
            left, norms, _ = np.linalg.svd(dense[~empty], full_matrices=False)
            slack = left[:, norms <= EMPTY * norms[0]].T
            spread = np.zeros((len(slack), size))
            spread[:, ~empty] = slack
            exact = np.vstack((exact, spread))
        if len(exact):
            found[int(node)] = exact
    return found


def _check_held(K: sp.csr_matrix, count: int, width: int, labels: np.ndarray) -> None:
    """Check that every node has stiffness in some direction."""
    loose = np.flatnonzero(np.diff(K.indptr)[: count * width].reshape(count, width).sum(axis=1) == 0)
    if len(loose):
        named = ", ".join(str(label) for label in labels[loose[:5]]) + (", ..." if len(loose) > 5 else "")
        raise ModelError(
            f"{len(loose)} node(s) have mass, but no stiffness: {named}. Remedy: export a matrix with what they hang "
            "on, such as rigid elements and ties, or leave their mass out and add it as a body in the scene"
        )


def _defined(axis: np.ndarray, r: np.ndarray, label: int) -> np.ndarray:
    """Return ``J^+ axis``, where the places of neighbours define the turn about a unit axis."""
    J = np.einsum("ja,ja->", r, r) * np.eye(3) - r.T @ r
    inverse = np.linalg.pinv(J, rcond=1e-8, hermitian=True)
    about = inverse @ axis
    if np.linalg.norm(J @ about - axis) > ALONG:
        raise ModelError(
            f"node {label} has no stiffness against rotation about {np.round(axis, 6).tolist()}, and "
            f"{'its neighbours lie on one line, so that they define none' if len(r) else 'it has no neighbours'}. "
            "Remedy: export without this node, or give its element rotational stiffness"
        )
    return np.asarray(about)
