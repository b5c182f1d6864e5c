"""Events of rigid contacts in compiled code: impacts, and what is open, sticks and slips afterwards.

The law is that of `kanefe.kane.rigid_contacts.impacts`, which is independent of this.
"""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.vectors import copy
from kanefe.kernels.compiler._numba import kernel
from kanefe.kernels.compiler.arrays import Filler, RealRows, Reals
from kanefe.kernels.compiler.entries import entry
from kanefe.kernels.compiler.signatures import Variant
from kanefe.kernels.constraints.contact_margins import Looked
from kanefe.kernels.constraints.loop_tables import Loops
from kanefe.kernels.contact.rigid_points import (
    AT_REST,
    CONTACT,
    HAS_FRICTION,
    KEPT,
    KEPT_RATE,
    MET,
    OF_POINT,
    STATUS,
    TELLS,
)
from kanefe.kernels.impacts.contact_questions import (
    BEGINS_SLIP,
    BEGINS_STICK,
    BLUR,
    BLURS,
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
    ON_GAP,
    ON_LEFT,
    ON_NORMAL,
    ON_SLIP,
    OPEN,
    SLIPS,
    STICKS,
    ContactScene,
    Decision,
)
from kanefe.kernels.impacts.impulses import is_at_rest, stop, strike
from kanefe.kernels.impacts.moments import put_margins, put_moment
from kanefe.kernels.impacts.stick_or_slip import on_surface, put_statuses
from kanefe.kernels.impacts.tolerances import (
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
from kanefe.kernels.layout import FlexibleTables, Tables
from kanefe.kernels.sweeps.drives import Drives


@entry(Variant(has_flexible=True))
def change_contacts(
    looked: Looked,
    loops: Loops,
    tables: Tables,
    flexible: FlexibleTables,
    motions: Drives,
    fill: Filler,
    held: Reals,
    decision: Decision,
    asked: Reals,
    y: Reals,
    reports: RealRows,
) -> None:
    """Write speeds and states of rigid contacts after an event to a state, or how far margins may be below zero.

    Parameters
    ----------
    looked, loops, tables, flexible, motions, fill, held
        See `kanefe.kernels.impacts.decision.ContactScene`.
    decision : Decision
    asked : ndarray, shape (ASKED,)
    y : ndarray, shape (state,)
        Begins with q, u and z.
    reports : ndarray, shape (R, 2)
        On return, behind those that there are: times and codes of what is told: ``REPORTED contact + what``, and behind
        those of all contacts ``POINT_CODES point + 6 before + 2 after + is struck``.
    """
    scene = ContactScene(looked, loops, tables, flexible, motions, fill, held)
    if int(asked[WHAT]) == BLURS:
        done = _put_blurs(scene, decision, asked, y)
    else:
        done = _change(scene, decision, asked, y, reports)
    asked[IS_DECIDED] = 1.0 if done else 0.0


@kernel
def _put_blurs(scene: ContactScene, decision: Decision, asked: np.ndarray, y: np.ndarray) -> bool:
    """Write how far each kind of margin may be below zero by round-off."""
    asked[BLUR : BLUR + 4] = 0.0
    if not put_margins(scene, decision, asked[WHEN], y):
        return False
    found, largest, slipping = decision.margins, 0.0, 0
    for p in range(len(found)):
        largest = max(largest, abs(found[p, ON_NORMAL]) if found[p, ON_NORMAL] < np.inf else 0.0)
        decision.is_taking[p] = found[p, ON_LEFT] < np.inf
        if decision.is_taking[p] != 0:
            decision.takes[slipping] = p
            slipping += 1
    for p in range(len(found)):
        gap, rate = found[p, ON_GAP], decision.now.met[p, MET.rates]
        if gap < np.inf:
            # what has bounced leaves from as deep as the moment of its impact was missed
            deep = DEEPER * -gap if gap < 0.0 and rate > 0.0 else 0.0
            asked[BLUR] = max(asked[BLUR], max(ROUND_OFF_OF_GAPS * asked[LENGTH], deep))
        if found[p, ON_NORMAL] < np.inf:
            asked[BLUR + LIFT - TOUCH] = ROUND_OFF_OF_FORCES * largest
        if found[p, ON_SLIP] < np.inf:
            asked[BLUR + SLIP - TOUCH] = ROUND_OFF_OF_FORCES * largest
    if slipping > 0:
        if not put_moment(scene, decision, slipping, asked[WHEN], y, decision.now):
            return False
        for a in range(slipping):
            p = decision.takes[a]
            rest = STOPPED * decision.now.sizes[p]
            # of a speed v against the slip, 3/2 v is left; for a slipping point the sign is known
            if np.hypot(decision.now.met[p, MET.rates + 1], decision.now.met[p, MET.rates + 2]) <= rest:
                asked[BLUR + STICK - TOUCH] = max(asked[BLUR + STICK - TOUCH], 1.5 * rest)
    return True


@kernel
def _change(scene: ContactScene, decision: Decision, asked: np.ndarray, y: np.ndarray, reports: np.ndarray) -> bool:
    """Write what follows an event; return whether it is known."""
    t, points, what = asked[WHEN], scene.loops.points, int(asked[WHAT])
    first, free = scene.looked.first_state - len(decision.du), len(decision.du)
    u, span = y[first : first + free], asked[RUN_SPAN]
    if not put_margins(scene, decision, t, y):
        return False
    count = _select(decision, asked, u)
    if count == 0:
        return True
    if not put_moment(scene, decision, count, t, y, decision.now):
        return False
    largest, strikes = 0.0, False
    for a in range(count):
        p = decision.takes[a]
        for i in range(3 * p, 3 * p + 3):
            largest = max(largest, abs(decision.now.b[i]))
    fallen = largest * MOMENT * span
    for a in range(count):
        p = decision.takes[a]
        size = decision.now.sizes[p]
        speed = max(size, asked[LENGTH])
        decision.still[p], decision.rest[p] = max(STILL * size, fallen), max(STOPPED * size, fallen)
        decision.slow[p] = asked[RUN_RTOL] ** BEGINNING * speed
        if what == STICK and decision.is_concerned[p] != 0:
            # a slip that ends, or turns, within the noise of the run, begins anew or is over
            decision.rest[p] = max(decision.rest[p], asked[RUN_RTOL] * speed)
        copy(decision.now.met[p, MET.rates : MET.rates + 3], decision.rates[3 * p : 3 * p + 3])
        decision.is_struck[p] = 0
        strikes = strikes or decision.rates[3 * p] < -decision.still[p]
    if strikes and not strike(points, decision, count, u):
        return False
    for a in range(count):
        p = decision.takes[a]
        lifts = what == LIFT and decision.is_concerned[p] != 0
        decision.is_closed[p] = decision.rates[3 * p] <= decision.still[p] and not lifts
    # of a run that goes on beyond the end that it assumed nothing is known
    is_stale, event = strikes, (t, y, span, asked[RUN_END] if asked[RUN_END] >= t else np.inf)
    while True:
        is_stale = stop(points, decision, count, u) or is_stale
        if is_stale and not put_moment(scene, decision, count, t, y, decision.now):
            return False
        is_stale = False
        if not put_statuses(scene, decision, count, event):
            return False
        if not _let_rest(scene, decision, count, asked, reports):
            break
    _write(scene, decision, count, y[scene.looked.first_state :])
    _tell(scene, decision, count, asked, reports)
    return True


@kernel
def _select(decision: Decision, asked: np.ndarray, u: np.ndarray) -> int:
    """Write which points the event concerns and which take part; return how many these are."""
    what, margins, count = int(asked[WHAT]), decision.margins, 0
    column, least, scale = max(what - TOUCH, 0), np.inf, 0.0
    for p in range(len(margins)):
        least = min(least, margins[p, column])
        scale = max(scale, abs(margins[p, ON_NORMAL]) if margins[p, ON_NORMAL] < np.inf else 0.0)
    if what == TOUCH:
        scale = asked[LENGTH]
    if what == STICK:
        scale = 0.0
        for c in range(len(u)):
            scale = max(scale, abs(u[c]))
    limit = max(least, 0.0) + NEAR * scale if least < np.inf else -np.inf
    for p in range(len(margins)):
        decision.is_concerned[p] = what != START and margins[p, column] <= limit
        touches = what == TOUCH and decision.is_concerned[p] != 0
        decision.is_taking[p] = decision.before[p] != OPEN or margins[p, ON_GAP] <= NEAR * asked[LENGTH] or touches
        if decision.is_taking[p] != 0:
            decision.takes[count] = p
            count += 1
    return count


@kernel
def _let_rest(scene: ContactScene, decision: Decision, count: int, asked: np.ndarray, reports: np.ndarray) -> bool:
    """Close what returns so soon that its impacts cannot be resolved; return whether there is any."""
    is_any, span, points = False, asked[RUN_SPAN], scene.loops.points
    for a in range(count):
        p = decision.takes[a]
        rate, fall, e = decision.rates[3 * p], -decision.accelerations[3 * p], points.numbers[p, OF_POINT.restitution]
        if decision.is_closed[p] != 0 or rate <= 0.0 or fall <= 0.0 or e == 1.0:
            continue
        flight = 2.0 * rate / fall
        if flight <= SHORT_FLIGHT * span or flight <= (1.0 - e) * CROWDED * span:
            decision.is_closed[p], is_any = 1, True
            _report(asked, reports, asked[WHEN] + flight / (1.0 - e), REPORTED * points.places[p, CONTACT] + RESTS)
    return is_any


@kernel
def _write(scene: ContactScene, decision: Decision, count: int, z: np.ndarray) -> None:
    """Write the status of each point that takes part, and what it keeps."""
    for a in range(count):
        p = decision.takes[a]
        at, after = scene.loops.points.places[p, STATUS], decision.after[p]
        is_same = after == STICKS and decision.before[p] == STICKS
        z[at] = after
        z[at + KEPT_RATE : at + KEPT_RATE + 3] = 0.0
        if after == SLIPS:
            speed = max(AT_REST, decision.slow[p] if is_at_rest(decision, p) else 0.0)
            along = on_surface(decision.now, p, decision.slips[p, 0], decision.slips[p, 1])
            for c in range(3):
                z[at + KEPT + c], z[at + KEPT_RATE + c] = speed * along[c], speed * decision.turning[p, c]
        elif not is_same:
            for c in range(3):
                z[at + KEPT + c] = decision.now.met[p, MET.place + c] if after == STICKS else 0.0


@kernel
def _report(asked: np.ndarray, reports: np.ndarray, t: float, code: int) -> None:
    """Add a report."""
    row = int(asked[REPORT_COUNT])
    reports[row, 0], reports[row, 1] = t, code
    asked[REPORT_COUNT] = row + 1


@kernel
def _tell(scene: ContactScene, decision: Decision, count: int, asked: np.ndarray, reports: np.ndarray) -> None:
    """Report what the event has changed, contact by contact."""
    places, t, what = scene.loops.points.places, asked[WHEN], int(asked[WHAT])
    contacts, a = places[len(places) - 1, CONTACT] + 1, 0
    while a < count:
        contact = places[decision.takes[a], CONTACT]
        touches = was_closed = is_closed = stuck = slipped = sticks = slips = False
        while a < count and places[decision.takes[a], CONTACT] == contact:
            p = decision.takes[a]
            before, after, struck = decision.before[p], decision.after[p], decision.is_struck[p]
            is_found = what == TOUCH and decision.is_concerned[p] != 0 and after != OPEN
            touches = touches or (before == OPEN and (struck != 0 or is_found))
            was_closed, is_closed = was_closed or before != OPEN, is_closed or after != OPEN
            stuck, slipped = stuck or before == STICKS, slipped or before == SLIPS
            sticks, slips = sticks or after == STICKS, slips or after == SLIPS
            if places[p, TELLS] != 0 and (before != after or (struck != 0 and before == OPEN)):
                code = REPORTED * contacts + POINT_CODES * p + 6 * before + 2 * after + struck
                _report(asked, reports, t, code)
            a += 1
        code, rubs = REPORTED * contact, places[decision.takes[a - 1], HAS_FRICTION] != 0
        if touches:
            _report(asked, reports, t, code + TOUCHES)
        if was_closed and not is_closed:
            _report(asked, reports, t, code + LIFTS)
        if rubs and slips and stuck and not slipped:
            _report(asked, reports, t, code + BEGINS_SLIP)
        if rubs and sticks and not slips and (slipped or not was_closed):
            _report(asked, reports, t, code + BEGINS_STICK)
