"""What a unit multiplier of a row of constraints does to all that it visits on its way inward."""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels.algebra.vectors import (
    Numbers,
    accumulate,
    copy,
    cross,
    dot,
    matrix,
    minus,
    numbers_of,
    plus,
    put,
    put_three,
    rotated,
    rotated_back,
    times,
    vector,
)
from kanefe.kernels.bodies import BorderedBodies
from kanefe.kernels.compiler._numba import inlined
from kanefe.kernels.constraints.constraint_rows import COUPLER_ROW
from kanefe.kernels.constraints.loop_factors import FORCE_AT_END, LEVER, MOMENT_AT_END, TURN, LoopFactors, modes_size
from kanefe.kernels.constraints.loop_tables import FIRST_TERM, KIND_OF, LEAST_SHARE, ROW_A, TERM_COUNT
from kanefe.kernels.constraints.row_paths import OF_JOINT, OF_MODES, VISITED
from kanefe.kernels.joints.on_arrays import moved_freely, partials, through_axis, through_ball
from kanefe.kernels.layout import (
    BASIS,
    BENT,
    CARRIED_COUNT,
    CARRIES,
    COUNT,
    DETA,
    FLEXIBLE,
    FREE,
    GIVEN,
    INTERFACE,
    KIND,
    OFFSET,
    PARENT,
    ROW,
    SPEED,
    SPHERICAL,
    R,
)
from kanefe.kernels.loads.markers import lever_of
from kanefe.kernels.loads.point_and_field_loads import share_of_modes, wrench_on_slopes
from kanefe.kernels.sweeps.elastic import total
from kanefe.kernels.sweeps.modal_elimination import push_through_modes, scale, subtract
from kanefe.kernels.tables import FlexibleTables, Loops, Tables


