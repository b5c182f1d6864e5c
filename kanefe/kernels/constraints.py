"""Loop joints and couplers in order n: the multipliers from sweeps that answer to each row's unit multiplier.

With du_0 of the tree alone and x_j its answer to row j, ``A lambda = -(J du_0 + remainder)`` and
``du = du_0 + sum lambda_j x_j``, where ``A_ij = J_i x_j``. A sweep of forces alone costs less than half of an
evaluation, so that m rows cost some m/2 evaluations and a system of m unknowns. Rows that depend on others drop out.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from kanefe.kernels._numba import inlined, kernel
from kanefe.kernels.accelerations import put_driving_forces, sweep_accelerations
from kanefe.kernels.body_inertia import clear_forces
from kanefe.kernels.constraint_rows import COUPLER_ROW, row_terms
from kanefe.kernels.elastic import span
from kanefe.kernels.inward import sweep_forces_inward
from kanefe.kernels.layout import (
    ABOUT,
    ACCELERATION,
    ALONG,
    ALPHA,
    AXIS,
    BASIS,
    BENT,
    COUNT,
    DETA,
    FIXED,
    FLEXIBLE,
    FREE,
    INTERFACE,
    KIND,
    OFFSET,
    PARENT,
    SPEED,
    SPHERICAL,
    TANGENT,
    WORK_FORCE,
    FlexibleTables,
    R,
    Tables,
    Y,
    Z,
)
from kanefe.kernels.loads import push
from kanefe.kernels.markers import axes_of, lever_of, motion_of
from kanefe.kernels.vectors import Numbers, cross, dot, matrix, plus, put, rotated_back, vector

# Columns of the integers of a row
KIND_OF, ROW_A, ROW_B, IS_BALL, FIRST_TERM, TERM_COUNT = range(6)
CONSTRAINT_INTEGERS = 6
# Columns of the room of a row
FORCE_A, MOMENT_A, FORCE_B, MOMENT_B = 0, 3, 6, 9
WRENCHES = 12
# Pivot of a scaled row, of 1 at most, that the tolerance is taken of at least: see `kanefe.kane.constraints.ROUND_OFF`
ROUND_OFF = 1e-16


class Loops(NamedTuple):
    """Constraints of a scene; None in its place leaves out their code.

    Attributes
    ----------
    rows : ndarray of int, shape (m, CONSTRAINT_INTEGERS)
        Kind, rows of both markers (-1: N), is a ball, first term and number of terms of a coupler.
    markers : ndarray, shape (2 m, MARKER_NUMBERS)
    numbers : ndarray, shape (m, 7)
        e, f, and a length, lead or radius.
    speeds : ndarray of int
        Speed of each term of couplers.
    coefficients : ndarray
    tolerance : ndarray, shape (1,)
        Pivot, of a row of unit length, below which it depends on others.
    """

    rows: np.ndarray
    markers: np.ndarray
    numbers: np.ndarray
    speeds: np.ndarray
    coefficients: np.ndarray
    tolerance: np.ndarray


@inlined
def hold_size(m: int, n: int) -> int:
    """Return how many numbers `hold` needs room for, with m rows and n free and driven speeds."""
    return m * (WRENCHES + n + m + 3) + 2 * n


@kernel
def hold(
    loops: Loops,
    tables: Tables,
    flexible: FlexibleTables | None,
    drives: np.ndarray,
    applied: np.ndarray,
    work: np.ndarray,
    modal: np.ndarray,
    border: np.ndarray,
    du: np.ndarray,
    driving: np.ndarray,
    multipliers: np.ndarray,
    room: np.ndarray,
    is_implicit: bool,
) -> Any:
    """Add to du and driving forces of the tree what the constraints need; return the weakest pivot that counts.

    Parameters
    ----------
    applied : ndarray, shape (free + driven,)
        Room: what is in it is lost.
    multipliers : ndarray, shape (m,)
        On return: of each row.
    room : ndarray, shape (`hold_size`,)
    """
    m, n, count = len(loops.rows), len(applied), len(du)
    wrenches = room[: m * WRENCHES].reshape(m, WRENCHES)
    room = room[m * WRENCHES :]
    answers = room[: m * n].reshape(m, n)
    room = room[m * n :]
    A = room[: m * m].reshape(m, m)
    room = room[m * m :]
    scale, rest, order = room[:m], room[m : 2 * m], room[2 * m : 3 * m]
    J, reach = room[3 * m : 3 * m + n], room[3 * m + n : 3 * m + 2 * n]
    for j in range(m):
        remainder = _write_row(loops, j, tables.gravity, drives, count, work, wrenches)
        rest[j] = remainder + _along(loops, j, work, wrenches, du)
        multipliers[j] = 0.0
    for j in range(m):
        J[:] = 0.0
        reach[:] = 0.0
        for i in range(len(tables.rows)):
            clear_forces(work, i)
        if flexible is not None:
            for f in range(len(flexible.bodies)):
                modal[span(flexible.bodies[f], WORK_FORCE)][:] = 0.0
        applied[:] = 0.0
        if loops.rows[j, KIND_OF] == COUPLER_ROW:
            for term in range(loops.rows[j, FIRST_TERM], loops.rows[j, FIRST_TERM] + loops.rows[j, TERM_COUNT]):
                speed = loops.speeds[term]
                applied[speed] += loops.coefficients[term]
                J[speed] += loops.coefficients[term]
                reach[speed] += abs(loops.coefficients[term])
        else:
            for end in range(2):
                row = loops.rows[j, ROW_A + end]
                force, moment = vector(wrenches, j, 6 * end), vector(wrenches, j, 6 * end + 3)
                push(tables.rows, flexible, row, force, moment, work, modal)
                _walk_inward(tables, flexible, row, force, moment, work, modal, J, reach)
        scale[j] = _row_scale(J, reach, work, count)
        answer = answers[j, :count]  # the driven entries keep the answer of the driving forces
        sweep_forces_inward(tables, flexible, applied, work, modal, border, is_implicit)
        sweep_accelerations(tables, flexible, applied, work, modal, border, is_implicit, answer)
        if len(driving) > 0:
            put_driving_forces(tables, applied, work, answers[j, count:])
        for i in range(m):
            A[i, j] = _along(loops, i, work, wrenches, answer)
    for j in range(m):
        # a row of unit length if it pointed along the motion of its ends
        size = A[j, j].real
        scale[j] = np.sqrt(scale[j] / size) if size > 0.0 else 0.0 * scale[j]
    weakest = _solve_pivoted(A, scale, rest, order, multipliers, loops.tolerance[0])
    for j in range(m):
        for i in range(count):
            du[i] += multipliers[j] * answers[j, i]
        for i in range(len(driving)):
            driving[i] += multipliers[j] * answers[j, count + i]
    return weakest


@kernel
def _write_row(
    loops: Loops, j: int, gravity: np.ndarray, drives: np.ndarray, count: int, work: np.ndarray, wrenches: np.ndarray
) -> Any:
    """Write the wrenches of a row about the origins of its rows; return its remainder."""
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


@kernel
def _walk_inward(
    tables: Tables,
    flexible: FlexibleTables | None,
    i: int,
    force: Numbers,
    moment: Numbers,
    work: np.ndarray,
    modal: np.ndarray,
    J: np.ndarray,
    reach: np.ndarray,
) -> None:
    """Add the generalised forces of a wrench on a row, and the largest they could be, on the way to N."""
    rows, geometry = tables.rows, tables.geometry
    # of a vector whose real part is zero, the square of a complex step is negative
    f_size, m_size = np.sqrt(abs(dot(force, force).real)), np.sqrt(abs(dot(moment, moment).real))
    while i >= 0:
        kind, speed = rows[i, KIND], rows[i, SPEED]
        if flexible is not None and kind == INTERFACE:
            body = flexible.bodies[rows[i, FLEXIBLE]]
            k, first = body[COUNT], body[DETA]
            G = matrix(work, rows[i, PARENT], R)
            a, b = rotated_back(G, force), rotated_back(matrix(work, i, TANGENT), rotated_back(G, moment))
            at, bent = rows[i, BASIS], rows[i, BENT]
            own, room = J[first : first + k], reach[first : first + k]
            if bent < 0:
                _add_modal_row(flexible.pool[at : at + 6 * k].reshape(6, k), a, b, f_size, m_size, own, room)
            else:
                _add_modal_row(modal[bent : bent + 6 * k].reshape(6, k), a, b, f_size, m_size, own, room)
        elif FIXED < kind <= AXIS:
            axis = (work[i, R + 2], work[i, R + 5], work[i, R + 8])
            J[speed] += geometry[i, ALONG] * dot(axis, force) + geometry[i, ABOUT] * dot(axis, moment)
            reach[speed] += abs(geometry[i, ALONG]) * f_size + abs(geometry[i, ABOUT]) * m_size
        elif kind in (SPHERICAL, FREE):
            last = speed
            if kind == FREE:
                for c in range(3):  # in N: the length is what matters
                    J[speed + c] += force[c]
                    reach[speed + c] += f_size
                last += 3
            for c in range(3):
                J[last + c] += moment[c]
                reach[last + c] += m_size
        lever = vector(work, i, OFFSET)
        moment = plus(moment, cross(lever, force))
        m_size += np.sqrt(abs(dot(lever, lever).real)) * f_size
        i = rows[i, PARENT]


@kernel
def _add_modal_row(
    basis: np.ndarray, a: Numbers, b: Numbers, f_size: float, m_size: float, J: np.ndarray, reach: np.ndarray
) -> None:
    """Add the generalised forces of a wrench in G on the modes of a body, and the largest they could be."""
    for j in range(len(J)):
        size, turn = 0.0, 0.0
        for c in range(3):
            J[j] += basis[c, j] * a[c] + basis[3 + c, j] * b[c]
            size += (basis[c, j] * basis[c, j]).real
            turn += (basis[3 + c, j] * basis[3 + c, j]).real
        reach[j] += np.sqrt(size) * f_size + np.sqrt(turn) * m_size


@inlined
def _row_scale(J: np.ndarray, reach: np.ndarray, work: np.ndarray, count: int) -> Any:
    """Return the square of how much of its reach a row has, between 0 and 1."""
    own = full = 0.0
    for i in range(count):
        own += J[i].real * J[i].real
        full += reach[i].real * reach[i].real
    share = 0.0 * work[0, R]
    return share + (own / full if full > 0.0 else 0.0)


@kernel
def _solve_pivoted(
    A: np.ndarray, scale: np.ndarray, rest: np.ndarray, order: np.ndarray, multipliers: np.ndarray, tolerance: float
) -> Any:
    """Write lambda of ``A lambda = -rest``, leaving out rows that depend on others; return the smallest pivot used."""
    m = len(rest)
    for i in range(m):
        rest[i] *= scale[i]
        order[i] = 0.0
        for j in range(m):
            A[i, j] *= scale[i] * scale[j]
    largest, weakest = ROUND_OFF, 1.0
    # Gauss and Jordan on the diagonal: A is symmetric and not negative
    for _ in range(m):
        best = -1
        for i in range(m):
            if order[i].real == 0.0 and (best < 0 or A[i, i].real > A[best, best].real):
                best = i
        pivot = A[best, best]
        largest = max(largest, pivot.real)
        if pivot.real <= tolerance * largest:
            if pivot.real > 1e-3 * tolerance * largest:
                weakest = pivot.real / largest
            break
        weakest = min(weakest, pivot.real / largest)
        order[best] = 1.0
        for i in range(m):
            if i != best and A[i, best] != 0.0:
                factor = A[i, best] / pivot
                for j in range(m):
                    A[i, j] -= factor * A[best, j]
                rest[i] -= factor * rest[best]
    for i in range(m):
        multipliers[i] = -scale[i] * rest[i] / A[i, i] if order[i].real > 0.0 else 0.0 * rest[i]
    return weakest
