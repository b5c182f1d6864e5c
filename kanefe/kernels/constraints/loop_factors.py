"""Memory of how loops hold the tree at one configuration."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kanefe.kernels.algebra.envelope import Envelope
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.constraints.loop_tables import RowWrenches, wrenches_in, wrenches_size
from kanefe.kernels.tables import Loops

TURN = 3
"""Place of the second vector of a wrench, and of the accelerations of a free joint."""

WRENCH = 6

FORCE_AT_END, MOMENT_AT_END, LEVER, CARRIED_NUMBERS = 6, 9, 12, 15
"""Places of what a wrench is before joints give way to it, and how many numbers there are of it."""


class LoopFactors(NamedTuple):
    """How loops hold the tree at one configuration, without rubbing contacts.

    Attributes
    ----------
    exerted : RowWrenches
    numbers : ndarray
        Of all visits, see `kanefe.kernels.constraints.row_visits.put_visits`.
    system : Envelope
        ``J M^-1 J^T``; a scaled row is of unit length if its wrench points along all motions on its way (scale 0: it
        moves nothing, or does not hold).
    rest, right : ndarray, shapes (m,), (m, 1)
        Acceleration that each row needs; workspace.
    felt, asked : ndarray, shape (m, WRENCH)
        What the row of the scene that carries the loops feels of a unit multiplier, and the multipliers that its unit
        accelerations ask for.
    carried : ndarray, shape (rows of the scene, CARRIED_NUMBERS)
        Wrenches on their way; force and moment at their end, and the lever to it.
    """

    exerted: RowWrenches
    numbers: np.ndarray
    system: Envelope
    rest: np.ndarray
    right: np.ndarray
    felt: np.ndarray
    asked: np.ndarray
    carried: np.ndarray


@kernel
def factors_size(loops: Loops) -> int:
    """Return how many numbers the workspace of `loop_factors_in` has."""
    m, paths = len(loops.rows), loops.paths
    rows = max(0, len(paths.places) - 2)
    return wrenches_size(loops) + paths.sizes[0] + 2 * paths.ends[m] + (7 + 2 * WRENCH) * m + CARRIED_NUMBERS * rows


@inlined
def loop_factors_in(workspace: np.ndarray, loops: Loops) -> LoopFactors:
    """Return the parts of a workspace of `factors_size`."""
    m, rows = len(loops.rows), max(0, len(loops.paths.places) - 2)
    envelope, size = loops.paths.ends[m], loops.paths.sizes[0]
    rest = workspace[wrenches_size(loops) :]
    numbers, rest = rest[:size], rest[size:]
    A, L, rest = rest[:envelope], rest[envelope : 2 * envelope], rest[2 * envelope :]
    of_rows, sixes, carried = rest[: 7 * m], rest[7 * m : (7 + 2 * WRENCH) * m], rest[(7 + 2 * WRENCH) * m :]
    felt_and_asked = sixes.reshape(2 * m, WRENCH)
    return LoopFactors(
        wrenches_in(workspace, loops),
        numbers,
        Envelope(
            loops.paths.ends,
            loops.paths.blocks,
            loops.paths.order,
            loops.paths.place,
            A,
            L,
            of_rows[:m],
            of_rows[m : 2 * m],
            of_rows[2 * m : 3 * m],
            of_rows[3 * m : 4 * m],
            of_rows[4 * m : 5 * m],
        ),
        of_rows[5 * m : 6 * m],
        of_rows[6 * m :].reshape(m, 1),
        felt_and_asked[:m],
        felt_and_asked[m:],
        carried[: CARRIED_NUMBERS * rows].reshape(rows, CARRIED_NUMBERS),
    )


@inlined
def modes_size(k: int, carried: int) -> int:
    """Return how many numbers a visit has of k modes of a body that carries something at some interfaces."""
    return 2 * k + 3 * WRENCH * carried
