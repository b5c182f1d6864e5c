"""Independent small motions of a scene with loops: which coordinates lead, and how the others follow.

Rows ``J z = 0`` split z into leading entries p and following ones: ``z = N p`` where N holds ones for p. Coordinates of
joints follow rather than elastic ones, so that what leads has a name an engineer knows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg

from kanefe.frames import Matrix, Vector
from kanefe.kane.constraints import Rates

WELL_CONDITIONED = 1e-2
"""Pivot, of the largest, down to which only coordinates of joints are asked to follow."""

RANK = 1e-6
"""Pivot of scaled rows, of the largest, below which a row depends on others: some 1e-12 is round-off."""


@dataclass(frozen=True, eq=False)
class Independent:
    """Leading and following entries of a small motion.

    Attributes
    ----------
    leading, following : ndarray of int
    N : ndarray, shape (n, leading)
        All entries from the leading ones.
    inverse : ndarray, shape (following, rows)
        Pseudo-inverse of J over the following entries.
    """

    leading: np.ndarray
    following: np.ndarray
    N: Matrix
    inverse: Matrix

    def followed(self, remainder: Matrix) -> Matrix:
        """Return the motions (n, k) with leading entries of zero and ``J x + remainder = 0``; remainder (rows, k)."""
        x = np.zeros((len(self.N), remainder.shape[1]))
        x[self.following] = -self.inverse @ remainder
        return x


def independent(
    rates: Rates, masses: Vector, joints: np.ndarray, given: np.ndarray, before: np.ndarray | None = None
) -> Independent:
    """Choose leading and following entries.

    Parameters
    ----------
    rates : Rates
        J (rows, n) and its reach.
    masses : ndarray, shape (n,)
        Diagonal of the mass matrix: makes columns of different units comparable.
    joints, given : ndarray of bool, shape (n,)
        Entries of joints, and entries that always lead: drives.
    before : ndarray of int, optional
        Entries that follow in any case.
    """
    J, n = rates.J, rates.J.shape[1]
    if not len(J):
        return Independent(np.arange(n), np.zeros(0, dtype=int), np.eye(n), np.zeros((0, 0)))
    weights = 1.0 / np.sqrt(np.where(masses > 0.0, masses, 1.0))
    sizes = np.sqrt((rates.reach * weights**2).sum(axis=1))
    scaled = J * weights / np.where(sizes > 0.0, sizes, 1.0)[:, None]
    following = np.zeros(0, dtype=int) if before is None else before
    for candidates, tolerance in ((joints & ~given, WELL_CONDITIONED), (~given, RANK)):
        basis = scipy.linalg.orth(scaled[:, following]) if len(following) else np.zeros((len(J), 0))
        columns = np.setdiff1d(np.flatnonzero(candidates), following)
        if not len(columns):
            continue
        rest = scaled[:, columns] - basis @ (basis.T @ scaled[:, columns])
        _, triangle, order = scipy.linalg.qr(rest, mode="economic", pivoting=True)
        pivots = np.abs(np.diag(triangle))
        largest = max(float(np.abs(scaled).max(initial=0.0)), 1e-300)
        following = np.concatenate((following, columns[order[: np.count_nonzero(pivots > tolerance * largest)]]))
    following = np.sort(following)
    leading = np.setdiff1d(np.arange(n), following)
    inverse = np.linalg.pinv(scaled[:, following], rcond=1e-12) / np.where(sizes > 0.0, sizes, 1.0)[None, :]
    inverse = weights[following, None] * inverse
    N = np.zeros((n, len(leading)))
    N[leading, range(len(leading))] = 1.0
    N[following] = -inverse @ J[:, leading]
    return Independent(leading, following, N, inverse)
