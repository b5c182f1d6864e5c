"""Events of rigid contacts: impacts, and which of them are open, stick and slip afterwards.

Impacts follow `kanefe.kernels.impacts.impulses`, all contacts that are closed taking part at once. What follows is
decided by the forces: the complementarity of accelerations.
"""

from __future__ import annotations

import numpy as np

from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.compiler.arrays import RealRows, Reals
from kanefe.kernels.compiler.entries import entry
from kanefe.kernels.contact.rigid_points import (
    AT_REST,
    CONTACT,
    HAS_FRICTION,
    HOLDING,
    KEPT,
    KEPT_RATE,
    LAW,
    NEWTON,
    OF_POINT,
    STATUS,
    TELLS,
    Meeting,
    Meetings,
)
from kanefe.kernels.impacts.contact_questions import (
    BEGINS_SLIP,
    BEGINS_STICK,
    BLUR,
    BLURS,
    BY_ORDER,
    BY_POISSON,
    GAINED,
    IS_DECIDED,
    LENGTH,
    LIFT,
    LIFTS,
    MARGINS,
    NO_FORCES,
    NO_IMPULSES,
    POINT_CODES,
    REPORT_COUNT,
    REPORTED,
    RESTS,
    RUN_END,
    RUN_RTOL,
    RUN_SPAN,
    SLIP,
    START,
    STICK,
    TELLS_GAINS,
    TOUCH,
    TOUCHES,
    UNKNOWN,
    WHAT,
    WHEN,
    WHY_NOT,
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
from kanefe.kernels.impacts.stick_or_slip import FOUND, Event, put_statuses
from kanefe.kernels.impacts.tolerances import (
    ACCEPTED,
    BEGINNING,
    CROWDED,
    DEEPER,
    MOMENT,
    NEAR,
    ROUND_OFF_OF_FORCES,
    ROUND_OFF_OF_GAPS,
    SHORT_FLIGHT,
    STILL,
    STOPPED,
)
from kanefe.kernels.joints.motion import put_three
from kanefe.kernels.tables import RigidPoints
from kanefe.kernels.values.tensors import ZERO, Vector, dot


@entry()
def change_contacts(asking: Asking, decision: Decision, asked: Reals, y: Reals, reports: RealRows) -> None:
    """Write speeds and states of rigid contacts after an event to a state, or what is asked of their margins.

    Parameters
    ----------
    asking : Asking
    decision : Decision
    asked : ndarray, shape (ASKED,)
    y : ndarray, shape (state,)
        Begins with q, u and z.
    reports : ndarray, shape (R, 2)
        On return, behind those that there are: times and codes of what is told: ``REPORTED contact + what``, and behind
        those of all contacts ``POINT_CODES point + 6 before + 2 after + is struck``.
    """
    what, asked[GAINED] = int(asked[WHAT]), 0.0
    if what == MARGINS:
        why_not = FOUND if look(asking, decision, Look.MARGINS, asked[WHEN], decision.taking[:0]) else UNKNOWN
    elif what == BLURS:
        why_not = _put_blurs(asking, decision, asked)
    else:
        why_not = _change(asking, decision, asked, y, reports)
    asked[IS_DECIDED], asked[WHY_NOT] = 1.0 if why_not == FOUND else 0.0, why_not


@kernel
def _put_blurs(asking: Asking, decision: Decision, asked: np.ndarray) -> int:
    """Write how far each kind of margin may be below zero by round-off."""
    points, meetings, largest, count = points_of(decision), Meetings(decision.now.met), 0.0, 0
    asked[BLUR : BLUR + 4] = 0.0
    if not look(asking, decision, Look.MARGINS, asked[WHEN], decision.taking[:0]):
        return UNKNOWN
    for p in range(len(points)):
        point = points[p]
        largest = max(largest, abs(point.normal) if point.normal < np.inf else 0.0)
        point.takes_part = point.left_of_slip < np.inf
        if point.takes_part:
            decision.taking[count] = p
            count += 1
    if count > 0 and not look(asking, decision, Look.POINTS, asked[WHEN], decision.taking[:count]):
        return UNKNOWN
    for p in range(len(points)):
        point, met = points[p], meetings[p]
        if point.gap < np.inf:
            asked[BLUR] = max(asked[BLUR], max(ROUND_OFF_OF_GAPS * asked[LENGTH], _blur_of_place(met)))
        lift, slip, stick = BLUR + LIFT - TOUCH, BLUR + SLIP - TOUCH, BLUR + STICK - TOUCH
        if point.normal < np.inf:
            asked[lift] = max(asked[lift], _blur_of_force(point.normal, largest))
        if point.slip_margin < np.inf:
            asked[slip] = max(asked[slip], _blur_of_force(point.slip_margin, largest))
        if point.left_of_slip < np.inf:
            rest = STOPPED * decision.now.sizes[p]
            # of a speed v against the slip, 3/2 v is left; for a slipping point the sign is known
            if np.hypot(met.rates.y, met.rates.z) <= rest:
                asked[stick] = max(asked[stick], 1.5 * rest)
    return FOUND


@inlined
def _blur_of_force(margin: float, largest: float) -> float:
    """Return how far below zero a margin is round-off, or what has been decided with it does not see, N."""
    is_accepted = -ACCEPTED * largest <= margin < 0.0
    return max(ROUND_OFF_OF_FORCES * largest, -DEEPER * margin if is_accepted else 0.0)


@inlined
def _blur_of_place(met: Meeting) -> float:
    """Return the round-off of a gap by the distance of its point from the origin, m."""
    return ROUND_OFF_OF_GAPS * np.sqrt(dot(met.point, met.point))


@kernel
def _change(asking: Asking, decision: Decision, asked: np.ndarray, y: np.ndarray, reports: np.ndarray) -> int:
    """Write what follows an event; return why it is not known."""
    points, t, first = points_of(decision), asked[WHEN], asking.first_state
    u, z = y[first - decision.motion.shape[1] : first], y[first:]
    if not look(asking, decision, Look.MARGINS, t, decision.taking[:0]):
        return UNKNOWN
    taking = decision.taking[: _select(asking.points, decision, asked, u)]
    if len(taking) == 0:
        return FOUND
    if not look(asking, decision, Look.POINTS, t, taking):
        return UNKNOWN
    strikes, fallen = False, largest_acceleration(decision, taking) * MOMENT * asked[RUN_SPAN]
    for p in taking:
        _begin(points[p], Meetings(decision.now.met)[p].rates, decision.now.sizes[p], fallen, asked)
        strikes = strikes or points[p].rates.x < -points[p].not_moving
    if strikes:
        is_found, gained = strike(asking, decision, taking, u, z)
        if not is_found:
            return NO_IMPULSES
        if gained > 0.0 and asked[TELLS_GAINS] == 0.0:
            return UNKNOWN
        asked[GAINED] = gained
        _tell_of_impact(asking.points, decision, taking, asked, reports)
    _close(decision, taking)
    is_known, is_drawn = draw_in(asking, decision, taking, t, u, z)
    if not is_known:
        return UNKNOWN
    _close(decision, taking)
    # of a run that goes on beyond the end that it assumed nothing is known
    end = asked[RUN_END] if asked[RUN_END] >= t else np.inf
    why_not = _decide(asking, decision, taking, Event(t, y, asked[RUN_SPAN], end, strikes or is_drawn), asked, reports)
    if why_not == FOUND:
        _write(asking.points, decision, taking, z)
        _tell(asking.points, decision, taking, asked, reports)
    return why_not


@kernel
def _decide(
    asking: Asking, decision: Decision, taking: np.ndarray, event: Event, asked: np.ndarray, reports: np.ndarray
) -> int:
    """Find what is open, sticks and slips; return why it is not known.

    Each round closes a point more, so that they end; or it is an impact of what friction draws in, of which there are
    not more.
    """
    first, impacts, is_stale = asking.first_state, 0, event.is_changed
    u, z = event.y[first - decision.motion.shape[1] : first], event.y[first:]
    while True:
        is_stale = stop(asking, decision, taking, u) or is_stale
        if is_stale and not look(asking, decision, Look.POINTS, event.t, taking):
            return UNKNOWN
        is_stale = False
        why_not = put_statuses(asking, decision, taking, event)
        if why_not == NO_FORCES and impacts < len(taking) and draw_in_together(asking, decision, taking, u, z):
            impacts, is_stale = impacts + 1, True
            _close(decision, taking)
        elif why_not != FOUND or not _let_rest(asking.points, decision, taking, asked, reports):
            return why_not


@kernel
def _select(rigid: RigidPoints, decision: Decision, asked: np.ndarray, u: np.ndarray) -> int:
    """Write which points the event concerns, lets go, and which take part; return how many these are.

    A point whose friction is used up since nothing presses it lifts, at the tip of its cone.
    """
    points, meetings, what, count = points_of(decision), Meetings(decision.now.met), int(asked[WHAT]), 0
    least, scale, pressed = np.inf, 0.0, 0.0
    for p in range(len(points)):
        least = min(least, _margin(points[p], what))
        pressed = max(pressed, abs(points[p].normal) if points[p].normal < np.inf else 0.0)
    for c in range(len(u)):
        scale = max(scale, abs(u[c]))
    scale = scale if what == STICK else pressed
    least = max(least, 0.0) if least < np.inf else -np.inf
    for p in range(len(points)):
        point, near = points[p], NEAR * asked[LENGTH] + _blur_of_place(meetings[p])
        limit = least + (near if what == TOUCH else NEAR * scale)
        point.is_concerned = what != START and _margin(point, what) <= limit
        lifts = what == LIFT
        if what == SLIP and point.is_concerned:
            rubs, noise = rigid.numbers[p, HOLDING] * point.normal - point.slip_margin, NEAR * scale
            # friction that is beyond its limit by the noise, and by how far a root is
            lifts = point.normal <= noise and rubs <= 2.0 * noise
        point.is_lifted = point.is_concerned and lifts
        touches = what == TOUCH and point.is_concerned
        point.takes_part = point.before != Status.OPEN or meetings[p].gap <= near or touches
        if point.takes_part:
            decision.taking[count] = p
            count += 1
    return count


@inlined
def _margin(point: Point, what: int) -> float:
    """Return how far a point is from a kind of event."""
    found = point.gap
    if what == LIFT:
        found = point.normal
    elif what == SLIP:
        found = point.slip_margin
    elif what == STICK:
        found = point.left_of_slip
    return found


@inlined
def _begin(point: Point, rates: Vector, size: float, fallen: float, asked: np.ndarray) -> None:
    """Write the rates of a point, and from where on they count."""
    speed = max(size, asked[LENGTH])
    point.not_moving, point.at_rest_below = max(STILL * size, fallen), max(STOPPED * size, fallen)
    point.slow, point.is_struck, point.rates = asked[RUN_RTOL] ** BEGINNING * speed, False, rates
    if int(asked[WHAT]) == STICK and point.is_concerned:
        # a slip that ends, or turns, within the noise of the run, begins anew or is over
        point.at_rest_below = max(point.at_rest_below, asked[RUN_RTOL] * speed)


@kernel
def _close(decision: Decision, taking: np.ndarray) -> None:
    """Write which points are closed."""
    points = points_of(decision)
    for p in taking:
        points[p].is_closed = points[p].rates.x <= points[p].not_moving and not points[p].is_lifted


@kernel
def _let_rest(
    rigid: RigidPoints, decision: Decision, taking: np.ndarray, asked: np.ndarray, reports: np.ndarray
) -> bool:
    """Close what returns so soon that its impacts cannot be resolved, or before it has left the surface.

    What was found at a depth, as a moment is found, and separates by less than that is never seen to return: each time
    it would be found deeper. Return whether there is any.
    """
    points, is_any, span = points_of(decision), False, asked[RUN_SPAN]
    for p in taking:
        point, e = points[p], rigid.numbers[p, OF_POINT.restitution]
        rate, fall = point.rates.x, -point.acceleration.x
        if point.is_closed or rate <= 0.0 or fall <= 0.0 or e == 1.0:
            continue
        flight, stays_in = 2.0 * rate / fall, rate * rate <= -2.0 * fall * Meetings(decision.now.met)[p].gap
        if stays_in or flight <= SHORT_FLIGHT * span or flight <= (1.0 - e) * CROWDED * span:
            point.is_closed, is_any = True, True
            _report(asked, reports, asked[WHEN] + flight / (1.0 - e), REPORTED * rigid.places[p, CONTACT] + RESTS)
    return is_any


@kernel
def _write(rigid: RigidPoints, decision: Decision, taking: np.ndarray, z: np.ndarray) -> None:
    """Write the status of each point that takes part, and what it keeps; of other ones from how deep they leave."""
    points, meetings = points_of(decision), Meetings(decision.now.met)
    for p in range(len(points)):
        if not points[p].takes_part:
            at = rigid.places[p, STATUS] + KEPT
            z[at] = min(z[at], max(-meetings[p].gap, 0.0))
    for p in taking:
        point, met, at, rate = points[p], meetings[p], rigid.places[p, STATUS], ZERO
        z[at] = point.after
        if point.after == Status.SLIPS:
            speed = max(AT_REST, point.slow if is_at_rest(point) else 0.0)
            put_three(z, at + KEPT, speed * on_surface(decision.now, p, point.along, point.across))
            rate = speed * point.turning
        elif point.after == Status.OPEN:
            put_three(z, at + KEPT, Vector(max(-met.gap, 0.0), 0.0, 0.0))
        elif point.before != Status.STICKS:
            put_three(z, at + KEPT, met.place)
        put_three(z, at + KEPT_RATE, rate)


@kernel
def _report(asked: np.ndarray, reports: np.ndarray, t: float, code: int) -> None:
    """Add a report."""
    row = int(asked[REPORT_COUNT])
    reports[row, 0], reports[row, 1] = t, code
    asked[REPORT_COUNT] = row + 1


@kernel
def _tell_of_impact(
    rigid: RigidPoints, decision: Decision, taking: np.ndarray, asked: np.ndarray, reports: np.ndarray
) -> None:
    """Report, once of each contact, that its impact was Poisson's against its law, or depends on an order."""
    points, poisson, order = points_of(decision), -1, -1
    for p in taking:
        contact = rigid.places[p, CONTACT]
        if contact != poisson and rigid.places[p, LAW] == NEWTON and points[p].is_poisson:
            _report(asked, reports, asked[WHEN], REPORTED * contact + BY_POISSON)
            poisson = contact
        if contact != order and points[p].depends:
            _report(asked, reports, asked[WHEN], REPORTED * contact + BY_ORDER)
            order = contact


@kernel
def _tell(rigid: RigidPoints, decision: Decision, taking: np.ndarray, asked: np.ndarray, reports: np.ndarray) -> None:
    """Report what the event has changed, contact by contact."""
    points, places, t, what = points_of(decision), rigid.places, asked[WHEN], int(asked[WHAT])
    contacts, a = places[len(places) - 1, CONTACT] + 1, 0
    while a < len(taking):
        contact = places[taking[a], CONTACT]
        touches = was_closed = is_closed = stuck = slipped = sticks = slips = False
        while a < len(taking) and places[taking[a], CONTACT] == contact:
            p, point = taking[a], points[taking[a]]
            before, after = point.before, point.after
            is_found = what == TOUCH and point.is_concerned and after != Status.OPEN
            touches = touches or (before == Status.OPEN and (point.is_struck or is_found))
            was_closed, is_closed = was_closed or before != Status.OPEN, is_closed or after != Status.OPEN
            stuck, slipped = stuck or before == Status.STICKS, slipped or before == Status.SLIPS
            sticks, slips = sticks or after == Status.STICKS, slips or after == Status.SLIPS
            if places[p, TELLS] != 0 and (before != after or (point.is_struck and before == Status.OPEN)):
                code = REPORTED * contacts + POINT_CODES * p + 6 * before + 2 * after + int(point.is_struck)
                _report(asked, reports, t, code)
            a += 1
        code, rubs = REPORTED * contact, places[taking[a - 1], HAS_FRICTION] != 0
        if touches:
            _report(asked, reports, t, code + TOUCHES)
        if was_closed and not is_closed:
            _report(asked, reports, t, code + LIFTS)
        if rubs and slips and stuck and not slipped:
            _report(asked, reports, t, code + BEGINS_SLIP)
        if rubs and sticks and not slips and (slipped or not was_closed):
            _report(asked, reports, t, code + BEGINS_STICK)