@inlined
def put_visits(
    loops: Loops,
    tables: Tables,
    flexible: FlexibleTables,
    j: int,
    work: np.ndarray,
    modal: np.ndarray,
    border: np.ndarray,
    is_implicit: bool,
    kept: LoopFactors,
) -> Any:
    """Write what a unit multiplier of a row does at all it visits; return how much of its reach it has, squared.

    That is ``|J|^2`` relative to that of a row whose wrench pointed along all motions on its way, over displacements of
    the scene's size, whatever the inertias. Modes count as what they have: a light body could move the row far by its
    high modes or its twist, which says nothing of a singular position. Zero for what is round-off of all. A joint with
    partial velocities v and w has ``v F + w (M + r x F)`` of force and moment at the end, with the lever r to it, and
    could have the root of ``(v F)^2 + w^2 (M^2 + r^2 F^2)``.

    Of a joint: e; of a free one the accelerations of its body. Of k modes and n numbers of what the body carries: the
    forces p on the modes, their accelerations x, what acts on the carried interfaces, how these move, and y. Wrenches
    are those that a link needs from its parent, against what acts on it.
    """
    paths, rows, geometry, carried, numbers = loops.paths, tables.rows, tables.geometry, kept.carried, kept.numbers
    begin, end = paths.first[j], paths.first[j + 1]
    own = reach = own_of_modes = reach_of_modes = 0.0 * work[0, R]
    for s in range(begin, end):
        i = paths.visits[s, VISITED]
        carried[i, :] = 0.0
        if paths.visits[s, OF_JOINT] >= 0 and rows[i, KIND] <= GIVEN:
            numbers[paths.visits[s, OF_JOINT]] = 0.0  # what a coupler applies, until its joint is reached
        if rows[i, KIND] != INTERFACE and paths.visits[s, OF_MODES] >= 0:
            body, at = flexible.bodies[rows[i, FLEXIBLE]], paths.visits[s, OF_MODES]
            numbers[at : at + modes_size(body[COUNT], body[CARRIED_COUNT])] = 0.0
    if loops.rows[j, KIND_OF] == COUPLER_ROW:
        _apply_coupler(loops, tables, j, kept)
    else:
        for which in range(2):
            i = loops.rows[j, ROW_A + which]
            if i >= 0:
                force = vector(kept.exerted.wrenches, j, 6 * which)
                moment = vector(kept.exerted.wrenches, j, 6 * which + 3)
                accumulate(carried, i, 0, times(-1.0, force))
                accumulate(carried, i, TURN, times(-1.0, moment))
                arm = lever_of(loops.markers, 2 * j + which, i, work)
                _hand_ends(carried, i, force, minus(moment, cross(arm, force)), arm)
    for s in range(begin, end):
        i, at, of_modes, of_wrench = paths.visits[s]
        kind, parent = rows[i, KIND], rows[i, PARENT]
        force, moment = vector(carried, i, 0), vector(carried, i, TURN)
        lever, moves = vector(carried, i, LEVER), s < paths.common[j]  # what carries both ends does not move the row
        pull, couple = vector(carried, i, FORCE_AT_END), vector(carried, i, MOMENT_AT_END)
        twist, along = plus(couple, cross(lever, pull)), dot(pull, pull)
        across = dot(couple, couple) + dot(lever, lever) * along
        is_end = s == end - 1 and at < 0 and of_wrench < 0
        if kind == INTERFACE and not is_end:
            body = flexible.bodies[rows[i, FLEXIBLE]]
            if body[COUNT] > 0:
                G = matrix(work, body[ROW], R)
                if moves:
                    reach_of_modes += _modal_reach(loops, flexible, rows, i, along, work, modal)
                if rows[i, CARRIES]:
                    if moves:
                        own_of_modes += _modal_share(loops, flexible, rows, i, pull, twist, work, modal)
                    put_three(numbers, of_modes, rotated_back(G, force))
                    put_three(numbers, of_modes + 3, rotated_back(G, moment))
                    _hand_ends(carried, parent, pull, couple, plus(lever, vector(work, i, OFFSET)))
                    continue
                p = numbers[of_modes : of_modes + body[COUNT]]
                share_of_modes(flexible, rows, i, times(-1.0, force), times(-1.0, moment), work, modal, p)
        elif of_modes >= 0:
            a, b, moved = _give_way(
                loops, flexible, rows[i, FLEXIBLE], of_modes, work, modal, border, is_implicit, numbers
            )
            force, moment = plus(force, a), plus(moment, b)
            if s <= paths.common[j]:
                own_of_modes += moved
        if is_end:
            put(kept.felt, j, 0, force)
            put(kept.felt, j, TURN, moment)
            break
        if of_wrench >= 0:
            put_three(numbers, of_wrench, force)
            put_three(numbers, of_wrench + TURN, moment)
        if kind == FREE:
            a, alpha = moved_freely(i, times(-1.0, force), times(-1.0, moment), work)
            put_three(numbers, at, a)
            put_three(numbers, at + TURN, alpha)
            if moves:
                shift, turn_size = loops.extents[rows[i, SPEED]], loops.extents[rows[i, SPEED] + 3]
                own += shift * shift * along + turn_size * turn_size * dot(twist, twist)
                reach += shift * shift * along + turn_size * turn_size * across
            continue
        if kind == SPHERICAL:
            turning, force = through_ball(i, force, moment, work)
            put_three(numbers, at, turning)
            moment = times(0.0, moment)
            if moves:
                size = loops.extents[rows[i, SPEED]]
                own += size * size * dot(twist, twist)
                reach += size * size * across
        elif at >= 0:
            v, w = partials(rows, geometry, i, work)
            applied = numbers[at]
            if moves:
                size = loops.extents[rows[i, SPEED]]
                moved = size * (applied + dot(v, pull) + dot(w, twist))
                own += moved * moved
                reach += size * size * (applied * applied + dot(v, v) * along + dot(w, w) * across)
            e, force, moment = through_axis(rows, geometry, i, applied, force, moment, work)
            numbers[at] = e
        if parent >= 0:
            accumulate(carried, parent, 0, force)
            offset = vector(work, i, OFFSET)
            accumulate(carried, parent, TURN, plus(moment, cross(offset, force)))
            _hand_ends(carried, parent, pull, couple, plus(lever, offset))
    whole = own + own_of_modes
    if not whole.real > LEAST_SHARE * (reach + reach_of_modes).real:  # else its pivot would be below all that count
        return 0.0 * whole
    return whole / (reach + own_of_modes)


@inlined
def _hand_ends(carried: np.ndarray, parent: int, pull: Numbers, couple: Numbers, lever: Numbers) -> None:
    put(carried, parent, FORCE_AT_END, pull)
    put(carried, parent, MOMENT_AT_END, couple)
    put(carried, parent, LEVER, lever)


