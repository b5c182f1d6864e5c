"""Loop joints and couplers in order n: the multipliers from sweeps that give the unit responses of the rows.

With du_0 of the tree alone and x_j its answer to row j, ``A lambda = -(J du_0 + remainder)`` and
``du = du_0 + sum lambda_j x_j``, where ``A_ij = J_i x_j``. A sweep of forces alone costs less than half of an
evaluation, so that m rows cost some m/2 evaluations and a system of m unknowns. Rows that depend on others drop out.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from kanefe.kernels.algebra.least_norm import factor_least, solve_least
from kanefe.kernels.algebra.pivoted import factor, solve
from kanefe.kernels.algebra.vectors import cross, dot, minus, plus, put, times, vector
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.compiler.arrays import IntegerRows, Integers, RealRows, Reals
from kanefe.kernels.constraints.constraint_jacobian import row_scale, walk_inward
from kanefe.kernels.constraints.constraint_rows import CONTACT_ROW, COUPLER_ROW, ROW_NUMBERS, row_terms
from kanefe.kernels.constraints.tolerances import HALF_ON
from kanefe.kernels.contact.rigid_points import (
    HAS_FRICTION,
    MET,
    MET_NUMBERS,
    SLIPS_FROM,
    RigidPoints,
    is_slipping,
    meet,
    motion_of_marker,
    no_rigid_points,
    rub_along,
)
from kanefe.kernels.layout import ACCELERATION, ALPHA, POSITION, WORK_FORCE, FlexibleTables, R, Tables
from kanefe.kernels.loads.markers import MARKER_NUMBERS, lever_of
from kanefe.kernels.loads.point_and_field_loads import push
from kanefe.kernels.sweeps.accelerations import put_driving_forces, sweep_accelerations
from kanefe.kernels.sweeps.body_inertia import clear_forces
from kanefe.kernels.sweeps.elastic import span
from kanefe.kernels.sweeps.inward import sweep_forces_inward

# Columns of the integers of a row
KIND_OF, ROW_A, ROW_B, IS_BALL, FIRST_TERM, TERM_COUNT, HOLDS_PLACE, IS_ANGLE, SWITCH = range(9)
CONSTRAINT_INTEGERS = 9
# Of a row of a contact point in place of them: which of its directions, 0: the normal, and the number of the point
DIRECTION, POINT = IS_BALL, FIRST_TERM
# Columns of the workspace of a row
FORCE_A, MOMENT_A, FORCE_B, MOMENT_B = 0, 3, 6, 9
WRENCHES = 12
# Places of the limits of a scene
RANK_TOLERANCE, LENGTH = range(2)
# Square of the share of its reach below which a row moves nothing: below the square of round-off, 1e-31, for all rows
LEAST_SHARE = 1e-29
# Share of what a normal force does without friction, below which friction takes away all that it does
LEAST_GAIN = 1e-9
# What is told of the rows of the last evaluation that `share_forces` had: how many hold (-1: it had none), and their rank
LIVE, RANK = range(2)


class Loops(NamedTuple):
    """Constraints of a scene; None in its place leaves out their code.

    Attributes
    ----------
    rows : ndarray of int, shape (m, CONSTRAINT_INTEGERS)
        Kind, rows of both markers (-1: N), is a ball, first term and number of terms of a coupler, whether it holds
        coordinates and not speeds alone, whether its residual is an angle, its switch among the internal states (-1:
        it always holds).
    markers : ndarray, shape (2 m, MARKER_NUMBERS)
    numbers : ndarray, shape (m, ROW_NUMBERS)
        See `kanefe.kernels.constraints.constraint_rows.RowNumbers`.
    speeds : ndarray of int
        Speed of each term of couplers.
    coefficients : ndarray
    coordinates : ndarray of int
        Coordinate of each term of couplers; -1 - drive if it is driven.
    extents : ndarray, shape (free,)
        A large displacement along each free speed: rad, m, or modal units.
    moves : ndarray, shape (free,)
        Largest step of an iteration that closes the loops, along each free speed.
    limits : ndarray, shape (2,)
        Pivot, of a row of unit length, below which it depends on others; a length of the scene, m.
    points : RigidPoints
        Of rigid contacts, three rows each behind those of constraints: along the normal, and in both directions along
        the surface.
    """

    rows: IntegerRows
    markers: RealRows
    numbers: RealRows
    speeds: Integers
    coefficients: Reals
    coordinates: Integers
    extents: Reals
    moves: Reals
    limits: Reals
    points: RigidPoints


def no_loops() -> Loops:
    """Return the tables of a scene without constraints."""
    integers, numbers = np.zeros(0, dtype=np.int64), np.zeros(0)
    rows, markers = np.zeros((0, CONSTRAINT_INTEGERS), dtype=np.int64), np.zeros((0, MARKER_NUMBERS))
    couplers = np.zeros((0, ROW_NUMBERS)), integers, numbers, integers, numbers, numbers
    return Loops(rows, markers, *couplers, np.zeros(2), no_rigid_points())


class UnitResponses(NamedTuple):
    """What the constraints do to the speeds at one configuration.

    Attributes
    ----------
    wrenches : ndarray, shape (m, WRENCHES)
        Of each row's unit multiplier, about the origins of its rows.
    unit_responses : ndarray, shape (m, n)
        Accelerations that they cause, and driving forces.
    A : ndarray, shape (m, m)
        Lower triangle of ``J M^-1 J^T``; where contacts rub, all of ``J M^-1 P^T``.
    L, inverses, order : ndarray, shapes (m, m), (m,), (m,)
        Its factors, see `kanefe.kernels.algebra.pivoted` and `kanefe.kernels.algebra.least_norm`.
    scale : ndarray, shape (m,)
        With which a row is of unit length if it points along the motion of its ends; 0: it moves nothing, or does not
        hold.
    rest, column : ndarray, shape (m,)
    J : ndarray, shape (m, n)
        The rows themselves.
    reach : ndarray, shape (n,)
        Workspace.
    plain : ndarray, shape (m,)
        Of rows of contacts: what the normal force alone would do along the row.
    live, spare : ndarray, shape (m,)
        Rows that hold where points touch; workspace.
    met : ndarray, shape (points, MET_NUMBERS)
        Of the points of rigid contacts.
    told : ndarray, shape (2,)
    """

    wrenches: np.ndarray
    unit_responses: np.ndarray
    A: np.ndarray
    L: np.ndarray
    inverses: np.ndarray
    order: np.ndarray
    scale: np.ndarray
    rest: np.ndarray
    column: np.ndarray
    J: np.ndarray
    reach: np.ndarray
    plain: np.ndarray
    live: np.ndarray
    spare: np.ndarray
    met: np.ndarray
    told: np.ndarray


@kernel
def hold_size(loops: Loops, n: int) -> int:
    """Return how many numbers the workspace of `hold` has, with n free and driven speeds."""
    m = len(loops.rows)
    return m * (WRENCHES + 2 * n + 2 * m + 8) + n + MET_NUMBERS * len(loops.points.places) + 2


@inlined
def unit_responses_in(workspace: np.ndarray, loops: Loops, n: int) -> UnitResponses:
    """Return the parts of a workspace of `hold_size`."""
    m, points = len(loops.rows), len(loops.points.places)
    at = m * WRENCHES
    wrenches = workspace[:at].reshape(m, WRENCHES)
    unit_responses = workspace[at : at + m * n].reshape(m, n)
    at += m * n
    A = workspace[at : at + m * m].reshape(m, m)
    at += m * m
    L = workspace[at : at + m * m].reshape(m, m)
    at += m * m
    J = workspace[at : at + m * n].reshape(m, n)
    at += m * n
    met = workspace[at : at + MET_NUMBERS * points].reshape(points, MET_NUMBERS)
    workspace = workspace[at + MET_NUMBERS * points :]
    return UnitResponses(
        wrenches,
        unit_responses,
        A,
        L,
        workspace[:m],
        workspace[m : 2 * m],
        workspace[2 * m : 3 * m],
        workspace[3 * m : 4 * m],
        workspace[4 * m : 5 * m],
        J,
        workspace[8 * m : 8 * m + n],
        workspace[5 * m : 6 * m],
        workspace[6 * m : 7 * m],
        workspace[7 * m : 8 * m],
        met,
        workspace[8 * m + n : 8 * m + n + 2],
    )


@inlined
def holds(loops: Loops, j: int, z: np.ndarray) -> bool:
    """Return whether a row holds with internal states z."""
    switch = loops.rows[j, SWITCH]
    if switch < 0:
        return True
    if loops.rows[j, KIND_OF] == CONTACT_ROW and loops.rows[j, DIRECTION] > 0 and z[switch].real > SLIPS_FROM:
        return False
    return z[switch].real > HALF_ON


@kernel
def hold(
    loops: Loops,
    tables: Tables,
    flexible: FlexibleTables | None,
    drives: np.ndarray,
    z: np.ndarray,
    applied: np.ndarray,
    work: np.ndarray,
    modal: np.ndarray,
    border: np.ndarray,
    du: np.ndarray,
    driving: np.ndarray,
    multipliers: np.ndarray,
    workspace: np.ndarray,
    is_implicit: bool,
) -> Any:
    """Add to du and driving forces of the tree what the constraints need; return the weakest pivot that counts.

    Parameters
    ----------
    z : ndarray, shape (states,)
        Internal states, of which the switches say which rows hold.
    applied : ndarray, shape (free + driven,)
        Workspace: what is in it is lost.
    multipliers : ndarray, shape (m,)
        On return: of each row.
    workspace : ndarray, shape (`hold_size`,)
    is_implicit : bool
        Whether the inertias are those of a linearly implicit sweep.
    """
    m, count = len(loops.rows), len(du)
    kept = unit_responses_in(workspace, loops, len(applied))
    is_skew = False
    for j in range(m):
        if not holds(loops, j, z):
            continue
        remainder = write_row(loops, j, tables.gravity, drives, z, count, work, kept)
        kept.rest[j] = -remainder - _along(loops, j, work, kept.wrenches, du)
        is_skew = is_skew or is_rubbing(loops, j, z)
    respond_to_rows(loops, tables, flexible, z, applied, work, modal, border, is_implicit, True, count, kept)
    if is_skew:
        weakest = share_forces(loops, z, True, multipliers, kept)
    else:
        rank, weakest = factor(
            kept.A, kept.scale, loops.limits[RANK_TOLERANCE], kept.L, kept.inverses, kept.order, kept.column
        )
        solve(kept.L, kept.inverses, kept.order, rank, kept.scale, kept.rest, kept.column, multipliers)
        kept.told[LIVE] = -1
        if len(loops.points.places) > 0 and not has_loops(loops, kept):
            weakest = 0.0 * weakest + 1.0
    for j in range(m):
        if multipliers[j] != 0.0:
            for i in range(count):
                du[i] += multipliers[j] * kept.unit_responses[j, i]
            for i in range(len(driving)):
                driving[i] += multipliers[j] * kept.unit_responses[j, count + i]
    return weakest


@kernel
def share_forces(loops: Loops, z: np.ndarray, is_skew: bool, multipliers: np.ndarray, kept: UnitResponses) -> Any:
    """Write the multipliers where points touch: of several the least ones; return the weakest pivot of loops, if any.

    Where a force presses a slipping point more than it can hold it out, they are not a number (Painleve's paradox).
    """
    m, closes = len(loops.rows), has_loops(loops, kept)
    if is_skew and not _is_determined(loops, z, closes, multipliers, kept):
        multipliers[:] = np.nan
        return 1.0
    n = 0
    for j in range(m):
        multipliers[j] = 0.0
        if kept.scale[j] != 0.0:
            kept.live[n] = j
            n += 1
    for a in range(n):
        i = int(kept.live[a].real)
        kept.column[a] = kept.scale[i] * kept.rest[i]
        for b in range(n):
            j = int(kept.live[b].real)
            entry = kept.A[i, j] if is_skew or j <= i else kept.A[j, i]
            kept.L[a, b] = kept.scale[i] * entry * kept.scale[j]
    rank, weakest = factor_least(
        kept.L, kept.column, n, loops.limits[RANK_TOLERANCE], kept.order, kept.inverses, kept.spare
    )
    solve_least(kept.L, kept.column, n, rank, kept.order, kept.inverses, kept.spare)
    for a in range(n):
        j = int(kept.live[a].real)
        multipliers[j] = kept.scale[j] * kept.column[a]
    kept.told[LIVE], kept.told[RANK] = n, rank
    return weakest if closes else 1.0


@kernel
def _is_determined(loops: Loops, z: np.ndarray, closes: bool, y: np.ndarray, kept: UnitResponses) -> bool:
    """Return whether the normal force of each slipping point holds it out, the loops held; y is workspace (m,)."""
    m, rank = len(loops.rows), 0
    for j in range(m):
        is_loop = loops.rows[j, KIND_OF] != CONTACT_ROW
        kept.spare[j] = kept.scale[j] if is_loop else 0.0 * kept.scale[j]
    for j in range(m):
        if kept.scale[j] == 0.0 or not is_rubbing(loops, j, z):
            continue
        gained, plain = kept.A[j, j].real, kept.plain[j].real
        if closes:
            if rank == 0:
                rank, _ = factor(
                    kept.A, kept.spare, loops.limits[RANK_TOLERANCE], kept.L, kept.inverses, kept.order, kept.column
                )
            for by in range(2):
                for i in range(m):
                    kept.live[i] = (
                        (kept.A[j, i] if by else kept.A[i, j]) if kept.spare[i] != 0.0 else 0.0 * kept.rest[i]
                    )
                solve(kept.L, kept.inverses, kept.order, rank, kept.spare, kept.live, kept.column, y)
                lost = 0.0
                for i in range(m):
                    if kept.spare[i] != 0.0:
                        lost += (kept.A[j, i] * y[i]).real
                gained, plain = (gained, plain - lost) if by else (gained - lost, plain)
        if not gained > LEAST_GAIN * plain:
            return False
    return True


@inlined
def has_loops(loops: Loops, kept: UnitResponses) -> bool:
    """Return whether rows of constraints hold, and not those of contacts alone."""
    found = False
    for j in range(len(loops.rows)):
        found = found or (kept.scale[j] != 0.0 and loops.rows[j, KIND_OF] != CONTACT_ROW)
    return found


@inlined
def is_rubbing(loops: Loops, j: int, z: np.ndarray) -> bool:
    """Return whether a row is the normal row of a point that slips with friction."""
    if loops.rows[j, KIND_OF] != CONTACT_ROW or loops.rows[j, DIRECTION] > 0:
        return False
    p = loops.rows[j, POINT]
    return is_slipping(loops.points, p, z) and loops.points.places[p, HAS_FRICTION] != 0


@kernel
def respond_to_rows(
    loops: Loops,
    tables: Tables,
    flexible: FlexibleTables | None,
    z: np.ndarray,
    applied: np.ndarray,
    work: np.ndarray,
    modal: np.ndarray,
    border: np.ndarray,
    is_implicit: bool,
    rubs: bool,
    count: int,
    kept: UnitResponses,
) -> None:
    """Write what the unit multiplier of each row causes, and A; the rows are written and the inertias eliminated.

    A row that does not hold is left out: its scale is zero.

    Parameters
    ----------
    z : ndarray, shape (states,)
    applied : ndarray, shape (free + driven,)
        Workspace.
    rubs : bool
        Whether what slips is rubbed by the multiplier of its normal row.
    count : int
        Of free speeds.
    """
    m, driven, reach, is_skew = len(loops.rows), len(applied) - count, kept.reach, False
    for j in range(m):
        if not holds(loops, j, z):
            kept.scale[j] = 0.0
            continue
        is_skew = is_skew or (rubs and is_rubbing(loops, j, z))
        J = kept.J[j]
        J[:] = 0.0
        reach[:] = 0.0
        if loops.rows[j, KIND_OF] == COUPLER_ROW:
            for term in range(loops.rows[j, FIRST_TERM], loops.rows[j, FIRST_TERM] + loops.rows[j, TERM_COUNT]):
                J[loops.speeds[term]] += loops.coefficients[term]
                reach[loops.speeds[term]] += abs(loops.coefficients[term])
        else:
            for end in range(2):
                force, moment = vector(kept.wrenches, j, 6 * end), vector(kept.wrenches, j, 6 * end + 3)
                walk_inward(tables, flexible, loops.rows[j, ROW_A + end], force, moment, work, modal, J, reach)
        share = row_scale(J, reach, loops.extents, work)
        # its pivot would be below all that count, and its sweeps would be for nothing
        kept.scale[j] = share if share.real > LEAST_SHARE else 0.0 * share
    for j in range(m):
        if kept.scale[j] == 0.0:
            continue
        response = kept.unit_responses[j, :count]  # the driven entries keep the answer of the driving forces
        is_rubbed = rubs and is_rubbing(loops, j, z)
        if is_rubbed:
            clear_all_forces(tables, flexible, applied, work, modal)
            push_row(loops, tables, flexible, j, 1.0, False, kept, applied, work, modal)
            sweep_forces_inward(tables, flexible, applied, work, modal, border, is_implicit)
            sweep_accelerations(tables, flexible, applied, work, modal, border, is_implicit, response)
            kept.plain[j] = _along(loops, j, work, kept.wrenches, response)
        clear_all_forces(tables, flexible, applied, work, modal)
        push_row(loops, tables, flexible, j, 1.0, is_rubbed, kept, applied, work, modal)
        sweep_forces_inward(tables, flexible, applied, work, modal, border, is_implicit)
        sweep_accelerations(tables, flexible, applied, work, modal, border, is_implicit, response)
        if driven > 0:
            put_driving_forces(tables, applied, work, kept.unit_responses[j, count:])
        for i in range(0 if is_skew else j, m):
            if kept.scale[i] != 0.0:
                kept.A[i, j] = _along(loops, i, work, kept.wrenches, response)
        if not is_rubbed:
            kept.plain[j] = kept.A[j, j]
    for j in range(m):
        # a row of unit length if it pointed along the motion of its ends
        if kept.scale[j] != 0.0:
            size = kept.plain[j].real
            kept.scale[j] = np.sqrt(kept.scale[j] / size) if size > 0.0 else 0.0 * kept.scale[j]


@kernel
def respond_to_multipliers(
    loops: Loops,
    tables: Tables,
    flexible: FlexibleTables | None,
    applied: np.ndarray,
    work: np.ndarray,
    modal: np.ndarray,
    border: np.ndarray,
    is_implicit: bool,
    count: int,
    multipliers: np.ndarray,
    workspace: np.ndarray,
) -> None:
    """Sweep what all multipliers cause together, after `hold`: forces and accelerations of rows are theirs alone then.

    Parameters
    ----------
    applied : ndarray, shape (free + driven,)
        Workspace.
    count : int
        Of free speeds.
    workspace : ndarray, shape (`hold_size`,)
        Of `hold`; its answers are lost.
    """
    kept = unit_responses_in(workspace, loops, len(applied))
    clear_all_forces(tables, flexible, applied, work, modal)
    for j in range(len(loops.rows)):
        if multipliers[j] != 0.0:
            push_row(loops, tables, flexible, j, multipliers[j], True, kept, applied, work, modal)
    sweep_forces_inward(tables, flexible, applied, work, modal, border, is_implicit)
    sweep_accelerations(tables, flexible, applied, work, modal, border, is_implicit, kept.unit_responses[0, :count])


@kernel
def clear_all_forces(
    tables: Tables, flexible: FlexibleTables | None, applied: np.ndarray, work: np.ndarray, modal: np.ndarray
) -> None:
    """Write no forces on rows, modes and joints."""
    for i in range(len(tables.rows)):
        clear_forces(work, i)
    if flexible is not None:
        for f in range(len(flexible.bodies)):
            modal[span(flexible.bodies[f], WORK_FORCE)][:] = 0.0
    applied[:] = 0.0


@kernel
def push_row(
    loops: Loops,
    tables: Tables,
    flexible: FlexibleTables | None,
    j: int,
    multiplier: Any,
    rubs: bool,
    kept: UnitResponses,
    applied: np.ndarray,
    work: np.ndarray,
    modal: np.ndarray,
) -> None:
    """Apply what a multiplier of a row exerts, with what it rubs where that is asked for."""
    if loops.rows[j, KIND_OF] == COUPLER_ROW:
        for term in range(loops.rows[j, FIRST_TERM], loops.rows[j, FIRST_TERM] + loops.rows[j, TERM_COUNT]):
            applied[loops.speeds[term]] += multiplier * loops.coefficients[term]
        return
    is_contact = loops.rows[j, KIND_OF] == CONTACT_ROW
    for end in range(2):
        row = loops.rows[j, ROW_A + end]
        force, moment = vector(kept.wrenches, j, 6 * end), vector(kept.wrenches, j, 6 * end + 3)
        if rubs and is_contact and row >= 0 and loops.rows[j, DIRECTION] == 0:
            p = loops.rows[j, POINT]
            rubbed = times(1.0 if end else -1.0, vector(kept.met, p, MET.tangential))
            arm = minus(vector(kept.met, p, MET.point), vector(work, row, POSITION))
            force, moment = plus(force, rubbed), plus(moment, cross(arm, rubbed))
        push(tables.rows, flexible, row, times(multiplier, force), times(multiplier, moment), work, modal)


@kernel
def write_row(
    loops: Loops,
    j: int,
    gravity: np.ndarray,
    drives: np.ndarray,
    z: np.ndarray,
    count: int,
    work: np.ndarray,
    kept: UnitResponses,
) -> Any:
    """Write the wrenches of a row that holds about the origins of its links; return its bias acceleration.

    Of a contact point that touches its normal row comes first.
    """
    zero, wrenches = 0.0 * work[0, R], kept.wrenches
    if loops.rows[j, KIND_OF] == CONTACT_ROW:
        p, direction = loops.rows[j, POINT], loops.rows[j, DIRECTION]
        if direction == 0:
            meet(loops.points, p, gravity, work, kept.met)
            rub_along(loops.points, p, z, work, kept.met)
        along = vector(kept.met, p, int(MET.normal) + 3 * direction)
        for end in range(2):
            row, force = loops.rows[j, ROW_A + end], times(1.0 if end else -1.0, along)
            arm = vector(kept.met, p, MET.point)
            if row >= 0:
                arm = minus(arm, vector(work, row, POSITION))
            put(wrenches, j, 6 * end, force)
            put(wrenches, j, 6 * end + 3, cross(arm, force))
        return kept.met[p, int(MET.remainder) + direction]
    if loops.rows[j, KIND_OF] == COUPLER_ROW:
        remainder = zero
        for term in range(loops.rows[j, FIRST_TERM], loops.rows[j, FIRST_TERM] + loops.rows[j, TERM_COUNT]):
            speed = loops.speeds[term]
            if speed >= count:
                remainder += loops.coefficients[term] * drives[speed - count, 2]
        return remainder
    a, b = loops.rows[j, ROW_A], loops.rows[j, ROW_B]
    lever_a, lever_b = lever_of(loops.markers, 2 * j, a, work), lever_of(loops.markers, 2 * j + 1, b, work)
    force_a, moment_a, force_b, moment_b, remainder = row_terms(
        loops.rows[j, KIND_OF],
        loops.numbers,
        j,
        loops.rows[j, IS_BALL] != 0,
        motion_of_marker(loops.markers, 2 * j, a, lever_a, gravity, work),
        motion_of_marker(loops.markers, 2 * j + 1, b, lever_b, gravity, work),
    )
    put(wrenches, j, FORCE_A, force_a)
    put(wrenches, j, MOMENT_A, plus(moment_a, cross(lever_a, force_a)))
    put(wrenches, j, FORCE_B, force_b)
    put(wrenches, j, MOMENT_B, plus(moment_b, cross(lever_b, force_b)))
    return remainder


@inlined
def _along(loops: Loops, j: int, work: np.ndarray, wrenches: np.ndarray, du: np.ndarray) -> Any:
    """Return J_j du from the share of du in the acceleration of the rows."""
    total = 0.0 * work[0, R]
    if loops.rows[j, KIND_OF] == COUPLER_ROW:
        for term in range(loops.rows[j, FIRST_TERM], loops.rows[j, FIRST_TERM] + loops.rows[j, TERM_COUNT]):
            if loops.speeds[term] < len(du):
                total += loops.coefficients[term] * du[loops.speeds[term]]
        return total
    for end in range(2):
        row = loops.rows[j, ROW_A + end]
        if row >= 0:
            total += dot(vector(wrenches, j, 6 * end), vector(work, row, ACCELERATION))
            total += dot(vector(wrenches, j, 6 * end + 3), vector(work, row, ALPHA))
    return total
