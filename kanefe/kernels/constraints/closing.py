"""Closing of loops in order n: the nearest coordinates at which they are closed, and speeds that keep them so.

The nearest in the metric of the inertias that the sweeps eliminate. Newton's step is ``-M^-1 J^T lambda`` with
``J M^-1 J^T lambda = g``: the answers to the rows' multipliers are those that also hold the accelerations. They are
kept while the loops close fast, so that what a step of an integrator leaves open costs one set of them and a few
outward sweeps. `kanefe.kane.loop_closure` is the same in dense matrices.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from kanefe.kernels.algebra.pivoted import factor, solve
from kanefe.kernels.algebra.vectors import copy
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.compiler.arrays import RealRows, Reals
from kanefe.kernels.compiler.entries import entry
from kanefe.kernels.compiler.signatures import Variant
from kanefe.kernels.constraints.loop_tables import (
    HOLDS_PLACE,
    RANK_TOLERANCE,
    Loops,
    UnitResponses,
    hold_size,
    holds,
    unit_responses_in,
)
from kanefe.kernels.constraints.multipliers import respond_to_rows, write_row
from kanefe.kernels.constraints.openings import openings, rate_of_row
from kanefe.kernels.constraints.tolerances import LARGEST_ITERATIONS, LARGEST_OPENING, MOST_HALVINGS, TOLERANCE
from kanefe.kernels.layout import (
    BORDER_SIZE,
    COORDINATES,
    DRIVES,
    MODAL_SIZE,
    SPEEDS,
    STATES,
    WORK,
    FlexibleTables,
    Tables,
)
from kanefe.kernels.sweeps.advance import advance
from kanefe.kernels.sweeps.implicit import stiffen_joints, stiffen_modes
from kanefe.kernels.sweeps.inertia import set_inertia
from kanefe.kernels.sweeps.inward import sweep_inward
from kanefe.kernels.sweeps.outward import sweep_outward

CLOSED, LEFT_OPEN, WITHOUT_INERTIA = range(3)
"""Return values of `close`. The literal route may be able to close open loops, and names those that cannot be closed;
the same holds for a tree in which something has no inertia of its own."""

SLOW = 0.1
"""Fraction of the gaps left by a step above which the unit responses are computed again."""

UNKNOWN, LARGEST_UNKNOWN = 100.0, 1e-6
"""Pivot below which a row may in fact depend on others, in multiples of the square of the largest gap, and its largest
value."""

NEAR, FAR = 1e-10, 1e-6
"""Gap at the start, relative to the weakest pivot: up to the first value speeds are accurate to round-off after one
solution with the unit responses of the start, up to the second after two; beyond, the unit responses are computed
again."""


class Closing(NamedTuple):
    """Workspace of `close`.

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


@kernel
def close_size(loops: Loops, n: int, coordinates: int) -> int:
    """Return how many numbers the workspace of `close` has, with n free and driven speeds."""
    m = len(loops.rows)
    return hold_size(loops, n) + 4 * n + 4 * m + 2 * coordinates


@inlined
def _closing_in(workspace: np.ndarray, m: int, n: int, count: int, coordinates: int) -> Closing:
    a, b = 2 * n + 4 * m, 2 * n + 4 * m + 2 * count
    rows = workspace[2 * n : a]
    return Closing(
        workspace[:n],
        workspace[n : 2 * n],
        rows[:m],
        rows[m : 2 * m],
        rows[2 * m : 3 * m],
        rows[3 * m :],
        workspace[a : a + count],
        workspace[a + count : b],
        workspace[b : b + coordinates],
        workspace[b + coordinates : b + 2 * coordinates],
    )


