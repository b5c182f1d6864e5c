"""Events of rigid contacts: impacts, and which of them are open, stick and slip afterwards.

Impacts follow `kanefe.kernels.impacts.impulses`, all contacts that are closed taking part at once. What follows is
decided by the forces: the complementarity of accelerations.
"""

import numpy as np

from kanefe.kernels.contact.rigid_points import (
    SLIPPING,
    GivenPoints,
    ImpactLaw,
    Meeting,
    Meetings,
    PointStates,
    given_points,
)
from kanefe.kernels.impacts.contact_questions import (
    POINT_CODES,
    REPORTED,
    Asks,
    ContactQuestion,
    Inquiry,
    Reported,
    Reports,
    WhyNot,
    margin_of,
    no_blurs,
    question_of,
)
from kanefe.kernels.impacts.decision import (
    Asking,
    Decision,
    Look,
    Point,
    Status,
    is_at_rest,
    look,
    on_surface,
    points_of,
)
from kanefe.kernels.impacts.drawn_in import draw_in, draw_in_together, largest_acceleration
from kanefe.kernels.impacts.impulses import stop, strike
from kanefe.kernels.impacts.stick_or_slip import Event, put_statuses
from kanefe.kernels.impacts.tolerances import CHANGING, ROUND_OFF_OF_FORCES
from kanefe.kernels.language import ZERO, Reals, Vector, dot, entry, inlined, kernel


@entry()
def change_contacts(asking: Asking, decision: Decision, inquiry: Inquiry, y: Reals) -> None:
    """Write speeds and states of rigid contacts after an event to a state, or what is asked of their margins.

    Parameters
    ----------
    asking : Asking
    decision : Decision
    inquiry : Inquiry
    y : ndarray, shape (state,)
        Begins with q, u and z.
    """
    asked, margins_alone = question_of(inquiry), decision.taking[:0]
    asked.gained = 0.0
    if asked.what == Asks.MARGINS:
        is_known = look(asking, decision, Look.MARGINS, asked.when, margins_alone)
        asked.why_not = WhyNot.FOUND if is_known else WhyNot.UNKNOWN
    elif asked.what == Asks.BLURS:
        asked.why_not = _put_blurs(asking, decision, asked)
    else:
        asked.why_not = _change(asking, decision, inquiry, y)


@kernel
def _put_blurs(asking: Asking, decision: Decision, asked: ContactQuestion) -> int:
    """Write how far each kind of margin may be below zero by round-off."""
    points, meetings, blurs, largest, count = points_of(decision), Meetings(decision.now.met), asked.blurs, 0.0, 0
    no_blurs(blurs)
    if not look(asking, decision, Look.MARGINS, asked.when, decision.taking[:0]):
        return WhyNot.UNKNOWN
    for p in range(len(points)):
        point = points[p]
        largest = max(largest, abs(point.normal) if point.normal < np.inf else 0.0)
        point.takes_part = point.left_of_slip < np.inf
        if point.takes_part:
            decision.taking[count] = p
            count += 1
    if count > 0 and not look(asking, decision, Look.POINTS, asked.when, decision.taking[:count]):
        return WhyNot.UNKNOWN
    for p in range(len(points)):
        point, met = points[p], meetings[p]
        if point.gap < np.inf:
            blurs.gap = max(blurs.gap, max(CHANGING.round_off_of_gaps * asked.length, _blur_of_place(met)))
        if point.normal < np.inf:
            blurs.normal = max(blurs.normal, _blur_of_force(point.normal, largest))
        if point.slip_margin < np.inf:
            blurs.slip_margin = max(blurs.slip_margin, _blur_of_force(point.slip_margin, largest))
        if point.left_of_slip < np.inf:
            rest = CHANGING.stopped * decision.now.sizes[p]
            # of a speed v against the slip, 3/2 v is left; for a slipping point the sign is known
            if np.hypot(met.rates.y, met.rates.z) <= rest:
                blurs.left_of_slip = max(blurs.left_of_slip, 1.5 * rest)
    return WhyNot.FOUND


@inlined
def _blur_of_force(margin: float, largest: float) -> float:
    """Return how far below zero a margin is round-off, or what has been decided with it does not see, N."""
    is_accepted = -CHANGING.accepted * largest <= margin < 0.0
    return max(ROUND_OFF_OF_FORCES * largest, -CHANGING.deeper * margin if is_accepted else 0.0)


@inlined
def _blur_of_place(met: Meeting) -> float:
    """Return the round-off of a gap by the distance of its point from the origin, m."""
    return CHANGING.round_off_of_gaps * np.sqrt(dot(met.point, met.point))


