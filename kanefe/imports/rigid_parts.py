"""Mass of nodes that rotate as rigid parts that move with them: what M says of the motion of every point.

In shells and beams that interpolate displacements and rotations alike (S4, S8R, B31, CQUAD4, SHELL181, BEAM188, ...),
and where mass is lumped with or without rotary inertia, a point s beside the reference moves by

    sum_i N_i (u_i + theta_i x s),

and the block of M between the nodes i and j is, with the moments m, c and S of 1 and s under ``rho N_i N_j``,

    [[m I, -c~], [c'~, tr(S) I - S^T]].

So M has all inner products of the functions N_i and N_i s_a, by which the points move: inertia is exact to the second
order of the displacements (Zwoelfer and Gerstmayr 2020), and M is reproduced. What does not fit these blocks is left.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from kanefe.errors import ModelError
from kanefe.fe_model.given_pattern import ROUND_OFF
from kanefe.fe_model.model import COMPONENTS, MassField
from kanefe.frames import skews

NOISE = 1e-12
"""Entry of a mass matrix, relative to its largest, that counts as round-off wherever it is."""

WIDTH = 6
"""Number of components of a node in all matrices of this module."""


class LabelledField(NamedTuple):
    """Mass points that move with labelled degrees of freedom, in the units of their file.

    Attributes
    ----------
    freedoms : ndarray of int, shape (N, 2)
        Label and number of the columns, as of `kanefe.imports.labelled.LabelledMatrix`.
    field : MassField
    """

    freedoms: np.ndarray
    field: MassField


class RigidParts(NamedTuple):
    """Points that move with nodes, and what of a mass matrix they explain.

    Attributes
    ----------
    field : MassField
    mass : bsr_matrix, shape (6 n, 6 n)
    """

    field: MassField
    mass: sp.bsr_matrix


def six_components(components: tuple[str, ...], count: int) -> sp.csr_matrix:
    """Return the matrix that gives the six components of `count` nodes from those that they have."""
    chosen = sp.csr_matrix([[float(c == name) for c in components] for name in COMPONENTS])
    return sp.kron(sp.identity(count), chosen, format="csr")


def rigid_parts(
    M: sp.spmatrix, points: np.ndarray, motions: sp.spmatrix, components: tuple[str, ...] = COMPONENTS
) -> RigidParts:
    """Return the points of the rigid parts of nodes.

    Parameters
    ----------
    M : sparse matrix, shape (6 n, 6 n)
        Mass matrix of the nodes in kg, kg m and kg m2.
    points : ndarray, shape (n, 3)
        Nodes in m.
    motions : sparse matrix, shape (6 n, N)
        Their motion by the degrees of freedom of the model.
    components : tuple of str
        The components that M has: the others tell nothing.
    """
    blocks = sp.csr_matrix(M).tobsr(blocksize=(WIDTH, WIDTH))
    rows = np.repeat(np.arange(len(points)), np.diff(blocks.indptr))
    has = np.array([name in components for name in COMPONENTS])
    grams = _moments(blocks.data, has)
    explained = sp.bsr_matrix((_blocks(grams) * np.outer(has, has), blocks.indices, blocks.indptr), shape=blocks.shape)
    own = np.zeros((len(points), 4, 4))
    own[rows[rows == blocks.indices]] = grams[rows == blocks.indices]
    lengths = _lengths(own, float(np.ptp(points, axis=0).max()) or 1.0)
    used = np.ones((len(points), 4), dtype=bool)
    largest = np.zeros((len(points), 4))
    np.maximum.at(largest, rows, np.abs(grams).max(axis=2))
    used[:, 1:] = largest[:, 1:] > 0.0
    change = np.zeros((len(points), 4, 4))
    change[:, 0, 0] = 1.0
    for a in range(1, 4):
        change[:, a, a] = 1.0 / lengths
        change[:, 0, a] = np.where(used[:, a], -1.0 / lengths, 0.0)
    grams = change[rows] @ grams @ np.swapaxes(change[blocks.indices], 1, 2)
    gram = sp.bsr_matrix((grams, blocks.indices, blocks.indptr), shape=(4 * len(points),) * 2).tocsr()
    kept = np.flatnonzero(used.ravel())
    arms = (lengths[:, None, None] * np.vstack((np.zeros(3), np.eye(3)))).reshape(-1, 3)[kept]
    return RigidParts(_points_of(kept // 4, arms, points, gram[kept][:, kept], motions), explained)


def is_round_off(rest: sp.spmatrix, M: sp.spmatrix) -> bool:
    """Return whether what is left of a mass matrix is round-off of a file, beside the masses of its rows."""
    scale = np.sqrt(np.maximum(M.diagonal(), 0.0))
    entries = sp.coo_matrix(rest)
    sizes = scale[entries.row] * scale[entries.col]
    return bool((np.abs(entries.data) <= ROUND_OFF * sizes + NOISE * scale.max(initial=0.0) ** 2).all())


def _points_of(
    node: np.ndarray, arms: np.ndarray, points: np.ndarray, gram: sp.csr_matrix, motions: sp.spmatrix
) -> MassField:
    """Return the points at arms (P, 3) from their nodes (P,), with the inner products (P, P) of their functions."""
    identity = np.broadcast_to(np.eye(3), (len(node), 3, 3))
    starts, shape = np.arange(len(node) + 1), (3 * len(node), motions.shape[0])
    moves = np.concatenate((identity, -skews(arms)), axis=2)
    turns = np.concatenate((np.zeros_like(identity), identity), axis=2)
    return MassField(
        points=points[node] + arms,
        mass=(0.5 * (gram + gram.T)).tocsr(),
        interpolation=(sp.bsr_matrix((moves, node, starts), shape=shape) @ motions).tocsr(),
        turns=(sp.bsr_matrix((turns, node, starts), shape=shape) @ motions).tocsr(),
        arms=arms,
    )


def _moments(blocks: np.ndarray, has: np.ndarray) -> np.ndarray:
    """Return the inner products (k, 4, 4) of 1 and s of two nodes that fit blocks (k, 6, 6) of M best."""
    grams = np.zeros((len(blocks), 4, 4))
    grams[:, 0, 0] = np.einsum("kaa,a->k", blocks[:, :3, :3], has[:3] / max(has[:3].sum(), 1))
    pairs = has[:3, None] * has[None, 3:]
    grams[:, 0, 1:] = _first(blocks[:, :3, 3:], pairs)
    grams[:, 1:, 0] = _first(np.swapaxes(blocks[:, 3:, :3], 1, 2), pairs)
    J = blocks[:, 3:, 3:].copy()
    if has[3:].sum() == 1:  # of a plane model: a part without thickness
        at = int(np.flatnonzero(has[3:])[0])
        for a in {0, 1, 2} - {at}:
            J[:, a, a] = 0.5 * J[:, at, at]
    half = 0.5 * np.trace(J, axis1=1, axis2=2)
    grams[:, 1:, 1:] = half[:, None, None] * np.eye(3) - np.swapaxes(J, 1, 2)
    return grams


def _first(blocks: np.ndarray, pairs: np.ndarray) -> np.ndarray:
    """Return c (k, 3) of blocks ``-c~`` (k, 3, 3), from the entries that are there."""
    found = np.zeros((len(blocks), 3))
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        count = float(pairs[b, c]) + float(pairs[c, b])
        found[:, a] = (blocks[:, b, c] - blocks[:, c, b]) / max(count, 1.0)
    return found


def _blocks(grams: np.ndarray) -> np.ndarray:
    """Return the blocks (k, 6, 6) of M with these inner products (k, 4, 4)."""
    S = grams[:, 1:, 1:]
    blocks = np.zeros((len(grams), WIDTH, WIDTH))
    blocks[:, :3, :3] = grams[:, 0, 0, None, None] * np.eye(3)
    blocks[:, :3, 3:] = -skews(grams[:, 0, 1:])
    blocks[:, 3:, :3] = skews(grams[:, 1:, 0])
    blocks[:, 3:, 3:] = np.trace(S, axis1=1, axis2=2)[:, None, None] * np.eye(3) - np.swapaxes(S, 1, 2)
    return blocks


def _lengths(own: np.ndarray, reach: float) -> np.ndarray:
    """Return the radii of gyration of the parts of nodes, shape (n,), or any length where they have none."""
    if reach > 1e150:
        raise ModelError(f"nodes are {reach:.3g} m apart: their squares overflow. Remedy: check the unit of nodes")
    mass, second = own[:, 0, 0], np.trace(own[:, 1:, 1:], axis1=1, axis2=2)
    known = (mass > 0.0) & (second > 0.0)
    return np.sqrt(np.where(known, second, reach**2) / np.where(known, mass, 1.0))
