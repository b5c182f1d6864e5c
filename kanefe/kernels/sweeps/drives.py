"""Driven coordinates at a time: piecewise cubic motions, and compiled functions of the user."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kanefe.kernels.compiler._numba import kernel
from kanefe.kernels.compiler.arrays import Filler, IntegerRows, RealRows

# Columns of the integers of a motion
FIRST_PIECE, PIECE_COUNT = range(2)
# Columns of a piece: when it starts (s), the coefficients of the powers of the time since, and the longest step from
# there (s)
SINCE, POWERS, LONGEST = 0, 1, 5
PIECE_NUMBERS = 6


class Drives(NamedTuple):
    """The motions of all driven coordinates; of none, where one of them is a Python function.

    Attributes
    ----------
    motions : ndarray of int, shape (driven, 2)
        First piece and number of pieces; none of what `given` writes.
    pieces : ndarray, shape (pieces, PIECE_NUMBERS)
    spans : ndarray, shape (driven, 2)
        Between which times each motion is known, s.
    given : function (t, values, values)
        Writes what functions of the user give into the values of all drives, see
        `kanefe.kernels.compiler.filling.filler`.
    """

    motions: IntegerRows
    pieces: RealRows
    spans: RealRows
    given: Filler


@kernel
def put_drives(motions: Drives, t: float, drives: np.ndarray) -> float:
    """Write position, speed and acceleration of all driven coordinates, (driven, 3); NaN where they are not known.

    Returns
    -------
    longest : float
        Step from this time, s, beyond which a table would be looked at less often than it needs.
    """
    values = drives.reshape(-1)
    motions.given(t, values, values)
    longest = np.inf
    for i in range(len(motions.motions)):
        if not motions.spans[i, 0] <= t <= motions.spans[i, 1]:
            drives[i, 0] = drives[i, 1] = drives[i, 2] = np.nan
            continue
        low, count = motions.motions[i, FIRST_PIECE], motions.motions[i, PIECE_COUNT]
        if count == 0:
            continue
        high = low + count
        while high - low > 1:
            middle = (low + high) // 2
            if motions.pieces[middle, SINCE] <= t:
                low = middle
            else:
                high = middle
        s, c = t - motions.pieces[low, SINCE], motions.pieces[low, POWERS:LONGEST]
        drives[i, 0] = ((c[3] * s + c[2]) * s + c[1]) * s + c[0]
        drives[i, 1] = (3.0 * c[3] * s + 2.0 * c[2]) * s + c[1]
        drives[i, 2] = 6.0 * c[3] * s + 2.0 * c[2]
        longest = min(longest, motions.pieces[low, LONGEST] - s)
    return longest
