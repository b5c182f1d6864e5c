"""Dense linear systems, real or complex, in memory that the caller has: Gaussian elimination with row exchanges."""

import numpy as np

from kanefe.kernels.language import inlined, kernel


@inlined
def _size(x: complex) -> float:
    """Return the size of a number without a root: for the choice of a pivot this will do."""
    return abs(x.real) + abs(x.imag)


@inlined
def factorise(A: np.ndarray, pivots: np.ndarray) -> bool:
    """Replace A by its factors, and note which row was exchanged with each; return whether A is regular.

    Where it is not, the factors are of no use, but `solve` stays within its memory.
    """
    size = len(A)
    for k in range(size):
        best = k
        for i in range(k + 1, size):
            if _size(A[i, k]) > _size(A[best, k]):
                best = i
        pivots[k] = best
        if not 0.0 < _size(A[best, k]) < np.inf:
            for i in range(k, size):
                pivots[i] = i
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


@inlined
def solve(A: np.ndarray, pivots: np.ndarray, b: np.ndarray) -> None:
    """Replace b by the solution of the system whose factors `factorise` left."""
    size = len(A)
    for k in range(size):
        best = int(pivots[k].real)
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
def factorise_from_last(A: np.ndarray, pivots: np.ndarray, border: int) -> bool:
    """Replace A by its factors, eliminated from the last unknown to the first; return whether A is regular.

    Behind its first `border` rows and columns A is sparse, and stays so: rows are exchanged among the sparse ones as
    long as these are eliminated, and what is zero is passed over. What is left is the dense border.
    """
    size = len(A)
    for k in range(size - 1, -1, -1):
        edge = border if k >= border else 0
        best = k
        for i in range(edge, k):
            if _size(A[i, k]) > _size(A[best, k]):
                best = i
        pivots[k] = best
        if not 0.0 < _size(A[best, k]) < np.inf:
            for i in range(k + 1):
                pivots[i] = i
            return False
        if best != k:
            for j in range(size):
                A[k, j], A[best, j] = A[best, j], A[k, j]
        low = edge
        while low < k and A[k, low] == 0.0:
            low += 1
        inverse = 1.0 / A[k, k]
        for i in range(k):
            if A[i, k] == 0.0:
                continue
            share = A[i, k] * inverse
            A[i, k] = share
            for j in range(edge):
                A[i, j] -= share * A[k, j]
            for j in range(low, k):
                A[i, j] -= share * A[k, j]
    return True


@kernel
def solve_from_last(A: np.ndarray, pivots: np.ndarray, b: np.ndarray) -> None:
    """Replace b by the solution of the system whose factors `factorise_from_last` left."""
    size = len(A)
    for k in range(size - 1, -1, -1):
        best = int(pivots[k].real)
        b[k], b[best] = b[best], b[k]
    for i in range(size - 2, -1, -1):
        total = b[i]
        for j in range(i + 1, size):
            total -= A[i, j] * b[j]
        b[i] = total
    for i in range(size):
        total = b[i]
        for j in range(i):
            total -= A[i, j] * b[j]
        b[i] = total / A[i, i]


@inlined
def solve_columns(A: np.ndarray, pivots: np.ndarray, B: np.ndarray) -> None:
    """Replace the columns of B by the solutions of the system whose factors `factorise` left."""
    size = len(A)
    for k in range(size):
        best = int(pivots[k].real)
        if best != k:
            for c in range(B.shape[1]):
                B[k, c], B[best, c] = B[best, c], B[k, c]
    for i in range(size):
        for j in range(i):
            for c in range(B.shape[1]):
                B[i, c] -= A[i, j] * B[j, c]
    for i in range(size - 1, -1, -1):
        for j in range(i + 1, size):
            for c in range(B.shape[1]):
                B[i, c] -= A[i, j] * B[j, c]
        for c in range(B.shape[1]):
            B[i, c] /= A[i, i]