@kernel
def _change(asking: Asking, decision: Decision, inquiry: Inquiry, y: np.ndarray) -> int:
    """Write what follows an event; return why it is not known."""
    points, rigid, asked = points_of(decision), given_points(asking.points), question_of(inquiry)
    first, t = asking.first_state, asked.when
    u, z = y[first - decision.motion.shape[1] : first], y[first:]
    if not look(asking, decision, Look.MARGINS, t, decision.taking[:0]):
        return WhyNot.UNKNOWN
    taking = decision.taking[: _select(rigid, decision, asked, u)]
    if len(taking) == 0:
        return WhyNot.FOUND
    if not look(asking, decision, Look.POINTS, t, taking):
        return WhyNot.UNKNOWN
    strikes, fallen = False, largest_acceleration(decision, taking) * CHANGING.moment * asked.span
    for p in taking:
        _begin(points[p], Meetings(decision.now.met)[p].rates, decision.now.sizes[p], fallen, asked)
        strikes = strikes or points[p].rates.x < -points[p].not_moving
    if strikes:
        is_found, gained = strike(asking, decision, taking, u, z)
        if not is_found:
            return WhyNot.NO_IMPULSES
        if gained > 0.0 and not asked.tells_gains:
            return WhyNot.UNKNOWN
        asked.gained = gained
        _tell_of_impact(rigid, decision, taking, inquiry)
    _close(decision, taking)
    is_known, is_drawn = draw_in(asking, decision, taking, t, u, z)
    if not is_known:
        return WhyNot.UNKNOWN
    _close(decision, taking)
    # of a run that goes on beyond the end that it assumed nothing is known
    end = asked.stop if asked.stop >= t else np.inf
    why_not = _decide(asking, decision, taking, Event(t, y, asked.span, end, strikes or is_drawn), inquiry)
    if why_not == WhyNot.FOUND:
        _write(rigid, decision, taking, z)
        _tell(rigid, decision, taking, inquiry)
    return why_not


@kernel
def _decide(asking: Asking, decision: Decision, taking: np.ndarray, event: Event, inquiry: Inquiry) -> int:
    """Find what is open, sticks and slips; return why it is not known.

    Each round closes a point more, so that they end; or it is an impact of what friction draws in, of which there are
    not more.
    """
    first, impacts, is_stale = asking.first_state, 0, event.is_changed
    u, z = event.y[first - decision.motion.shape[1] : first], event.y[first:]
    while True:
        is_stale = stop(asking, decision, taking, u) or is_stale
        if is_stale and not look(asking, decision, Look.POINTS, event.t, taking):
            return WhyNot.UNKNOWN
        is_stale = False
        why_not = put_statuses(asking, decision, taking, event)
        if why_not == WhyNot.NO_FORCES and impacts < len(taking) and draw_in_together(asking, decision, taking, u, z):
            impacts, is_stale = impacts + 1, True
            _close(decision, taking)
        elif why_not != WhyNot.FOUND or not _let_rest(given_points(asking.points), decision, taking, inquiry):
            return why_not


@kernel
def _select(rigid: GivenPoints, decision: Decision, asked: ContactQuestion, u: np.ndarray) -> int:
    """Write which points the event concerns, lets go, and which take part; return how many these are.

    A point whose friction is used up since nothing presses it lifts, at the tip of its cone.
    """
    points, meetings, what, count = points_of(decision), Meetings(decision.now.met), asked.what, 0
    least, scale, pressed = np.inf, 0.0, 0.0
    for p in range(len(points)):
        least = min(least, margin_of(points[p], what))
        pressed = max(pressed, abs(points[p].normal) if points[p].normal < np.inf else 0.0)
    for c in range(len(u)):
        scale = max(scale, abs(u[c]))
    scale = scale if what == Asks.STICK else pressed
    least = max(least, 0.0) if least < np.inf else -np.inf
    for p in range(len(points)):
        point, near = points[p], CHANGING.near * asked.length + _blur_of_place(meetings[p])
        limit = least + (near if what == Asks.TOUCH else CHANGING.near * scale)
        point.is_concerned = what != Asks.START and margin_of(point, what) <= limit
        lifts = what == Asks.LIFT
        if what == Asks.SLIP and point.is_concerned:
            rubs, noise = rigid[p].friction.holding * point.normal - point.slip_margin, CHANGING.near * scale
            # friction that is beyond its limit by the noise, and by how far a root is
            lifts = point.normal <= noise and rubs <= 2.0 * noise
        point.is_lifted = point.is_concerned and lifts
        touches = what == Asks.TOUCH and point.is_concerned
        point.takes_part = point.before != Status.OPEN or meetings[p].gap <= near or touches
        if point.takes_part:
            decision.taking[count] = p
            count += 1
    return count


@inlined
def _begin(point: Point, rates: Vector, size: float, fallen: float, asked: ContactQuestion) -> None:
    """Write the rates of a point, and from where on they count."""
    speed = max(size, asked.length)
    point.not_moving, point.at_rest_below = max(CHANGING.still * size, fallen), max(CHANGING.stopped * size, fallen)
    point.slow, point.is_struck, point.rates = asked.rtol**CHANGING.beginning * speed, False, rates
    if asked.what == Asks.STICK and point.is_concerned:
        # a slip that ends, or turns, within the noise of the run, begins anew or is over
        point.at_rest_below = max(point.at_rest_below, asked.rtol * speed)


@kernel
def _close(decision: Decision, taking: np.ndarray) -> None:
    """Write which points are closed."""
    points = points_of(decision)
    for p in taking:
        points[p].is_closed = points[p].rates.x <= points[p].not_moving and not points[p].is_lifted