@inlined
def _modal_reach(
    loops: Loops,
    flexible: FlexibleTables,
    rows: np.ndarray,
    i: int,
    force_square: Any,
    work: np.ndarray,
    modal: np.ndarray,
) -> Any:
    """Return what a force on an interface would move of the modes if it pointed along their motions there."""
    body, at, bent = flexible.bodies[rows[i, FLEXIBLE]], rows[i, BASIS], rows[i, BENT]
    k, shift = body[COUNT], 0.0 * work[0, R]
    for m in range(k):
        size = loops.extents[body[DETA] + m]
        for a in range(3):
            if bent < 0:
                x = 0.0 * shift + size * flexible.pool[at + a * k + m]
            else:
                x = size * modal[bent + a * k + m]
            shift += x * x
    return shift * force_square


@inlined
def _modal_share(
    loops: Loops,
    flexible: FlexibleTables,
    rows: np.ndarray,
    i: int,
    force: Numbers,
    moment: Numbers,
    work: np.ndarray,
    modal: np.ndarray,
) -> Any:
    """Return what a wrench in N on an interface moves of the modes."""
    body, at, bent = flexible.bodies[rows[i, FLEXIBLE]], rows[i, BASIS], rows[i, BENT]
    k, own = body[COUNT], 0.0 * work[0, R]
    a, b = wrench_on_slopes(rows, i, force, moment, work)
    for m in range(k):
        p = 0.0 * own
        for c in range(3):
            if bent < 0:
                p += flexible.pool[at + c * k + m] * a[c] + flexible.pool[at + (3 + c) * k + m] * b[c]
            else:
                p += modal[bent + c * k + m] * a[c] + modal[bent + (3 + c) * k + m] * b[c]
        own += (loops.extents[body[DETA] + m] * p) ** 2
    return own


@inlined
def _apply_coupler(loops: Loops, tables: Tables, j: int, kept: LoopFactors) -> None:
    """Apply the terms of a coupler at their joints: its driven coordinates do not give way."""
    paths, rows = loops.paths, tables.rows
    for term in range(loops.rows[j, FIRST_TERM], loops.rows[j, FIRST_TERM] + loops.rows[j, TERM_COUNT]):
        speed, coefficient = loops.speeds[term], loops.coefficients[term]
        for s in range(paths.first[j], paths.first[j + 1]):
            i, at = paths.visits[s, VISITED], paths.visits[s, OF_JOINT]
            if at >= 0 and rows[i, SPEED] == speed:
                kept.numbers[at] += coefficient


@inlined
def _give_way(
    loops: Loops,
    flexible: FlexibleTables,
    f: int,
    at: int,
    work: np.ndarray,
    modal: np.ndarray,
    border: np.ndarray,
    is_implicit: bool,
    numbers: np.ndarray,
) -> tuple[Numbers, Numbers, Any]:
    """Write how the modes of a body give way to a row; return what its link feels more, in N, and what the row moves.

    That is over the coordinates themselves, as what it could move is, and without what it moves by what is carried.
    See `kanefe.kernels.sweeps.modal_elimination`: with G at rest ``x = p - B^T y``, and y as there.
    """
    body = flexible.bodies[f]
    k, n, G = body[COUNT], 6 * body[CARRIED_COUNT], matrix(work, body[ROW], R)
    p, x, rest = numbers[at : at + k], numbers[at + k : at + 2 * k], numbers[at + 2 * k : at + 2 * k + 3 * n]
    on, moved, held = rest[:n], rest[n : 2 * n], rest[2 * n :]
    parts, own = BorderedBodies(flexible.bodies, flexible.pool, modal, border)[f], 0.0 * work[0, R]
    for d in range(k):
        own += (loops.extents[body[DETA] + d] * p[d]) ** 2
    scale(body, p.reshape(1, k), modal, is_implicit)
    copy(p, x)
    for c in range(n):
        subtract(parts.basis[c], on[c], x)
    a, b = push_through_modes(parts, p, on, moved, held)
    copy(p, x)
    for c in range(n):
        subtract(parts.basis[c], held[c], x)
    for c in range(n):
        moved[c] = total(parts.basis[c], x)
    return rotated(G, numbers_of(a)), rotated(G, numbers_of(b)), own
