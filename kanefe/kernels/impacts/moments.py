"""A scene with rigid contacts at a moment: what unit forces at its points do, and how far they are from events."""

from typing import NamedTuple

import numpy as np

from kanefe.kernels.algebra.pivoted import factor, pivots_of, solve
from kanefe.kernels.compiler.arrays import Filler
from kanefe.kernels.constraints.constraint_rows import RowKind
from kanefe.kernels.constraints.contact_margins import Looked, find_forces
from kanefe.kernels.constraints.loop_tables import Limits, UnitResponses, has_loops, head_of, rows_of, unit_responses_in
from kanefe.kernels.contact.rigid_points import (
    PointStates,
    given_points,
    is_closed,
    is_slipping,
    left_of_gap,
    left_of_slip,
    meet,
    touches,
)
from kanefe.kernels.evaluation.evaluation import DONE_AS
from kanefe.kernels.impacts.decision import Asked, Decision, Look, Moment, Points, Status, points_of
from kanefe.kernels.language import Reals, call_address, copy, entry, inlined, kernel
from kanefe.kernels.steppers.step_commands import RATES, VECTOR
from kanefe.kernels.sweeps.advance import advance
from kanefe.kernels.sweeps.drives import Drives, put_drives
from kanefe.kernels.tables import FlexibleTables, Loops, Tables
from kanefe.kernels.tree import Frames


class ContactScene(NamedTuple):
    """A scene of which events of rigid contacts ask.

    Attributes
    ----------
    looked : Looked
        An evaluation in space.
    loops, tables, flexible : named tuples
        Of the scene; without flexible bodies the latter is empty.
    motions : Drives
    fill : function (t, y, inputs)
    held : ndarray, shape (inputs,)
        Values of loads, those written that do not change in the run.
    """

    looked: Looked
    loops: Loops
    tables: Tables
    flexible: FlexibleTables
    motions: Drives
    fill: Filler
    held: Reals


@entry()
def look_at_points(scene: ContactScene, decision: Decision, y: Reals) -> None:
    """Write what the question of a decision asks for, of a state, or of one a little later.

    Parameters
    ----------
    scene : ContactScene
    decision : Decision
        For what is later, its `state` has the speeds of then, and its `motion` the way there.
    y : ndarray, shape (state,)
        Begins with q, u and z.
    """
    looked = scene.looked
    asked, points = Asked(decision.asked, decision.when), points_of(decision)
    what, taking = asked.look, decision.taking[: asked.taking]
    first, state = looked.first_state - decision.motion.shape[1], y
    if what == Look.POINTS_LATER:
        advance(scene.tables, scene.flexible, y[:first], decision.motion[1], 1.0, decision.state[:first])
        state = decision.state
    asked.is_known = _evaluate(scene, points, asked.t, state, what)
    if not asked.is_known:
        return
    if what == Look.MARGINS:
        _put_margins(scene, decision, y)
    elif what == Look.FREE_ACCELERATIONS:
        copy(looked.vectors[VECTOR.slope, first : looked.first_state], decision.motion[0])
    elif what == Look.POINTS:
        _put_moment(scene, taking, state[first:], decision.now)
    else:
        _put_moment(scene, taking, state[first:], decision.later)


@kernel
def _evaluate(scene: ContactScene, points: Points, t: float, y: np.ndarray, what: int) -> bool:
    """Evaluate the scene at a state, with what takes part or nothing closed; return whether it has rates."""
    looked, given = scene.looked, given_points(scene.loops.points)
    width = min(len(y), looked.vectors.shape[1])
    copy(y[:width], looked.vectors[0, :width])
    put_drives(scene.motions, t, looked.drives)
    copy(scene.held, looked.inputs)
    scene.fill(t, y, looked.inputs)
    if what != Look.MARGINS:
        for p in range(len(points)):
            sticks = what != Look.FREE_ACCELERATIONS and points[p].takes_part
            states = PointStates(looked.vectors[0], looked.first_state + given[p].status)
            states.status = 1.0 if sticks else 0.0  # `Status`
    looked.evaluation.numbers[looked.time_at] = t
    call_address(looked.evaluation.address, (looked.evaluation.places, looked.evaluation.numbers))
    return int(looked.evaluation.numbers[DONE_AS]) == RATES


