"""Dense linear systems, real or complex, in memory that the caller has: Gaussian elimination with row exchanges."""

from __future__ import annotations

import numpy as np

from kanefe.kernels.compiler._numba import inlined, kernel


@inlined
def _size(x: complex) -> float:
    """Return the size of a number without a root: for the choice of a pivot this will do."""
    return abs(x.real) + abs(x.imag)


@kernel
def factorise(A: np.ndarray, pivots: np.ndarray) -> bool:
    """Replace A by its factors, and note which row was exchanged with each; return whether A is regular."""
    size = len(A)
    for k in range(size):
        best = k
        for i in range(k + 1, size):
            if _size(A[i, k]) > _size(A[best, k]):
                best = i
        pivots[k] = best
        if not 0.0 < _size(A[best, k]) < np.inf:
            return False
        if best != k:
            for j in range(size):
                A[k, j], A[best, j] = A[best, j], A[k, j]
        inverse = 1.0 / A[k, k]
        for i in range(k + 1, size):
            share = A[i, k] * inverse
            A[i, k] = share
            for j in range(k + 1, size):
                A[i, j] -= share * A[k, j]
    return True


@kernel
def solve(A: np.ndarray, pivots: np.ndarray, b: np.ndarray) -> None:
    """Replace b by the solution of the system whose factors `factorise` left."""
    size = len(A)
    for k in range(size):
        best = int(pivots[k])
        b[k], b[best] = b[best], b[k]
    for i in range(size):
        total = b[i]
        for j in range(i):
            total -= A[i, j] * b[j]
        b[i] = total
    for i in range(size - 1, -1, -1):
        total = b[i]
        for j in range(i + 1, size):
            total -= A[i, j] * b[j]
        b[i] = total / A[i, i]


@kernel
def solve_in_place(system: np.ndarray, first: np.ndarray, second: np.ndarray, column: np.ndarray) -> None:
    """Replace two matrices and a column by ``system^-1`` times them; Gauss and Jordan with row exchange."""
    n = len(column)
    for i in range(n):
        best = i
        for a in range(i + 1, n):
            if abs(system[a, i].real) > abs(system[best, i].real):
                best = a
        if best != i:
            for b in range(n):
                system[i, b], system[best, b] = system[best, b], system[i, b]
                first[i, b], first[best, b] = first[best, b], first[i, b]
                second[i, b], second[best, b] = second[best, b], second[i, b]
            column[i], column[best] = column[best], column[i]
        pivot = 1.0 / system[i, i]
        for b in range(i, n):
            system[i, b] *= pivot
        for b in range(n):
            first[i, b] *= pivot
            second[i, b] *= pivot
        column[i] *= pivot
        for a in range(n):
            s = system[a, i]
            if a != i and s != 0.0:
                for b in range(i, n):
                    system[a, b] -= s * system[i, b]
                for b in range(n):
                    first[a, b] -= s * first[i, b]
                    second[a, b] -= s * second[i, b]
                column[a] -= s * column[i]
