"""Tables of the ways of rows of constraints: the joints and modes between their ends and what carries both."""

from __future__ import annotations

import numpy as np

from kanefe.kernels.tables import RowPaths

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


def no_paths() -> RowPaths:
    """Return the tables of a scene without constraints."""
    none, one = np.zeros(0, dtype=np.int64), np.zeros(1, dtype=np.int64)
    visits, met = np.zeros((0, VISIT_INTEGERS), dtype=np.int64), np.zeros((1, MEETING_INTEGERS), dtype=np.int64)
    return RowPaths(one, none, visits, none, none, none, none, met, np.zeros((0, 2), dtype=np.int64), one, none, one)
