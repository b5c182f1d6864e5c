"""Symmetric sparse systems whose rows may depend on each other: ``L D L^T`` within an envelope.

The lower triangle is kept row by row, each from its first entry to the diagonal: what elimination fills in stays
inside. The order is given, so that neighbours come together; successive rows with the same neighbours are a block, in
which the largest pivot is first. A full system is one block: it is factored as by
`kanefe.kernels.algebra.pivoted.factor`, where what is said of pivots holds here too.
"""

from typing import NamedTuple

import numpy as np

from kanefe.kernels.algebra.pivoted import PIVOT
from kanefe.kernels.language import inlined


class Envelope(NamedTuple):
    """A system in its envelope, and its factors.

    Attributes
    ----------
    ends : ndarray of int, shape (m + 1,)
        Row a is from ``ends[a]`` to ``ends[a + 1]``, its diagonal last. It begins where a block begins.
    blocks : ndarray of int, shape (m,)
        Where the block of each place ends.
    order, place : ndarray of int, shape (m,)
        Which unknown is given at each place, and the place of each.
    A, L : ndarray, shape (ends[-1],)
    scale : ndarray, shape (m,)
        Of each unknown; 0: its row is left out.
    inverses, whole : ndarray, shape (m,)
        Of the pivots at each place, faded near the tolerance; whole, but 0 for those that are left out.
    taken : ndarray, shape (m,)
        Which unknown is at each place, with the largest pivot of each block first.
    column : ndarray, shape (m,)
        Workspace.
    """

    ends: np.ndarray
    blocks: np.ndarray
    order: np.ndarray
    place: np.ndarray
    A: np.ndarray
    L: np.ndarray
    scale: np.ndarray
    inverses: np.ndarray
    whole: np.ndarray
    taken: np.ndarray
    column: np.ndarray


@inlined
def first_of(ends: np.ndarray, a: int) -> int:
    """Return the place at which a row of an envelope begins."""
    return a + 1 - (ends[a + 1] - ends[a])


@inlined
def factor_envelope(system: Envelope, tolerance: float, begin: int, end: int) -> tuple[float, float]:
    """Factor a part of a system that has nothing in common with the rest; return its least and its largest pivot.

    The least of those that count, 0 if the system is indefinite; the largest is that of the scaled diagonal, before.
    Of a part of which all rows are left out: infinity and 0.
    """
    ends, largest, p = system.ends, 0.0, begin
    for a in range(begin, end):
        size = system.scale[system.order[a]]
        largest = max(largest, (size * size * system.A[ends[a + 1] - 1]).real)
    weakest, most = np.inf, max(largest, PIVOT.round_off)
    while p < end:
        first, q = first_of(ends, p), system.blocks[p]
        _reduce(system, first, p, q)
        weakest = min(weakest, _pivot(system, tolerance, most, first, p, q))
        p = q
    return weakest, largest


@inlined
def _reduce(system: Envelope, first: int, p: int, q: int) -> None:
    """Take what is before a block, at places p to q, off its rows."""
    ends, A, L, scale = system.ends, system.A, system.L, system.scale
    for a in range(p, q):
        own, start = scale[system.order[a]], ends[a] - first
        system.taken[a] = system.order[a]
        for b in range(first, p):
            other, before = int(system.taken[b].real), first_of(ends, b)
            total = own * scale[other] * A[start + system.place[other]]
            for c in range(max(first, before), b):
                total -= L[start + c] * L[ends[b] - before + c]
            L[start + b] = total
        for b in range(p, a):
            total = own * scale[system.order[b]] * A[start + b]
            for c in range(first, p):
                total -= L[start + c] * L[ends[b] - first + c]
            L[start + b] = total
        pivot = own * own * A[start + a]
        for c in range(first, p):
            share = L[start + c] * system.whole[c]
            pivot -= share * L[start + c]
            L[start + c] = share
        L[start + a] = pivot


@inlined
def _pivot(system: Envelope, tolerance: float, largest: float, first: int, p: int, q: int) -> float:
    """Factor a block from which what is before is taken off; return its least pivot, 0 if it is indefinite.

    Infinity, if none counts.
    """
    ends, L, column, weakest, least = system.ends, system.L, system.column, np.inf, tolerance * largest
    for k in range(p, q):
        best = k
        for i in range(k + 1, q):
            if L[ends[i + 1] - 1].real > L[ends[best + 1] - 1].real:
                best = i
        if best != k:
            _exchange(system, first, k, best, q)
        pivot = L[ends[k + 1] - 1]
        if not pivot.real > PIVOT.least_kept * least:
            for i in range(k, q):
                if L[ends[i + 1] - 1].real < -PIVOT.negative * largest:
                    weakest = 0.0
                system.inverses[i] = system.whole[i] = 0.0 * pivot
            return weakest
        weakest = pivot.real
        system.whole[k] = 1.0 / pivot
        system.inverses[k] = system.whole[k] / (1.0 + (least / pivot.real) ** 4)
        for i in range(k + 1, q):
            column[i] = L[ends[i] - first + k]
        for i in range(k + 1, q):
            share = system.whole[k] * column[i]
            if share != 0.0:
                at = ends[i] - first
                for j in range(k + 1, i + 1):
                    L[at + j] -= share * column[j]
            L[ends[i] - first + k] = share
    return weakest


@inlined
def _exchange(system: Envelope, first: int, k: int, other: int, q: int) -> None:
    """Exchange two rows, and columns, of a block of which the lower triangle is kept, and what is before them."""
    ends, L, taken = system.ends, system.L, system.taken
    at, by = ends[k] - first, ends[other] - first
    taken[k], taken[other] = taken[other], taken[k]
    for c in range(first, k):
        L[at + c], L[by + c] = L[by + c], L[at + c]
    L[at + k], L[by + other] = L[by + other], L[at + k]
    for i in range(k + 1, other):
        row = ends[i] - first
        L[row + k], L[by + i] = L[by + i], L[row + k]
    for i in range(other + 1, q):
        row = ends[i] - first
        L[row + k], L[row + other] = L[row + other], L[row + k]


@inlined
def solve_envelope(system: Envelope, right: np.ndarray, begin: int, end: int, x: np.ndarray) -> None:
    """Write x of ``A x = right`` for columns, (m, columns), of a part; zero for rows that are left out."""
    ends, L, count = system.ends, system.L, right.shape[1]
    for a in range(begin, end):
        first, i = first_of(ends, a), int(system.taken[a].real)
        scale, start = system.scale[i], ends[a] - first
        for d in range(count):
            x[i, d] = scale * right[i, d] if scale != 0.0 else 0.0 * scale
        for c in range(first, a):
            share, j = L[start + c], int(system.taken[c].real)
            if share != 0.0:
                for d in range(count):
                    x[i, d] -= share * x[j, d]
    for a in range(begin, end):
        i = int(system.taken[a].real)
        for d in range(count):
            x[i, d] *= system.inverses[a]
    for a in range(end - 1, begin - 1, -1):
        first, i = first_of(ends, a), int(system.taken[a].real)
        start = ends[a] - first
        for c in range(first, a):
            share, j = L[start + c], int(system.taken[c].real)
            if share != 0.0:
                for d in range(count):
                    x[j, d] -= share * x[i, d]
        for d in range(count):
            x[i, d] *= system.scale[i]
