"""Sparse matrices with blocks of one size on their diagonal."""

from __future__ import annotations

import numpy as np

from kanefe.storage.scipy_later import sp


def block_diagonal(blocks: np.ndarray) -> sp.csr_matrix:
    """Return a sparse matrix with these blocks (m, k, k) on its diagonal."""
    count = np.arange(len(blocks) + 1)
    size = len(blocks) * blocks.shape[1]
    return sp.bsr_matrix((blocks, count[:-1], count), shape=(size, size)).tocsr()
