"""Impulses of closed contacts in a step over impacts: by Newton's restitution, as far as that makes no energy.

    y = v_E + s e v_A along the normal, v_E across it,    v_E = v_free + G I

obeys Coulomb's law with impulses I, whose work is ``I (v_A + v_E) / 2``. With friction, and between several contacts,
Newton's restitution may make energy (Kane & Levinson, "Dynamics: Theory and Applications", 1985): there the share s of
it is the largest, below 1, with which it does not. Forces that turn a motion round within a step may let impulses do
work without any restitution, by what is of second order in the step: there the mean ``(v_A + v_E) / 2`` obeys the law,
whose work then is that of Coulomb's friction.
"""

from typing import NamedTuple

import numpy as np

from kanefe.kernels.compiler.arrays import IntegerRows, Integers, Prepared, RealRows, Reals
from kanefe.kernels.contact.rigid_points import given_points
from kanefe.kernels.impacts.cones import Cones, Problem, largest_of, let_choose, residual, summed
from kanefe.kernels.impacts.decision import put_problem, solve
from kanefe.kernels.impacts.tolerances import HALVINGS, ROUND_OFF_OF_FORCES
from kanefe.kernels.joints.motion import put_three, three
from kanefe.kernels.language import Record, Rows, entry, in_place, inlined, kernel, largest_in
from kanefe.kernels.tables import RigidPoints
from kanefe.kernels.values.filled import allocate
from kanefe.kernels.values.tensors import Vector, dot


class Closed(Record):
    """A point that is closed in a step.

    Attributes
    ----------
    point : int
        Its number.
    is_done : bool
        Whether it has its impulse.
    before, freely, after : Vector
        Rates at the middle of the step with its first speeds, and what they become without impulses, and with them,
        m/s.
    remainder : Vector
        What is left of the rate of its rates without accelerations, m/s2.
    impulse : Vector
        N s.
    """

    point: int
    is_done: bool
    before: Vector
    freely: Vector
    after: Vector
    remainder: Vector
    impulse: Vector


ClosedPoints = Rows[Closed]
"""All that may be closed: of `Step.integers` and `Step.numbers`."""


class Tried(Record):
    """What is told of a step.

    Attributes
    ----------
    closed : int
        How many points are closed.
    depth : float
        Of the deepest, m.
    residual : float
        Of their complementarity, of the largest impulse.
    approach, bend : float
        By how much it may enter a surface that it has not met before, and one along which it goes, m.
    lowered : float
        Of how many groups of contacts the restitution was lowered.
    """

    closed: int
    depth: float
    residual: float
    approach: float
    bend: float
    lowered: float


@in_place
class Step(NamedTuple):
    """A step over impacts, and what solves for its impulses.

    Attributes
    ----------
    points : RigidPoints
    problem : Problem
    solving : Prepared
        Call of `kanefe.kernels.impacts.cones.solve_one` with it.
    G : ndarray, shape (3 points, 3 points)
        What unit impulses do to the rates.
    members : ndarray of int, shape (2, points)
        Closed points that move each other, by their order; and their numbers.
    integers, numbers : ndarray
        `ClosedPoints`.
    tried, told : ndarray
        `Tried`.
    """

    points: RigidPoints
    problem: Problem
    solving: Prepared
    G: RealRows
    members: IntegerRows
    integers: IntegerRows
    numbers: RealRows
    tried: Integers
    told: Reals


def step_of(points: RigidPoints, problem: Problem, solving: Prepared, G: np.ndarray) -> Step:
    """Return the memory of a step."""
    n = len(points.places)
    members, integers = (np.zeros(shape, dtype=np.int64) for shape in ((2, n), (n, Closed.integer_count)))
    return Step(points, problem, solving, G, members, integers, np.zeros((n, Closed.number_count)), *allocate(Tried))


def closed_points(step: Step) -> list[Closed]:
    """Return the closed points of a step."""
    return list(ClosedPoints(step.integers, step.numbers))[: Tried(step.tried, step.told).closed]


@entry()
def solve_step(step: Step) -> bool:
    """Write the impulses of the closed points of a step, `Tried.closed` of them; return whether there are some."""
    return solve_islands(step)


