"""Closing of loops in order n: the nearest coordinates at which they are closed, and speeds that keep them so.

The nearest in the metric of the inertias that the sweeps eliminate. Newton's step is ``-M^-1 J^T lambda`` with
``J M^-1 J^T lambda = g``: the answers to the rows' multipliers are those that also hold the accelerations. They are
kept while the loops close fast, so that what a step of an integrator leaves open costs one set of them and a few
outward sweeps. `kanefe.kane.loop_closure` is the same in dense matrices.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from kanefe.kernels._numba import entry, inlined, kernel
from kanefe.kernels.advance import advance
from kanefe.kernels.constraint_rows import COUPLER_ROW, row_residual
from kanefe.kernels.constraints import (
    FIRST_TERM,
    HOLDS_PLACE,
    IS_ANGLE,
    IS_BALL,
    KIND_OF,
    LENGTH,
    RANK_TOLERANCE,
    ROW_A,
    ROW_B,
    TERM_COUNT,
    Answers,
    Loops,
    answer_rows,
    answers_in,
    hold_size,
    holds,
    write_row,
)
from kanefe.kernels.drives import Drives, put_drives
from kanefe.kernels.implicit import stiffen_joints, stiffen_modes
from kanefe.kernels.inertia import set_inertia
from kanefe.kernels.inward import sweep_inward
from kanefe.kernels.layout import (
    BORDER_SIZE,
    COORDINATES,
    MODAL_SIZE,
    OMEGA,
    POSITION,
    SPEEDS,
    STATES,
    VELOCITY,
    WORK,
    FlexibleTables,
    Tables,
)
from kanefe.kernels.markers import axes_of, lever_of
from kanefe.kernels.outward import sweep_outward
from kanefe.kernels.pivoted import factor, solve
from kanefe.kernels.tolerances import LARGEST_ITERATIONS, LARGEST_OPENING, MOST_HALVINGS, TOLERANCE
from kanefe.kernels.vectors import Numbers, copy, dot, plus, vector

CLOSED, LEFT_OPEN, WITHOUT_INERTIA = range(3)
"""What `close` returns: loops that are open can perhaps be closed by the literal route, which names those that cannot.
So can those of a tree in which something has no inertia of its own."""

SLOW = 0.1
"""Share of the openings left by a step above which the answers are computed anew."""

UNKNOWN, LARGEST_UNKNOWN = 100.0, 1e-6
"""Pivot, of the square of the largest opening, and at most, below which a row may depend on others in truth."""

NEAR, FAR = 1e-10, 1e-6
"""Opening at the start, of the weakest pivot: speeds are right to round-off after one solution with the answers of
there, after two, or need their own."""


class Closing(NamedTuple):
    """Room of `close`.

    Attributes
    ----------
    applied, added : ndarray, shape (free + driven,)
    residuals, trial_residuals, multipliers, scale : ndarray, shape (m,)
    step, speeds : ndarray, shape (free,)
    place, trial : ndarray, shape (coordinates,)
        Coordinates reached, and those tried.
    """

    applied: np.ndarray
    added: np.ndarray
    residuals: np.ndarray
    trial_residuals: np.ndarray
    multipliers: np.ndarray
    scale: np.ndarray
    step: np.ndarray
    speeds: np.ndarray
    place: np.ndarray
    trial: np.ndarray


@entry
def close_size(m: int, n: int, coordinates: int) -> int:
    """Return how many numbers `close` needs room for, with m rows, n free and driven speeds and so many coordinates."""
    return hold_size(m, n) + 4 * n + 4 * m + 2 * coordinates


@inlined
def _closing_in(room: np.ndarray, m: int, n: int, count: int, coordinates: int) -> Closing:
    a, b = 2 * n + 4 * m, 2 * n + 4 * m + 2 * count
    rows = room[2 * n : a]
    return Closing(
        room[:n],
        room[n : 2 * n],
        rows[:m],
        rows[m : 2 * m],
        rows[2 * m : 3 * m],
        rows[3 * m :],
        room[a : a + count],
        room[a + count : b],
        room[b : b + coordinates],
        room[b + coordinates : b + 2 * coordinates],
    )


@kernel
def close(
    tables: Tables,
    flexible: FlexibleTables | None,
    loops: Loops,
    drives: np.ndarray,
    share_stiffness: float,
    q: np.ndarray,
    u: np.ndarray,
    z: np.ndarray,
    work: np.ndarray,
    modal: np.ndarray,
    border: np.ndarray,
    room: np.ndarray,
) -> tuple[int, float]:
    """Close the loops: change q and then u, both to the nearest; return how it ended and the weakest pivot.

    Parameters
    ----------
    drives : ndarray, shape (driven, 3)
    share_stiffness : float
        Of the stiffness of modes and joints in the metric ``M + r K``, s2: stiff modes, which M alone would move, then
        stay where they are.
    q, u : ndarray, shapes (coordinates,), (free,)
        Changed in place, unless what is returned is not CLOSED.
    z : ndarray, shape (states,)
        Of which the switches say which rows hold.
    work, modal, border : ndarray
        Work arrays: what is in them is lost.
    room : ndarray, shape (`close_size`,)
    """
    m, count, n = len(loops.rows), len(u), len(u) + len(drives)
    kept = answers_in(room, m, n)
    at = _closing_in(room[hold_size(m, n) :], m, n, count, len(q))
    copy(q, at.place)
    sweep_outward(tables, flexible, drives, at.place, u, work, modal)
    worst, total = _openings(loops, tables, drives, at.place, z, work, at.residuals)
    start, rank, weakest = worst, 0, 1.0
    has_answers = is_here = False  # whether there are answers, and whether they are those of the place
    is_swept = True
    for _ in range(LARGEST_ITERATIONS):
        if worst == 0.0:
            break
        if not has_answers:
            if not is_swept:
                sweep_outward(tables, flexible, drives, at.place, u, work, modal)
            if not _answer(loops, tables, flexible, drives, share_stiffness, u, z, work, modal, border, at, kept):
                return WITHOUT_INERTIA, 0.0
            rank, weakest = _factor_places(loops, worst, at, kept)
            if weakest == 0.0:
                return WITHOUT_INERTIA, 0.0
            has_answers = is_here = True
        solve(kept.L, kept.inverses, kept.order, rank, at.scale, at.residuals, kept.column, at.multipliers)
        _combine(kept, at.multipliers, at.step)
        shrink = 1.0
        for i in range(count):
            shrink = max(shrink, abs(at.step[i]) / loops.moves[i])
        share = -1.0 / shrink
        # what is closed but for round-off gets better by a whole step or not at all
        tries = MOST_HALVINGS if is_here and worst > TOLERANCE else 1
        is_better, is_swept = False, False
        for _half in range(tries):
            advance(tables, flexible, at.place, at.step, share, at.trial)
            sweep_outward(tables, flexible, drives, at.trial, u, work, modal)
            opening, square = _openings(loops, tables, drives, at.trial, z, work, at.trial_residuals)
            if square < total:
                is_better = True
                break
            share *= 0.5
        if is_better:
            has_answers = opening <= TOLERANCE or square <= SLOW * SLOW * total
            worst, total, is_here, is_swept = opening, square, False, True
            copy(at.trial, at.place)
            copy(at.trial_residuals, at.residuals)
        elif is_here or worst <= TOLERANCE:
            break
        else:
            has_answers = False
    if not worst <= LARGEST_OPENING:
        return LEFT_OPEN, weakest
    if not is_swept:
        sweep_outward(tables, flexible, drives, at.place, u, work, modal)
    if not has_answers or (start > FAR * weakest and not is_here):
        if not _answer(loops, tables, flexible, drives, share_stiffness, u, z, work, modal, border, at, kept):
            return WITHOUT_INERTIA, 0.0
        rank, weakest = factor(
            kept.A, kept.scale, loops.limits[RANK_TOLERANCE], kept.L, kept.inverses, kept.order, kept.column
        )
        is_here = True
    elif loops.rows[:, HOLDS_PLACE].sum() < m:
        rank, weakest = factor(
            kept.A, kept.scale, loops.limits[RANK_TOLERANCE], kept.L, kept.inverses, kept.order, kept.column
        )
    copy(u, at.speeds)
    for _again in range(1 if is_here or start <= NEAR * weakest else 2):
        if _again > 0:
            sweep_outward(tables, flexible, drives, at.place, at.speeds, work, modal)
        for j in range(m):
            at.residuals[j] = 0.0
            if not holds(loops, j, z):
                continue
            write_row(loops, j, tables.gravity, drives, count, work, kept.wrenches)
            at.residuals[j] = _rate(loops, j, drives, work, kept.wrenches, at.speeds)
        solve(kept.L, kept.inverses, kept.order, rank, kept.scale, at.residuals, kept.column, at.multipliers)
        _combine(kept, at.multipliers, at.step)
        for i in range(count):
            at.speeds[i] -= at.step[i]
    copy(at.place, q)
    copy(at.speeds, u)
    return CLOSED, weakest


@kernel
def close_state(
    tables: Tables,
    flexible: FlexibleTables | None,
    loops: Loops,
    motions: Drives,
    drives: np.ndarray,
    t: float,
    share_stiffness: float,
    y: np.ndarray,
    work: np.ndarray,
    modal: np.ndarray,
    border: np.ndarray,
    room: np.ndarray,
) -> bool:
    """Close the loops of a state ``(q, u, z, ...)`` at time t, see `close`; tell whether that was possible."""
    put_drives(motions, t, drives)
    n, m, k = tables.sizes[COORDINATES], tables.sizes[SPEEDS], tables.sizes[STATES]
    q, u, z = y[:n], y[n : n + m], y[n + m : n + m + k]
    ended, _ = close(tables, flexible, loops, drives, share_stiffness, q, u, z, work, modal, border, room)
    return ended == CLOSED


@kernel
def _answer(
    loops: Loops,
    tables: Tables,
    flexible: FlexibleTables | None,
    drives: np.ndarray,
    share_stiffness: float,
    u: np.ndarray,
    z: np.ndarray,
    work: np.ndarray,
    modal: np.ndarray,
    border: np.ndarray,
    at: Closing,
    kept: Answers,
) -> bool:
    """Write the rows and their answers after an outward sweep; tell whether everything has inertia."""
    count, is_implicit, none = len(u), share_stiffness > 0.0, at.step
    for j in range(len(loops.rows)):
        if holds(loops, j, z):
            write_row(loops, j, tables.gravity, drives, count, work, kept.wrenches)
    set_inertia(tables, flexible, work, modal)
    at.applied[:] = 0.0
    if is_implicit:
        none[:] = 0.0
        stiffen_joints(tables, 0.0, share_stiffness, none, none, at.place, u, at.applied, at.added)
        if flexible is not None:
            stiffen_modes(flexible, 0.0, share_stiffness, none, none, modal)
    if not sweep_inward(tables, flexible, at.applied, work, modal, border, is_implicit, at.added):
        return False
    answer_rows(loops, tables, flexible, z, at.applied, work, modal, border, is_implicit, count, kept)
    return True


@kernel
def _factor_places(loops: Loops, worst: float, at: Closing, kept: Answers) -> tuple[int, Any]:
    """Factor the rows that hold places, with openings of `worst` at most; return rank and weakest pivot."""
    for j in range(len(loops.rows)):
        at.scale[j] = kept.scale[j] if loops.rows[j, HOLDS_PLACE] else 0.0
    # rows that depend on each other where the loops are closed seem not to, by the square of how far they are open
    tolerance = max(loops.limits[RANK_TOLERANCE], min(UNKNOWN * worst * worst, LARGEST_UNKNOWN))
    return factor(kept.A, at.scale, tolerance, kept.L, kept.inverses, kept.order, kept.column)


@kernel
def _combine(kept: Answers, multipliers: np.ndarray, step: np.ndarray) -> None:
    """Write what all multipliers cause together."""
    step[:] = 0.0
    for j in range(len(multipliers)):
        if multipliers[j] != 0.0:
            for i in range(len(step)):
                step[i] += multipliers[j] * kept.answers[j, i]


@kernel
def _openings(
    loops: Loops,
    tables: Tables,
    drives: np.ndarray,
    q: np.ndarray,
    z: np.ndarray,
    work: np.ndarray,
    residuals: np.ndarray,
) -> tuple[float, float]:
    """Write g of all rows after an outward sweep; return the largest opening, and the sum of their squares.

    Openings are of the scene's length, or in rad; zero for rows on speeds alone, and for those that do not hold.
    """
    length = loops.limits[LENGTH]
    for i in range(len(tables.rows)):  # far from N's origin round-off is that of the distance
        for c in range(3):
            length = max(length, abs(work[i, POSITION + c]))
    worst = total = 0.0
    for j in range(len(loops.rows)):
        residuals[j] = 0.0
        if not loops.rows[j, HOLDS_PLACE] or not holds(loops, j, z):
            continue
        if loops.rows[j, KIND_OF] == COUPLER_ROW:
            residuals[j] = -loops.numbers[j, 6]
            for term in range(loops.rows[j, FIRST_TERM], loops.rows[j, FIRST_TERM] + loops.rows[j, TERM_COUNT]):
                i = loops.coordinates[term]
                residuals[j] += loops.coefficients[term] * (q[i] if i >= 0 else drives[-1 - i, 0])
        else:
            residuals[j] = row_residual(
                loops.rows[j, KIND_OF],
                loops.numbers,
                j,
                loops.rows[j, IS_BALL] != 0,
                _place(loops.markers, 2 * j, loops.rows[j, ROW_A], work),
                _place(loops.markers, 2 * j + 1, loops.rows[j, ROW_B], work),
            )
        opening = abs(residuals[j]) / (1.0 if loops.rows[j, IS_ANGLE] else length)
        worst = max(worst, opening)
        total += opening * opening
    return worst if total < np.inf else np.inf, total


@inlined
def _place(markers: np.ndarray, n: int, row: int, work: np.ndarray) -> tuple[Numbers, Numbers]:
    """Return position and axes of a marker in N."""
    lever = lever_of(markers, n, row, work)
    axes = axes_of(markers, n, row, work)
    if row < 0:
        return lever, axes
    return plus(vector(work, row, POSITION), lever), axes


@inlined
def _rate(loops: Loops, j: int, drives: np.ndarray, work: np.ndarray, wrenches: np.ndarray, u: np.ndarray) -> float:
    """Return dg/dt of a row from the velocities of its ends."""
    total = 0.0
    if loops.rows[j, KIND_OF] == COUPLER_ROW:
        for term in range(loops.rows[j, FIRST_TERM], loops.rows[j, FIRST_TERM] + loops.rows[j, TERM_COUNT]):
            speed = loops.speeds[term]
            total += loops.coefficients[term] * (u[speed] if speed < len(u) else drives[speed - len(u), 1])
        return total
    for end in range(2):
        row = loops.rows[j, ROW_A + end]
        if row >= 0:
            total += dot(vector(wrenches, j, 6 * end), vector(work, row, VELOCITY))
            total += dot(vector(wrenches, j, 6 * end + 3), vector(work, row, OMEGA))
    return total


@entry
def close_loops(
    tables: Tables,
    flexible: FlexibleTables | None,
    loops: Loops,
    drives: np.ndarray,
    share_stiffness: float,
    q: np.ndarray,
    u: np.ndarray,
    z: np.ndarray,
) -> tuple[int, float]:
    """Close the loops, for Python: change q and u in place; return how it ended and the weakest pivot, see `close`."""
    modes = borders = 0
    if flexible is not None:
        modes, borders = flexible.sizes[MODAL_SIZE], flexible.sizes[BORDER_SIZE]
    rows = WORK * len(tables.rows)
    size = close_size(len(loops.rows), len(u) + len(drives), len(q))
    room = np.empty(rows + modes + borders + size)
    return close(
        tables,
        flexible,
        loops,
        drives,
        share_stiffness,
        q,
        u,
        z,
        room[:rows].reshape(-1, WORK),
        room[rows : rows + modes],
        room[rows + modes : rows + modes + borders],
        room[rows + modes + borders :],
    )
