"""Forces of rigid contacts at an event, and what they decide: which of what is at rest sticks, and how slips begin.

The complementarity of accelerations; where it is in balance with the limit of friction, that of a moment later.
"""

from typing import NamedTuple

import numpy as np

from kanefe.kernels.contact.falling import steady_coefficient
from kanefe.kernels.contact.rigid_points import RigidPoint, given_points
from kanefe.kernels.impacts.cones import Cone, Cones, Problem, largest_of, let_choose, rates_by, slips_along, summed
from kanefe.kernels.impacts.contact_questions import WhyNot
from kanefe.kernels.impacts.decision import (
    Asking,
    Decision,
    Look,
    Point,
    Status,
    block,
    is_at_rest,
    look,
    on_surface,
    points_of,
    put_problem,
    solve,
)
from kanefe.kernels.impacts.impulses import moved_by, respond
from kanefe.kernels.impacts.tolerances import ROUND_OFF_OF_FORCES, STICKING
from kanefe.kernels.joints.motion import put_three, three
from kanefe.kernels.language import ZERO, copy, inlined, kernel, largest_in


class Event(NamedTuple):
    """An event of a run.

    Attributes
    ----------
    t : float
        s.
    y : ndarray
        State at it, begins with q, u and z.
    span, stop : float
        Of the run, s.
    is_changed : bool
        Whether speeds have changed since the scene was looked at.
    """

    t: float
    y: np.ndarray
    span: float
    stop: float
    is_changed: bool


@kernel
def put_statuses(asking: Asking, decision: Decision, taking: np.ndarray, event: Event) -> int:
    """Write accelerations, and the status of each point that takes part with its slip; return why they are not known.

    What is at rest sticks, unless the accelerations say that it slips; where these are at the limit of friction, those
    a moment later. Each round lets a point more slip, and none stick again, so that they end.
    """
    points, problem, rigid, k = points_of(decision), decision.problem, given_points(asking.points), 0
    for p in taking:
        points[p].begins = False
        if points[p].is_closed:
            decision.active[k] = p
            k += 1
    active = decision.active[:k]
    put_problem(decision.now.G, active, problem)
    for a in range(k):
        p = active[a]
        _put_cone(points[p], rigid[p], Cones(problem.each)[a])
        put_three(problem.b, 3 * a, three(decision.now.b, 3 * p))
    while True:
        why_not = _follow(asking, decision, active)
        if why_not != WhyNot.FOUND:
            return why_not
        if not _find_slipping(problem, active, decision):
            known, is_any = _find_slipping_soon(asking, decision, taking, active, event)
            if not known:
                return WhyNot.UNKNOWN
            if not is_any:
                break
        for a in range(k):
            point, cone = points[active[a]], Cones(problem.each)[a]
            if point.is_new:
                point.begins, cone.along, cone.across = True, point.along, point.across
                cone.mu = steady_coefficient(rigid[active[a]].friction, 0.0)
    if not _turn(asking, decision, taking, active, event):
        return WhyNot.UNKNOWN
    _put_found(decision, taking, active)
    return WhyNot.FOUND


@inlined
def _put_cone(point: Point, given: RigidPoint, cone: Cone) -> None:
    """Write what a closed point can have."""
    cone.least = cone.mu = cone.along = cone.across = 0.0
    if not given.rubs:
        return
    if is_at_rest(point):
        cone.mu = given.friction.holding
        let_choose(cone)
    else:
        speed = np.hypot(point.rates.y, point.rates.z)
        cone.mu = steady_coefficient(given.friction, speed)
        cone.along, cone.across = point.rates.y / speed, point.rates.z / speed


