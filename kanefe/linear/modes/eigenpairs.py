"""Eigenvalues and eigenvectors of state matrices whose entries differ by many powers of ten."""

from __future__ import annotations

import numpy as np
import scipy.linalg

from kanefe.frames import Vector
from kanefe.linear.overflow import refuse_overflow

NOTHING = 1e-16
"""Size of a column, relative to the largest entry, below which it is round-off."""


def eigenpairs(A: np.ndarray, weights: Vector) -> tuple[np.ndarray, np.ndarray]:
    """Return the eigenvalues of a state matrix, 1/s, and its eigenvectors as columns.

    The matrix is scaled by weights of its states, see `rate_weights`, and columns of round-off are set to zero: LAPACK
    would balance them by unbounded factors, and eigenvectors would be lost in round-off.

    Examples
    --------
    >>> values, _ = eigenpairs(np.array(((0.0, 1.0), (-4.0, 0.0))), np.array((2.0, 1.0)))
    >>> np.abs(values)
    array([2., 2.])
    """
    if not A.size:
        return np.zeros(0, dtype=complex), np.zeros((0, 0), dtype=complex)
    scaled = weights[:, None] * A / weights[None, :]
    refuse_overflow("the state matrix", scaled)
    largest = np.abs(scaled).max(axis=0, initial=0.0)
    scaled[:, largest <= NOTHING * largest.max(initial=0.0)] = 0.0
    values, vectors = scipy.linalg.eig(scaled)
    return values, vectors / weights[:, None]


def rate_weights(A: np.ndarray, positions: int, least: float = 1e-8, arms: int = 0) -> Vector:
    """Return weights of the states of A that make positions and speeds comparable: frequencies of single coordinates.

    The states are `positions` positions, then speeds, then those of `arms`, which count as speeds; the scaled matrix
    is ``weights[:, None] * A / weights``. Frequencies below `least` times the largest are replaced by the median; the
    default is the root of round-off.
    """
    is_holonomic = len(A) - arms == 2 * positions
    rates = np.sqrt(np.abs(np.diag(A[positions:, :positions]))) if is_holonomic else np.ones(positions)
    counts = rates > least * rates.max(initial=0.0)
    middle = float(np.median(rates[counts])) if counts.any() else 1.0
    return np.concatenate((np.where(counts, rates, middle), np.ones(len(A) - positions)))
