"""Symmetric sparse systems whose rows may depend on each other: ``L D L^T`` within an envelope.

The lower triangle is kept row by row, each from its first entry to the diagonal: what elimination fills in stays
inside. The order is given, so that neighbours come together; `kanefe.kernels.algebra.pivoted` chooses it by the pivots
of a full system. What counts as dependent is the same.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels.algebra.pivoted import LEAST_KEPT, NEGATIVE, ROUND_OFF
from kanefe.kernels.compiler._numba import kernel


@kernel
def factor_envelope(
    A: np.ndarray,
    ends: np.ndarray,
    order: np.ndarray,
    scale: np.ndarray,
    tolerance: float,
    begin: int,
    end: int,
    L: np.ndarray,
    inverses: np.ndarray,
    column: np.ndarray,
) -> Any:
    """Factor the rows of a block of A whose scale is not zero; return the least pivot that counts, of the largest.

    It is 0 if the block is indefinite. Pivots below `tolerance` of the largest fade as those of
    `kanefe.kernels.algebra.pivoted.factor`.

    Parameters
    ----------
    A, L : ndarray, shape (ends[-1],)
        In the envelope.
    ends : ndarray of int, shape (m + 1,)
        Row a is from ``ends[a]`` to ``ends[a + 1]``, its diagonal last.
    order : ndarray of int, shape (m,)
        Which unknown is at each place of the envelope.
    scale : ndarray, shape (m,)
        Of each unknown.
    begin, end : int
        Places of the block, which has nothing in common with others.
    inverses : ndarray, shape (m,)
        On return: of the pivots, for `solve_envelope`.
    column : ndarray, shape (m,)
        Workspace: inverses that do not fade.
    """
    largest, weakest = ROUND_OFF, 1.0
    for a in range(begin, end):
        size = scale[order[a]]
        largest = max(largest, (size * size * A[ends[a + 1] - 1]).real)
    least = tolerance * largest
    for a in range(begin, end):
        start, first = ends[a], a + 1 - (ends[a + 1] - ends[a])
        own = scale[order[a]]
        if own == 0.0:
            for c in range(start, ends[a + 1]):
                L[c] = 0.0 * own
            inverses[a], column[a] = 0.0 * own, 0.0 * own
            continue
        for b in range(first, a):
            begun = b + 1 - (ends[b + 1] - ends[b])
            total = own * scale[order[b]] * A[start + b - first]
            for c in range(max(first, begun), b):
                total -= L[start + c - first] * L[ends[b] + c - begun]
            L[start + b - first] = total
        pivot = own * own * A[ends[a + 1] - 1]
        for b in range(first, a):
            share = L[start + b - first] * column[b]
            pivot -= share * L[start + b - first]
            L[start + b - first] = share
        if not pivot.real > LEAST_KEPT * least:
            if pivot.real < -NEGATIVE * largest:
                weakest = 0.0
            inverses[a], column[a] = 0.0 * own, 0.0 * own
            continue
        weakest = min(weakest, pivot.real / largest)
        column[a] = 1.0 / pivot
        inverses[a] = column[a] / (1.0 + (least / pivot.real) ** 4)
    return weakest


@kernel
def solve_envelope(
    L: np.ndarray,
    ends: np.ndarray,
    order: np.ndarray,
    inverses: np.ndarray,
    scale: np.ndarray,
    right: np.ndarray,
    begin: int,
    end: int,
    column: np.ndarray,
    x: np.ndarray,
) -> None:
    """Write x of ``A x = right`` for a block, zero for rows that were left out; `column` (m,) is workspace."""
    for a in range(begin, end):
        start, first = ends[a], a + 1 - (ends[a + 1] - ends[a])
        total = scale[order[a]] * right[order[a]]
        for c in range(first, a):
            total -= L[start + c - first] * column[c]
        column[a] = total
    for a in range(begin, end):
        column[a] *= inverses[a]
    for a in range(end - 1, begin - 1, -1):
        start, first = ends[a], a + 1 - (ends[a + 1] - ends[a])
        for c in range(first, a):
            column[c] -= L[start + c - first] * column[a]
    for a in range(begin, end):
        x[order[a]] = scale[order[a]] * column[a]


@kernel
def solve_envelope_columns(
    L: np.ndarray,
    ends: np.ndarray,
    order: np.ndarray,
    inverses: np.ndarray,
    scale: np.ndarray,
    right: np.ndarray,
    begin: int,
    end: int,
    x: np.ndarray,
) -> None:
    """Write x of ``A x = right`` for several columns, (m, columns), of a block."""
    count = right.shape[1]
    for a in range(begin, end):
        start, first, i = ends[a], a + 1 - (ends[a + 1] - ends[a]), order[a]
        for d in range(count):
            x[i, d] = scale[i] * right[i, d] if scale[i] != 0.0 else 0.0 * scale[i]
        for c in range(first, a):
            share = L[start + c - first]
            for d in range(count):
                x[i, d] -= share * x[order[c], d]
    for a in range(begin, end):
        for d in range(count):
            x[order[a], d] *= inverses[a]
    for a in range(end - 1, begin - 1, -1):
        start, first, i = ends[a], a + 1 - (ends[a + 1] - ends[a]), order[a]
        for c in range(first, a):
            share = L[start + c - first]
            for d in range(count):
                x[order[c], d] -= share * x[i, d]
        for d in range(count):
            x[i, d] *= scale[i]
