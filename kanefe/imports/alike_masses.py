"""Entries of a mass matrix that are missing between two nodes, and are there between all others like them."""

from __future__ import annotations

import warnings

import numpy as np

from kanefe.errors import AccuracyWarning, outside
from kanefe.fe_model.given_pattern import ROUND_OFF
from kanefe.fe_model.model import FiniteElementModel
from kanefe.imports.mass_properties import FEW

LEAST = 5
"""Number of pairs of nodes along one direction, from which they are compared."""

LOST = 2
"""Number of entries between two nodes that differ, as one that was lost, or two that were swapped."""

DENSE = 0.5
"""Number of pairs of nodes that a matrix couples, relative to all, above which it is condensed, without a pattern."""


def check_alike(model: FiniteElementModel) -> None:
    """Warn if an entry between two nodes is missing, or one too many, unlike other pairs in their direction.

    Elements of one kind along one direction have entries in the same places. What moves as a body does not show that
    an entry between two rotations was lost: it is of the order of the rotary inertia of one element.

    Warns
    -----
    AccuracyWarning
    """
    count = len(model.nodes)
    if model.generalised or count < LEAST:
        return
    pairs, patterns = _patterns(model)
    if len(pairs) < LEAST or len(pairs) > DENSE * count * (count - 1) / 2:
        return
    apart = model.nodes[pairs[:, 1]] - model.nodes[pairs[:, 0]]
    directions = np.round(apart / np.linalg.norm(apart, axis=1)[:, None], 6) + 0.0  # without -0
    _, group, sizes = np.unique(directions, axis=0, return_inverse=True, return_counts=True)
    order = np.argsort(group.ravel(), kind="stable")
    ends = np.cumsum(sizes)
    for which in np.flatnonzero(sizes >= LEAST):
        rows = order[ends[which] - sizes[which] : ends[which]]
        found, times = np.unique(patterns[rows], return_counts=True)
        usual = found[times.argmax()]
        odd = [row for row in rows[patterns[rows] != usual] if bin(int(patterns[row] ^ usual)).count("1") <= LOST]
        if 0 < len(odd) <= FEW and times.max() >= LEAST - 1:
            _warn(model, pairs[odd[0]], int(patterns[odd[0]]), int(usual), int(times.max()))


def _patterns(model: FiniteElementModel) -> tuple[np.ndarray, np.ndarray]:
    """Return pairs of nodes (m, 2) that M couples, in one of both orders, and a bit for each entry between them."""
    width, count, size = len(model.components), len(model.nodes), model.nodal_size
    M = model.mass[:size, :size].tocoo()
    own = np.sqrt(np.maximum(model.mass.diagonal()[:size], 0.0))
    first, second = M.row // width, M.col // width
    apart = model.nodes[second] - model.nodes[first]
    leading = np.take_along_axis(apart, np.abs(apart).argmax(axis=1)[:, None], axis=1)[:, 0]
    kept = (leading > 0) & (np.abs(M.data) > ROUND_OFF * own[M.row] * own[M.col])
    keys = first[kept].astype(np.int64) * count + second[kept]
    bits = np.int64(1) << (width * (M.row[kept] % width) + M.col[kept] % width).astype(np.int64)
    order = np.argsort(keys, kind="stable")
    unique, starts = np.unique(keys[order], return_index=True)
    patterns = np.bitwise_or.reduceat(bits[order], starts) if len(unique) else np.zeros(0, dtype=np.int64)
    return np.column_stack((unique // count, unique % count)), patterns


def _warn(model: FiniteElementModel, pair: np.ndarray, pattern: int, usual: int, times: int) -> None:
    row, column = divmod((pattern ^ usual).bit_length() - 1, len(model.components))
    a, b = model.components[row], model.components[column]
    has = "has no entry" if usual & (pattern ^ usual) else "has an entry"
    warnings.warn(
        f"the mass between nodes {pair[0]} and {pair[1]} (from 0) {has} of {a} and {b}, unlike that of {times} other "
        "pairs of nodes in the same direction. Remedy: check that no entry of the mass matrix is missing or wrong",
        AccuracyWarning,
        stacklevel=outside(),
    )
