"""Closing of loops in order n: the nearest coordinates at which they are closed, and speeds that keep them so.

The nearest in the metric of the inertias that the sweeps eliminate. Newton's step is ``-M^-1 J^T lambda`` with
``J M^-1 J^T lambda = g``: the system that also holds the accelerations. What is eliminated is kept while the loops
close fast, so that what a step of an integrator leaves open costs one elimination and a few sweeps.
`kanefe.kane.loop_closure` is the same in dense matrices.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kanefe.kernels.algebra.vectors import copy
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.compiler.arrays import RealRows, Reals
from kanefe.kernels.compiler.entries import entry
from kanefe.kernels.constraints.holding import Held
from kanefe.kernels.constraints.loop_factors import LoopFactors, factors_size, loop_factors_in
from kanefe.kernels.constraints.loop_tables import HOLDS_PLACE, RowWrenches, holds, wrenches_in, wrenches_size
from kanefe.kernels.constraints.openings import openings, rate_of_row, size_of_rate
from kanefe.kernels.constraints.row_wrenches import clear_all_forces, write_rows
from kanefe.kernels.constraints.tolerances import LARGEST_ITERATIONS, LARGEST_OPENING, MOST_HALVINGS, TOLERANCE
from kanefe.kernels.constraints.tree_sweeps import (
    sweep_accelerations,
    sweep_forces_inward,
    sweep_inward,
)
from kanefe.kernels.layout import BORDER_SIZE, COORDINATES, DRIVES, MODAL_SIZE, SPEEDS, STATES, WORK, work_size
from kanefe.kernels.sweeps.advance import advance
from kanefe.kernels.sweeps.implicit import stiffen_joints, stiffen_modes
from kanefe.kernels.sweeps.inertia import set_inertia
from kanefe.kernels.sweeps.outward import sweep_outward
from kanefe.kernels.sweeps.unit_mass import scale_beams
from kanefe.kernels.tables import FlexibleTables, Loops, Tables

CLOSED, LEFT_OPEN, WITHOUT_INERTIA = range(3)
"""Return values of `close`. The literal route may be able to close open loops, and names those that cannot be closed;
the same holds for a tree in which something has no inertia of its own."""

SLOW = 0.1
"""Fraction of the gaps left by a step above which the inertias are eliminated again."""

ROUND_OFF = 4.0 * float(np.finfo(float).eps)
"""Gap, relative to the scene's length or in rad, that no step closes further."""

UNKNOWN, LARGEST_UNKNOWN = 100.0, 1e-6
"""Pivot below which a row may in fact depend on others, in multiples of the square of the largest gap, and its largest
value."""

NEAR, FAR = 1e-10, 1e-6
"""Gap at the start, relative to the weakest pivot: up to the first value speeds are accurate to round-off after one
solution with the inertias of the start, up to the second after two; beyond, they are eliminated again."""


class Closing(NamedTuple):
    """Workspace of `close`.

    Attributes
    ----------
    applied, added : ndarray, shape (free + driven,)
    residuals, trial_residuals, multipliers : ndarray, shape (m,)
    step, speeds : ndarray, shape (free,)
    place, trial : ndarray, shape (coordinates,)
        Coordinates reached, and those tried.
    exerted : RowWrenches
        At these, while those of the factors are kept.
    work, modal : ndarray
        Of outward sweeps there.
    """

    applied: np.ndarray
    added: np.ndarray
    residuals: np.ndarray
    trial_residuals: np.ndarray
    multipliers: np.ndarray
    step: np.ndarray
    speeds: np.ndarray
    place: np.ndarray
    trial: np.ndarray
    exerted: RowWrenches
    work: np.ndarray
    modal: np.ndarray


@kernel
def close_size(tables: Tables, flexible: FlexibleTables, loops: Loops) -> int:
    """Return how many numbers the workspace of `close` has."""
    m, n = len(loops.rows), tables.sizes[SPEEDS] + tables.sizes[DRIVES]
    size = factors_size(loops) + 2 * n + 3 * m + 2 * (tables.sizes[SPEEDS] + tables.sizes[COORDINATES])
    return size + wrenches_size(loops) + work_size(tables) + flexible.sizes[MODAL_SIZE]