@kernel
def _let_rest(rigid: GivenPoints, decision: Decision, taking: np.ndarray, inquiry: Inquiry) -> bool:
    """Close what returns so soon that its impacts cannot be resolved, or before it has left the surface.

    What was found at a depth, as a moment is found, and separates by less than that is never seen to return: each time
    it would be found deeper. Return whether there is any.
    """
    points, is_any, asked = points_of(decision), False, question_of(inquiry)
    for p in taking:
        point, e = points[p], rigid[p].restitution
        rate, fall = point.rates.x, -point.acceleration.x
        if point.is_closed or rate <= 0.0 or fall <= 0.0 or e == 1.0:
            continue
        flight, stays_in = 2.0 * rate / fall, rate * rate <= -2.0 * fall * Meetings(decision.now.met)[p].gap
        if (
            stays_in
            or flight <= CHANGING.short_flight * asked.span
            or flight <= (1.0 - e) * CHANGING.crowded * asked.span
        ):
            point.is_closed, is_any = True, True
            _report(inquiry, asked.when + flight / (1.0 - e), REPORTED * rigid[p].contact + Reported.RESTS)
    return is_any


@kernel
def _write(rigid: GivenPoints, decision: Decision, taking: np.ndarray, z: np.ndarray) -> None:
    """Write the status of each point that takes part, and what it keeps; of other ones from how deep they leave."""
    points, meetings = points_of(decision), Meetings(decision.now.met)
    for p in range(len(points)):
        if not points[p].takes_part:
            states = PointStates(z, rigid[p].status)
            kept = states.kept
            states.kept = Vector(min(kept.x, max(-meetings[p].gap, 0.0)), kept.y, kept.z)
    for p in taking:
        point, met, states = points[p], meetings[p], PointStates(z, rigid[p].status)
        states.status, states.rate = 0.0 + point.after, ZERO
        if point.after == Status.SLIPS:
            speed = max(SLIPPING.at_rest, point.slow if is_at_rest(point) else 0.0)
            states.kept = speed * on_surface(decision.now, p, point.along, point.across)
            states.rate = speed * point.turning
        elif point.after == Status.OPEN:
            states.kept = Vector(max(-met.gap, 0.0), 0.0, 0.0)
        elif point.before != Status.STICKS:
            states.kept = met.place


@kernel
def _report(inquiry: Inquiry, t: float, code: int) -> None:
    """Add a report."""
    asked = question_of(inquiry)
    report = Reports(inquiry.reports)[asked.reports]
    report.t, report.code = t, 0.0 + code
    asked.reports += 1


@kernel
def _tell_of_impact(rigid: GivenPoints, decision: Decision, taking: np.ndarray, inquiry: Inquiry) -> None:
    """Report, once of each contact, that its impact was Poisson's against its law, or depends on an order."""
    points, poisson, order, t = points_of(decision), -1, -1, question_of(inquiry).when
    for p in taking:
        contact = rigid[p].contact
        if contact != poisson and rigid[p].law == ImpactLaw.NEWTON and points[p].is_poisson:
            _report(inquiry, t, REPORTED * contact + Reported.BY_POISSON)
            poisson = contact
        if contact != order and points[p].depends:
            _report(inquiry, t, REPORTED * contact + Reported.BY_ORDER)
            order = contact


@kernel
def _tell(rigid: GivenPoints, decision: Decision, taking: np.ndarray, inquiry: Inquiry) -> None:
    """Report what the event has changed, contact by contact."""
    points, asked = points_of(decision), question_of(inquiry)
    contacts, t, a = rigid[-1].contact + 1, asked.when, 0
    while a < len(taking):
        given = rigid[taking[a]]
        touches = was_closed = is_closed = stuck = slipped = sticks = slips = False
        while a < len(taking) and rigid[taking[a]].contact == given.contact:
            p, point = taking[a], points[taking[a]]
            before, after = point.before, point.after
            is_found = asked.what == Asks.TOUCH and point.is_concerned and after != Status.OPEN
            touches = touches or (before == Status.OPEN and (point.is_struck or is_found))
            was_closed, is_closed = was_closed or before != Status.OPEN, is_closed or after != Status.OPEN
            stuck, slipped = stuck or before == Status.STICKS, slipped or before == Status.SLIPS
            sticks, slips = sticks or after == Status.STICKS, slips or after == Status.SLIPS
            if given.tells and (before != after or (point.is_struck and before == Status.OPEN)):
                code = REPORTED * contacts + POINT_CODES * p + 6 * before + 2 * after + int(point.is_struck)
                _report(inquiry, t, code)
            a += 1
        code = REPORTED * given.contact
        if touches:
            _report(inquiry, t, code + Reported.TOUCHES)
        if was_closed and not is_closed:
            _report(inquiry, t, code + Reported.LIFTS)
        if given.rubs and slips and stuck and not slipped:
            _report(inquiry, t, code + Reported.BEGINS_SLIP)
        if given.rubs and sticks and not slips and (slipped or not was_closed):
            _report(inquiry, t, code + Reported.BEGINS_STICK)
