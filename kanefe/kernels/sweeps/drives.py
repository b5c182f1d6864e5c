"""Driven coordinates at a time: piecewise cubic motions, and compiled functions of the user."""

from typing import Annotated, NamedTuple

import numpy as np

from kanefe.kernels.compiler.arrays import Filler
from kanefe.kernels.language import Columns, IntegerRows, RealRows, Record, Rows, kernel


class DrivenMotion(Record, is_frozen=True):
    """A motion: its first piece, and how many it has; none of what `Drives.given` writes."""

    first: int
    count: int


class Piece(Record):
    """A piece of a motion: when it starts (s), powers of the time since, and the longest step from there (s)."""

    since: float
    powers: Annotated[np.ndarray, Columns(4)]
    longest: float


DrivenMotions = Rows[DrivenMotion]
Pieces = Rows[Piece]


class Drives(NamedTuple):
    """The motions of all driven coordinates; of none, where one of them is a Python function.

    Attributes
    ----------
    motions : ndarray of int
        `DrivenMotions`.
    pieces : ndarray
        `Pieces`.
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
    values, all_motions, pieces = drives.reshape(-1), DrivenMotions(motions.motions), Pieces(motions.pieces)
    motions.given(t, values, values)
    longest = np.inf
    for i in range(len(all_motions)):
        if not motions.spans[i, 0] <= t <= motions.spans[i, 1]:
            drives[i, 0] = drives[i, 1] = drives[i, 2] = np.nan
            continue
        low, count = all_motions[i].first, all_motions[i].count
        if count == 0:
            continue
        high = low + count
        while high - low > 1:
            middle = (low + high) // 2
            if pieces[middle].since <= t:
                low = middle
            else:
                high = middle
        s, c = t - pieces[low].since, pieces[low].powers
        drives[i, 0] = ((c[3] * s + c[2]) * s + c[1]) * s + c[0]
        drives[i, 1] = (3.0 * c[3] * s + 2.0 * c[2]) * s + c[1]
        drives[i, 2] = 6.0 * c[3] * s + 2.0 * c[2]
        longest = min(longest, pieces[low].longest - s)
    return longest
