"""Loop joints and couplers in order n: the multipliers from sweeps that give the unit responses of the rows.

With du_0 of the tree alone and x_j its answer to row j, ``A lambda = -(J du_0 + remainder)`` and
``du = du_0 + sum lambda_j x_j``, where ``A_ij = J_i x_j``. A sweep of forces alone costs less than half of an
evaluation, so that m rows cost some m/2 evaluations and a system of m unknowns. Rows that depend on others drop out.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from kanefe.kernels.algebra.pivoted import factor, solve
from kanefe.kernels.algebra.vectors import Numbers, cross, dot, plus, put, times, vector
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.compiler.arrays import IntegerRows, Integers, RealRows, Reals
from kanefe.kernels.constraints.constraint_jacobian import row_scale, walk_inward
from kanefe.kernels.constraints.constraint_rows import COUPLER_ROW, ROW_NUMBERS, row_terms
from kanefe.kernels.constraints.tolerances import HALF_ON
from kanefe.kernels.layout import (
    ACCELERATION,
    ALPHA,
    WORK_FORCE,
    FlexibleTables,
    R,
    Tables,
    Y,
    Z,
)
from kanefe.kernels.loads.markers import MARKER_NUMBERS, axes_of, lever_of, motion_of
from kanefe.kernels.loads.point_and_field_loads import push
from kanefe.kernels.sweeps.accelerations import put_driving_forces, sweep_accelerations
from kanefe.kernels.sweeps.body_inertia import clear_forces
from kanefe.kernels.sweeps.elastic import span
from kanefe.kernels.sweeps.inward import sweep_forces_inward

# Columns of the integers of a row
KIND_OF, ROW_A, ROW_B, IS_BALL, FIRST_TERM, TERM_COUNT, HOLDS_PLACE, IS_ANGLE, SWITCH = range(9)
CONSTRAINT_INTEGERS = 9
# Columns of the workspace of a row
FORCE_A, MOMENT_A, FORCE_B, MOMENT_B = 0, 3, 6, 9
WRENCHES = 12
# Places of the limits of a scene
RANK_TOLERANCE, LENGTH = range(2)
# Square of the share of its reach below which a row moves nothing: below the square of round-off, 1e-31, for all rows
LEAST_SHARE = 1e-29


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


def no_loops() -> Loops:
    """Return the tables of a scene without constraints."""
    integers, numbers = np.zeros(0, dtype=np.int64), np.zeros(0)
    rows, markers = np.zeros((0, CONSTRAINT_INTEGERS), dtype=np.int64), np.zeros((0, MARKER_NUMBERS))
    return Loops(rows, markers, np.zeros((0, ROW_NUMBERS)), integers, numbers, integers, numbers, numbers, np.zeros(2))


class UnitResponses(NamedTuple):
    """What the constraints do to the speeds at one configuration.

    Attributes
    ----------
    wrenches : ndarray, shape (m, WRENCHES)
        Of each row's unit multiplier, about the origins of its rows.
    unit_responses : ndarray, shape (m, n)
        Accelerations that they cause, and driving forces.
    A : ndarray, shape (m, m)
        Lower triangle of ``J M^-1 J^T``.
    L, inverses, order : ndarray, shapes (m, m), (m,), (m,)
        Its factors, see `kanefe.kernels.algebra.pivoted`.
    scale : ndarray, shape (m,)
        With which a row is of unit length if it points along the motion of its ends; 0: it moves nothing, or does not
        hold.
    rest, column : ndarray, shape (m,)
    J, reach : ndarray, shape (n,)
        Workspace.
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


@kernel
def hold_size(m: int, n: int) -> int:
    """Return how many numbers the workspace of `hold` has, with m rows and n free and driven speeds."""
    return m * (WRENCHES + n + 2 * m + 5) + 2 * n


@inlined
def unit_responses_in(workspace: np.ndarray, m: int, n: int) -> UnitResponses:
    """Return the parts of a workspace of `hold_size`."""
    at = m * WRENCHES
    wrenches = workspace[:at].reshape(m, WRENCHES)
    unit_responses = workspace[at : at + m * n].reshape(m, n)
    at += m * n
    A = workspace[at : at + m * m].reshape(m, m)
    at += m * m
    L = workspace[at : at + m * m].reshape(m, m)
    workspace = workspace[at + m * m :]
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
        workspace[5 * m : 5 * m + n],
        workspace[5 * m + n : 5 * m + 2 * n],
    )


