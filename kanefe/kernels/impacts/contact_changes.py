"""Events of rigid contacts in compiled code: impacts, and what is open, sticks and slips afterwards.

The law is that of `kanefe.kane.rigid_contacts.impacts`, which is independent of this.
"""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.vectors import copy
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
    MET,
    NEWTON,
    OF_POINT,
    STATUS,
    TELLS,
)
from kanefe.kernels.impacts.contact_questions import (
    BEGINS_SLIP,
    BEGINS_STICK,
    BLUR,
    BLURS,
    BY_ORDER,
    BY_POISSON,
    IS_DECIDED,
    LENGTH,
    LIFT,
    LIFTS,
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
    TOUCH,
    TOUCHES,
    WHAT,
    WHEN,
)
from kanefe.kernels.impacts.decision import (
    ACCELERATIONS,
    AFTER,
    AT_REST_BELOW,
    BEFORE,
    IS_CLOSED,
    IS_CONCERNED,
    IS_LIFTED,
    IS_STRUCK,
    IS_TAKING,
    MARGINS_NOW,
    NOT_MOVING,
    ON_GAP,
    ON_LEFT,
    ON_NORMAL,
    ON_SLIP,
    OPEN,
    POINTS_NOW,
    RATES_OF_POINTS,
    SLIP_OF,
    SLIPS,
    SLOW,
    STICKS,
    TAKES,
    TOLD_OF_ORDER,
    TOLD_OF_POISSON,
    TURNING,
    Asking,
    Decision,
    look,
)
from kanefe.kernels.impacts.impulses import is_at_rest, stop, strike
from kanefe.kernels.impacts.stick_or_slip import on_surface, put_statuses
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
from kanefe.kernels.tables import RigidPoints


