"""Sparse linear systems, real or complex, whose order and pattern are given: ``L U`` without exchanges of rows.

Rows are kept one behind the other, each with its columns in rising order; what elimination fills in has its place from
the start. L has ones along its diagonal; of U the inverse of the diagonal is kept.
"""

from typing import NamedTuple

import numpy as np

from kanefe.kernels.language import Integers, entry, kernel


class Pattern(NamedTuple):
    """Where a matrix and its factors have entries.

    Attributes
    ----------
    starts : ndarray of int, shape (n + 1,)
        Row i is from ``starts[i]`` to ``starts[i + 1]``.
    columns : ndarray of int, shape (starts[n],)
    diagonals : ndarray of int, shape (n,)
    """

    starts: np.ndarray
    columns: np.ndarray
    diagonals: np.ndarray


@entry()
def fill_in(
    starts: Integers, columns: Integers, filled: Integers, into: Integers, diagonals: Integers, marks: Integers
) -> int:
    """Write the pattern of the factors of a matrix; return how many entries they have, which may be more than written.

    Parameters
    ----------
    starts, columns : ndarray of int
        Pattern of the matrix; columns of a row in any order, also twice.
    filled, into, diagonals : ndarray of int
        Where that of the factors is written: see `Pattern`.
    marks : ndarray of int, shape (n,)
        Workspace.
    """
    n, count = len(diagonals), 0
    marks[:] = -1
    for i in range(n):
        filled[i] = count
        first = last = i
        marks[i] = i
        for p in range(starts[i], starts[i + 1]):
            marks[columns[p]] = i
            first, last = min(first, columns[p]), max(last, columns[p])
        j = first
        while j <= last:
            if marks[j] == i:
                if j == i:
                    diagonals[i] = count
                if count < len(into):
                    into[count] = j
                count += 1
                if j < i:
                    for p in range(diagonals[j] + 1, min(filled[j + 1], len(into))):
                        marks[into[p]] = i
                        last = max(last, into[p])
            j += 1
        filled[i + 1] = count
    return count


@kernel
def factorise_sparse(pattern: Pattern, A: np.ndarray, row: np.ndarray) -> bool:
    """Replace a matrix by its factors; return whether all pivots are numbers, and none is zero.

    `row` is workspace of as many numbers as there are rows.
    """
    starts, columns, diagonals = pattern
    for i in range(len(diagonals)):
        diagonal, end = diagonals[i], starts[i + 1]
        for p in range(starts[i], end):
            row[columns[p]] = A[p]
        for p in range(starts[i], diagonal):
            k = columns[p]
            share = row[k] * A[diagonals[k]]
            A[p] = share
            if share != 0.0:
                for q in range(diagonals[k] + 1, starts[k + 1]):
                    row[columns[q]] -= share * A[q]
        pivot = row[i]
        if not 0.0 < abs(pivot.real) + abs(pivot.imag) < np.inf:
            return False
        A[diagonal] = 1.0 / pivot
        for p in range(diagonal + 1, end):
            A[p] = row[columns[p]]
    return True


@kernel
def solve_sparse(pattern: Pattern, A: np.ndarray, x: np.ndarray) -> None:
    """Replace x by the solution of the system whose factors `factorise_sparse` left."""
    starts, columns, diagonals = pattern
    for i in range(len(diagonals)):
        total = x[i]
        for p in range(starts[i], diagonals[i]):
            total -= A[p] * x[columns[p]]
        x[i] = total
    for i in range(len(diagonals) - 1, -1, -1):
        total = x[i]
        for p in range(diagonals[i] + 1, starts[i + 1]):
            total -= A[p] * x[columns[p]]
        x[i] = total * A[diagonals[i]]