@inlined
def _closing_in(workspace: np.ndarray, tables: Tables, loops: Loops, n: int) -> Closing:
    m, count, coordinates = len(loops.rows), tables.sizes[SPEEDS], tables.sizes[COORDINATES]
    rows, rest = workspace[2 * n : 2 * n + 3 * m], workspace[2 * n + 3 * m :]
    places, exerted = rest[2 * count : 2 * (count + coordinates)], rest[2 * (count + coordinates) :]
    work = exerted[wrenches_size(loops) :]
    size = work_size(tables)
    return Closing(
        workspace[:n],
        workspace[n : 2 * n],
        rows[:m],
        rows[m : 2 * m],
        rows[2 * m :],
        rest[:count],
        rest[count : 2 * count],
        places[:coordinates],
        places[coordinates:],
        wrenches_in(exerted, loops),
        work[:size].reshape(-1, WORK),
        work[size:],
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
    kept = loop_factors_in(workspace, loops)
    at = _closing_in(workspace[factors_size(loops) :], tables, loops, n)
    copy(q, at.place)
    sweep_outward(tables, flexible, drives, at.place, u, work, modal)
    worst, total = openings(loops, tables, drives, at.place, z, work, kept.exerted.met, at.residuals)
    start, weakest = worst, 1.0
    # whether there are factors, and those of the place; whether `work` and `at.work` have no more than a sweep there
    is_factored = is_here = False
    is_swept, is_tried = True, False
    for _ in range(LARGEST_ITERATIONS):
        if worst <= ROUND_OFF:
            break
        if not is_factored:
            if not is_swept:
                sweep_outward(tables, flexible, drives, at.place, u, work, modal)
            # rows that depend on each other in closed loops seem not to, by the square of how far these are open
            tolerance = min(UNKNOWN * worst * worst, LARGEST_UNKNOWN)
            weakest = _eliminate(
                loops, tables, flexible, drives, share_stiffness, u, z, True, tolerance, work, modal, border, at, kept
            )
            if weakest == 0.0:
                return WITHOUT_INERTIA, 0.0
            is_factored, is_here, is_swept = True, True, False
        _move(loops, tables, flexible, share_stiffness, z, work, modal, border, at, kept)
        shrink = 1.0
        for i in range(count):
            shrink = max(shrink, abs(at.step[i]) / loops.moves[i])
        share = -1.0 / shrink
        # what is closed but for round-off gets better by a whole step or not at all
        tries = MOST_HALVINGS if is_here and worst > TOLERANCE else 1
        is_better, is_tried = False, False
        for _half in range(tries):
            advance(tables, flexible, at.place, at.step, share, at.trial)
            sweep_outward(tables, flexible, drives, at.trial, u, at.work, at.modal)
            opening, square = openings(loops, tables, drives, at.trial, z, at.work, at.exerted.met, at.trial_residuals)
            if square < total:
                is_better = True
                break
            share *= 0.5
        if is_better:
            is_factored = opening <= TOLERANCE or square <= SLOW * SLOW * total
            worst, total, is_here, is_tried = opening, square, False, True
            copy(at.trial, at.place)
            copy(at.trial_residuals, at.residuals)
        elif is_here or worst <= TOLERANCE:
            break
        else:
            is_factored = False
    if not worst <= LARGEST_OPENING:
        return LEFT_OPEN, weakest
    if is_swept and not is_tried and _has_closed_speeds(loops, tables, drives, u, z, work, at):
        return CLOSED, weakest
    holds_speeds = loops.rows[:, HOLDS_PLACE].sum() < m
    if not is_factored or holds_speeds or (start > FAR * weakest and not is_here):
        if not is_swept:
            sweep_outward(tables, flexible, drives, at.place, u, work, modal)
        weakest = _eliminate(
            loops, tables, flexible, drives, share_stiffness, u, z, False, 0.0, work, modal, border, at, kept
        )
        if weakest == 0.0:
            return WITHOUT_INERTIA, 0.0
        is_here = True
    copy(u, at.speeds)
    for again in range(1 if is_here or start <= NEAR * weakest else 2):
        if again > 0 or not is_tried:
            sweep_outward(tables, flexible, drives, at.place, at.speeds, at.work, at.modal)
        write_rows(loops, tables.gravity, drives, z, count, at.work, at.exerted)
        for j in range(m):
            at.residuals[j] = 0.0
            if holds(loops, j, z):
                at.residuals[j] = rate_of_row(loops, j, drives, at.work, at.exerted, at.speeds)
        _move(loops, tables, flexible, share_stiffness, z, work, modal, border, at, kept)
        for i in range(count):
            at.speeds[i] -= at.step[i]
    copy(at.place, q)
    copy(at.speeds, u)
    return CLOSED, weakest


@inlined
def _has_closed_speeds(
    loops: Loops, tables: Tables, drives: np.ndarray, u: np.ndarray, z: np.ndarray, work: np.ndarray, at: Closing
) -> bool:
    """Return whether what the speeds open, after a sweep with them, is round-off."""
    write_rows(loops, tables.gravity, drives, z, len(u), work, at.exerted)
    found = True
    for j in range(len(loops.rows)):
        if found and holds(loops, j, z):
            rate = abs(rate_of_row(loops, j, drives, work, at.exerted, u))
            found = rate <= ROUND_OFF * size_of_rate(loops, j, work, at.exerted)
    return found


# Of a prepared call of `close_state`: its number, and what is returned
SHARE_IN_METRIC, ENDED_AS = range(2)


@entry()
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
    rows = work_size(tables)
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
    size = work_size(tables) + int(flexible.sizes[MODAL_SIZE] + flexible.sizes[BORDER_SIZE])
    return size + int(close_size(tables, flexible, loops))


@kernel
def _eliminate(
    loops: Loops,
    tables: Tables,
    flexible: FlexibleTables,
    drives: np.ndarray,
    share_stiffness: float,
    u: np.ndarray,
    z: np.ndarray,
    places_only: bool,
    tolerance: float,
    work: np.ndarray,
    modal: np.ndarray,
    border: np.ndarray,
    at: Closing,
    kept: LoopFactors,
) -> float:
    """Eliminate tree and loops after an outward sweep; return the weakest pivot, 0 where something has no inertia."""
    is_implicit, none = share_stiffness > 0.0, at.step
    write_rows(loops, tables.gravity, drives, z, len(u), work, kept.exerted)
    kept.rest[:] = 0.0
    set_inertia(tables, flexible, work, modal)
    at.applied[:] = 0.0
    if is_implicit:
        none[:] = 0.0
        stiffen_joints(tables, 0.0, share_stiffness, none, none, at.place, u, at.applied, at.added)
        stiffen_modes(flexible, 0.0, share_stiffness, none, none, modal)
    scale_beams(flexible, modal)
    held = Held(loops, kept, at.multipliers, z, places_only, tolerance)
    is_regular, weakest = sweep_inward(tables, flexible, at.applied, work, modal, border, is_implicit, at.added, held)
    return weakest if is_regular else 0.0


@kernel
def _move(
    loops: Loops,
    tables: Tables,
    flexible: FlexibleTables,
    share_stiffness: float,
    z: np.ndarray,
    work: np.ndarray,
    modal: np.ndarray,
    border: np.ndarray,
    at: Closing,
    kept: LoopFactors,
) -> None:
    """Write the nearest step that moves the rows by the residuals."""
    is_implicit = share_stiffness > 0.0
    copy(at.residuals, kept.rest)
    clear_all_forces(tables, flexible, at.applied, work, modal)
    held = Held(loops, kept, at.multipliers, z, False, 0.0)
    sweep_forces_inward(tables, flexible, at.applied, work, modal, border, is_implicit, held)
    sweep_accelerations(tables, flexible, at.applied, work, modal, border, is_implicit, held, at.step)
