"""Steps of Moreau and Jean over the impacts of rigid contacts in compiled code, from output to output.

The equations are those of `kanefe.literal.impact_steps`. The scene is asked for them by the calls that
events of rigid contacts have: a unit of its own, which is built where a run takes such steps.
"""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.vectors import copy
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.compiler.arrays import RealRows, Reals
from kanefe.kernels.compiler.entries import entry
from kanefe.kernels.constraints.contact_margins import Looked
from kanefe.kernels.constraints.loop_tables import unit_responses_in
from kanefe.kernels.constraints.tolerances import NEAR_SINGULAR
from kanefe.kernels.contact.rigid_points import (
    AT_REST,
    FIRST_STATE,
    HAS_FRICTION,
    KEPT,
    KEPT_RATE,
    OF_POINT,
    SLIP,
    STATUS,
    TAKEN,
    WORK,
    Meetings,
)
from kanefe.kernels.evaluation.bending import watch_bends
from kanefe.kernels.evaluation.evaluation import LEAST_PIVOT
from kanefe.kernels.events.closing_call import close_at
from kanefe.kernels.impacts.decision import Decision, Look, block, largest_in, look, on_surface, points_of
from kanefe.kernels.impacts.impulses import holding_of, respond
from kanefe.kernels.impacts.march import (
    BEYOND,
    BROKEN,
    DONE,
    DOUBLY,
    LEFT,
    NEW,
    NEXT,
    OLD,
    ROUND_OFF,
    ImpactScene,
    March,
    Progress,
    Told,
)
from kanefe.kernels.impacts.step_impulses import ClosedPoints, Tried, solve_islands
from kanefe.kernels.impacts.tolerances import ROUND_OFF_OF_FORCES
from kanefe.kernels.joints.motion import put_three, three
from kanefe.kernels.layout import COORDINATES
from kanefe.kernels.steppers.step_commands import SLOPE
from kanefe.kernels.sweeps.advance import advance
from kanefe.kernels.tables import Tables
from kanefe.kernels.values.tensors import dot


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
    at, ends = Progress(march.integers, march.reals), march.ends
    while at.passed < len(times_of_outputs) and at.most > 0:
        left = at.stop - at.time
        h = left if left <= at.length * (1.0 + ROUND_OFF) else at.length
        watch_bends(march.bends, march.bent, at.time, ends[NEW])
        done = _step(scene, decision, march, h)
        if done != DONE:
            return done
        copy(ends[NEW], ends[OLD])
        copy(ends[NEXT], ends[NEW])
        at.time_old = at.time
        at.time = at.stop if h == left else at.time + h
        at.most -= 1
        at.steps += 1
        while at.passed < len(times_of_outputs) and times_of_outputs[at.passed] <= at.time:
            _put_between(march, times_of_outputs[at.passed], scene.tables, outputs[at.passed])
            at.passed += 1
    return DONE


@kernel
def _put_between(march: March, t: float, tables: Tables, found: np.ndarray) -> None:
    """Write the state at a time of the last step."""
    old, new, at = march.ends[OLD], march.ends[NEW], Progress(march.integers, march.reals)
    share = (t - at.time_old) / (at.time - at.time_old)
    copy(new if share > 0.5 else old, found)
    for i in range(tables.sizes[COORDINATES]):
        found[i] = (1.0 - share) * old[i] + share * new[i]


@kernel
def _step(scene: ImpactScene, decision: Decision, march: March, h: float) -> int:
    """Write the next state after a step of h (s); return whether it is done."""
    looked, y, at, asking = scene.looked, march.ends[NEXT], march.at, scene.asking
    first, last = scene.tables.sizes[COORDINATES], looked.first_state
    t = Progress(march.integers, march.reals).time + 0.5 * h
    _open_all(scene, march)
    advance(scene.tables, scene.flexible, y[:first], y[first:last], 0.5 * h, at[:first])
    if not (look(asking, decision, Look.MARGINS, t, decision.taking[:0]) and _is_regular(looked)):
        return LEFT
    taking, slope = decision.taking[: _find_closed(decision, march)], looked.vectors[SLOPE]
    for c in range(first, last):
        at[c] = y[c] + 0.5 * h * slope[c]
    if not (look(asking, decision, Look.FREE_ACCELERATIONS, t, taking) and _is_regular(looked)):
        return LEFT
    for c in range(first, last):
        y[c] += h * slope[c]
        at[c] = y[c]  # what forces at points do is asked with the speeds without them, whose rates are wanted too
    for i in range(len(y) - 2, len(y)):
        y[i] += h * slope[i]
    if len(taking) > 0:
        if not look(asking, decision, Look.POINTS, t, taking):
            return LEFT
        _put_rates(scene, decision, march, h)
        if not solve_islands(march.step):
            return LEFT
        if not _strike(decision, march, y[first:last]):
            return BROKEN
    advance(scene.tables, scene.flexible, at[:first], y[first:last], 0.5 * h, y[:first])
    if scene.closing.has_loops and not close_at(scene.closing, t + 0.5 * h, 0.0, y):
        return LEFT
    if len(taking) > 0:
        _put_statuses(scene, decision, march, h)
    return DONE


@inlined
def _is_regular(looked: Looked) -> bool:
    """Return whether the loops hold what they should in the last evaluation."""
    return bool(looked.evaluation.numbers[LEAST_PIVOT] >= NEAR_SINGULAR)