@kernel
def _put_found(decision: Decision, taking: np.ndarray, active: np.ndarray) -> None:
    """Write the accelerations by the forces that were found, and what they say of each point."""
    points, x, now, largest = points_of(decision), decision.problem.x, decision.now, 0.0
    biggest = largest_of(x, 3 * len(active))
    for p in taking:
        points[p].after = Status.OPEN
        points[p].force = ZERO
    for a in range(len(active)):
        points[active[a]].force = three(x, 3 * a)
    for p in taking:  # by what forces do: to hold what moves more takes a pull that counts
        moved = moved_by(decision, active, p)
        points[p].acceleration = three(now.b, 3 * p) + moved
        largest = max(largest, largest_in(moved))
    least = ROUND_OFF_OF_FORCES * largest if biggest > 0.0 else -1.0
    for a in range(len(active)):
        point, cone = points[active[a]], Cones(decision.problem.each)[a]
        slips = slips_along(cone)
        moves = abs(point.acceleration.x) if slips else largest_in(point.acceleration)
        # what others carry for it stays closed where it would not move either
        if point.force.x <= ROUND_OFF_OF_FORCES * biggest and moves > least:
            continue
        point.after = Status.STICKS
        if slips:
            point.after, point.along, point.across = Status.SLIPS, cone.along, cone.across


@inlined
def _is_at_limit(problem: Problem, a: int, biggest: float) -> bool:
    """Return whether a contact sticks by all that its friction can hold."""
    cone, force = Cones(problem.each)[a], three(problem.x, 3 * a)
    is_full = np.hypot(force.y, force.z) >= STICKING.holds * cone.mu * force.x
    return not slips_along(cone) and force.x > ROUND_OFF_OF_FORCES * biggest and is_full


@kernel
def _find_slipping(problem: Problem, active: np.ndarray, decision: Decision) -> bool:
    """Write which contacts should stick and do not, and along what their accelerations are; return if there are any."""
    points, k, found, largest = points_of(decision), len(active), False, 0.0
    biggest = largest_of(problem.x, 3 * k)
    for a in range(k):
        largest = max(largest, largest_in(summed(problem.G, k, a, problem.x, ZERO)))
    for a in range(k):
        point = points[active[a]]
        point.is_new = False
        if not _is_at_limit(problem, a, biggest):
            continue
        moves = rates_by(problem, k, a, problem.x)
        size = np.hypot(moves.y, moves.z)
        if size > ROUND_OFF_OF_FORCES * largest:
            point.is_new, point.along, point.across, found = True, moves.y / size, moves.z / size, True
    return found


@kernel
def _find_slipping_soon(
    asking: Asking, decision: Decision, taking: np.ndarray, active: np.ndarray, event: Event
) -> tuple[bool, bool]:
    """Write in which directions begins to slip what is held by all that friction can hold.

    Returns
    -------
    is_known, is_any : bool
    """
    points, problem, later, k, is_any = points_of(decision), decision.problem, decision.ahead, len(active), False
    biggest = largest_of(problem.x, 3 * k)
    for a in range(k):
        is_any = is_any or _is_at_limit(problem, a, biggest)
    if not is_any or event.span <= 0.0:
        return True, False
    for share in STICKING.ahead:
        if not _go_ahead(asking, decision, taking, active, share, event):
            return False, False
        if not solve(asking.solving_ahead, later, k, True):
            continue
        _find_slipping(later, active, decision)
        found = stays = False
        height = largest_of(later.x, 3 * k)
        for a in range(k):
            was, point = _is_at_limit(problem, a, biggest), points[active[a]]
            point.is_new = point.is_new and was
            found = found or point.is_new
            stays = stays or (was and _is_at_limit(later, a, height))
        if found or not stays:
            return True, found
    return True, False


@kernel
def _go_ahead(
    asking: Asking, decision: Decision, taking: np.ndarray, active: np.ndarray, share: float, event: Event
) -> bool:
    """Write the problem of the forces a fraction of the span later, with those of now; return if it is known."""
    problem, later, state = decision.problem, decision.ahead, decision.state
    du, step = decision.motion[0], decision.motion[1]
    h, free, k = min(share * event.span, event.stop - event.t), decision.motion.shape[1], len(active)
    if not look(asking, decision, Look.FREE_ACCELERATIONS, event.t, taking):
        return False
    first = asking.first_state - free
    for a in range(k):
        respond(decision, active[a], three(problem.x, 3 * a), du)
    copy(event.y[: len(state)], state)
    for c in range(free):
        step[c] = h * (event.y[first + c] + 0.5 * h * du[c])
        state[first + c] = event.y[first + c] + h * du[c]
    if not look(asking, decision, Look.POINTS_LATER, event.t + h, taking):
        return False
    put_problem(decision.later.G, active, later)
    copy(problem.x[: 3 * k], later.x)
    for a in range(k):
        copy(problem.each[a], later.each[a])
        put_three(later.b, 3 * a, three(decision.later.b, 3 * active[a]))
    return True


