"""Memory of what happens to rigid contacts at an event: the scene at a moment, and what is decided there."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kanefe.kernels.compiler._numba import kernel
from kanefe.kernels.compiler.arrays import IntegerRows, Prepared, RealBlocks, RealRows, Reals
from kanefe.kernels.compiler.calls import call_address
from kanefe.kernels.contact.rigid_points import MET_NUMBERS
from kanefe.kernels.impacts.cones import (
    AHEAD_OF_IT,
    CONTACTS,
    IS_SOLVED,
    IS_WARM,
    ROW_OF_FORCES,
    ConeMemory,
    cones_of,
)
from kanefe.kernels.impacts.stronge import TURNING_NUMBERS, TURNING_ROWS
from kanefe.kernels.tables import RigidPoints

OPEN, STICKS, SLIPS = range(3)
"""Status of a point: see `kanefe.contact.contact`."""

ON_GAP, ON_NORMAL, ON_SLIP, ON_LEFT = range(4)
"""Columns of the margins of points: of gaps, normal forces, friction that is left, and slips."""


class Asking(NamedTuple):
    """Whom the decision asks of the scene.

    Attributes
    ----------
    points : RigidPoints
    looking, solving : Prepared
        Calls of `kanefe.kernels.impacts.moments.look_at_points` and `kanefe.kernels.impacts.cones.solve_one`.
    wanted : ndarray, shape (5,)
        Of the latter.
    first_state : int
        Where in a state the internal states begin; the free speeds are before them.
    """

    points: RigidPoints
    looking: Prepared
    solving: Prepared
    wanted: Reals
    first_state: int


class Moment(NamedTuple):
    """All points at a moment, as if all of them were open.

    Attributes
    ----------
    met : ndarray, shape (points, MET_NUMBERS)
    axes : ndarray, shape (points, 9)
        Of their surfaces, from them to N.
    G : ndarray, shape (3 points, 3 points)
        What unit forces at points do to their rates, loops held.
    b : ndarray, shape (3 points,)
        Accelerations without them.
    responses : ndarray, shape (3 points, free)
        Accelerations of the free speeds that unit forces add.
    sizes : ndarray, shape (points,)
        Sum of the speeds with which a point moves by each of the speeds of the scene, m/s.
    accelerated : ndarray, shape (points,)
        Sum of the accelerations that it has by each of them while all hold, m/s2.
    """

    met: RealRows
    axes: RealRows
    G: RealRows
    b: Reals
    responses: RealRows
    sizes: Reals
    accelerated: Reals


TAKES, ACTIVE, BEFORE, AFTER, IS_TAKING, IS_CONCERNED, IS_LIFTED, IS_STRUCK, IS_CLOSED, BEGINS, IS_NEW = range(11)
GROUP, TOLD_OF_POISSON, TOLD_OF_ORDER = range(11, 14)
"""Rows of `Decision.flags`: numbers of the points that take part, and of those of them that are closed, in order;
status before and after; whether a point takes part, is one that the event concerns, is let go by it, was struck, is
closed; whether an active one begins to slip, in this event and in this round; the least point of those whose impulses
move each other; whether the impact of a point was Poisson's, and depends on the order of several."""
FLAGS = 14

NOT_MOVING, AT_REST_BELOW, SLOW = range(3)
"""Rows of `Decision.speeds`: below which a point does not move along the normal, does not slip, and slips in the
direction of the friction that would hold it, m/s."""

RATES_OF_POINTS, ACCELERATIONS, FORCES, X, OTHER = range(5)
"""Rows of `Decision.vectors`: of all points; and forces of the active ones."""

SLIP_OF, FOUND, TURNING = range(3)
"""Rows of `Decision.directions`: of slips; in which active points begin to slip; and, in axes of the surface, the rates
of those of slips that begin, 1/s."""

LOOK, AT_TIME, COUNT, IS_KNOWN = range(4)
"""Numbers of `Decision.question`: what is looked at, when (s), with how many points; and whether that is known."""
MARGINS_NOW, POINTS_NOW, POINTS_LATER, FREE_ACCELERATIONS = range(4)


class Decision(NamedTuple):
    """What is decided at an event.

    Attributes
    ----------
    now, later : Moment
        At the event, and a little after it.
    problem, ahead : ConeMemory
        Of the forces then.
    flags : ndarray of int, shape (FLAGS, points)
    margins : ndarray, shape (points, 4)
        Distances from possible events; infinite of others.
    speeds : ndarray, shape (3, points)
    vectors : ndarray, shape (5, 3 points)
    directions : ndarray, shape (3, points, 3)
    motion : ndarray, shape (2, free)
        Accelerations without contacts, and a step along the speeds.
    state : ndarray, shape (state,)
        A little after the event.
    question : ndarray, shape (4,)
    turning : ndarray, shape (TURNING_ROWS, TURNING_NUMBERS)
        Memory of an impact of one point.
    """

    now: Moment
    later: Moment
    problem: ConeMemory
    ahead: ConeMemory
    flags: IntegerRows
    margins: RealRows
    speeds: RealRows
    vectors: RealRows
    directions: RealBlocks
    motion: RealRows
    state: Reals
    question: Reals
    turning: RealRows


def decision_of(points: int, free: int, size: int) -> Decision:
    """Return the memory for a scene with so many points and free speeds, and states of a size."""
    n = 3 * points

    def moment() -> Moment:
        met, axes = np.zeros((points, MET_NUMBERS)), np.zeros((points, 9))
        return Moment(met, axes, np.zeros((n, n)), np.zeros(n), np.zeros((n, free)), *np.zeros((2, points)))

    return Decision(
        now=moment(),
        later=moment(),
        problem=cones_of(points),
        ahead=cones_of(points),
        flags=np.zeros((FLAGS, points), dtype=np.int64),
        margins=np.zeros((points, 4)),
        speeds=np.zeros((3, points)),
        vectors=np.zeros((5, n)),
        directions=np.zeros((3, points, 3)),
        motion=np.zeros((2, free)),
        state=np.zeros(size),
        question=np.zeros(4),
        turning=np.zeros((TURNING_ROWS, TURNING_NUMBERS)),
    )


@kernel
def look(asking: Asking, decision: Decision, what: int, t: float, count: int) -> bool:
    """Have something of the scene written to the decision; return whether it is known."""
    question = decision.question
    question[LOOK], question[AT_TIME], question[COUNT] = what, t, count
    call_address(asking.looking.address, (asking.looking.places, asking.looking.numbers))
    return question[IS_KNOWN] != 0.0


@kernel
def solve(asking: Asking, is_ahead: bool, k: int, row: int, is_warm: bool) -> bool:
    """Write the forces of k active points to a row of vectors; return whether there are some."""
    wanted = asking.wanted
    wanted[AHEAD_OF_IT], wanted[IS_WARM] = 1.0 if is_ahead else 0.0, 1.0 if is_warm else 0.0
    wanted[CONTACTS], wanted[ROW_OF_FORCES] = k, row
    call_address(asking.solving.address, (asking.solving.places, asking.solving.numbers))
    return wanted[IS_SOLVED] != 0.0
