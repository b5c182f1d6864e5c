"""Memory of what happens to rigid contacts at an event: the scene at a moment, and what is decided there."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kanefe.kernels.compiler.arrays import Filler, Integers, RealRows, Reals
from kanefe.kernels.constraints.contact_margins import Looked
from kanefe.kernels.constraints.loop_tables import Loops
from kanefe.kernels.contact.rigid_points import MET_NUMBERS
from kanefe.kernels.impacts.cones import Cones, cones_of
from kanefe.kernels.layout import FlexibleTables, Tables
from kanefe.kernels.sweeps.drives import Drives

OPEN, STICKS, SLIPS = range(3)
"""Status of a point: see `kanefe.contact.contact`."""

ON_GAP, ON_NORMAL, ON_SLIP, ON_LEFT = range(4)
"""Columns of the margins of points: of gaps, normal forces, friction that is left, and slips."""


class ContactScene(NamedTuple):
    """A scene of which events of rigid contacts ask.

    Attributes
    ----------
    looked : Looked
        An evaluation in space.
    loops, tables, flexible : named tuples
        Of the scene; without flexible bodies the latter is empty.
    motions : Drives
    fill : function (t, y, inputs)
    held : ndarray, shape (inputs,)
        Values of loads, those written that do not change in the run.
    """

    looked: Looked
    loops: Loops
    tables: Tables
    flexible: FlexibleTables
    motions: Drives
    fill: Filler
    held: Reals


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
    """

    met: RealRows
    axes: RealRows
    G: RealRows
    b: Reals
    responses: RealRows
    sizes: Reals


class Decision(NamedTuple):
    """What is decided at an event; by the numbers of the points, but where something else is said.

    Attributes
    ----------
    now, later : Moment
        At the event, and a little after it.
    problem, ahead : Cones
        Of the forces then.
    takes, active : ndarray of int, shape (points,)
        Numbers of the points that take part, and of those of them that are closed, in order.
    before, after : ndarray of int, shape (points,)
        OPEN, STICKS or SLIPS.
    margins : ndarray, shape (points, 4)
        Distances from possible events; infinite of others.
    is_taking, is_concerned, is_struck, is_closed : ndarray of int, shape (points,)
    still, rest, slow : ndarray, shape (points,)
        Speeds below which a point does not move along the normal, does not slip, and slips in the direction of the
        friction that would hold it, m/s.
    rates, accelerations, forces : ndarray, shape (3 points,)
    slips : ndarray, shape (points, 2)
        Directions of slips.
    turning : ndarray, shape (points, 3)
        Rates of the directions of slips that begin, in axes of the surface, 1/s.
    x, other : ndarray, shape (3 points,)
        Forces of the active ones.
    begins, is_new : ndarray of int, shape (points,)
        Which of the active ones begin to slip, in this event and in this round.
    found : ndarray, shape (points, 2)
        Directions in which active ones begin to slip.
    state : ndarray, shape (state,)
        A little after the event.
    du, step : ndarray, shape (free,)
    """

    now: Moment
    later: Moment
    problem: Cones
    ahead: Cones
    takes: Integers
    active: Integers
    before: Integers
    after: Integers
    margins: RealRows
    is_taking: Integers
    is_concerned: Integers
    is_struck: Integers
    is_closed: Integers
    still: Reals
    rest: Reals
    slow: Reals
    rates: Reals
    accelerations: Reals
    forces: Reals
    slips: RealRows
    turning: RealRows
    x: Reals
    other: Reals
    begins: Integers
    is_new: Integers
    found: RealRows
    state: Reals
    du: Reals
    step: Reals


def decision_of(points: int, free: int, size: int) -> Decision:
    """Return the memory for a scene with so many points and free speeds, and states of a size."""
    n = 3 * points

    def moment() -> Moment:
        square, rows = np.zeros((n, n)), np.zeros((n, free))
        return Moment(
            np.zeros((points, MET_NUMBERS)), np.zeros((points, 9)), square, np.zeros(n), rows, np.zeros(points)
        )

    def integers() -> np.ndarray:
        return np.zeros(points, dtype=np.int64)

    return Decision(
        now=moment(),
        later=moment(),
        problem=cones_of(points),
        ahead=cones_of(points),
        takes=integers(),
        active=integers(),
        before=integers(),
        after=integers(),
        margins=np.zeros((points, 4)),
        is_taking=integers(),
        is_concerned=integers(),
        is_struck=integers(),
        is_closed=integers(),
        still=np.zeros(points),
        rest=np.zeros(points),
        slow=np.zeros(points),
        rates=np.zeros(n),
        accelerations=np.zeros(n),
        forces=np.zeros(n),
        slips=np.zeros((points, 2)),
        turning=np.zeros((points, 3)),
        x=np.zeros(n),
        other=np.zeros(n),
        begins=integers(),
        is_new=integers(),
        found=np.zeros((points, 2)),
        state=np.zeros(size),
        du=np.zeros(free),
        step=np.zeros(free),
    )