@kernel
def _turn(asking: Asking, decision: Decision, taking: np.ndarray, active: np.ndarray, event: Event) -> bool:
    """Write the rates of the directions of slips that begin, in the axes of the surfaces; return if they are known."""
    points, later, is_any = points_of(decision), decision.ahead, False
    h = min(STICKING.ahead[-1] * event.span, event.stop - event.t)
    for p in taking:
        points[p].turning = ZERO
        is_any = is_any or points[p].begins
    if not is_any or h <= 0.0:
        return True
    if not _go_ahead(asking, decision, taking, active, STICKING.ahead[-1], event):
        return False
    for a in range(len(active)):
        if points[active[a]].begins:
            let_choose(Cones(later.each)[a])
    if not solve(asking.solving_ahead, later, len(active), True):
        return True
    for a in range(len(active)):
        p, force = active[a], three(later.x, 3 * a)
        size = np.hypot(force.y, force.z)
        if points[p].begins and size > 0.0:
            slip = Cones(decision.problem.each)[a]
            before = on_surface(decision.now, p, slip.along, slip.across)
            points[p].turning = (1.0 / h) * (on_surface(decision.later, p, -force.y / size, -force.z / size) - before)
    return True


@kernel
def _follow(asking: Asking, decision: Decision, active: np.ndarray) -> int:
    """Write the forces, with slips that begin against the friction of what is free to choose its direction.

    That is known also where it is all but balanced, and accelerations are the difference of large numbers. Returns
    why there are no forces: in Painleve's paradox there are none, or several.
    """
    problem, k, drawn = decision.problem, len(active), -1
    _begin_slips(asking, decision, active)
    for a in range(k):
        cone, own = Cones(problem.each)[a], block(problem.G, a, a).T.x
        if (
            slips_along(cone)
            and own.x - cone.mu * (own.y * cone.along + own.z * cone.across) <= STICKING.not_determined * own.x
        ):
            drawn = a if drawn < 0 else drawn
    is_found = solve(asking.solving, problem, k, False)
    if not is_found and (drawn < 0 or k > 1):
        return WhyNot.NO_FORCES
    if not is_found or drawn >= 0:
        decision.alone[0] = active[drawn]
        return WhyNot.PARADOX
    noise = 0.0
    for p in active:
        own = decision.now.G[3 * p, 3 * p]
        if own > 0.0:
            noise = max(noise, STICKING.round_off_of_accelerations * decision.now.accelerated[p] / own)
    if largest_of(problem.x, 3 * k) <= noise:  # what falls freely presses on nothing
        problem.x[: 3 * k] = 0.0
    return WhyNot.FOUND


@kernel
def _begin_slips(asking: Asking, decision: Decision, active: np.ndarray) -> None:
    """Let slips begin against the friction of what is free to choose its direction."""
    points, problem, is_any = points_of(decision), decision.problem, False
    for a in range(len(active)):
        point, cone = points[active[a]], Cones(problem.each)[a]
        if point.begins:
            point.along, point.across, is_any = cone.along, cone.across, True
            let_choose(cone)
    if not is_any:
        return
    is_free = solve(asking.solving, problem, len(active), False)
    for a in range(len(active)):
        point, cone, force = points[active[a]], Cones(problem.each)[a], three(problem.x, 3 * a)
        size = np.hypot(force.y, force.z) if is_free else 0.0
        if point.begins:
            cone.along = -force.y / size if size > 0.0 else point.along
            cone.across = -force.z / size if size > 0.0 else point.across
