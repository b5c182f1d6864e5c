"""A scene with rigid contacts at a moment: what unit forces at its points do, and how far they are from events."""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.pivoted import factor, solve
from kanefe.kernels.algebra.vectors import copy
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.compiler.calls import call_address
from kanefe.kernels.constraints.constraint_rows import CONTACT_ROW
from kanefe.kernels.constraints.contact_margins import find_forces
from kanefe.kernels.constraints.loop_tables import (
    KIND_OF,
    RANK_TOLERANCE,
    Loops,
    UnitResponses,
    has_loops,
    unit_responses_in,
)
from kanefe.kernels.contact.falling import AT
from kanefe.kernels.contact.rigid_points import (
    HAS_FRICTION,
    MET,
    OF_POINT,
    ON_SURFACE,
    STATUS,
    is_closed,
    is_slipping,
    left_of_slip,
    meet,
)
from kanefe.kernels.evaluation.evaluation import DONE_AS
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
    Moment,
)
from kanefe.kernels.loads.markers import axes_of
from kanefe.kernels.steppers.step_commands import RATES, SLOPE
from kanefe.kernels.sweeps.drives import put_drives

AS_THEY_ARE, TAKING_PART, NONE = range(3)
"""Which points touch in an evaluation: those that do, those that take part, or none."""


@kernel
def _evaluate(scene: ContactScene, decision: Decision, t: float, y: np.ndarray, touching: int) -> bool:
    """Evaluate the scene at a state; return whether it has rates."""
    looked, points = scene.looked, scene.loops.points
    width = min(len(y), looked.vectors.shape[1])
    copy(y[:width], looked.vectors[0, :width])
    put_drives(scene.motions, t, looked.drives)
    copy(scene.held, looked.inputs)
    scene.fill(t, y, looked.inputs)
    if touching != AS_THEY_ARE:
        for p in range(len(points.places)):
            is_held = touching == TAKING_PART and decision.is_taking[p] != 0
            looked.vectors[0, looked.first_state + points.places[p, STATUS]] = STICKS if is_held else OPEN
    looked.evaluation.numbers[looked.time_at] = t
    call_address(looked.evaluation.address, (looked.evaluation.places, looked.evaluation.numbers))
    return int(looked.evaluation.numbers[DONE_AS]) == RATES


@kernel
def put_accelerations(scene: ContactScene, decision: Decision, t: float, y: np.ndarray) -> bool:
    """Write the accelerations of a state without contacts; return whether there are some."""
    looked = scene.looked
    done = _evaluate(scene, decision, t, y, NONE)
    free = len(decision.du)
    copy(looked.vectors[SLOPE, looked.first_state - free : looked.first_state], decision.du)
    return done


@kernel
def put_margins(scene: ContactScene, decision: Decision, t: float, y: np.ndarray) -> bool:
    """Write the status of each point, where it meets its surface, and its margins; return whether there are rates."""
    loops, looked = scene.loops, scene.looked
    if not _evaluate(scene, decision, t, y, AS_THEY_ARE):
        return False
    points, kept = loops.points, unit_responses_in(looked.holding, loops, looked.speeds)
    z, forces = y[looked.first_state :], looked.multipliers
    first, touches = len(loops.rows) - 3 * len(points.places), False
    for p in range(len(points.places)):
        touches = touches or is_closed(points, p, z)
    if touches:
        find_forces(loops, z, forces, kept)
    decision.margins[:, :] = np.inf
    for p in range(len(points.places)):
        row, normal = decision.margins[p], forces[first + 3 * p]
        decision.before[p] = OPEN
        if not is_closed(points, p, z):
            meet(points, p, scene.tables.gravity, looked.work, kept.met)
            row[ON_GAP] = kept.met[p, MET.gap]
        else:
            row[ON_NORMAL] = normal
            decision.before[p] = SLIPS if is_slipping(points, p, z) else STICKS
            if decision.before[p] == STICKS:
                holding = points.numbers[p, int(OF_POINT.friction) + int(AT.holding)]
                row[ON_SLIP] = holding * normal - np.hypot(forces[first + 3 * p + 1], forces[first + 3 * p + 2])
            elif points.places[p, HAS_FRICTION] != 0:
                row[ON_LEFT] = left_of_slip(points, p, z, looked.work, kept.met)
        copy(kept.met[p], decision.now.met[p])
    return True