@inlined
def holds(loops: Loops, j: int, z: np.ndarray) -> bool:
    """Return whether a row holds with internal states z."""
    switch = loops.rows[j, SWITCH]
    return switch < 0 or z[switch].real > HALF_ON


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
    kept = unit_responses_in(workspace, m, len(applied))
    for j in range(m):
        if not holds(loops, j, z):
            continue
        remainder = write_row(loops, j, tables.gravity, drives, count, work, kept.wrenches)
        kept.rest[j] = -remainder - _along(loops, j, work, kept.wrenches, du)
    respond_to_rows(loops, tables, flexible, z, applied, work, modal, border, is_implicit, count, kept)
    rank, weakest = factor(
        kept.A, kept.scale, loops.limits[RANK_TOLERANCE], kept.L, kept.inverses, kept.order, kept.column
    )
    solve(kept.L, kept.inverses, kept.order, rank, kept.scale, kept.rest, kept.column, multipliers)
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
    count : int
        Of free speeds.
    """
    m, driven, J, reach = len(loops.rows), len(applied) - count, kept.J, kept.reach
    for j in range(m):
        if not holds(loops, j, z):
            kept.scale[j] = 0.0
            continue
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
        clear_all_forces(tables, flexible, applied, work, modal)
        push_row(loops, tables, flexible, j, 1.0, kept.wrenches, applied, work, modal)
        response = kept.unit_responses[j, :count]  # the driven entries keep the answer of the driving forces
        sweep_forces_inward(tables, flexible, applied, work, modal, border, is_implicit)
        sweep_accelerations(tables, flexible, applied, work, modal, border, is_implicit, response)
        if driven > 0:
            put_driving_forces(tables, applied, work, kept.unit_responses[j, count:])
        for i in range(j, m):
            if kept.scale[i] != 0.0:
                kept.A[i, j] = _along(loops, i, work, kept.wrenches, response)
    for j in range(m):
        # a row of unit length if it pointed along the motion of its ends
        if kept.scale[j] != 0.0:
            size = kept.A[j, j].real
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
    kept = unit_responses_in(workspace, len(loops.rows), len(applied))
    clear_all_forces(tables, flexible, applied, work, modal)
    for j in range(len(loops.rows)):
        if multipliers[j] != 0.0:
            push_row(loops, tables, flexible, j, multipliers[j], kept.wrenches, applied, work, modal)
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
    wrenches: np.ndarray,
    applied: np.ndarray,
    work: np.ndarray,
    modal: np.ndarray,
) -> None:
    """Apply what a multiplier of a row exerts."""
    if loops.rows[j, KIND_OF] == COUPLER_ROW:
        for term in range(loops.rows[j, FIRST_TERM], loops.rows[j, FIRST_TERM] + loops.rows[j, TERM_COUNT]):
            applied[loops.speeds[term]] += multiplier * loops.coefficients[term]
        return
    for end in range(2):
        force, moment = vector(wrenches, j, 6 * end), vector(wrenches, j, 6 * end + 3)
        push(
            tables.rows,
            flexible,
            loops.rows[j, ROW_A + end],
            times(multiplier, force),
            times(multiplier, moment),
            work,
            modal,
        )


@kernel
def write_row(
    loops: Loops, j: int, gravity: np.ndarray, drives: np.ndarray, count: int, work: np.ndarray, wrenches: np.ndarray
) -> Any:
    """Write the wrenches of a row about the origins of its links; return its bias acceleration."""
    zero = 0.0 * work[0, R]
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
        _motion(loops.markers, 2 * j, a, lever_a, gravity, work),
        _motion(loops.markers, 2 * j + 1, b, lever_b, gravity, work),
    )
    put(wrenches, j, FORCE_A, force_a)
    put(wrenches, j, MOMENT_A, plus(moment_a, cross(lever_a, force_a)))
    put(wrenches, j, FORCE_B, force_b)
    put(wrenches, j, MOMENT_B, plus(moment_b, cross(lever_b, force_b)))
    return remainder


@inlined
def _motion(markers: np.ndarray, n: int, row: int, lever: Numbers, gravity: np.ndarray, work: np.ndarray):  # type: ignore[no-untyped-def]
    """Return position, axes, velocity, angular velocity, Z and Y of a marker; gravity in Z cancels."""
    axes = axes_of(markers, n, row, work)
    p, v, w = motion_of(row, lever, work)
    zero = 0.0 * lever[0]
    if row < 0:
        fall = (zero - gravity[0], zero - gravity[1], zero - gravity[2])
        return p, axes, v, w, fall, (zero, zero, zero)
    turn = vector(work, row, Y)
    return p, axes, v, w, plus(vector(work, row, Z), plus(cross(turn, lever), cross(w, cross(w, lever)))), turn


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
