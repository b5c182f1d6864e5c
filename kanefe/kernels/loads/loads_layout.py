"""Where everything is in the tables of loads between frames, and in the workspace of one evaluation of them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kanefe.kernels.compiler._numba import inlined
from kanefe.kernels.compiler.arrays import IntegerRows, Integers, RealRows, Reals
from kanefe.kernels.force_elements.places import END_NUMBERS, WRENCH, WRENCHES
from kanefe.kernels.loads.markers import MARKER_NUMBERS
from kanefe.kernels.loads.reach import Reach, no_reach

# Columns of the integers of a load
(
    FIRST_END,
    END_COUNT,
    FIRST_NUMBER,
    INPUT,
    FIRST_STATE,
    STATE_COUNT,
    TEAM,
    FIRST_POINT,
    POINT_COUNT,
    POINT_END,
) = range(10)
LOAD_INTEGERS = 10
REAL, COMPLEX = range(2)
# The same in tables of loads that are watched
LOOKS, CHANGES = range(2)
# Of the workspace: all of it, that of `find_near`, and that of points
WHOLE, NEAR, OF_POINTS = range(3)

COORDINATE, A_POINT = -2, -3
"""Values in place of the link of an end: it is a joint coordinate; it is a point of a group."""
POINT_NUMBERS = 21
"""Number of values in the workspace of a point: motion (6) and its rates (6), those of all points first, and the
rotation by slopes (9)."""
AT, SPEED = range(2)
"""Columns of the marker of a joint coordinate: its index in q (-1 - drive if it is driven), and that of its speed."""


class LoadsBetween(NamedTuple):
    """Loads between frames of a scene.

    Attributes
    ----------
    loads : ndarray of int, shape (n, LOAD_INTEGERS)
        First end and number of ends, first of its numbers, first input, first internal state and number of states,
        team (-1: none), first point in it, number of points and the end that is the first of them.
    addresses : ndarray of int, shape (n, 2)
        Of its function for real and for complex numbers.
    rows : ndarray of int, shape (ends,)
        Row of each end (-1: N, COORDINATE, A_POINT).
    markers : ndarray, shape (ends, MARKER_NUMBERS)
    numbers : ndarray
        Constants of all loads.
    decay_rates, decay_energies : ndarray, shape (states,)
        Of states of loads that cannot act: l of ``dz/dt = -l z``, and e of an energy ``e z^2``.
    reach : Reach
        Where loads can act.
    workspace_size : ndarray of int, shape (3,)
        How many numbers the workspace of loads has, that of `find_near` at its beginning, and that of points after it.
    bearings : ndarray of int, shape (k, 3)
        Of loads that follow the reaction of a joint: number of the load, row of the joint's body, and whether moments
        count.
    bearing_places : ndarray, shape (k, 6)
        Origin of that body's frame, and the axis of the joint, in axes of the row.
    """

    loads: IntegerRows
    addresses: IntegerRows
    rows: Integers
    markers: RealRows
    numbers: Reals
    decay_rates: Reals
    decay_energies: Reals
    reach: Reach
    workspace_size: Integers
    bearings: IntegerRows
    bearing_places: RealRows


def no_loads_between() -> LoadsBetween:
    """Return the tables of a scene without such loads."""
    none = np.zeros((0, LOAD_INTEGERS), dtype=np.int64), np.zeros((0, 2), dtype=np.int64), np.zeros(0, dtype=np.int64)
    numbers = np.zeros((0, MARKER_NUMBERS)), np.zeros(0), np.zeros(0), np.zeros(0)
    bearings = np.zeros((0, 3), dtype=np.int64), np.zeros((0, 6))
    return LoadsBetween(*none, *numbers, no_reach(), np.zeros(3, dtype=np.int64), *bearings)


def load_workspace_size(ends: int, states: int) -> int:
    """Return how many numbers the workspace of a load with so many ends and internal states has."""
    return ends * (END_NUMBERS + WRENCH) + WRENCHES + states


@inlined
def place_of_load(between: LoadsBetween) -> int:
    """Return where the ends of a load, and then what it does, are in the workspace."""
    return between.workspace_size[NEAR] + between.workspace_size[OF_POINTS]


@inlined
def span_of_load(between: LoadsBetween, n: int) -> slice:
    """Return where a load writes: see `kanefe.kernels.force_elements.places`."""
    count = between.loads[n, END_COUNT]
    at = place_of_load(between) + END_NUMBERS * count
    return slice(at, at + WRENCHES + WRENCH * count + between.loads[n, STATE_COUNT])
