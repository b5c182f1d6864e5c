"""Products with a sparse matrix that is a selection almost everywhere: most rows are a row of the identity."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

NOTHING = np.zeros(1)


class Selection:
    """A sparse matrix A, as a gather where its rows pick one entry, and as a sparse matrix elsewhere.

    Of a mesh of Lagrange elements the points are the nodes, and only those of interfaces follow anything but
    coordinates of their own: a gather is several times faster than a sparse product.

    Parameters
    ----------
    matrix : csr_matrix, shape (m, n)

    Examples
    --------
    >>> A = Selection(sp.csr_matrix([[0.0, 1.0], [0.0, 0.0], [1.0, 0.0]]))
    >>> A.times(np.array([3.0, 5.0])), A.transposed_times(np.array([1.0, 2.0, 4.0]))
    (array([5., 0., 3.]), array([4., 1.]))
    """

    def __init__(self, matrix: sp.csr_matrix) -> None:
        matrix = sp.csr_matrix(matrix, copy=True)
        matrix.eliminate_zeros()
        rows, columns = matrix.shape
        entries = np.diff(matrix.indptr)
        single = np.flatnonzero(entries == 1)
        picks = matrix.data[matrix.indptr[single]] == 1.0
        single = single[picks]
        places = matrix.indices[matrix.indptr[single]]
        places, first = np.unique(places, return_index=True)  # a column that several rows pick is a product
        single = single[first]
        self._from = np.full(rows, columns)
        self._from[single] = places
        self._to = np.full(columns, rows)
        self._to[places] = single
        self._others = np.setdiff1d(np.flatnonzero(entries), single)
        self._rest = matrix[self._others]
        self._rest_transposed = self._rest.T.tocsr()
        self._has_rest = self._others.size > 0

    def times(self, x: np.ndarray) -> np.ndarray:
        """Return ``A x``, shape (m,)."""
        found = np.concatenate((x, NOTHING))[self._from]
        if self._has_rest:
            found[self._others] = self._rest @ x
        return found

    def transposed_times(self, y: np.ndarray) -> np.ndarray:
        """Return ``A^T y``, shape (n,)."""
        found = np.concatenate((y, NOTHING))[self._to]
        if self._has_rest:
            found += self._rest_transposed @ y[self._others]
        return found
