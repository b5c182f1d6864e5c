"""Rows of loop joints, couplers and contact points: their tables, and the memory of what is found of them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.constraints.constraint_rows import CONTACT_ROW, ROW_NUMBERS
from kanefe.kernels.constraints.row_paths import no_paths
from kanefe.kernels.constraints.tolerances import HALF_ON
from kanefe.kernels.contact.rigid_points import HAS_FRICTION, MET_NUMBERS, SLIPS_FROM, is_slipping, no_rigid_points
from kanefe.kernels.loads.markers import MARKER_NUMBERS
from kanefe.kernels.tables import Loops

# Columns of the integers of a row
KIND_OF, ROW_A, ROW_B, IS_BALL, FIRST_TERM, TERM_COUNT, HOLDS_PLACE, IS_ANGLE, SWITCH, GOES_ON = range(10)
CONSTRAINT_INTEGERS = 10
# Of a row of a contact point in place of them: which of its directions, 0: the normal, and the number of the point
DIRECTION, POINT = IS_BALL, FIRST_TERM
# Columns of the workspace of a row
FORCE_A, MOMENT_A, FORCE_B, MOMENT_B = 0, 3, 6, 9
WRENCHES = 12
# Places of the limits of a scene
RANK_TOLERANCE, LENGTH = range(2)
# What is told of the rows that `share_forces` had in the last evaluation: how many hold (-1: it had none), their rank
LIVE, RANK = range(2)
# Square of the share of its reach below which a row moves nothing: below the square of round-off, 1e-31, for all rows
LEAST_SHARE = 1e-29


def no_loops() -> Loops:
    """Return the tables of a scene without constraints."""
    integers, numbers = np.zeros(0, dtype=np.int64), np.zeros(0)
    rows, markers = np.zeros((0, CONSTRAINT_INTEGERS), dtype=np.int64), np.zeros((0, MARKER_NUMBERS))
    couplers = np.zeros((0, ROW_NUMBERS)), integers, numbers, integers, numbers, numbers
    return Loops(rows, markers, *couplers, np.zeros(2), no_rigid_points(), no_paths())


class RowWrenches(NamedTuple):
    """What rows exert at one configuration.

    Attributes
    ----------
    wrenches : ndarray, shape (m, WRENCHES)
        Of each row's unit multiplier, about the origins of its rows.
    met : ndarray, shape (points, MET_NUMBERS)
        Of the points of rigid contacts.
    remainders : ndarray, shape (m,)
        Accelerations along the rows that are not linear in du.
    """

    wrenches: np.ndarray
    met: np.ndarray
    remainders: np.ndarray


@kernel
def wrenches_size(loops: Loops) -> int:
    """Return how many numbers the memory of `wrenches_in` has."""
    return (WRENCHES + 1) * len(loops.rows) + MET_NUMBERS * len(loops.points.places)


@inlined
def wrenches_in(memory: np.ndarray, loops: Loops) -> RowWrenches:
    """Return the parts of a memory of `wrenches_size`."""
    m, points = len(loops.rows), len(loops.points.places)
    at, size = WRENCHES * m, wrenches_size(loops)
    met = memory[at : size - m].reshape(points, MET_NUMBERS)
    return RowWrenches(memory[:at].reshape(m, WRENCHES), met, memory[size - m : size])


class UnitResponses(NamedTuple):
    """What the constraints do to the speeds at one configuration, row by row.

    Attributes
    ----------
    exerted : RowWrenches
    unit_responses : ndarray, shape (m, n)
        Accelerations that they cause, and driving forces.
    A : ndarray, shape (m, m)
        Lower triangle of ``J M^-1 J^T``; where contacts rub, all of ``J M^-1 P^T``.
    L, inverses, order : ndarray, shapes (m, m), (m,), (m,)
        Its factors, see `kanefe.kernels.algebra.pivoted` and `kanefe.kernels.algebra.least_norm`.
    scale : ndarray, shape (m,)
        With which a row is of unit length if it points along the motion of its ends; 0: it moves nothing, or does not
        hold.
    rest, column : ndarray, shape (m,)
    J : ndarray, shape (m, n)
        The rows themselves.
    reach : ndarray, shape (n,)
        Workspace.
    plain : ndarray, shape (m,)
        Of rows of contacts: what the normal force alone would do along the row.
    live, spare : ndarray, shape (m,)
        Rows that hold where points touch; workspace.
    told : ndarray, shape (2,)
    """

    exerted: RowWrenches
    unit_responses: np.ndarray
    A: np.ndarray
    L: np.ndarray
    inverses: np.ndarray
    order: np.ndarray
    scale: np.ndarray
    rest: np.ndarray
    column: np.ndarray
    J: np.ndarray
    reach: np.ndarray
    plain: np.ndarray
    live: np.ndarray
    spare: np.ndarray
    told: np.ndarray


@kernel
def unit_responses_size(loops: Loops, n: int) -> int:
    """Return how many numbers the workspace of `unit_responses_in` has, with n free and driven speeds."""
    m = len(loops.rows)
    return wrenches_size(loops) + m * (2 * n + 2 * m + 8) + n + 2


@inlined
def unit_responses_in(workspace: np.ndarray, loops: Loops, n: int) -> UnitResponses:
    """Return the parts of a workspace of `unit_responses_size`."""
    m, at = len(loops.rows), wrenches_size(loops)
    unit_responses = workspace[at : at + m * n].reshape(m, n)
    at += m * n
    A = workspace[at : at + m * m].reshape(m, m)
    at += m * m
    L = workspace[at : at + m * m].reshape(m, m)
    at += m * m
    J = workspace[at : at + m * n].reshape(m, n)
    rest = workspace[at + m * n :]
    return UnitResponses(
        wrenches_in(workspace, loops),
        unit_responses,
        A,
        L,
        rest[:m],
        rest[m : 2 * m],
        rest[2 * m : 3 * m],
        rest[3 * m : 4 * m],
        rest[4 * m : 5 * m],
        J,
        rest[8 * m : 8 * m + n],
        rest[5 * m : 6 * m],
        rest[6 * m : 7 * m],
        rest[7 * m : 8 * m],
        rest[8 * m + n : 8 * m + n + 2],
    )


@inlined
def holds(loops: Loops, j: int, z: np.ndarray) -> bool:
    """Return whether a row holds with internal states z."""
    switch = loops.rows[j, SWITCH]
    if switch < 0:
        return True
    if loops.rows[j, KIND_OF] == CONTACT_ROW and loops.rows[j, DIRECTION] > 0 and z[switch].real > SLIPS_FROM:
        return False
    return z[switch].real > HALF_ON


@inlined
def has_loops(loops: Loops, kept: UnitResponses) -> bool:
    """Return whether rows of constraints hold, and not those of contacts alone."""
    found = False
    for j in range(len(loops.rows)):
        found = found or (kept.scale[j] != 0.0 and loops.rows[j, KIND_OF] != CONTACT_ROW)
    return found


@inlined
def is_rubbing(loops: Loops, j: int, z: np.ndarray) -> bool:
    """Return whether a row is the normal row of a point that slips with friction."""
    if loops.rows[j, KIND_OF] != CONTACT_ROW or loops.rows[j, DIRECTION] > 0:
        return False
    p = loops.rows[j, POINT]
    return is_slipping(loops.points, p, z) and loops.points.places[p, HAS_FRICTION] != 0
