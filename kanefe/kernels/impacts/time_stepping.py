"""Steps of Moreau and Jean over the impacts of rigid contacts in compiled code, from output to output.

The equations are those of `kanefe.literal.impact_steps`. The scene is asked for them by the calls that
events of rigid contacts have: a unit of its own, which is built where a run takes such steps.
"""

import numpy as np

from kanefe.kernels.constraints.contact_margins import Looked
from kanefe.kernels.constraints.loop_tables import head_of, unit_responses_in
from kanefe.kernels.constraints.tolerances import NEAR_SINGULAR
from kanefe.kernels.contact.output_places import Status
from kanefe.kernels.contact.rigid_points import SLIPPING, Meetings, PointStates, RigidStates, given_points
from kanefe.kernels.evaluation.bending import watch_bends
from kanefe.kernels.evaluation.evaluation import LEAST_PIVOT
from kanefe.kernels.events.closing_call import close_at
from kanefe.kernels.impacts.decision import Decision, Look, block, look, on_surface, points_of
from kanefe.kernels.impacts.impulses import respond
from kanefe.kernels.impacts.march import MARCHING, Ending, ImpactScene, March, Progress, Told
from kanefe.kernels.impacts.step_impulses import ClosedPoints, Tried, solve_islands
from kanefe.kernels.impacts.tolerances import ROUND_OFF_OF_FORCES
from kanefe.kernels.language import ZERO, RealRows, Reals, copy, dot, entry, inlined, kernel, largest_in
from kanefe.kernels.scene import Sizes
from kanefe.kernels.steppers.step_commands import VECTOR
from kanefe.kernels.sweeps.advance import advance
from kanefe.kernels.tables import Tables


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
    at = Progress(march.integers, march.reals)
    while at.passed < len(times_of_outputs) and at.most > 0:
        left = at.stop - at.time
        h = left if left <= at.length * (1.0 + MARCHING.round_off) else at.length
        watch_bends(march.bends, march.bent, at.time, march.new)
        done = _step(scene, decision, march, h)
        if done != Ending.DONE:
            return done.value
        copy(march.new, march.old)
        copy(march.tried, march.new)
        at.time_old = at.time
        at.time = at.stop if h == left else at.time + h
        at.most -= 1
        at.steps += 1
        while at.passed < len(times_of_outputs) and times_of_outputs[at.passed] <= at.time:
            _put_between(march, times_of_outputs[at.passed], scene.tables, outputs[at.passed])
            at.passed += 1
    return Ending.DONE.value


@kernel
def _put_between(march: March, t: float, tables: Tables, found: np.ndarray) -> None:
    """Write the state at a time of the last step."""
    old, new, at = march.old, march.new, Progress(march.integers, march.reals)
    share = (t - at.time_old) / (at.time - at.time_old)
    copy(new if share > 0.5 else old, found)
    for i in range(Sizes(tables.sizes).coordinate_count):
        found[i] = (1.0 - share) * old[i] + share * new[i]


@kernel
def _step(scene: ImpactScene, decision: Decision, march: March, h: float) -> Ending:
    """Write the next state after a step of h (s); return whether it is done."""
    looked, y, at, asking = scene.looked, march.tried, march.at, scene.asking
    first, last = Sizes(scene.tables.sizes).coordinate_count, looked.first_state
    t = Progress(march.integers, march.reals).time + 0.5 * h
    _open_all(scene, march)
    advance(scene.tables, scene.flexible, y[:first], y[first:last], 0.5 * h, at[:first])
    if not (look(asking, decision, Look.MARGINS, t, decision.taking[:0]) and _is_regular(looked)):
        return Ending.LEFT
    taking, slope = decision.taking[: _find_closed(decision, march)], looked.vectors[VECTOR.slope]
    for c in range(first, last):
        at[c] = y[c] + 0.5 * h * slope[c]
    if not (look(asking, decision, Look.FREE_ACCELERATIONS, t, taking) and _is_regular(looked)):
        return Ending.LEFT
    for c in range(first, last):
        y[c] += h * slope[c]
        at[c] = y[c]  # what forces at points do is asked with the speeds without them, whose rates are wanted too
    for i in range(len(y) - 2, len(y)):
        y[i] += h * slope[i]
    if len(taking) > 0:
        if not look(asking, decision, Look.POINTS, t, taking):
            return Ending.LEFT
        _put_rates(scene, decision, march, h)
        if not solve_islands(march.step):
            return Ending.LEFT
        if not _strike(decision, march, y[first:last]):
            return Ending.BROKEN
    advance(scene.tables, scene.flexible, at[:first], y[first:last], 0.5 * h, y[:first])
    if scene.closing.has_loops and not close_at(scene.closing, t + 0.5 * h, 0.0, y):
        return Ending.LEFT
    if len(taking) > 0:
        _put_statuses(scene, decision, march, h)
    return Ending.DONE