@kernel
def close(
    tables: Tables,
    flexible: FlexibleTables,
    loops: Loops,
    drives: np.ndarray,
    share_stiffness: float,
    q: np.ndarray,
    u: np.ndarray,
    z: np.ndarray,
    work: np.ndarray,
    modal: np.ndarray,
    border: np.ndarray,
    workspace: np.ndarray,
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
    workspace : ndarray, shape (`close_size`,)
    """
    m, count, n = len(loops.rows), len(u), len(u) + len(drives)
    kept = unit_responses_in(workspace, loops, n)
    at = _closing_in(workspace[hold_size(loops, n) :], m, n, count, len(q))
    copy(q, at.place)
    sweep_outward(tables, flexible, drives, at.place, u, work, modal)
    worst, total = openings(loops, tables, drives, at.place, z, work, kept.met, at.residuals)
    start, rank, weakest = worst, 0, 1.0
    has_responses = is_here = False  # whether there are answers, and whether they are those of the place
    is_swept = True
    for _ in range(LARGEST_ITERATIONS):
        if worst == 0.0:
            break
        if not has_responses:
            if not is_swept:
                sweep_outward(tables, flexible, drives, at.place, u, work, modal)
            if not _unit_responses(
                loops, tables, flexible, drives, share_stiffness, u, z, work, modal, border, at, kept
            ):
                return WITHOUT_INERTIA, 0.0
            rank, weakest = _factor_places(loops, worst, at, kept)
            if weakest == 0.0:
                return WITHOUT_INERTIA, 0.0
            has_responses = is_here = True
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
            opening, square = openings(loops, tables, drives, at.trial, z, work, kept.met, at.trial_residuals)
            if square < total:
                is_better = True
                break
            share *= 0.5
        if is_better:
            has_responses = opening <= TOLERANCE or square <= SLOW * SLOW * total
            worst, total, is_here, is_swept = opening, square, False, True
            copy(at.trial, at.place)
            copy(at.trial_residuals, at.residuals)
        elif is_here or worst <= TOLERANCE:
            break
        else:
            has_responses = False
    if not worst <= LARGEST_OPENING:
        return LEFT_OPEN, weakest
    if not is_swept:
        sweep_outward(tables, flexible, drives, at.place, u, work, modal)
    if not has_responses or (start > FAR * weakest and not is_here):
        if not _unit_responses(loops, tables, flexible, drives, share_stiffness, u, z, work, modal, border, at, kept):
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
            write_row(loops, j, tables.gravity, drives, z, count, work, kept)
            at.residuals[j] = rate_of_row(loops, j, drives, work, kept, at.speeds)
        solve(kept.L, kept.inverses, kept.order, rank, kept.scale, at.residuals, kept.column, at.multipliers)
        _combine(kept, at.multipliers, at.step)
        for i in range(count):
            at.speeds[i] -= at.step[i]
    copy(at.place, q)
    copy(at.speeds, u)
    return CLOSED, weakest


# Of a prepared call of `close_state`: its number, and what is returned
SHARE_IN_METRIC, ENDED_AS = range(2)


@entry(Variant(has_flexible=True))
def close_state(
    share_stiffness: float,
    tables: Tables,
    flexible: FlexibleTables,
    loops: Loops,
    drives: RealRows,
    y: Reals,
    memory: Reals,
) -> tuple[int, float]:
    """Close the loops of a state ``(q, u, z, ...)``; return how it ended and the weakest pivot: see `close`.

    `memory` has as many numbers as `closing_memory_size` tells.
    """
    n, m, k = tables.sizes[COORDINATES], tables.sizes[SPEEDS], tables.sizes[STATES]
    modes, borders = flexible.sizes[MODAL_SIZE], flexible.sizes[BORDER_SIZE]
    rows = WORK * len(tables.rows)
    return close(
        tables,
        flexible,
        loops,
        drives,
        share_stiffness,
        y[:n],
        y[n : n + m],
        y[n + m : n + m + k],
        memory[:rows].reshape(-1, WORK),
        memory[rows : rows + modes],
        memory[rows + modes : rows + modes + borders],
        memory[rows + modes + borders :],
    )


def closing_memory_size(tables: Tables, flexible: FlexibleTables, loops: Loops) -> int:
    """Return how many numbers the memory of `close_state` has."""
    size = WORK * len(tables.rows) + int(flexible.sizes[MODAL_SIZE] + flexible.sizes[BORDER_SIZE])
    speeds = int(tables.sizes[SPEEDS] + tables.sizes[DRIVES])
    return size + close_size(loops, speeds, int(tables.sizes[COORDINATES]))


@kernel
def _unit_responses(
    loops: Loops,
    tables: Tables,
    flexible: FlexibleTables,
    drives: np.ndarray,
    share_stiffness: float,
    u: np.ndarray,
    z: np.ndarray,
    work: np.ndarray,
    modal: np.ndarray,
    border: np.ndarray,
    at: Closing,
    kept: UnitResponses,
) -> bool:
    """Write the rows and their unit responses after an outward sweep; return whether everything has inertia."""
    count, is_implicit, none = len(u), share_stiffness > 0.0, at.step
    for j in range(len(loops.rows)):
        if holds(loops, j, z):
            write_row(loops, j, tables.gravity, drives, z, count, work, kept)
    set_inertia(tables, flexible, work, modal)
    at.applied[:] = 0.0
    if is_implicit:
        none[:] = 0.0
        stiffen_joints(tables, 0.0, share_stiffness, none, none, at.place, u, at.applied, at.added)
        stiffen_modes(flexible, 0.0, share_stiffness, none, none, modal)
    if not sweep_inward(tables, flexible, at.applied, work, modal, border, is_implicit, at.added):
        return False
    respond_to_rows(loops, tables, flexible, z, at.applied, work, modal, border, is_implicit, False, count, kept)
    return True


@kernel
def _factor_places(loops: Loops, worst: float, at: Closing, kept: UnitResponses) -> tuple[int, Any]:
    """Factor the rows that hold places, with openings of `worst` at most; return rank and weakest pivot."""
    for j in range(len(loops.rows)):
        at.scale[j] = kept.scale[j] if loops.rows[j, HOLDS_PLACE] else 0.0
    # rows that depend on each other where the loops are closed seem not to, by the square of how far they are open
    tolerance = max(loops.limits[RANK_TOLERANCE], min(UNKNOWN * worst * worst, LARGEST_UNKNOWN))
    return factor(kept.A, at.scale, tolerance, kept.L, kept.inverses, kept.order, kept.column)


@kernel
def _combine(kept: UnitResponses, multipliers: np.ndarray, step: np.ndarray) -> None:
    """Write what all multipliers cause together."""
    step[:] = 0.0
    for j in range(len(multipliers)):
        if multipliers[j] != 0.0:
            for i in range(len(step)):
                step[i] += multipliers[j] * kept.unit_responses[j, i]
