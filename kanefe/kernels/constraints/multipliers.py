"""Loop joints and couplers in order n: the multipliers from sweeps that give the unit responses of the rows.

With du_0 of the tree alone and x_j its answer to row j, ``A lambda = -(J du_0 + remainder)`` and
``du = du_0 + sum lambda_j x_j``, where ``A_ij = J_i x_j``. A sweep of forces alone costs less than half of an
evaluation, so that m rows cost some m/2 evaluations and a system of m unknowns. Rows that depend on others drop out.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels.algebra.pivoted import factor, solve
from kanefe.kernels.algebra.vectors import cross, dot, minus, plus, put, times, vector
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.constraints.constraint_jacobian import row_scale, walk_inward
from kanefe.kernels.constraints.constraint_rows import CONTACT_ROW, COUPLER_ROW, row_terms
from kanefe.kernels.constraints.least_forces import share_forces
from kanefe.kernels.constraints.loop_tables import (
    DIRECTION,
    FIRST_TERM,
    FORCE_A,
    FORCE_B,
    IS_BALL,
    KIND_OF,
    LIVE,
    MOMENT_A,
    MOMENT_B,
    POINT,
    RANK_TOLERANCE,
    ROW_A,
    ROW_B,
    TERM_COUNT,
    Loops,
    UnitResponses,
    has_loops,
    holds,
    is_rubbing,
    unit_responses_in,
)
from kanefe.kernels.contact.rigid_points import MET, meet, motion_of_marker, rub_along
from kanefe.kernels.layout import ACCELERATION, ALPHA, POSITION, WORK_FORCE, FlexibleTables, R, Tables
from kanefe.kernels.loads.markers import lever_of
from kanefe.kernels.loads.point_and_field_loads import push
from kanefe.kernels.sweeps.accelerations import put_driving_forces, sweep_accelerations
from kanefe.kernels.sweeps.body_inertia import clear_forces
from kanefe.kernels.sweeps.elastic import span
from kanefe.kernels.sweeps.inward import sweep_forces_inward

# Square of the share of its reach below which a row moves nothing: below the square of round-off, 1e-31, for all rows
LEAST_SHARE = 1e-29


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
