"""Rows of constraints on speeds: their rates, and from where on they count."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kanefe.frames import Matrix, Vector

PIVOT_TOLERANCE = 1e-13
"""Pivot relative to the entry of M that it comes from up to which it is round-off and not inertia."""

RANK_TOLERANCE = 1e-10
"""Smallest eigenvalue of ``J M^-1 J^T``, with rows scaled by their lever arms and relative to the largest, that counts.
Round-off leaves about 1e-15 for a dependent row. A position at which the rank drops can be reached to the root of
round-off only, and the eigenvalue grows with the square of the distance from it: below 1e-10 the direction is too
inaccurate to divide by it."""

ROUND_OFF = 1e-16
"""Smallest value of the largest eigenvalue to which the tolerance is relative. Rows that no speed can move are the
square of round-off in all their entries, about 1e-31 where 1 is the largest, and must not be measured by each other."""


class Rates(NamedTuple):
    """Constraints on the rates of the speeds: ``J du + remainder = 0``, all rows that hold.

    Attributes
    ----------
    J : ndarray, shape (rows, columns)
        Partial derivatives of dg/dt by the speeds.
    remainder : ndarray, shape (rows,)
    reach : ndarray, shape (rows, columns)
        Squares of what the entries of J could be if the row pointed along the motion of its ends: what makes a row
        small.
    given : ndarray, shape (rows,)
        Part of dg/dt that is no speed's: of belts.
    """

    J: Matrix
    remainder: Vector
    reach: Matrix
    given: Vector

    def over(self, columns: slice | np.ndarray, rows: slice | np.ndarray = slice(None)) -> Rates:
        """Return the rows, all or some, over some of the speeds."""
        J, reach = self.J[rows], self.reach[rows]
        return Rates(J[:, columns], self.remainder[rows], reach[:, columns], self.given[rows])

    def open_rates(self, full: Vector) -> Vector:
        """Return dg/dt at the speeds of a state."""
        return np.asarray(self.J @ full[: self.J.shape[1]] + self.given)

    def sizes(self, u: Vector) -> Vector:
        """Return how large dg/dt could be at speeds of such size: ``J u`` of a row that nothing moves is round-off."""
        return np.asarray(np.sqrt(self.reach) @ np.abs(u))
