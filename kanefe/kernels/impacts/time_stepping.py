"""Steps of Moreau and Jean over the impacts of rigid contacts in compiled code, from output to output.

The equations are those of `kanefe.kane.rigid_contacts.time_stepping`. The scene is asked for them by the calls that
events of rigid contacts have: a unit of its own, which is built where a run takes such steps.
"""

from __future__ import annotations

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
from kanefe.kernels.compiler.arrays import RealRows, Reals
from kanefe.kernels.compiler.entries import entry
from kanefe.kernels.constraints.contact_margins import Looked
from kanefe.kernels.constraints.loop_tables import unit_responses_in
from kanefe.kernels.constraints.tolerances import NEAR_SINGULAR
from kanefe.kernels.contact.rigid_points import (
    AT_REST,
    FIRST_STATE,
    HAS_FRICTION,
    HOLDING,
    KEPT,
    KEPT_RATE,
    MET,
    OF_POINT,
    SLIP,
    STATUS,
    TAKEN,
    WORK,
)
from kanefe.kernels.evaluation.bending import watch_bends
from kanefe.kernels.evaluation.evaluation import LEAST_PIVOT
from kanefe.kernels.events.closing_call import close_at
from kanefe.kernels.impacts.decision import (
    FREE_ACCELERATIONS,
    IS_TAKING,
    MARGINS_NOW,
    ON_GAP,
    OPEN,
    POINTS_NOW,
    SLIPS,
    STICKS,
    TAKES,
    Decision,
    look,
)
from kanefe.kernels.impacts.march import (
    AFTER_STEP,
    APPROACH,
    BEFORE_STEP,
    BEND,
    BEYOND,
    BROKEN,
    CLOSED,
    DEEPEST,
    DONE,
    DOUBLY,
    FREELY,
    IMPULSE,
    LEFT,
    LENGTH,
    LOWERED,
    MOST,
    NEW,
    NEXT,
    OLD,
    OWN_APPROACH,
    OWN_BEND,
    OWN_DEPTH,
    OWN_LOWERED,
    OWN_RESIDUAL,
    PASSED,
    REMAINDER,
    RESIDUAL,
    ROUND_OFF,
    STEPS,
    STOP,
    TIME,
    TIME_OLD,
    TOO_DEEP,
    ImpactScene,
    March,
)
from kanefe.kernels.impacts.step_impulses import solve_islands
from kanefe.kernels.impacts.tolerances import ROUND_OFF_OF_FORCES
from kanefe.kernels.layout import COORDINATES
from kanefe.kernels.steppers.step_commands import SLOPE
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
        own = last + points.places[p, STATUS]
        y[own : own + KEPT_RATE + 3] = OPEN  # also from how deep a point left, and its slip: none
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
        if not solve_islands(scene, decision, march, count):
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
    kept = unit_responses_in(looked.holding, loops)
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
        y[contact + TAKEN] -= taken - rubbed
        y[contact + SLIP] += points.numbers[p, OF_POINT.share] * slip * h
        if after[0] > still:  # it has bounced
            continue
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
