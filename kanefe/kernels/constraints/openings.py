"""How far loops are open, and how fast they open: residuals of rows after an outward sweep, and their rates."""

import numpy as np

from kanefe.kernels.constraints.constraint_rows import Action, ConstraintRow, RowKind, residual
from kanefe.kernels.constraints.loop_tables import Limits, RowWork, holds, rows_of, terms_of
from kanefe.kernels.constraints.row_wrenches import along_ends, over_drives, over_speeds
from kanefe.kernels.contact.rigid_points import PointStates, along, given_points, meet, part_of
from kanefe.kernels.language import dot, inlined, kernel, largest_in, norm
from kanefe.kernels.loads.markers import motion_of
from kanefe.kernels.scene import Scene, State, Work
from kanefe.kernels.tables import Loops
from kanefe.kernels.tree import Frames


@kernel
def openings(scene: Scene, state: State, work: Work, kept: RowWork, residuals: np.ndarray) -> tuple[float, float]:
    """Write g of all rows after an outward sweep; return the largest opening, and the sum of their squares.

    Openings are of the scene's length, or in rad; zero for rows on speeds alone, and for those that do not hold.
    """
    rows, frames, length, worst, total = rows_of(scene.loops), work.frames, Limits(scene.loops.limits).length, 0.0, 0.0
    for i in range(len(frames) - 1):  # far from N's origin round-off is that of the distance
        length = max(length, largest_in(frames[i].p))
    for j in range(len(rows)):
        row = rows[j]
        residuals[j] = 0.0
        if not row.holds_place or not holds(row, state.z):
            continue
        if row.kind == RowKind.CONTACT:
            residuals[j] = _off(scene, state, work, kept, row)
        elif row.kind == RowKind.COUPLER:
            residuals[j] = _turned(scene.loops, state, row)
        else:
            residuals[j] = residual(row, motion_of(row.a, frames), motion_of(row.b, frames))
        opening = abs(residuals[j]) / (1.0 if row.is_angle else length)
        worst = max(worst, opening)
        total += opening * opening
    return worst if total < np.inf else np.inf, total


@inlined
def _turned(loops: Loops, state: State, row: ConstraintRow) -> float:
    """Return g of a coupler."""
    terms, total = terms_of(loops), over_drives(loops, row, state.drives, 0) - row.constant
    for n in range(row.first_term, row.first_term + row.term_count):
        if terms[n].coordinate >= 0:
            total += terms[n].coefficient * state.q[terms[n].coordinate]
    return total


@inlined
def _off(scene: Scene, state: State, work: Work, kept: RowWork, row: ConstraintRow) -> float:
    """Return the gap of a point, or how far it is along a direction of the surface from where it sticks, m."""
    points, met = scene.loops.points, kept.met[row.point]
    given = given_points(points)[row.point]
    if row.direction == 0:
        meet(given, points.shapes, work.frames, met)
        return met.gap
    off = met.surface @ (met.place - PointStates(state.z, given.status).kept)
    return dot(along(met, row.direction), off)


@inlined
def rate_of_row(scene: Scene, state: State, work: Work, kept: RowWork, j: int) -> float:
    """Return dg/dt of a row from the velocities of its ends."""
    row, loops = rows_of(scene.loops)[j], scene.loops
    if row.kind == RowKind.CONTACT:
        rate = part_of(kept.met[row.point].rates, row.direction)
    elif row.kind == RowKind.COUPLER:
        rate = over_speeds(loops, row, state.u) + over_drives(loops, row, state.drives, 1)
    else:
        a, b = work.frames[row.a.row], work.frames[row.b.row]
        rate = along_ends(kept.actions[j], a.v, a.w, b.v, b.w)
    return rate


@inlined
def size_of_rate(row: ConstraintRow, action: Action, frames: Frames) -> float:
    """Return how large dg/dt of a row between two ends could be at their speeds; zero of couplers."""
    size = 0.0
    if row.kind != RowKind.COUPLER:
        a, b = frames[row.a.row], frames[row.b.row]
        size = norm(action.force) * (norm(a.v) + norm(b.v))
        size += norm(action.moment_a) * norm(a.w) + norm(action.moment_b) * norm(b.w)
    return size