@kernel
def solve_islands(step: Step) -> bool:
    """Write the impulses of closed points, of those that move each other together; return whether there are some."""
    closed, tried, members = ClosedPoints(step.integers, step.numbers), Tried(step.tried, step.told), step.members[0]
    count = tried.closed
    tried.residual = tried.lowered = 0.0
    for a in range(count):
        closed[a].is_done = False
    for a in range(count):
        if closed[a].is_done:
            continue
        members[0], closed[a].is_done, k, seen = a, True, 1, 0
        while seen < k:
            for b in range(count):
                if not closed[b].is_done and _moves(step.G, closed[members[seen]].point, closed[b].point):
                    members[k], closed[b].is_done = b, True
                    k += 1
            seen += 1
        if not _solve_island(step, k):
            return False
        tried.residual = max(tried.residual, _left(step, k))
        for b in range(k):
            closed[members[b]].impulse = three(step.problem.x, 3 * b)
    return True


@kernel
def _solve_island(step: Step, k: int) -> bool:
    """Write the impulses of k points that move each other, which make no energy; return whether there are some."""
    closed, tried = ClosedPoints(step.integers, step.numbers), Tried(step.tried, step.told)
    for a in range(k):
        step.members[1, a] = closed[step.members[0, a]].point
        cone = Cones(step.problem.each)[a]
        cone.mu, cone.least = given_points(step.points)[step.members[1, a]].friction.holding, 0.0
        let_choose(cone)
    put_problem(step.G, step.members[1, :k], step.problem)
    if not _solve_by(step, k, 1.0, 0.0):
        return False
    if not _makes_energy(step, k):
        return True
    if not _solve_by(step, k, 0.0, 0.0):
        return False
    if _makes_energy(step, k):
        return _solve_by(step, k, 0.0, 1.0)
    low, high = 0.0, 1.0
    for _ in range(HALVINGS):
        share = 0.5 * (low + high)
        if not _solve_by(step, k, share, 0.0) or _makes_energy(step, k):
            high = share
        else:
            low = share
    tried.lowered += 1.0
    return _solve_by(step, k, low, 0.0)


@kernel
def _solve_by(step: Step, k: int, share: float, of_all: float) -> bool:
    """Write the impulses by shares of the restitution, and of the rates before that count in all directions."""
    closed = ClosedPoints(step.integers, step.numbers)
    for a in range(k):
        one = closed[step.members[0, a]]
        e = share * given_points(step.points)[one.point].restitution
        put_three(step.problem.b, 3 * a, one.freely + of_all * one.before + Vector(e * one.before.x, 0.0, 0.0))
    return solve(step.solving, step.problem, k, False)


@kernel
def _makes_energy(step: Step, k: int) -> bool:
    """Return whether the impulses of k points that move each other do work beyond round-off."""
    closed, problem, work, size, fastest = ClosedPoints(step.integers, step.numbers), step.problem, 0.0, 0.0, 0.0
    for a in range(k):
        one, force = closed[step.members[0, a]], three(problem.x, 3 * a)
        after = summed(problem.G, k, a, problem.x, one.freely)
        work += 0.5 * dot(force, one.before + after)
        size += abs(force.x) + abs(force.y) + abs(force.z)
        fastest = max(fastest, max(largest_in(one.before), largest_in(one.freely)))
    return work > ROUND_OFF_OF_FORCES * fastest * size


@inlined
def _moves(G: np.ndarray, p: int, q: int) -> bool:
    """Return whether a force at a point moves another one."""
    found = False
    for i in range(3 * p, 3 * p + 3):
        for j in range(3 * q, 3 * q + 3):
            found = found or G[i, j] != 0.0
    return found


@kernel
def _left(step: Step, k: int) -> float:
    """Return the residual of the impulses of k points that move each other, of the largest."""
    closed, problem, softest, fastest = ClosedPoints(step.integers, step.numbers), step.problem, 0.0, 0.0
    for a in range(k):
        fastest = max(fastest, largest_in(closed[step.members[0, a]].before))
    for i in range(3 * k):
        softest = max(softest, problem.G[i, i])
    return residual(problem, k, problem.x) / max(max(largest_of(problem.x, 3 * k), fastest / softest), 1e-300)