@entry()
def change_contacts(asking: Asking, decision: Decision, asked: Reals, y: Reals, reports: RealRows) -> None:
    """Write speeds and states of rigid contacts after an event to a state, or how far margins may be below zero.

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
    if int(asked[WHAT]) == BLURS:
        done = _put_blurs(asking, decision, asked, y)
    else:
        done = _change(asking, decision, asked, y, reports)
    asked[IS_DECIDED] = 1.0 if done else 0.0


@kernel
def _put_blurs(asking: Asking, decision: Decision, asked: np.ndarray, y: np.ndarray) -> bool:
    """Write how far each kind of margin may be below zero by round-off."""
    now = decision.now
    flags = decision.flags
    asked[BLUR : BLUR + 4] = 0.0
    if not look(asking, decision, MARGINS_NOW, asked[WHEN], 0):
        return False
    found, largest, asks = decision.margins, 0.0, 0
    for p in range(len(found)):
        largest = max(largest, abs(found[p, ON_NORMAL]) if found[p, ON_NORMAL] < np.inf else 0.0)
        flags[IS_TAKING, p] = found[p, ON_LEFT] < np.inf
        if flags[IS_TAKING, p] != 0:
            flags[TAKES, asks] = p
            asks += 1
    if asks > 0 and not look(asking, decision, POINTS_NOW, asked[WHEN], asks):
        return False
    for p in range(len(found)):
        if found[p, ON_GAP] < np.inf:
            asked[BLUR] = max(asked[BLUR], max(ROUND_OFF_OF_GAPS * asked[LENGTH], _blur_of_place(now.met, p)))
        lift, slip = BLUR + LIFT - TOUCH, BLUR + SLIP - TOUCH
        if found[p, ON_NORMAL] < np.inf:
            asked[lift] = max(asked[lift], _blur_of_force(found[p, ON_NORMAL], largest))
        if found[p, ON_SLIP] < np.inf:
            asked[slip] = max(asked[slip], _blur_of_force(found[p, ON_SLIP], largest))
        if found[p, ON_LEFT] < np.inf:
            rest = STOPPED * now.sizes[p]
            # of a speed v against the slip, 3/2 v is left; for a slipping point the sign is known
            if np.hypot(now.met[p, MET.rates + 1], now.met[p, MET.rates + 2]) <= rest:
                asked[BLUR + STICK - TOUCH] = max(asked[BLUR + STICK - TOUCH], 1.5 * rest)
    return True


@inlined
def _blur_of_force(margin: float, largest: float) -> float:
    """Return how far below zero a margin is round-off, or what has been decided with it does not see, N."""
    is_accepted = -ACCEPTED * largest <= margin < 0.0
    return max(ROUND_OFF_OF_FORCES * largest, -DEEPER * margin if is_accepted else 0.0)


@kernel
def _change(asking: Asking, decision: Decision, asked: np.ndarray, y: np.ndarray, reports: np.ndarray) -> bool:
    """Write what follows an event; return whether it is known."""
    now = decision.now
    flags, vectors, speeds = decision.flags, decision.vectors, decision.speeds
    t, what = asked[WHEN], int(asked[WHAT])
    u, span = y[asking.first_state - decision.motion.shape[1] : asking.first_state], asked[RUN_SPAN]
    if not look(asking, decision, MARGINS_NOW, t, 0):
        return False
    count = _select(asking.points, decision, asked, u)
    if count == 0:
        return True
    if not look(asking, decision, POINTS_NOW, t, count):
        return False
    largest, strikes = 0.0, False
    for a in range(count):
        p = flags[TAKES, a]
        for i in range(3 * p, 3 * p + 3):
            largest = max(largest, abs(now.b[i]))
    fallen = largest * MOMENT * span
    for a in range(count):
        p = flags[TAKES, a]
        size = now.sizes[p]
        speed = max(size, asked[LENGTH])
        speeds[NOT_MOVING, p], speeds[AT_REST_BELOW, p] = (
            max(STILL * size, fallen),
            max(STOPPED * size, fallen),
        )
        speeds[SLOW, p] = asked[RUN_RTOL] ** BEGINNING * speed
        if what == STICK and flags[IS_CONCERNED, p] != 0:
            # a slip that ends, or turns, within the noise of the run, begins anew or is over
            speeds[AT_REST_BELOW, p] = max(speeds[AT_REST_BELOW, p], asked[RUN_RTOL] * speed)
        copy(now.met[p, MET.rates : MET.rates + 3], vectors[RATES_OF_POINTS][3 * p : 3 * p + 3])
        flags[IS_STRUCK, p] = 0
        strikes = strikes or vectors[RATES_OF_POINTS, 3 * p] < -speeds[NOT_MOVING, p]
    if strikes:
        if not strike(asking, decision, count, u, y[asking.first_state :]):
            return False
        _tell_of_impact(asking, decision, count, asked, reports)
    for a in range(count):
        p = flags[TAKES, a]
        flags[IS_CLOSED, p] = vectors[RATES_OF_POINTS, 3 * p] <= speeds[NOT_MOVING, p] and flags[IS_LIFTED, p] == 0
    # of a run that goes on beyond the end that it assumed nothing is known
    is_stale, event = strikes, (t, y, span, asked[RUN_END] if asked[RUN_END] >= t else np.inf)
    while True:
        is_stale = stop(asking, decision, count, u) or is_stale
        if is_stale and not look(asking, decision, POINTS_NOW, t, count):
            return False
        is_stale = False
        if not put_statuses(asking, decision, count, event):
            return False
        if not _let_rest(asking, decision, count, asked, reports):
            break
    _write(asking, decision, count, y[asking.first_state :])
    _tell(asking, decision, count, asked, reports)
    return True


@kernel
def _select(points: RigidPoints, decision: Decision, asked: np.ndarray, u: np.ndarray) -> int:
    """Write which points the event concerns, lets go, and which take part; return how many these are.

    A point whose friction is used up since nothing presses it lifts, at the tip of its cone.
    """
    flags = decision.flags
    what, margins, count = int(asked[WHAT]), decision.margins, 0
    column, least, scale = max(what - TOUCH, 0), np.inf, 0.0
    for p in range(len(margins)):
        least = min(least, margins[p, column])
        scale = max(scale, abs(margins[p, ON_NORMAL]) if margins[p, ON_NORMAL] < np.inf else 0.0)
    if what == STICK:
        scale = 0.0
        for c in range(len(u)):
            scale = max(scale, abs(u[c]))
    least = max(least, 0.0) if least < np.inf else -np.inf
    for p in range(len(margins)):
        near = NEAR * asked[LENGTH] + _blur_of_place(decision.now.met, p)
        limit = least + (near if what == TOUCH else NEAR * scale)
        flags[IS_CONCERNED, p] = what != START and margins[p, column] <= limit
        lifts = what == LIFT
        if what == SLIP and flags[IS_CONCERNED, p] != 0:
            normal, noise = margins[p, ON_NORMAL], NEAR * scale
            rubs = points.numbers[p, HOLDING] * normal - margins[p, ON_SLIP]
            # friction that is beyond its limit by the noise, and by how far a root is
            lifts = normal <= noise and rubs <= 2.0 * noise
        flags[IS_LIFTED, p] = flags[IS_CONCERNED, p] != 0 and lifts
        touches, gap = what == TOUCH and flags[IS_CONCERNED, p] != 0, decision.now.met[p, MET.gap]
        flags[IS_TAKING, p] = flags[BEFORE, p] != OPEN or gap <= near or touches
        if flags[IS_TAKING, p] != 0:
            flags[TAKES, count] = p
            count += 1
    return count


@inlined
def _blur_of_place(met: np.ndarray, p: int) -> float:
    """Return the round-off of a gap by the distance of its point from the origin, m."""
    return ROUND_OFF_OF_GAPS * np.sqrt(met[p, MET.point] ** 2 + met[p, MET.point + 1] ** 2 + met[p, MET.point + 2] ** 2)


@kernel
def _let_rest(asking: Asking, decision: Decision, count: int, asked: np.ndarray, reports: np.ndarray) -> bool:
    """Close what returns so soon that its impacts cannot be resolved, or before it has left the surface.

    What was found at a depth, as a moment is found, and separates by less than that is never seen to return: each time
    it would be found deeper. Return whether there is any.
    """
    flags, vectors = decision.flags, decision.vectors
    is_any, span, points = False, asked[RUN_SPAN], asking.points
    for a in range(count):
        p = flags[TAKES, a]
        rate, fall, e = (
            vectors[RATES_OF_POINTS, 3 * p],
            -vectors[ACCELERATIONS, 3 * p],
            points.numbers[p, OF_POINT.restitution],
        )
        if flags[IS_CLOSED, p] != 0 or rate <= 0.0 or fall <= 0.0 or e == 1.0:
            continue
        flight, stays_in = 2.0 * rate / fall, rate * rate <= -2.0 * fall * decision.now.met[p, MET.gap]
        if stays_in or flight <= SHORT_FLIGHT * span or flight <= (1.0 - e) * CROWDED * span:
            flags[IS_CLOSED, p], is_any = 1, True
            _report(asked, reports, asked[WHEN] + flight / (1.0 - e), REPORTED * points.places[p, CONTACT] + RESTS)
    return is_any


@kernel
def _write(asking: Asking, decision: Decision, count: int, z: np.ndarray) -> None:
    """Write the status of each point that takes part, and what it keeps; of other ones from how deep they leave."""
    flags, directions = decision.flags, decision.directions
    for p in range(len(asking.points.places)):
        if flags[IS_TAKING, p] == 0:
            at = asking.points.places[p, STATUS] + KEPT
            z[at] = min(z[at], max(-decision.now.met[p, MET.gap], 0.0))
    for a in range(count):
        p = flags[TAKES, a]
        at, after = asking.points.places[p, STATUS], flags[AFTER, p]
        is_same = after == STICKS and flags[BEFORE, p] == STICKS
        z[at] = after
        z[at + KEPT_RATE : at + KEPT_RATE + 3] = 0.0
        if after == SLIPS:
            speed = max(AT_REST, decision.speeds[SLOW, p] if is_at_rest(decision, p) else 0.0)
            along = on_surface(decision.now, p, directions[SLIP_OF, p, 0], directions[SLIP_OF, p, 1])
            for c in range(3):
                z[at + KEPT + c], z[at + KEPT_RATE + c] = speed * along[c], speed * directions[TURNING, p, c]
        elif not is_same:
            for c in range(3):
                z[at + KEPT + c] = decision.now.met[p, MET.place + c] if after == STICKS else 0.0
            if after == OPEN:
                z[at + KEPT] = max(-decision.now.met[p, MET.gap], 0.0)


@kernel
def _report(asked: np.ndarray, reports: np.ndarray, t: float, code: int) -> None:
    """Add a report."""
    row = int(asked[REPORT_COUNT])
    reports[row, 0], reports[row, 1] = t, code
    asked[REPORT_COUNT] = row + 1


@kernel
def _tell_of_impact(asking: Asking, decision: Decision, count: int, asked: np.ndarray, reports: np.ndarray) -> None:
    """Report, once of each contact, that its impact was Poisson's against its law, or depends on an order."""
    places, flags, poisson, order = asking.points.places, decision.flags, -1, -1
    for a in range(count):
        p = flags[TAKES, a]
        contact = places[p, CONTACT]
        if contact != poisson and places[p, LAW] == NEWTON and flags[TOLD_OF_POISSON, p] != 0:
            _report(asked, reports, asked[WHEN], REPORTED * contact + BY_POISSON)
            poisson = contact
        if contact != order and flags[TOLD_OF_ORDER, p] != 0:
            _report(asked, reports, asked[WHEN], REPORTED * contact + BY_ORDER)
            order = contact


