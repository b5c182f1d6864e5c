"""Steps of Moreau and Jean over the impacts of rigid contacts in compiled code, from output to output.

The equations are those of `kanefe.kane.rigid_contacts.time_stepping`. The scene is asked for them by the calls that
events of rigid contacts have: a unit of its own, which is built where a run takes such steps.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kanefe.kernels.algebra.vectors import (
    Numbers,
    copy,
    dot,
    matrix,
    plus,
    rotated,
    rotated_back,
    three,
    times,
    vector,
)
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.compiler.arrays import Integers, RealRows, Reals
from kanefe.kernels.compiler.entries import entry
from kanefe.kernels.constraints.contact_margins import Looked
from kanefe.kernels.constraints.loop_tables import Loops, unit_responses_in
from kanefe.kernels.constraints.tolerances import NEAR_SINGULAR
from kanefe.kernels.contact.falling import AT
from kanefe.kernels.contact.rigid_points import (
    AT_REST,
    FIRST_STATE,
    HAS_FRICTION,
    KEPT,
    KEPT_RATE,
    MET,
    OF_POINT,
    SLIP,
    STATUS,
    WORK,
)
from kanefe.kernels.evaluation.bending import watch_bends
from kanefe.kernels.evaluation.evaluation import LEAST_PIVOT
from kanefe.kernels.events.closing_call import ClosingCall, close_at
from kanefe.kernels.impacts.cones import LEAST, MU, largest_of, residual
from kanefe.kernels.impacts.decision import (
    ACTIVE,
    FREE_ACCELERATIONS,
    IS_NEW,
    IS_TAKING,
    MARGINS_NOW,
    ON_GAP,
    OPEN,
    POINTS_NOW,
    SLIPS,
    STICKS,
    TAKES,
    Asking,
    Decision,
    X,
    look,
    solve,
)
from kanefe.kernels.impacts.tolerances import ROUND_OFF_OF_FORCES
from kanefe.kernels.layout import COORDINATES, FlexibleTables, Tables
from kanefe.kernels.steppers.step_commands import SLOPE
from kanefe.kernels.sweeps.advance import advance

BEYOND = 1e-6
"""Violation relative to the friction limit, to the largest normal force and to the scene's length above which the run
is in error."""

DOUBLY = 2.0
"""Penetration, in multiples of the first-order error of steps over impacts, above which it is an error."""

ROUND_OFF = 1e-9
"""Tolerance, relative to a step, by which the last step may be longer."""

HALVINGS = 20
"""Number of times that the interval of a share of the restitution is halved: it is known to a millionth."""

DONE, LEFT, BROKEN = range(3)
"""How steps end: at the last output or the most steps; before one that is left to the literal equations; before one
that breaks a law of a contact."""

MOST, STEPS, PASSED, CLOSED = range(4)
"""Integers: steps that may be taken, steps in total, outputs passed, contact points that were closed in the last step.
"""
INTEGERS = 4

TIME, TIME_OLD, STOP, LENGTH, TOO_DEEP, OWN_DEPTH, OWN_RESIDUAL, OWN_APPROACH, OWN_BEND, OWN_LOWERED = range(10)
"""Reals: time reached, start of the last step, end and length of steps (s); a depth that is round-off (m); and of the
step that was tried last what is told of steps."""
REALS = 10

DEEPEST, RESIDUAL, APPROACH, BEND, LOWERED = range(5)
"""Told of all steps so far: the largest depth (m) and residual; by how much a step may enter a surface that it has
not met before, the largest, and one along which it goes, of all steps together (m); and in all together, of how many
groups of contacts the restitution was lowered."""
TOLD = 5

OLD, NEW, NEXT = range(3)
"""Rows of the ends of steps: of the last one, and of the one that is tried."""

BEFORE_STEP, REMAINDER, FREELY, AFTER_STEP, IMPULSE = range(5)
"""Rows of the vectors of closed points: rates at the middle of a step with its first speeds, m/s, and what is left of
their rates without accelerations, m/s2; what they become without impulses, and with them, m/s; impulses, N s."""
VECTORS = 5

HOLDING = int(OF_POINT.friction) + int(AT.holding)


class ImpactScene(NamedTuple):
    """A scene that is stepped over its impacts.

    Attributes
    ----------
    asking : Asking
        Its calls look at the state `at` of a march.
    looked : Looked
    closing : ClosingCall
    tables, flexible, loops : named tuples
    """

    asking: Asking
    looked: Looked
    closing: ClosingCall
    tables: Tables
    flexible: FlexibleTables
    loops: Loops


class March(NamedTuple):
    """Steps through a run.

    Attributes
    ----------
    integers, reals, told : ndarray, shapes (INTEGERS,), (REALS,), (TOLD,)
    ends : ndarray, shape (3, state)
        States with quadratures.
    vectors : ndarray, shape (VECTORS, 3 points)
    at : ndarray, shape (state,)
        The state that the scene is asked about.
    bends, bent : ndarray
        Of bodies whose bending is watched: see `kanefe.kernels.evaluation.bending`.
    """

    integers: Integers
    reals: Reals
    told: Reals
    ends: RealRows
    vectors: RealRows
    at: Reals
    bends: Integers
    bent: Reals


@entry()
def march_over_impacts(
    scene: ImpactScene, decision: Decision, march: March, times_of_outputs: Reals, outputs: RealRows
) -> int:
    """Take steps; return how they end.

    Parameters
    ----------
    scene : ImpactScene
    decision : Decision
        Memory of its calls.
    march : March
    times_of_outputs : ndarray, shape (T,)
        Ascending, s.
    outputs : ndarray, shape (T, state)
        Places between two steps are on the line between them; speeds and what else jumps are those of the nearer end.
    """
    integers, reals, ends = march.integers, march.reals, march.ends
    while integers[PASSED] < len(times_of_outputs) and integers[MOST] > 0:
        left = reals[STOP] - reals[TIME]
        h = left if left <= reals[LENGTH] * (1.0 + ROUND_OFF) else reals[LENGTH]
        watch_bends(march.bends, march.bent, reals[TIME], ends[NEW])
        done = _step(scene, decision, march, h)
        if done != DONE:
            return done
        copy(ends[NEW], ends[OLD])
        copy(ends[NEXT], ends[NEW])
        reals[TIME_OLD] = reals[TIME]
        reals[TIME] = reals[STOP] if h == left else reals[TIME] + h
        integers[MOST] -= 1
        integers[STEPS] += 1
        while integers[PASSED] < len(times_of_outputs) and times_of_outputs[integers[PASSED]] <= reals[TIME]:
            _put_between(march, times_of_outputs[integers[PASSED]], scene.tables, outputs[integers[PASSED]])
            integers[PASSED] += 1
    return DONE


@kernel
def _put_between(march: March, t: float, tables: Tables, found: np.ndarray) -> None:
    """Write the state at a time of the last step."""
    old, new, reals = march.ends[OLD], march.ends[NEW], march.reals
    share = (t - reals[TIME_OLD]) / (reals[TIME] - reals[TIME_OLD])
    copy(new if share > 0.5 else old, found)
    for i in range(tables.sizes[COORDINATES]):
        found[i] = (1.0 - share) * old[i] + share * new[i]


@kernel
def _step(scene: ImpactScene, decision: Decision, march: March, h: float) -> int:
    """Write the next state after a step of h (s); return whether it is done."""
    looked, points, asking = scene.looked, scene.loops.points, scene.asking
    before, y, at = march.ends[NEW], march.ends[NEXT], march.at
    first, last = scene.tables.sizes[COORDINATES], looked.first_state
    t, size = march.reals[TIME] + 0.5 * h, len(y)
    copy(before, y)
    for p in range(len(points.places)):
        y[last + points.places[p, STATUS]] = OPEN
    copy(y, at)
    advance(scene.tables, scene.flexible, y[:first], y[first:last], 0.5 * h, at[:first])
    if not (look(asking, decision, MARGINS_NOW, t, 0) and _is_regular(looked)):
        return LEFT
    slope, count, flags = looked.vectors[SLOPE], 0, decision.flags
    for p in range(len(points.places)):
        flags[IS_TAKING, p] = 1 if decision.margins[p, ON_GAP] <= 0.0 else 0
        if flags[IS_TAKING, p] != 0:
            for i in range(3):
                march.vectors[BEFORE_STEP, 3 * count + i] = decision.now.met[p, int(MET.rates) + i]
                march.vectors[REMAINDER, 3 * count + i] = decision.now.met[p, int(MET.remainder) + i]
            flags[TAKES, count] = p
            count += 1
    for c in range(first, last):
        at[c] = y[c] + 0.5 * h * slope[c]
    if not (look(asking, decision, FREE_ACCELERATIONS, t, 0) and _is_regular(looked)):
        return LEFT
    for c in range(first, last):
        y[c] += h * slope[c]
        at[c] = y[c]  # what forces at points do is asked with the speeds without them, whose rates are wanted too
    for i in range(size - 2, size):
        y[i] += h * slope[i]
    march.integers[CLOSED] = count
    if count > 0:
        if not look(asking, decision, POINTS_NOW, t, count):
            return LEFT
        _put_rates(scene, decision, march, count, h)
        if not _solve_islands(scene, decision, march, count):
            return LEFT
        if not _strike(scene, decision, march, count):
            return BROKEN
    advance(scene.tables, scene.flexible, at[:first], y[first:last], 0.5 * h, y[:first])
    if scene.closing.has_loops and not close_at(scene.closing, march.reals[TIME] + h, 0.0, y):
        return LEFT
    if count > 0:
        _put_statuses(scene, decision, march, count, h)
    return DONE


@inlined
def _is_regular(looked: Looked) -> bool:
    """Return whether the loops hold what they should in the last evaluation."""
    return bool(looked.evaluation.numbers[LEAST_PIVOT] >= NEAR_SINGULAR)


@kernel
def _put_rates(scene: ImpactScene, decision: Decision, march: March, count: int, h: float) -> None:
    """Write the rates of closed points, and how far a step may go into their surfaces."""
    looked, loops, vectors, reals, drives = scene.looked, scene.loops, march.vectors, march.reals, scene.looked.drives
    kept = unit_responses_in(looked.holding, loops, looked.speeds)
    met, row, free = decision.now.met, len(loops.rows) - 3 * len(loops.points.places), looked.speeds - len(drives)
    reals[OWN_DEPTH] = reals[OWN_APPROACH] = reals[OWN_BEND] = 0.0
    for a in range(count):
        p, curved = decision.flags[TAKES, a], vectors[REMAINDER, 3 * a]
        for i in range(3):
            vectors[FREELY, 3 * a + i] = met[p, int(MET.rates) + i]
        for d in range(len(drives)):
            curved += kept.J[row + 3 * p, free + d] * drives[d, 2]
        reals[OWN_DEPTH] = max(reals[OWN_DEPTH], -met[p, MET.gap])
        reals[OWN_APPROACH] = max(reals[OWN_APPROACH], -h * vectors[BEFORE_STEP, 3 * a])
        reals[OWN_BEND] = max(reals[OWN_BEND], 0.5 * h * h * abs(curved))


@kernel
def _solve_islands(scene: ImpactScene, decision: Decision, march: March, count: int) -> bool:
    """Write the impulses of closed points, of those that move each other together; return whether there are some."""
    flags, reals, vectors = decision.flags, march.reals, march.vectors
    takes, members, is_done = flags[TAKES], flags[ACTIVE], flags[IS_NEW]
    reals[OWN_RESIDUAL] = reals[OWN_LOWERED] = 0.0
    for a in range(count):
        is_done[a] = 0
    for a in range(count):
        if is_done[a] != 0:
            continue
        members[0], is_done[a], k, seen = a, 1, 1, 0
        while seen < k:
            for b in range(count):
                if is_done[b] == 0 and _moves(decision.now.G, takes[members[seen]], takes[b]):
                    members[k], is_done[b] = b, 1
                    k += 1
            seen += 1
        if not _solve_island(scene, decision, march, k):
            return False
        reals[OWN_RESIDUAL] = max(reals[OWN_RESIDUAL], _left(decision, march, k))
        for b in range(k):
            for i in range(3):
                vectors[IMPULSE, 3 * members[b] + i] = decision.vectors[X, 3 * b + i]
    return True


@kernel
def _solve_island(scene: ImpactScene, decision: Decision, march: March, k: int) -> bool:
    """Write the impulses of k active points, which make no energy; return whether there are some.

    See `kanefe.kane.rigid_contacts.step_impulses`.
    """
    _put_problem(scene, decision, k)
    if not _solve_by(scene, decision, march, k, 1.0, 0.0):
        return False
    if not _makes_energy(decision, march, k):
        return True
    if not _solve_by(scene, decision, march, k, 0.0, 0.0):
        return False
    if _makes_energy(decision, march, k):
        return _solve_by(scene, decision, march, k, 0.0, 1.0)
    low, high = 0.0, 1.0
    for _ in range(HALVINGS):
        share = 0.5 * (low + high)
        if not _solve_by(scene, decision, march, k, share, 0.0) or _makes_energy(decision, march, k):
            high = share
        else:
            low = share
    march.reals[OWN_LOWERED] += 1.0
    return _solve_by(scene, decision, march, k, low, 0.0)


@kernel
def _solve_by(scene: ImpactScene, decision: Decision, march: March, k: int, share: float, of_all: float) -> bool:
    """Write the impulses by shares of the restitution, and of the rates before that count in all directions."""
    numbers, members, vectors = scene.loops.points.numbers, decision.flags[ACTIVE], march.vectors
    for a in range(k):
        at = 3 * members[a]
        for i in range(3):
            decision.problem.b[3 * a + i] = vectors[FREELY, at + i] + of_all * vectors[BEFORE_STEP, at + i]
        e = share * numbers[decision.flags[TAKES, members[a]], OF_POINT.restitution]
        decision.problem.b[3 * a] += e * vectors[BEFORE_STEP, at]
    return solve(scene.asking, False, k, X, False)


@kernel
def _makes_energy(decision: Decision, march: March, k: int) -> bool:
    """Return whether the impulses of k active points do work beyond round-off."""
    G, x, vectors, members = decision.problem.G, decision.vectors[X], march.vectors, decision.flags[ACTIVE]
    work = size = fastest = 0.0
    for a in range(k):
        for i in range(3):
            before, freely = vectors[BEFORE_STEP, 3 * members[a] + i], vectors[FREELY, 3 * members[a] + i]
            after = freely
            for j in range(3 * k):
                after += G[3 * a + i, j] * x[j]
            work += 0.5 * x[3 * a + i] * (before + after)
            size += abs(x[3 * a + i])
            fastest = max(fastest, max(abs(before), abs(freely)))
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
def _put_problem(scene: ImpactScene, decision: Decision, k: int) -> None:
    """Write the problem of the impulses of k active points among the closed ones, but for the law."""
    problem, G, members = decision.problem, decision.now.G, decision.flags[ACTIVE]
    points, takes = scene.loops.points, decision.flags[TAKES]
    for a in range(k):
        p = takes[members[a]]
        for i in range(3 * a, 3 * a + 3):
            for b in range(k):
                for j in range(3):
                    problem.G[i, 3 * b + j] = G[3 * p + i - 3 * a, 3 * takes[members[b]] + j]
        problem.of_each[MU, a] = points.numbers[p, HOLDING] if points.places[p, HAS_FRICTION] != 0 else 0.0
        problem.of_each[LEAST, a] = 0.0
        problem.slips[a, 0] = problem.slips[a, 1] = np.nan


@kernel
def _left(decision: Decision, march: March, k: int) -> float:
    """Return the residual of the impulses of k active points, of the largest."""
    problem, x, softest, fastest = decision.problem, decision.vectors[X], 0.0, 0.0
    for a in range(k):
        for i in range(3):
            softest = max(softest, problem.G[3 * a + i, 3 * a + i])
            fastest = max(fastest, abs(march.vectors[BEFORE_STEP, 3 * decision.flags[ACTIVE, a] + i]))
    return residual(problem, k, x) / max(max(largest_of(x, 3 * k), fastest / softest), 1e-300)


@kernel
def _strike(scene: ImpactScene, decision: Decision, march: March, count: int) -> bool:
    """Change the speeds by the impulses; return whether contacts can have these."""
    y, reals, told, vectors = march.ends[NEXT], march.reals, march.told, march.vectors
    now, places, numbers = decision.now, scene.loops.points.places, scene.loops.points.numbers
    takes, x = decision.flags[TAKES], march.vectors[IMPULSE]
    first, last, pressed = scene.tables.sizes[COORDINATES], scene.looked.first_state, 0.0
    for a in range(count):
        p = takes[a]
        pressed = max(pressed, abs(x[3 * a]))
        for i in range(3):
            for c in range(first, last):
                y[c] += x[3 * a + i] * now.responses[3 * p + i, c - first]
            after = vectors[FREELY, 3 * a + i]
            for b in range(count):
                for j in range(3):
                    after += now.G[3 * p + i, 3 * takes[b] + j] * x[3 * b + j]
            vectors[AFTER_STEP, 3 * a + i] = after
    approach, bend = max(told[APPROACH], reals[OWN_APPROACH]), told[BEND] + reals[OWN_BEND]
    is_right = reals[OWN_DEPTH] <= reals[TOO_DEEP] + DOUBLY * (approach + bend)
    for a in range(count):
        p, normal = takes[a], x[3 * a]
        mu = numbers[p, HOLDING] if places[p, HAS_FRICTION] != 0 else 0.0
        along, beyond = np.hypot(x[3 * a + 1], x[3 * a + 2]), max(BEYOND * mu, ROUND_OFF_OF_FORCES) * pressed
        is_right = is_right and normal >= -BEYOND * pressed and along <= mu * normal + beyond
    if is_right:
        told[APPROACH], told[BEND] = approach, bend
        told[DEEPEST] = max(told[DEEPEST], reals[OWN_DEPTH])
        told[RESIDUAL] = max(told[RESIDUAL], reals[OWN_RESIDUAL])
        told[LOWERED] += reals[OWN_LOWERED]
    return is_right


@kernel
def _put_statuses(scene: ImpactScene, decision: Decision, march: March, count: int, h: float) -> None:
    """Write what contacts did in a step to their states, and the energy that they took to the books."""
    points, now, y, vectors = scene.loops.points, decision.now, march.ends[NEXT], march.vectors
    last, size, x, pressed, fastest = scene.looked.first_state, len(y), march.vectors[IMPULSE], 0.0, 0.0
    for a in range(3 * count):
        pressed = max(pressed, abs(x[a]))
        fastest = max(fastest, max(abs(vectors[BEFORE_STEP, a]), abs(vectors[FREELY, a])))
    least, still = ROUND_OFF_OF_FORCES * pressed, ROUND_OFF_OF_FORCES * fastest
    for a in range(count):
        p = decision.flags[TAKES, a]
        own, rubbed, taken = points.places[p], 0.0, 0.0
        belt = rotated(matrix(now.axes, p, 0), three(points.numbers[p], OF_POINT.belt))
        for i in range(3):
            work = x[3 * a + i] * 0.5 * (vectors[BEFORE_STEP, 3 * a + i] + vectors[AFTER_STEP, 3 * a + i])
            taken += work
            rubbed += work if i > 0 else 0.0
        y[size - 2] -= taken
        y[size - 1] += dot(_along(now.met, p, x[3 * a + 1], x[3 * a + 2]), belt)
        if x[3 * a] <= least:
            continue
        after = vectors[AFTER_STEP, 3 * a : 3 * a + 3]
        slip, contact, at = np.hypot(after[1], after[2]), last + own[FIRST_STATE], last + own[STATUS]
        y[contact + WORK] -= rubbed
        y[contact + SLIP] += points.numbers[p, OF_POINT.share] * slip * h
        if after[0] > still:  # it has bounced
            continue
        y[at + KEPT_RATE : at + KEPT_RATE + 3] = 0.0
        if own[HAS_FRICTION] != 0 and slip <= still:
            y[at] = STICKS
            copy(now.met[p, MET.place : int(MET.place) + 3], y[at + KEPT : at + KEPT + 3])
        else:
            share = AT_REST / slip if slip > 0.0 else 0.0
            y[at] = SLIPS
            way = rotated_back(matrix(now.axes, p, 0), _along(now.met, p, share * after[1], share * after[2]))
            y[at + KEPT], y[at + KEPT + 1], y[at + KEPT + 2] = way


@inlined
def _along(met: np.ndarray, p: int, along: float, across: float) -> Numbers:
    """Return a vector from its parts along both directions of the surface at a point."""
    return plus(times(along, vector(met, p, MET.first)), times(across, vector(met, p, MET.second)))
