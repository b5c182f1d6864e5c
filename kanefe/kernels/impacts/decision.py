"""Memory of what happens to rigid contacts at an event: the scene at a moment, and what is decided there."""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from kanefe.kernels.compiler.arrays import IntegerRows, Integers, Prepared, RealRows, Reals
from kanefe.kernels.contact.output_places import Margins
from kanefe.kernels.contact.output_places import Status as Status
from kanefe.kernels.contact.rigid_points import Meeting, Meetings
from kanefe.kernels.impacts.cones import Problem, Wanted, problem_of
from kanefe.kernels.impacts.stronge import TURNING_ROWS, Blow, Turned
from kanefe.kernels.language import Record, Rows, call_address, in_place, inlined, kernel
from kanefe.kernels.tables import RigidPoints
from kanefe.kernels.values.filled import allocate
from kanefe.kernels.values.tensors import Matrix, Vector, dot


class Look(IntEnum):
    """What is looked at of the scene."""

    MARGINS = 0
    POINTS = 1
    POINTS_LATER = 2
    FREE_ACCELERATIONS = 3


@in_place
class Asking(NamedTuple):
    """Whom the decision asks of the scene.

    Attributes
    ----------
    points : RigidPoints
    looking : Prepared
        Call that writes what `Decision.question` asks for: `kanefe.kernels.impacts.moments.look_at_points`, or a
        function in Python.
    solving, solving_ahead : Prepared
        Calls of `kanefe.kernels.impacts.cones.solve_one` with both problems of a decision.
    first_state : int
        Where in a state the internal states begin; the free speeds are before them.
    """

    points: RigidPoints
    looking: Prepared
    solving: Prepared
    solving_ahead: Prepared
    first_state: int


