"""Eigenvalues and shapes of state matrices, whose entries differ by many powers of ten."""

from __future__ import annotations

import numpy as np
import scipy.linalg

from kanefe.frames import Vector

NOTHING = 1e-16
"""Size of a column, relative to the largest entry, below which its roots are frequencies of round-off."""


def eigenpairs(A: np.ndarray, weights: Vector) -> tuple[np.ndarray, np.ndarray]:
    """Return the eigenvalues of a state matrix, 1/s, and its shapes as columns.

    Scaled by weights of its states, see `rate_weights`. LAPACK balances matrices, by factors without bounds where a
    column is nearly nothing, such as what is left of a torque that is just starting; shapes are lost in its round-off
    then.

    Examples
    --------
    >>> values, _ = eigenpairs(np.array(((0.0, 1.0), (-4.0, 0.0))), np.array((2.0, 1.0)))
    >>> np.abs(values)
    array([2., 2.])
    """
    scaled = weights[:, None] * A / weights[None, :]
    largest = np.abs(scaled).max(axis=0, initial=0.0)
    scaled[:, largest <= NOTHING * largest.max(initial=0.0)] = 0.0
    values, vectors = scipy.linalg.eig(scaled)
    return values, vectors / weights[:, None]


def rate_weights(A: np.ndarray, positions: int, least: float = 1e-8) -> Vector:
    """Return a scaling of the states of A that makes rates and coordinates alike: frequencies of entries by themselves.

    States are so many positions, then speeds; scaled is ``weights[:, None] * A / weights``. Frequencies below the share
    `least` of the largest are round-off, by default its root; where nothing is unresisted they are what they are.
    """
    rates = np.sqrt(np.abs(np.diag(A[positions:, :positions]))) if len(A) == 2 * positions else np.ones(positions)
    counts = rates > least * rates.max(initial=0.0)
    middle = float(np.median(rates[counts])) if counts.any() else 1.0
    return np.concatenate((np.where(counts, rates, middle), np.ones(len(A) - positions)))