@kernel
def _put_margins(scene: ContactScene, decision: Decision, y: np.ndarray) -> None:
    """Write the status of each point, where it meets its surface, and its margins."""
    loops, looked = scene.loops, scene.looked
    points, kept, frames = given_points(loops.points), unit_responses_in(looked.holding, loops), Frames(looked.frames)
    z, forces = y[looked.first_state :], looked.multipliers
    if touches(points, z):
        find_forces(loops, z, forces, kept)
    for p in range(len(points)):
        given, point, met, head = points[p], points_of(decision)[p], kept.met[p], head_of(loops, p)
        point.before, point.gap, point.normal = Status.OPEN, np.inf, np.inf
        point.slip_margin = point.left_of_slip = np.inf
        if not is_closed(given, z):
            meet(given, loops.points.shapes, frames, met)
            point.gap = left_of_gap(given, z, met)
        elif is_slipping(given, z):
            point.before, point.normal = Status.SLIPS, forces[head]
            if given.rubs:
                point.left_of_slip = left_of_slip(given, z, met)
        else:
            point.before, point.normal = Status.STICKS, forces[head]
            point.slip_margin = given.friction.holding * forces[head] - np.hypot(forces[head + 1], forces[head + 2])
        copy(kept.met.numbers[p], decision.now.met[p])


@kernel
def _put_moment(scene: ContactScene, taking: np.ndarray, u: np.ndarray, moment: Moment) -> None:
    """Write what unit forces at the points that take part do; speeds u are followed by the rest of the state."""
    loops, looked, free = scene.loops, scene.looked, moment.responses.shape[1]
    kept = unit_responses_in(looked.holding, loops)
    first = head_of(loops, 0)
    du = looked.vectors[VECTOR.slope, looked.first_state - free : looked.first_state]
    for a in range(len(taking)):
        p = taking[a]
        copy(kept.met.numbers[p], moment.met[p])
        for i in range(3 * p, 3 * p + 3):
            j = first + i
            moment.b[i] = -kept.rest[j]
            for c in range(free):
                moment.responses[i, c] = kept.unit_responses[j, c] if kept.scale[j] != 0.0 else 0.0
            for q in taking[: a + 1]:
                for k in range(3 * q, min(3 * q + 3, i + 1)):
                    moves = kept.scale[j] != 0.0 and kept.scale[first + k] != 0.0
                    moment.G[i, k] = moment.G[k, i] = kept.A[j, first + k] if moves else 0.0
        moment.sizes[p] = _moved(kept, first + 3 * p, u, looked.drives, 1, free)
        moment.accelerated[p] = _moved(kept, first + 3 * p, du, looked.drives, 2, free)
    if has_loops(loops, kept):
        _hold_loops(loops, kept, taking, moment)


@inlined
def _moved(kept: UnitResponses, j: int, u: np.ndarray, drives: np.ndarray, rate: int, free: int) -> float:
    """Return the sum of the speeds with which the point of three rows moves, or of its accelerations (rate 1, 2)."""
    total = 0.0
    for c in range(free + len(drives)):
        largest = max(abs(kept.J[j, c]), max(abs(kept.J[j + 1, c]), abs(kept.J[j + 2, c])))
        total += largest * abs(u[c] if c < free else drives[c - free, rate])
    return total


@kernel
def _hold_loops(loops: Loops, kept: UnitResponses, taking: np.ndarray, moment: Moment) -> None:
    """Take from what unit forces do what the loops take up."""
    first = head_of(loops, 0)
    for j in range(len(loops.rows)):
        kept.spare[j] = kept.scale[j] if rows_of(loops)[j].kind != RowKind.CONTACT else 0.0
    tolerance = Limits(loops.limits).rank_tolerance
    rank, _ = factor(kept.A, kept.spare, tolerance, pivots_of(kept))
    right, share = kept.live, kept.plain
    for p in taking:
        for i in range(3 * p, 3 * p + 3):
            if kept.scale[first + i] == 0.0:
                continue
            for j in range(first):
                right[j] = kept.A[first + i, j] if kept.spare[j] != 0.0 else 0.0
            solve(pivots_of(kept), rank, kept.spare, right, share)
            for j in range(first):
                if kept.spare[j] == 0.0:
                    continue
                moment.b[i] += share[j] * kept.rest[j]
                for c in range(moment.responses.shape[1]):
                    moment.responses[i, c] -= share[j] * kept.unit_responses[j, c]
                for q in taking:
                    for k in range(3 * q, 3 * q + 3):
                        if kept.scale[first + k] != 0.0:
                            moment.G[k, i] -= share[j] * kept.A[first + k, j]