@kernel
def _open_all(scene: ImpactScene, march: March) -> None:
    """Begin a step with all points open."""
    y = march.ends[NEXT]
    copy(march.ends[NEW], y)
    for p in range(len(scene.loops.points.places)):
        own = scene.looked.first_state + scene.loops.points.places[p, STATUS]
        y[own : own + KEPT_RATE + 3] = 0.0  # also from how deep a point left, and its slip: none
    copy(y, march.at)


@kernel
def _find_closed(decision: Decision, march: March) -> int:
    """Write which points are closed, and how they move; return how many these are."""
    points, closed, count = points_of(decision), ClosedPoints(march.step.integers, march.step.numbers), 0
    for p in range(len(points)):
        points[p].takes_part = points[p].gap <= 0.0
        if points[p].takes_part:
            one, met = closed[count], Meetings(decision.now.met)[p]
            one.point, one.before, one.remainder, decision.taking[count] = p, met.rates, met.remainder, p
            count += 1
    Tried(march.step.tried, march.step.told).closed = count
    return count


@kernel
def _put_rates(scene: ImpactScene, decision: Decision, march: March, h: float) -> None:
    """Write the rates of closed points, and how far a step may go into their surfaces."""
    looked, loops, drives = scene.looked, scene.loops, scene.looked.drives
    closed, tried = ClosedPoints(march.step.integers, march.step.numbers), Tried(march.step.tried, march.step.told)
    kept, free = unit_responses_in(looked.holding, loops), looked.speeds - len(drives)
    row = len(loops.rows) - 3 * len(loops.points.places)
    tried.depth = tried.approach = tried.bend = 0.0
    for a in range(tried.closed):
        one = closed[a]
        met, curved = Meetings(decision.now.met)[one.point], one.remainder.x
        one.freely = met.rates
        for d in range(len(drives)):
            curved += kept.J[row + 3 * one.point, free + d] * drives[d, 2]
        tried.depth = max(tried.depth, -met.gap)
        tried.approach = max(tried.approach, -h * one.before.x)
        tried.bend = max(tried.bend, 0.5 * h * h * abs(curved))


@kernel
def _strike(decision: Decision, march: March, u: np.ndarray) -> bool:
    """Change the speeds by the impulses; return whether contacts can have these."""
    told, tried = Told(march.told), Tried(march.step.tried, march.step.told)
    closed, pressed = ClosedPoints(march.step.integers, march.step.numbers), 0.0
    for a in range(tried.closed):
        one = closed[a]
        pressed = max(pressed, abs(one.impulse.x))
        respond(decision, one.point, one.impulse, u)
        after = one.freely
        for b in range(tried.closed):
            after += block(decision.now.G, one.point, closed[b].point) @ closed[b].impulse
        one.after = after
    approach, bend = max(told.approach, tried.approach), told.bend + tried.bend
    too_deep = Progress(march.integers, march.reals).too_deep
    is_right = tried.depth <= too_deep + DOUBLY * (approach + bend)
    for a in range(tried.closed):
        push, mu = closed[a].impulse, holding_of(march.step.points, closed[a].point)
        along, beyond = np.hypot(push.y, push.z), max(BEYOND * mu, ROUND_OFF_OF_FORCES) * pressed
        is_right = is_right and push.x >= -BEYOND * pressed and along <= mu * push.x + beyond
    if is_right:
        told.approach, told.bend, told.deepest = approach, bend, max(told.deepest, tried.depth)
        told.residual, told.lowered = max(told.residual, tried.residual), told.lowered + tried.lowered
    return is_right


@kernel
def _put_statuses(scene: ImpactScene, decision: Decision, march: March, h: float) -> None:
    """Write what contacts did in a step to their states, and the energy that they took to the books."""
    points, y, pressed, fastest = scene.loops.points, march.ends[NEXT], 0.0, 0.0
    closed = ClosedPoints(march.step.integers, march.step.numbers)
    count = Tried(march.step.tried, march.step.told).closed
    for a in range(count):
        one = closed[a]
        pressed = max(pressed, largest_in(one.impulse))
        fastest = max(fastest, max(largest_in(one.before), largest_in(one.freely)))
    still = ROUND_OFF_OF_FORCES * fastest
    for a in range(count):
        one, p = closed[a], closed[a].point
        push, mean = one.impulse, 0.5 * (one.before + one.after)
        taken, rubbed = dot(push, mean), push.y * mean.y + push.z * mean.z
        y[len(y) - 2] -= taken
        belt = on_surface(decision.now, p, push.y, push.z)
        y[len(y) - 1] += dot(belt, three(points.numbers[p], OF_POINT.belt))
        if push.x <= ROUND_OFF_OF_FORCES * pressed:
            continue
        slip, contact = np.hypot(one.after.y, one.after.z), scene.looked.first_state + points.places[p, FIRST_STATE]
        y[contact + WORK] -= rubbed
        y[contact + TAKEN] -= taken - rubbed
        y[contact + SLIP] += points.numbers[p, OF_POINT.share] * slip * h
        if one.after.x <= still:  # else it has bounced
            at = scene.looked.first_state + points.places[p, STATUS]
            sticks = points.places[p, HAS_FRICTION] != 0 and slip <= still
            y[at] = 1.0 if sticks else 2.0  # `Status`
            share = AT_REST / slip if slip > 0.0 else 0.0
            way = on_surface(decision.now, p, share * one.after.y, share * one.after.z)
            put_three(y, at + KEPT, Meetings(decision.now.met)[p].place if sticks else way)
