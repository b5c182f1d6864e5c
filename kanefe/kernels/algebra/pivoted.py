"""Symmetric systems whose rows may depend on each other: ``L D L^T`` with the largest pivot first.

Rows are scaled, so that a pivot says how much of a row is not said by those before it. Pivots of round-off are left
out: the unknowns of their rows are zero, and the others are solved for.
"""

from typing import Any, NamedTuple

import numpy as np

from kanefe.kernels.language import inlined, kernel


class PivotLimits(NamedTuple):
    """Pivots that count."""

    # Pivot of a scaled row, of 1 at most, that the tolerance is taken of at least: `kanefe.tree.row_rates.ROUND_OFF`
    round_off: float = 1e-16
    # Pivots below this share of the tolerance are left out; above it they fade, see `kanefe.states.constraints`
    least_kept: float = 1e-3
    # A negative pivot that is no round-off, of the largest: what moves with the row has an inertia below zero
    negative: float = 1e-8


PIVOT = PivotLimits()


class Pivots(NamedTuple):
    """Memory of the factors of a matrix of m rows.

    Attributes
    ----------
    L : ndarray, shape (m, m)
    inverses, order : ndarray, shape (m,)
        Of the pivots, and the rows that they are of.
    column : ndarray, shape (m,)
        Workspace.
    """

    L: np.ndarray
    inverses: np.ndarray
    order: np.ndarray
    column: np.ndarray


@inlined
def pivots_of(kept: Any) -> Pivots:
    """Return the memory of factors that is part of a record."""
    return Pivots(kept.L, kept.inverses, kept.order, kept.column)


@kernel
def factor(A: np.ndarray, scale: np.ndarray, tolerance: float, pivots: Pivots) -> tuple[int, Any]:
    """Factor the rows of A whose scale is not zero; return how many pivots count, and the least of the largest.

    The least is 0 if A is indefinite.

    Parameters
    ----------
    A : ndarray, shape (m, m)
        Its lower triangle is read.
    scale : ndarray, shape (m,)
        Of each row.
    tolerance : float
        Pivot below which a row depends on others. A cut there would be a jump of the accelerations, on which error
        control gets stuck: the inverses of smaller pivots fall to zero smoothly.
    pivots : Pivots
        On return: for `solve`.
    """
    L, inverses, order, live = pivots.L, pivots.inverses, pivots.order, 0
    for i in range(len(scale)):
        if scale[i].real > 0.0:
            order[live] = i
            live += 1
    for a in range(live):
        i = int(order[a].real)
        for b in range(a + 1):
            j = int(order[b].real)
            L[a, b] = scale[i] * scale[j] * A[i, j]
    least = tolerance * PIVOT.round_off
    largest, weakest = PIVOT.round_off, 1.0
    for k in range(live):
        best = k
        for i in range(k + 1, live):
            if L[i, i].real > L[best, best].real:
                best = i
        if best != k:
            _exchange(L, k, best, live)
            order[k], order[best] = order[best], order[k]
        pivot = L[k, k]
        if k == 0:
            largest = max(PIVOT.round_off, pivot.real)
            least = tolerance * largest
        if not pivot.real > PIVOT.least_kept * least:
            for i in range(k, live):
                if L[i, i].real < -PIVOT.negative * largest:
                    weakest = 0.0
            return k, weakest
        weakest = pivot.real / largest
        fade = (least / pivot.real) ** 4
        inverses[k] = 1.0 / (pivot * (1.0 + fade))
        _eliminate(L, k, live, pivots.column)
    return live, weakest


@kernel
def _eliminate(L: np.ndarray, k: int, n: int, column: np.ndarray) -> None:
    """Take what a pivot row says from the rows behind it."""
    inverse = 1.0 / L[k, k]
    for i in range(k + 1, n):
        column[i] = L[i, k]
    for i in range(k + 1, n):
        share = inverse * column[i]
        if share != 0.0:
            row = L[i]
            for j in range(k + 1, i + 1):
                row[j] -= share * column[j]
        L[i, k] = share


@kernel
def _exchange(L: np.ndarray, p: int, q: int, n: int) -> None:
    """Exchange rows and columns p < q of a symmetric matrix of which the lower triangle is kept."""
    for c in range(p):
        L[p, c], L[q, c] = L[q, c], L[p, c]
    L[p, p], L[q, q] = L[q, q], L[p, p]
    for i in range(p + 1, q):
        L[i, p], L[q, i] = L[q, i], L[i, p]
    for i in range(q + 1, n):
        L[i, p], L[i, q] = L[i, q], L[i, p]


@kernel
def solve(pivots: Pivots, rank: int, scale: np.ndarray, right: np.ndarray, x: np.ndarray) -> None:
    """Write x of ``A x = right`` (m,), zero for rows that were left out."""
    L, inverses, order, column = pivots
    for k in range(rank):
        i = int(order[k].real)
        total = scale[i] * right[i]
        for c in range(k):
            total -= L[k, c] * column[c]
        column[k] = total
    for k in range(rank):
        column[k] *= inverses[k]
    for k in range(rank - 1, 0, -1):
        for c in range(k):
            column[c] -= L[k, c] * column[k]
    for i in range(len(x)):
        x[i] = 0.0
    for k in range(rank):
        i = int(order[k].real)
        x[i] = scale[i] * column[k]
