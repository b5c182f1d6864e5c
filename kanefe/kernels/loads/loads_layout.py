"""Where everything is in the tables of loads between frames, and in the workspace of one evaluation of them."""

from __future__ import annotations

import numpy as np

from kanefe.kernels.compiler._numba import inlined
from kanefe.kernels.force_elements.places import END_NUMBERS, WRENCH, WRENCHES
from kanefe.kernels.loads.markers import MARKER_NUMBERS
from kanefe.kernels.loads.reach import no_reach
from kanefe.kernels.tables import LoadsBetween

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
