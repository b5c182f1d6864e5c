"""Tables of the ways of rows of constraints: the joints and modes between their ends and N, and who meets whom there."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kanefe.kernels.compiler.arrays import IntegerRows, Integers

# Columns of the visits: the row of the scene, and where the numbers of its joint and of its modes are; -1: none
VISITED, OF_JOINT, OF_MODES = range(3)
VISIT_INTEGERS = 3
# Columns of the meetings: the constraint and its visit
ROW_OF_LOOPS, VISIT = range(2)
# Numbers of a joint at a visit, by its coordinates: see `kanefe.kernels.constraints.loop_system.JOINT`
OF_AXIS, OF_BALL, OF_FREE = 1, 6, 12


class RowPaths(NamedTuple):
    """What the rows of constraints visit on their way to N, of both ends; and the order of their elimination.

    Attributes
    ----------
    first : ndarray of int, shape (m + 1,)
        First visit of each row.
    common : ndarray of int, shape (m,)
        First visit of a row of the scene that carries both ends.
    visits : ndarray of int, shape (visits, VISIT_INTEGERS)
        Children before parents. Of an interface that carries something: where its wrench is among the numbers of the
        modes.
    met_first : ndarray of int, shape (rows of the scene + 1,)
        First meeting at each row of the scene.
    met : ndarray of int, shape (meetings, 2)
        The constraints that visit a row of the scene with something that moves, in the order of elimination.
    order, place : ndarray of int, shape (m,)
        The row that is eliminated at each place, and the place of each row.
    ends : ndarray of int, shape (m + 1,)
        The envelope: see `kanefe.kernels.algebra.envelope`.
    sizes : ndarray of int, shape (1,)
        How many numbers all visits have.
    """

    first: Integers
    common: Integers
    visits: IntegerRows
    met_first: Integers
    met: IntegerRows
    order: Integers
    place: Integers
    ends: Integers
    sizes: Integers


def no_paths() -> RowPaths:
    """Return the tables of a scene without constraints."""
    none, one = np.zeros(0, dtype=np.int64), np.zeros(1, dtype=np.int64)
    visits, met = np.zeros((0, VISIT_INTEGERS), dtype=np.int64), np.zeros((0, 2), dtype=np.int64)
    return RowPaths(one, none, visits, one, met, none, none, one, one)