@inlined
def _is_regular(looked: Looked) -> bool:
    """Return whether the loops hold what they should in the last evaluation."""
    return bool(looked.evaluation.numbers[LEAST_PIVOT] >= NEAR_SINGULAR)


@kernel
def _open_all(scene: ImpactScene, march: March) -> None:
    """Begin a step with all points open."""
    y, points = march.tried, given_points(scene.loops.points)
    copy(march.new, y)
    for p in range(len(points)):
        states = PointStates(y, scene.looked.first_state + points[p].status)
        # also from how deep a point left, and its slip: none
        states.status, states.kept, states.rate = 0.0 + Status.OPEN.value, ZERO, ZERO
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
    tried.depth = tried.approach = tried.bend = 0.0
    for a in range(tried.closed):
        one = closed[a]
        met, curved = Meetings(decision.now.met)[one.point], one.remainder.x
        one.freely = met.rates
        for d in range(len(drives)):
            curved += kept.J[head_of(loops, one.point), free + d] * drives[d, 2]
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
    is_right = tried.depth <= too_deep + MARCHING.doubly * (approach + bend)
    for a in range(tried.closed):
        push, mu = closed[a].impulse, given_points(march.step.points)[closed[a].point].friction.holding
        along, beyond = np.hypot(push.y, push.z), max(MARCHING.beyond * mu, ROUND_OFF_OF_FORCES) * pressed
        is_right = is_right and push.x >= -MARCHING.beyond * pressed and along <= mu * push.x + beyond
    if is_right:
        told.approach, told.bend, told.deepest = approach, bend, max(told.deepest, tried.depth)
        told.residual, told.lowered = max(told.residual, tried.residual), told.lowered + tried.lowered
    return is_right


@kernel
def _put_statuses(scene: ImpactScene, decision: Decision, march: March, h: float) -> None:
    """Write what contacts did in a step to their states, and the energy that they took to the books."""
    points, y, pressed, fastest = given_points(scene.loops.points), march.tried, 0.0, 0.0
    closed, first = ClosedPoints(march.step.integers, march.step.numbers), scene.looked.first_state
    count = Tried(march.step.tried, march.step.told).closed
    for a in range(count):
        one = closed[a]
        pressed = max(pressed, largest_in(one.impulse))
        fastest = max(fastest, max(largest_in(one.before), largest_in(one.freely)))
    still = ROUND_OFF_OF_FORCES * fastest
    for a in range(count):
        one, given, p = closed[a], points[closed[a].point], closed[a].point
        push, mean = one.impulse, 0.5 * (one.before + one.after)
        taken, rubbed = dot(push, mean), push.y * mean.y + push.z * mean.z
        y[len(y) - 2] -= taken
        belt = on_surface(decision.now, p, push.y, push.z)
        y[len(y) - 1] += dot(belt, given.belt)
        if push.x <= ROUND_OFF_OF_FORCES * pressed:
            continue
        slip, contact = np.hypot(one.after.y, one.after.z), RigidStates(y, first + given.first_state)
        contact.work -= rubbed
        contact.taken -= taken - rubbed
        contact.slip += given.share * slip * h
        if one.after.x <= still:  # else it has bounced
            states, sticks = PointStates(y, first + given.status), given.rubs and slip <= still
            states.status = 0.0 + (Status.STICKS if sticks else Status.SLIPS).value
            share = SLIPPING.at_rest / slip if slip > 0.0 else 0.0
            way = on_surface(decision.now, p, share * one.after.y, share * one.after.z)
            states.kept = Meetings(decision.now.met)[p].place if sticks else way