@kernel
def put_moment(scene: ContactScene, decision: Decision, count: int, t: float, y: np.ndarray, moment: Moment) -> bool:
    """Write what unit forces at the points that take part do at a state; return whether that is determined."""
    if not _evaluate(scene, decision, t, y, TAKING_PART):
        return False
    loops, looked = scene.loops, scene.looked
    kept, free = unit_responses_in(looked.holding, loops, looked.speeds), len(decision.du)
    first = len(loops.rows) - 3 * len(loops.points.places)
    for a in range(count):
        p = decision.takes[a]
        copy(kept.met[p], moment.met[p])
        axes = axes_of(loops.points.markers, 2 * p, loops.points.places[p, ON_SURFACE], looked.work)
        for c in range(9):
            moment.axes[p, c] = axes[c]
        for i in range(3 * p, 3 * p + 3):
            j = first + i
            moment.b[i] = -kept.rest[j]
            for c in range(free):
                moment.responses[i, c] = kept.unit_responses[j, c] if kept.scale[j] != 0.0 else 0.0
            for other in range(a + 1):
                q = decision.takes[other]
                for k in range(3 * q, min(3 * q + 3, i + 1)):
                    moves = kept.scale[j] != 0.0 and kept.scale[first + k] != 0.0
                    moment.G[i, k] = moment.G[k, i] = kept.A[j, first + k] if moves else 0.0
        moment.sizes[p] = _size(kept, first + 3 * p, y[looked.first_state - free :], looked.drives, free)
    if has_loops(loops, kept):
        _hold_loops(loops, kept, decision, count, moment)
    return True


@inlined
def _size(kept: UnitResponses, j: int, u: np.ndarray, drives: np.ndarray, free: int) -> float:
    """Return the sum of the speeds with which the point of three rows moves."""
    total = 0.0
    for c in range(free + len(drives)):
        largest = max(abs(kept.J[j, c]), max(abs(kept.J[j + 1, c]), abs(kept.J[j + 2, c])))
        total += largest * abs(u[c] if c < free else drives[c - free, 1])
    return total


@kernel
def _hold_loops(loops: Loops, kept: UnitResponses, decision: Decision, count: int, moment: Moment) -> None:
    """Take from what unit forces do what the loops take up."""
    first = len(loops.rows) - 3 * len(loops.points.places)
    for j in range(len(loops.rows)):
        kept.spare[j] = kept.scale[j] if loops.rows[j, KIND_OF] != CONTACT_ROW else 0.0
    tolerance = loops.limits[RANK_TOLERANCE]
    rank, _ = factor(kept.A, kept.spare, tolerance, kept.L, kept.inverses, kept.order, kept.column)
    right, share = kept.live, kept.plain
    for a in range(count):
        for i in range(3 * decision.takes[a], 3 * decision.takes[a] + 3):
            if kept.scale[first + i] == 0.0:
                continue
            for j in range(first):
                right[j] = kept.A[first + i, j] if kept.spare[j] != 0.0 else 0.0
            solve(kept.L, kept.inverses, kept.order, rank, kept.spare, right, kept.column, share)
            for j in range(first):
                if kept.spare[j] == 0.0:
                    continue
                moment.b[i] += share[j] * kept.rest[j]
                for c in range(len(decision.du)):
                    moment.responses[i, c] -= share[j] * kept.unit_responses[j, c]
                for other in range(count):
                    for k in range(3 * decision.takes[other], 3 * decision.takes[other] + 3):
                        if kept.scale[first + k] != 0.0:
                            moment.G[k, i] -= share[j] * kept.A[first + k, j]


@kernel
def respond(decision: Decision, count: int, forces: np.ndarray, y: np.ndarray) -> None:
    """Add to free speeds what forces (3 points,) at the points that take part do."""
    for a in range(count):
        for i in range(3 * decision.takes[a], 3 * decision.takes[a] + 3):
            if forces[i] != 0.0:
                for c in range(len(y)):
                    y[c] += forces[i] * decision.now.responses[i, c]
