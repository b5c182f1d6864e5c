"""Tables of the ways of rows of constraints: the joints and modes between their ends and what carries both."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kanefe.kernels.compiler.arrays import IntegerRows, Integers

# Columns of the visits: the row of the scene, and where the numbers of its joint, of its modes and of the wrench on it
# are; -1: none. Of an interface that carries something: where its wrench is among the numbers of the modes. The row at
# which the way ends has neither joint nor wrench.
VISITED, OF_JOINT, OF_MODES, OF_WRENCH = range(4)
VISIT_INTEGERS = 4
# Columns of the meetings: the row of the scene, whether it is its modes that are shared, and the first guest
MET_AT, IS_MODES, FIRST_GUEST = range(3)
MEETING_INTEGERS = 3
# Columns of their guests: the row of constraints, and its visit
GUEST, GUEST_VISIT = range(2)
# Numbers of a joint at a visit, by its coordinates
OF_AXIS, OF_BALL, OF_FREE = 1, 3, 6


class RowPaths(NamedTuple):
    """What the rows of constraints visit on their way from both ends to the row that holds them together.

    Rows of constraints that have a joint or modes in common are eliminated together, at the row of the scene that
    carries all that they visit; at -1, in N, those that reach it.

    Attributes
    ----------
    first : ndarray of int, shape (m + 1,)
        First visit of each row of constraints.
    common : ndarray of int, shape (m,)
        First of its visits to what carries both its ends.
    visits : ndarray of int, shape (visits, VISIT_INTEGERS)
        Children before parents.
    order, place : ndarray of int, shape (m,)
        The row of constraints that is eliminated at each place, and the place of each.
    places, meetings_at : ndarray of int, shape (rows of the scene + 2,)
        First place, and first meeting, of what is eliminated at each row of the scene, from N on.
    meetings : ndarray of int, shape (meetings + 1, MEETING_INTEGERS)
        Where rows of constraints meet.
    guests : ndarray of int, shape (guests, 2)
        In the order of elimination.
    ends, blocks : ndarray of int, shapes (m + 1,), (m,)
        The envelope: see `kanefe.kernels.algebra.envelope`.
    sizes : ndarray of int, shape (1,)
        How many numbers all visits have.
    """

    first: Integers
    common: Integers
    visits: IntegerRows
    order: Integers
    place: Integers
    places: Integers
    meetings_at: Integers
    meetings: IntegerRows
    guests: IntegerRows
    ends: Integers
    blocks: Integers
    sizes: Integers


def no_paths() -> RowPaths:
    """Return the tables of a scene without constraints."""
    none, one = np.zeros(0, dtype=np.int64), np.zeros(1, dtype=np.int64)
    visits, met = np.zeros((0, VISIT_INTEGERS), dtype=np.int64), np.zeros((1, MEETING_INTEGERS), dtype=np.int64)
    return RowPaths(one, none, visits, none, none, none, none, met, np.zeros((0, 2), dtype=np.int64), one, none, one)