@in_place
class Moment(NamedTuple):
    """All points at a moment, as if all of them were open.

    Attributes
    ----------
    met : ndarray
        `Meetings`.
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
    G: RealRows
    b: Reals
    responses: RealRows
    sizes: Reals
    accelerated: Reals


class Point(Margins):
    """What is decided of a point; margins of events that are not possible are infinite.

    Attributes
    ----------
    before, after : int
        `Status`.
    group : int
        The least point of those whose impulses move each other.
    takes_part, is_concerned, is_lifted, is_struck, is_closed : bool
        Whether it takes part in the event, is one that this concerns, is let go by it, was struck, is closed.
    is_poisson, depends, gains : bool
        Whether its impact was Poisson's, depends on the order of several, and makes energy.
    begins, is_new : bool
        Whether it begins to slip, in this event and in this round.
    not_moving, at_rest_below, slow : float
        Speeds below which it does not move along the normal, does not slip, and slips in the direction of the friction
        that would hold it, m/s.
    rates, force, acceleration : Vector
        Rate (m/s), force or impulse, and acceleration along the normal and both directions of the surface.
    along, across : float
        Direction of its slip, or in which it begins to slip.
    turning : Vector
        Rate of that of a slip that begins, in axes of the surface, 1/s.
    """

    before: int
    after: int
    group: int
    takes_part: bool
    is_concerned: bool
    is_lifted: bool
    is_struck: bool
    is_closed: bool
    is_poisson: bool
    depends: bool
    gains: bool
    begins: bool
    is_new: bool
    not_moving: float
    at_rest_below: float
    slow: float
    rates: Vector
    force: Vector
    acceleration: Vector
    along: float
    across: float
    turning: Vector


Points = Rows[Point]
"""All points: of `Decision.integers` and `Decision.numbers`."""


class Asked(Record):
    """What is asked of the scene.

    Attributes
    ----------
    look : int
        `Look`.
    taking : int
        With how many points.
    is_known : bool
        On return.
    t : float
        When, s.
    """

    look: int
    taking: int
    is_known: bool
    t: float


@in_place
class Decision(NamedTuple):
    """What is decided at an event.

    Attributes
    ----------
    now, later : Moment
        At the event, and a little after it.
    problem, ahead : Problem
        Of the forces then.
    integers, numbers : ndarray
        `Points`.
    taking, active : ndarray of int, shape (points,)
        Numbers of the points that take part; and of those of a problem, in order.
    alone : ndarray of int, shape (1,)
        Number of a point that is struck by itself.
    rates, pressed : ndarray, shape (3 points,)
        Rates and impulses of the active points.
    motion : ndarray, shape (2, free)
        Accelerations without contacts, and a step along the speeds.
    state : ndarray, shape (state,)
        A little after the event.
    asked, when : ndarray
        `Asked`.
    blow, of_blow, turned : ndarray
        Memory of an impact of one point: `kanefe.kernels.impacts.stronge.Blow` and `Turns`.
    """

    now: Moment
    later: Moment
    problem: Problem
    ahead: Problem
    integers: IntegerRows
    numbers: RealRows
    taking: Integers
    active: Integers
    alone: Integers
    rates: Reals
    pressed: Reals
    motion: RealRows
    state: Reals
    asked: Integers
    when: Reals
    blow: Integers
    of_blow: Reals
    turned: RealRows


def decision_of(points: int, free: int, size: int) -> Decision:
    """Return the memory for a scene with so many points and free speeds, and states of a size."""
    n = 3 * points

    def moment() -> Moment:
        met = np.zeros((points, Meeting.number_count))
        return Moment(met, np.zeros((n, n)), np.zeros(n), np.zeros((n, free)), *np.zeros((2, points)))

    (asked, when), (blow, of_blow) = allocate(Asked), allocate(Blow)
    return Decision(
        now=moment(),
        later=moment(),
        problem=problem_of(points),
        ahead=problem_of(points),
        integers=np.zeros((points, Point.integer_count), dtype=np.int64),
        numbers=np.zeros((points, Point.number_count)),
        taking=np.zeros(points, dtype=np.int64),
        active=np.zeros(points, dtype=np.int64),
        alone=np.zeros(1, dtype=np.int64),
        rates=np.zeros(n),
        pressed=np.zeros(n),
        motion=np.zeros((2, free)),
        state=np.zeros(size),
        asked=asked,
        when=when,
        blow=blow,
        of_blow=of_blow,
        turned=np.zeros((TURNING_ROWS, Turned.number_count)),
    )


@inlined
def points_of(decision: Decision) -> Points:
    """Return what is decided of all points."""
    return Points(decision.integers, decision.numbers)


@kernel
def look(asking: Asking, decision: Decision, what: int, t: float, taking: np.ndarray) -> bool:
    """Have something of the scene written to the decision; return whether it is known."""
    asked = Asked(decision.asked, decision.when)
    asked.look, asked.taking, asked.t, asked.is_known = what, len(taking), t, False
    call_address(asking.looking.address, (asking.looking.places, asking.looking.numbers))
    return asked.is_known


@kernel
def solve(solving: Prepared, problem: Problem, k: int, is_warm: bool) -> bool:
    """Write the forces of k contacts; return whether there are some."""
    wanted = Wanted(problem.wanted)
    wanted.contacts, wanted.is_warm = k, is_warm
    call_address(solving.address, (solving.places, solving.numbers))
    return wanted.is_solved


@inlined
def block(G: np.ndarray, p: int, q: int) -> Matrix:
    """Return what a unit force at a point does to another."""
    i, j = 3 * p, 3 * q
    return Matrix(
        G[i, j], G[i, j + 1], G[i, j + 2],
        G[i + 1, j], G[i + 1, j + 1], G[i + 1, j + 2],
        G[i + 2, j], G[i + 2, j + 1], G[i + 2, j + 2],
    )  # fmt: skip


@inlined
def sizes(a: Vector) -> Vector:
    """Return the sizes of components."""
    return Vector(abs(a.x), abs(a.y), abs(a.z))


@inlined
def taken_by(force: Vector, before: Vector, after: Vector) -> float:
    """Return the energy that an impulse takes."""
    return -0.5 * dot(force, before + after)


@inlined
def is_at_rest(point: Point) -> bool:
    """Return whether a point slips by round-off only: then its acceleration decides."""
    return np.hypot(point.rates.y, point.rates.z) <= point.at_rest_below


@kernel
def put_problem(G: np.ndarray, active: np.ndarray, problem: Problem) -> None:
    """Write the unit responses of some points to a problem."""
    for a in range(len(active)):
        for i in range(3):
            for b in range(len(active)):
                for j in range(3):
                    problem.G[3 * a + i, 3 * b + j] = G[3 * active[a] + i, 3 * active[b] + j]


@inlined
def on_surface(moment: Moment, p: int, along: float, across: float) -> Vector:
    """Return a direction along a surface in its axes, from its parts along both directions at a point."""
    met = Meetings(moment.met)[p]
    return met.surface.T @ (along * met.first + across * met.second)
