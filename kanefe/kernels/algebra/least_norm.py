"""Square systems whose rows may depend on each other: the solution of least norm, that meets them best.

Reflections with the largest column first, until what is left is round-off, and from the right for what is left out: a
complete orthogonal decomposition, ``B = Q [T 0] Z P^T`` (Golub & Van Loan, "Matrix Computations", section 5.4).
"""

from typing import Any

import numpy as np

from kanefe.kernels.language import kernel


@kernel
def factor_least(
    B: np.ndarray, right: np.ndarray, n: int, tolerance: float, order: np.ndarray, shares: np.ndarray, row: np.ndarray
) -> tuple[int, Any]:
    """Replace a matrix by its factors, a right-hand side by ``Q^T right``; return rank and least pivot, of the largest.

    Parameters
    ----------
    B : ndarray, shape (n or more, n or more)
        Of which n rows and columns count.
    right : ndarray, shape (n,)
    tolerance : float
        Pivot, of the largest, below which what is left is round-off.
    order, shares, row : ndarray, shape (n,)
        On return: the order of the columns, and of each reflection from the right its factor; workspace.
    """
    for j in range(n):
        order[j] = j
    largest, rank, weakest = 0.0, n, 1.0
    for k in range(n):
        row[:n] = 0.0
        for i in range(k, n):
            for j in range(k, n):
                row[j] += (B[i, j] * B[i, j]).real
        best = k
        for j in range(k + 1, n):
            if row[j].real > row[best].real:
                best = j
        size = np.sqrt(row[best].real)
        if k == 0:
            largest = size
        if not size > tolerance * largest:
            rank = k
            break
        weakest = size / largest
        if best != k:
            for i in range(n):
                B[i, k], B[i, best] = B[i, best], B[i, k]
            order[k], order[best] = order[best], order[k]
        _reflect_columns(B, right, k, n, row)
    if rank == 0:
        return 0, 1.0
    if rank < n:
        for k in range(rank - 1, -1, -1):
            shares[k] = _reflect_row(B, k, rank, n)
    return rank, weakest


@kernel
def _reflect_columns(B: np.ndarray, right: np.ndarray, k: int, n: int, row: np.ndarray) -> None:
    """Bring a column to its pivot, and do the same to those behind it and to the right-hand side."""
    total = 0.0 * B[k, k]
    for i in range(k, n):
        total += B[i, k] * B[i, k]
    size = np.sqrt(total)
    pivot = -size if B[k, k].real > 0.0 else size
    head = B[k, k] - pivot
    share = head * pivot  # minus half the square of the reflected vector
    row[:n] = 0.0
    along = 0.0 * total
    for i in range(k, n):
        x = head if i == k else B[i, k]
        for j in range(k + 1, n):
            row[j] += x * B[i, j]
        along += x * right[i]
    for i in range(k, n):
        x = (head if i == k else B[i, k]) / share
        for j in range(k + 1, n):
            B[i, j] += x * row[j]
        right[i] += x * along
    B[k, k] = pivot


@kernel
def _reflect_row(B: np.ndarray, k: int, rank: int, n: int) -> Any:
    """Bring what a row has beyond the rank to its pivot, and do the same to the rows above; return the factor."""
    total = B[k, k] * B[k, k]
    for j in range(rank, n):
        total += B[k, j] * B[k, j]
    size = np.sqrt(total)
    pivot = -size if B[k, k].real > 0.0 else size
    head = B[k, k] - pivot
    share = pivot * head
    for i in range(k):
        along = B[i, k] * head
        for j in range(rank, n):
            along += B[i, j] * B[k, j]
        along /= share
        B[i, k] += along * head
        for j in range(rank, n):
            B[i, j] += along * B[k, j]
    # the reflected vector is kept with a head of one
    for j in range(rank, n):
        B[k, j] /= head
    B[k, k] = pivot
    return head * head / share


@kernel
def solve_least(
    B: np.ndarray, right: np.ndarray, n: int, rank: int, order: np.ndarray, shares: np.ndarray, y: np.ndarray
) -> None:
    """Replace ``Q^T right`` by the solution, from what `factor_least` left; y is workspace (n,)."""
    for k in range(rank - 1, -1, -1):
        total = right[k]
        for j in range(k + 1, rank):
            total -= B[k, j] * y[j]
        y[k] = total / B[k, k]
    for k in range(rank, n):
        y[k] = 0.0
    if rank < n:
        for k in range(rank):
            _reflect(B, k, rank, n, shares, y)
    for k in range(n):
        right[int(order[k].real)] = y[k]


@kernel
def leave_spare(
    B: np.ndarray, x: np.ndarray, n: int, rank: int, order: np.ndarray, shares: np.ndarray, y: np.ndarray
) -> None:
    """Leave of x (n,) what the matrix does not see, from what `factor_least` left; y is workspace (n,)."""
    for k in range(n):
        y[k] = x[int(order[k].real)]
    for k in range(rank - 1, -1, -1):
        _reflect(B, k, rank, n, shares, y)
    for k in range(rank):
        y[k] = 0.0
    for k in range(rank):
        _reflect(B, k, rank, n, shares, y)
    for k in range(n):
        x[int(order[k].real)] = y[k]


@kernel
def _reflect(B: np.ndarray, k: int, rank: int, n: int, shares: np.ndarray, y: np.ndarray) -> None:
    """Reflect a vector as the k-th row was."""
    along = y[k]
    for j in range(rank, n):
        along += B[k, j] * y[j]
    along *= shares[k]
    y[k] += along
    for j in range(rank, n):
        y[j] += along * B[k, j]
