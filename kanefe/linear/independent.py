"""Independent entries of small motions.

Rows ``J z = 0`` divide z into leading (independent) entries p and following ones, ``z = N p``, with ones in N for p.
Joint coordinates are preferred as following ones to elastic coordinates.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg

from kanefe.frames import Matrix, Vector
from kanefe.tree.row_groups import groups_of_rows
from kanefe.tree.row_rates import RANK_TOLERANCE, ROUND_OFF, Rates

WELL_CONDITIONED = 1e-2
"""Pivot relative to the largest above which only joint coordinates are taken as following."""

RANK = 1e-6
"""Pivot of scaled rows, relative to the largest, below which a row depends on others: round-off is about 1e-12."""

LEAST = (RANK_TOLERANCE * ROUND_OFF) ** 0.5
"""Pivot of scaled rows (length 1 of one that its speeds can move) below which it is round-off, however small the others
are, as for a run: all rows of a second hinge on the axis of the first are about 1e-16."""


@dataclass(frozen=True, eq=False)
class Independent:
    """Leading and following entries of a small motion.

    Attributes
    ----------
    leading, following : ndarray of int
    N : ndarray, shape (n, leading)
        Maps the leading entries to all entries.
    inverse : ndarray, shape (following, rows)
        Pseudo-inverse of J over the following entries.
    """

    leading: np.ndarray
    following: np.ndarray
    N: Matrix
    inverse: Matrix

    def followed(self, remainder: Matrix) -> Matrix:
        """Return the motions (n, k) with zero leading entries and ``J x + remainder = 0``, with remainder (rows, k)."""
        x = np.zeros((len(self.N), remainder.shape[1]))
        x[self.following] = -self.inverse @ remainder
        return x


def all_of(n: int) -> Independent:
    """Return n entries that all lead: there are no rows."""
    return Independent(np.arange(n), np.zeros(0, dtype=int), np.eye(n), np.zeros((0, 0)))


def independent(
    rates: Rates, masses: Vector, joints: np.ndarray, given: np.ndarray, before: np.ndarray | None = None
) -> Independent:
    """Choose leading and following entries, in each group of loops by itself: see `groups_of_rows`.

    Parameters
    ----------
    rates : Rates
        J (rows, n) and the sizes of its entries.
    masses : ndarray, shape (n,)
        Diagonal of the mass matrix, which makes columns with different units comparable.
    joints, given : ndarray of bool, shape (n,)
        Entries of joints, and entries that always lead: drives.
    before : ndarray of int, optional
        Entries that follow in any case.
    """
    J, n = rates.J, rates.J.shape[1]
    if not len(J):
        return all_of(n)
    weights = 1.0 / np.sqrt(np.where(masses > 0.0, masses, 1.0))
    sizes = np.sqrt((rates.reach * weights**2).sum(axis=1))
    sizes = np.where(sizes > 0.0, sizes, 1.0)
    scaled = J * weights / sizes[:, None]
    largest = float(np.abs(scaled).max(initial=0.0))
    follows = np.zeros(n, dtype=bool)
    if before is not None:
        follows[before] = True
    groups = groups_of_rows(J)
    for rows in groups:
        columns = np.flatnonzero(J[rows].any(axis=0))
        if len(columns):
            follows[columns] |= _following(
                scaled[np.ix_(rows, columns)], follows[columns], joints[columns], given[columns], largest
            )
    leading, following = np.flatnonzero(~follows), np.flatnonzero(follows)
    place, inverse = np.cumsum(follows) - 1, np.zeros((len(following), len(J)))
    N = np.zeros((n, len(leading)))
    N[leading, range(len(leading))] = 1.0
    for rows in groups:
        columns = J[rows].any(axis=0)
        own = np.flatnonzero(columns & follows)
        if len(own):
            own_inverse = np.linalg.pinv(scaled[np.ix_(rows, own)], rcond=1e-12) / sizes[rows]
            inverse[np.ix_(place[own], rows)] = weights[own, None] * own_inverse
            led = np.flatnonzero(columns & ~follows)
            N[np.ix_(own, led - np.searchsorted(following, led))] = (
                -inverse[np.ix_(place[own], rows)] @ J[np.ix_(rows, led)]
            )
    return Independent(leading, following, N, inverse)


def _following(scaled: Matrix, before: np.ndarray, joints: np.ndarray, given: np.ndarray, largest: float) -> np.ndarray:
    """Return which columns of a group of rows follow, as a mask, with those that follow before."""
    follows = before.copy()
    for candidates, tolerance in ((joints & ~given, WELL_CONDITIONED), (~given, RANK)):
        columns = np.flatnonzero(candidates & ~follows)
        if not len(columns):
            continue
        rest = scaled[:, columns]
        if follows.any():
            basis = scipy.linalg.orth(scaled[:, follows])
            rest = rest - basis @ (basis.T @ rest)
        _, triangle, order = scipy.linalg.qr(rest, mode="economic", pivoting=True)
        pivots = np.abs(np.diag(triangle))
        follows[columns[order[: np.count_nonzero(pivots > max(tolerance * largest, LEAST))]]] = True
    return follows
