"""The system of the multipliers of loops by the ways of their rows to N: what loops have in common, and nothing else.

A wrench on its way inward leaves at each joint, and at the modes of each body, a force that is given way to. With
``k`` that force, ``D`` the inertia that `kanefe.kernels.sweeps.inward` has eliminated there, and ``e = D^-1 k``,

    J_i M^-1 J_j^T = sum of k_i e_j over all joints and modes that both rows visit,

since the sweeps are a factorisation ``M^-1 = Psi^T D^-1 Psi`` (Rodriguez 1987, Jain 1991). Rows without a joint in
common do not meet in the system.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from kanefe.kernels.algebra.envelope import factor_envelope
from kanefe.kernels.algebra.vectors import (
    Numbers,
    accumulate,
    cross,
    dot,
    matrix,
    minus,
    plus,
    product,
    put,
    put_three,
    rotated,
    rotated_back,
    symmetric,
    symmetric_times,
    three,
    times,
    vector,
)
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.constraints.constraint_jacobian import row_scale_over, walk_inward
from kanefe.kernels.constraints.constraint_rows import COUPLER_ROW
from kanefe.kernels.constraints.loop_tables import (
    FIRST_TERM,
    KIND_OF,
    LEAST_SHARE,
    RANK_TOLERANCE,
    ROW_A,
    TERM_COUNT,
    Loops,
    RowWrenches,
    holds,
    wrenches_in,
    wrenches_size,
)
from kanefe.kernels.constraints.row_paths import OF_JOINT, OF_MODES, ROW_OF_LOOPS, VISIT, VISITED
from kanefe.kernels.layout import (
    AXES,
    CARRIED_COUNT,
    CARRIES,
    COUNT,
    DETA,
    DRIVE,
    FIXED,
    FLEXIBLE,
    FREE,
    GIVEN,
    INTERFACE,
    KIND,
    OFFSET,
    PARENT,
    PIVOT,
    ROW,
    SPEED,
    SPHERICAL,
    WORK_SCALE,
    FlexibleTables,
    H,
    J,
    R,
    Tables,
    U,
)
from kanefe.kernels.loads.point_and_field_loads import share_of_modes
from kanefe.kernels.sweeps.border import border_in
from kanefe.kernels.sweeps.elastic import project, span, total
from kanefe.kernels.sweeps.inward import through_axis, through_ball
from kanefe.kernels.sweeps.modal_elimination import coupling_span

TURN = 3
"""Place of the second vector of a joint that has two."""

ACCELERATED = 6
"""Place of the accelerations among the numbers of a free joint."""

WRENCH = 6


class LoopFactors(NamedTuple):
    """What loops do to the speeds at one configuration, without rubbing contacts.

    Attributes
    ----------
    exerted : RowWrenches
    numbers : ndarray
        Of all visits, see `put_visits`.
    A, L : ndarray, shape (envelope,)
        ``J M^-1 J^T`` in its envelope, and its factors.
    inverses, scale, rest, column : ndarray, shape (m,)
        Of pivots; with which a row is of unit length if it points along the motion of its ends (0: it moves nothing,
        or does not hold); right-hand side; workspace.
    J, reach : ndarray, shape (n,)
        A row and the largest it could be: workspace.
    carried : ndarray, shape (rows of the scene, WRENCH)
        Wrenches on their way.
    response : ndarray, shape (n,)
        What all multipliers cause: accelerations, and driving forces.
    """

    exerted: RowWrenches
    numbers: np.ndarray
    A: np.ndarray
    L: np.ndarray
    inverses: np.ndarray
    scale: np.ndarray
    rest: np.ndarray
    column: np.ndarray
    J: np.ndarray
    reach: np.ndarray
    carried: np.ndarray
    response: np.ndarray


@kernel
def factors_size(loops: Loops, n: int) -> int:
    """Return how many numbers the workspace of `loop_factors_in` has, with n free and driven speeds."""
    m, paths = len(loops.rows), loops.paths
    rows, envelope = len(paths.met_first) - 1, paths.ends[m]
    return wrenches_size(loops) + paths.sizes[0] + 2 * envelope + 4 * m + 3 * n + WRENCH * rows


@inlined
def loop_factors_in(workspace: np.ndarray, loops: Loops, n: int) -> LoopFactors:
    """Return the parts of a workspace of `factors_size`."""
    m, rows = len(loops.rows), len(loops.paths.met_first) - 1
    envelope, size = loops.paths.ends[m], loops.paths.sizes[0]
    rest = workspace[wrenches_size(loops) :]
    numbers, rest = rest[:size], rest[size:]
    A, L, rest = rest[:envelope], rest[envelope : 2 * envelope], rest[2 * envelope :]
    of_rows, of_speeds, carried = rest[: 4 * m], rest[4 * m : 4 * m + 3 * n], rest[4 * m + 3 * n :]
    return LoopFactors(
        wrenches_in(workspace, loops),
        numbers,
        A,
        L,
        of_rows[:m],
        of_rows[m : 2 * m],
        of_rows[2 * m : 3 * m],
        of_rows[3 * m :],
        of_speeds[:n],
        of_speeds[n : 2 * n],
        carried[: WRENCH * rows].reshape(rows, WRENCH),
        of_speeds[2 * n :],
    )


@kernel
def put_loop_system(
    loops: Loops,
    tables: Tables,
    flexible: FlexibleTables | None,
    z: np.ndarray,
    work: np.ndarray,
    modal: np.ndarray,
    border: np.ndarray,
    is_implicit: bool,
    kept: LoopFactors,
) -> None:
    """Write A and the scales of all rows; their wrenches are written and the inertias eliminated.

    A row that does not hold is left out: its scale is zero.
    """
    kept.A[:] = 0.0
    for j in range(len(loops.rows)):
        kept.scale[j] = 0.0
        if not holds(loops, j, z):
            continue
        share = _share_of_reach(loops, tables, flexible, j, work, modal, kept)
        # its pivot would be below all that count, and its way would be for nothing
        if share.real > LEAST_SHARE:
            kept.scale[j] = share
            _put_visits(loops, tables, flexible, j, work, modal, border, is_implicit, kept)
    _sum_meetings(loops, tables, flexible, work, kept)
    ends, place = loops.paths.ends, loops.paths.place
    for j in range(len(loops.rows)):
        # a row of unit length if it pointed along the motion of its ends
        if kept.scale[j] != 0.0:
            size = kept.A[ends[place[j] + 1] - 1]
            kept.scale[j] = np.sqrt(kept.scale[j] / size) if size.real > 0.0 else 0.0 * kept.scale[j]


@kernel
def factor_loops(loops: Loops, scale: np.ndarray, tolerance: float, kept: LoopFactors) -> Any:
    """Factor the rows whose scale is not zero; return the weakest pivot that counts."""
    paths = loops.paths
    tolerance = max(tolerance, loops.limits[RANK_TOLERANCE])
    return factor_envelope(kept.A, paths.ends, paths.order, scale, tolerance, kept.L, kept.inverses, kept.column)


@kernel
def _share_of_reach(
    loops: Loops,
    tables: Tables,
    flexible: FlexibleTables | None,
    j: int,
    work: np.ndarray,
    modal: np.ndarray,
    kept: LoopFactors,
) -> Any:
    """Return the square of how much of its reach a row has, see `row_scale_over`, from what its ends do not share."""
    paths, rows, J, reach = loops.paths, tables.rows, kept.J, kept.reach
    for s in range(paths.first[j], paths.first[j + 1]):
        i = paths.visits[s, VISITED]
        for c in range(rows[i, SPEED], rows[i, SPEED] + _speed_count(rows[i, KIND])):
            J[c] = reach[c] = 0.0
        if flexible is not None and rows[i, KIND] != INTERFACE and paths.visits[s, OF_MODES] >= 0:
            body = flexible.bodies[rows[i, FLEXIBLE]]
            J[body[DETA] : body[DETA] + body[COUNT]] = 0.0
            reach[body[DETA] : body[DETA] + body[COUNT]] = 0.0
    if loops.rows[j, KIND_OF] == COUPLER_ROW:
        for term in range(loops.rows[j, FIRST_TERM], loops.rows[j, FIRST_TERM] + loops.rows[j, TERM_COUNT]):
            J[loops.speeds[term]] += loops.coefficients[term]
            reach[loops.speeds[term]] += abs(loops.coefficients[term])
    else:
        for end in range(2):
            force, moment = vector(kept.exerted.wrenches, j, 6 * end), vector(kept.exerted.wrenches, j, 6 * end + 3)
            walk_inward(tables, flexible, loops.rows[j, ROW_A + end], force, moment, work, modal, J, reach)
    own, full = 0.0 * work[0, R], 0.0 * work[0, R]
    for s in range(paths.first[j], min(paths.common[j] + 1, paths.first[j + 1])):
        i = paths.visits[s, VISITED]
        if rows[i, KIND] == INTERFACE:
            continue
        if s < paths.common[j] and rows[i, DRIVE] < 0:
            first = rows[i, SPEED]
            own, full = row_scale_over(J, reach, loops.extents, first, _speed_count(rows[i, KIND]), own, full)
        if flexible is not None and paths.visits[s, OF_MODES] >= 0:  # of a link that carries both: through its modes
            body = flexible.bodies[rows[i, FLEXIBLE]]
            own, full = row_scale_over(J, reach, loops.extents, body[DETA], body[COUNT], own, full)
    return own / full if full.real > 0.0 else 0.0 * full


@inlined
def _speed_count(kind: int) -> int:
    """Return how many speeds a joint of a row has."""
    if kind == SPHERICAL:
        return 3
    if kind == FREE:
        return 6
    return 1 if FIXED < kind <= GIVEN else 0


@kernel
def _put_visits(
    loops: Loops,
    tables: Tables,
    flexible: FlexibleTables | None,
    j: int,
    work: np.ndarray,
    modal: np.ndarray,
    border: np.ndarray,
    is_implicit: bool,
    kept: LoopFactors,
) -> None:
    """Write what a unit multiplier of a row does at all it visits.

    Of a joint of one coordinate: e. Of a spherical one: moment and e. Of a free one: force and moment, and the
    accelerations they cause. Of k modes and n numbers of what the body carries: the forces p on the modes, their
    accelerations x, what acts on the carried interfaces and how these move. Wrenches are those that the row needs from
    its parent, against what acts on it.
    """
    paths, rows, geometry, carried, numbers = loops.paths, tables.rows, tables.geometry, kept.carried, kept.numbers
    begin, end = paths.first[j], paths.first[j + 1]
    for s in range(begin, end):
        i = paths.visits[s, VISITED]
        carried[i, :] = 0.0
        if paths.visits[s, OF_JOINT] >= 0 and rows[i, KIND] <= GIVEN:
            numbers[paths.visits[s, OF_JOINT]] = 0.0  # what a coupler applies, until its joint is reached
        if flexible is not None and rows[i, KIND] != INTERFACE and paths.visits[s, OF_MODES] >= 0:
            body, at = flexible.bodies[rows[i, FLEXIBLE]], paths.visits[s, OF_MODES]
            numbers[at : at + modes_size(body[COUNT], body[CARRIED_COUNT])] = 0.0
    if loops.rows[j, KIND_OF] == COUPLER_ROW:
        _apply_coupler(loops, tables, j, work, kept)
    else:
        for which in range(2):
            i = loops.rows[j, ROW_A + which]
            if i >= 0:
                force = vector(kept.exerted.wrenches, j, 6 * which)
                moment = vector(kept.exerted.wrenches, j, 6 * which + 3)
                accumulate(carried, i, 0, times(-1.0, force))
                accumulate(carried, i, TURN, times(-1.0, moment))
    for s in range(begin, end):
        i, at, of_modes = paths.visits[s]
        kind, parent = rows[i, KIND], rows[i, PARENT]
        force, moment = vector(carried, i, 0), vector(carried, i, TURN)
        if flexible is not None and kind == INTERFACE:
            body = flexible.bodies[rows[i, FLEXIBLE]]
            if body[COUNT] > 0:
                G = matrix(work, body[ROW], R)
                if rows[i, CARRIES]:
                    put_three(numbers, of_modes, rotated_back(G, force))
                    put_three(numbers, of_modes + 3, rotated_back(G, moment))
                    continue
                p = numbers[of_modes : of_modes + body[COUNT]]
                share_of_modes(flexible, rows, i, times(-1.0, force), times(-1.0, moment), work, modal, p)
        elif flexible is not None and of_modes >= 0:
            a, b = _give_way(flexible, rows[i, FLEXIBLE], of_modes, work, modal, border, is_implicit, numbers)
            force, moment = plus(force, a), plus(moment, b)
        if kind == FREE:
            put_three(numbers, at, force)
            put_three(numbers, at + TURN, moment)
            h, inverse = matrix(work, i, H), symmetric(work, i, U)
            pull, turn = times(-1.0, force), times(-1.0, moment)
            alpha = symmetric_times(symmetric(work, i, J), minus(turn, rotated_back(h, symmetric_times(inverse, pull))))
            put_three(numbers, at + ACCELERATED, symmetric_times(inverse, minus(pull, rotated(h, alpha))))
            put_three(numbers, at + ACCELERATED + TURN, alpha)
            continue
        if kind == SPHERICAL:
            put_three(numbers, at, moment)
            none = times(0.0, moment)
            turning, force, moment = through_ball(i, none, force, moment, work)
            put_three(numbers, at + TURN, turning)
        elif at >= 0:
            e, force, moment = through_axis(rows, geometry, i, numbers[at], force, moment, work)
            numbers[at] = e
        if parent >= 0:
            accumulate(carried, parent, 0, force)
            accumulate(carried, parent, TURN, plus(moment, cross(vector(work, i, OFFSET), force)))


@kernel
def _apply_coupler(loops: Loops, tables: Tables, j: int, work: np.ndarray, kept: LoopFactors) -> None:
    """Apply the terms of a coupler at their joints: its driven coordinates do not give way."""
    paths, rows = loops.paths, tables.rows
    for term in range(loops.rows[j, FIRST_TERM], loops.rows[j, FIRST_TERM] + loops.rows[j, TERM_COUNT]):
        speed, coefficient = loops.speeds[term], loops.coefficients[term]
        for s in range(paths.first[j], paths.first[j + 1]):
            i, at = paths.visits[s, VISITED], paths.visits[s, OF_JOINT]
            if at < 0 or not rows[i, SPEED] <= speed < rows[i, SPEED] + _speed_count(rows[i, KIND]):
                continue
            if rows[i, KIND] == FREE:  # one of its displacements: its turns have no coordinates
                c = speed - rows[i, SPEED]
                along = (
                    coefficient if c == 0 else 0.0,
                    coefficient if c == 1 else 0.0,
                    coefficient if c == 2 else 0.0,
                )
                fixed = matrix(tables.geometry, i, AXES)
                if rows[i, PARENT] >= 0:
                    fixed = product(matrix(work, rows[i, PARENT], R), fixed)
                accumulate(kept.carried, i, 0, times(-1.0, rotated(fixed, along)))
            else:
                kept.numbers[at] += coefficient


@inlined
def modes_size(k: int, carried: int) -> int:
    """Return how many numbers a visit has of k modes of a body that carries something at some interfaces."""
    return 2 * k + 3 * WRENCH * carried


@kernel
def _give_way(
    flexible: FlexibleTables,
    f: int,
    at: int,
    work: np.ndarray,
    modal: np.ndarray,
    border: np.ndarray,
    is_implicit: bool,
    numbers: np.ndarray,
) -> tuple[Numbers, Numbers]:
    """Write how the modes of a body give way to a row; return the wrench that its link feels more, in N.

    See `kanefe.kernels.sweeps.modal_elimination`: with G at rest ``x = p - B^T y``, and y as there.
    """
    body = flexible.bodies[f]
    k, n, G = body[COUNT], 6 * body[CARRIED_COUNT], matrix(work, body[ROW], R)
    p, x, rest = numbers[at : at + k], numbers[at + k : at + 2 * k], numbers[at + 2 * k : at + 2 * k + 3 * n]
    if is_implicit:
        scale = modal[span(body, WORK_SCALE)]
        for c in range(k):
            p[c] *= scale[c]
    coupling = modal[coupling_span(body)].reshape(6, k)
    a, b = project(coupling, 0, p), project(coupling, 3, p)
    for c in range(k):
        x[c] = p[c]
    if n > 0:
        parts = border_in(border, body)
        on, moved, held = rest[:n], rest[n : 2 * n], rest[2 * n :]
        for c in range(n):
            moved[c] = total(parts.basis[c], p)
        for c in range(n):
            held[c] = total(parts.inverse[c], on) + total(parts.series[c], moved)
            a = plus(a, times(held[c], three(parts.lever[c], 0)))
            b = plus(b, times(held[c], three(parts.lever[c], 3)))
        for c in range(n):
            for d in range(k):
                x[d] -= held[c] * parts.basis[c, d]
        for c in range(n):
            moved[c] = total(parts.basis[c], x)
    return rotated(G, a), rotated(G, b)


@kernel
def _sum_meetings(
    loops: Loops, tables: Tables, flexible: FlexibleTables | None, work: np.ndarray, kept: LoopFactors
) -> None:
    """Add what rows have in common at each joint and each body to A."""
    paths, rows, numbers, A = loops.paths, tables.rows, kept.numbers, kept.A
    for i in range(len(rows)):
        kind, size = rows[i, KIND], _speed_count(rows[i, KIND])
        for a in range(paths.met_first[i], paths.met_first[i + 1]):
            row, s = paths.met[a]
            if kept.scale[row] == 0.0:
                continue
            place, at, of_modes = paths.place[row], paths.visits[s, OF_JOINT], paths.visits[s, OF_MODES]
            diagonal = paths.ends[place + 1] - 1
            for b in range(paths.met_first[i], a + 1):
                other, t = paths.met[b]
                if kept.scale[other] == 0.0:
                    continue
                by, shared = paths.visits[t, OF_JOINT], 0.0 * work[0, R]
                if at < 0:
                    pass
                elif kind == SPHERICAL:
                    shared += dot(three(numbers, at), three(numbers, by + TURN))
                elif kind == FREE:
                    shared -= dot(three(numbers, at), three(numbers, by + ACCELERATED))
                    shared -= dot(three(numbers, at + TURN), three(numbers, by + ACCELERATED + TURN))
                elif size == 1:
                    shared += numbers[at] * numbers[by] / work[i, PIVOT]
                if flexible is not None and of_modes >= 0 and paths.visits[t, OF_MODES] >= 0:
                    body, their = flexible.bodies[rows[i, FLEXIBLE]], paths.visits[t, OF_MODES]
                    k, n = body[COUNT], 6 * body[CARRIED_COUNT]
                    shared += total(numbers[of_modes : of_modes + k], numbers[their + k : their + 2 * k])
                    on, moved = of_modes + 2 * k, their + 2 * k + n
                    shared -= total(numbers[on : on + n], numbers[moved : moved + n])
                A[diagonal - place + paths.place[other]] += shared