@kernel
def _tell(asking: Asking, decision: Decision, count: int, asked: np.ndarray, reports: np.ndarray) -> None:
    """Report what the event has changed, contact by contact."""
    flags = decision.flags
    places, t, what = asking.points.places, asked[WHEN], int(asked[WHAT])
    contacts, a = places[len(places) - 1, CONTACT] + 1, 0
    while a < count:
        contact = places[flags[TAKES, a], CONTACT]
        touches = was_closed = is_closed = stuck = slipped = sticks = slips = False
        while a < count and places[flags[TAKES, a], CONTACT] == contact:
            p = flags[TAKES, a]
            before, after, struck = flags[BEFORE, p], flags[AFTER, p], flags[IS_STRUCK, p]
            is_found = what == TOUCH and flags[IS_CONCERNED, p] != 0 and after != OPEN
            touches = touches or (before == OPEN and (struck != 0 or is_found))
            was_closed, is_closed = was_closed or before != OPEN, is_closed or after != OPEN
            stuck, slipped = stuck or before == STICKS, slipped or before == SLIPS
            sticks, slips = sticks or after == STICKS, slips or after == SLIPS
            if places[p, TELLS] != 0 and (before != after or (struck != 0 and before == OPEN)):
                code = REPORTED * contacts + POINT_CODES * p + 6 * before + 2 * after + struck
                _report(asked, reports, t, code)
            a += 1
        code, rubs = REPORTED * contact, places[flags[TAKES, a - 1], HAS_FRICTION] != 0
        if touches:
            _report(asked, reports, t, code + TOUCHES)
        if was_closed and not is_closed:
            _report(asked, reports, t, code + LIFTS)
        if rubs and slips and stuck and not slipped:
            _report(asked, reports, t, code + BEGINS_SLIP)
        if rubs and sticks and not slips and (slipped or not was_closed):
            _report(asked, reports, t, code + BEGINS_STICK)
