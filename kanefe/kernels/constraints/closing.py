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
from kanefe.kernels.constraints.loop_factors import factors_size, loop_factors_in
from kanefe.kernels.constraints.loop_tables import HOLDS_PLACE, RowWrenches, holds, wrenches_in, wrenches_size
from kanefe.kernels.constraints.openings import openings, rate_of_row, size_of_rate
from kanefe.kernels.constraints.row_wrenches import clear_all_forces, write_rows
from kanefe.kernels.constraints.tolerances import LARGEST_ITERATIONS, LARGEST_OPENING, MOST_HALVINGS, TOLERANCE
from kanefe.kernels.constraints.tree_sweeps import (
    sweep_accelerations,
    sweep_forces_inward,
    sweep_inward,
)
from kanefe.kernels.layout import COORDINATES, SPEEDS
from kanefe.kernels.scene import Scene, State, Work, memory_size, state_in, work_in
from kanefe.kernels.sweeps.advance import advance
from kanefe.kernels.sweeps.implicit import Pushes, stiffen_joints, stiffen_modes
from kanefe.kernels.sweeps.inertia import set_inertia
from kanefe.kernels.sweeps.outward import sweep_outward
from kanefe.kernels.sweeps.unit_mass import scale_beams
from kanefe.kernels.tables import Loops, Tables

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
    residuals, trial_residuals : ndarray, shape (m,)
    step, speeds : ndarray, shape (free,)
    place, trial : ndarray, shape (coordinates,)
        Coordinates reached, and those tried.
    exerted : RowWrenches
        At these, while those of the factors are kept.
    """

    residuals: np.ndarray
    trial_residuals: np.ndarray
    step: np.ndarray
    speeds: np.ndarray
    place: np.ndarray
    trial: np.ndarray
    exerted: RowWrenches


@kernel
def close_size(tables: Tables, loops: Loops) -> int:
    """Return how many numbers the workspace of `close` has."""
    m = len(loops.rows)
    size = factors_size(loops) + 2 * m + 2 * (tables.sizes[SPEEDS] + tables.sizes[COORDINATES])
    return size + wrenches_size(loops)


@inlined
def _closing_in(workspace: np.ndarray, tables: Tables, loops: Loops) -> Closing:
    m, count, coordinates = len(loops.rows), tables.sizes[SPEEDS], tables.sizes[COORDINATES]
    rest = workspace[2 * m :]
    places, exerted = rest[2 * count : 2 * (count + coordinates)], rest[2 * (count + coordinates) :]
    return Closing(
        workspace[:m],
        workspace[m : 2 * m],
        rest[:count],
        rest[count : 2 * count],
        places[:coordinates],
        places[coordinates:],
        wrenches_in(exerted, loops),
    )


@kernel
def close(
    scene: Scene, state: State, share_stiffness: float, work: Work, other: Work, workspace: np.ndarray
) -> tuple[int, float]:
    """Close the loops: change q and then u, both to the nearest; return how it ended and the weakest pivot.

    Parameters
    ----------
    state : State
        q and u are changed in place, unless what is returned is not CLOSED. The switches in z say which rows hold.
    share_stiffness : float
        Of the stiffness of modes and joints in the metric ``M + r K``, s2: stiff modes, which M alone would move, then
        stay where they are.
    work, other : Work
        At the place of the factors, and of outward sweeps elsewhere: what is in them is lost.
    workspace : ndarray, shape (`close_size`,)
    """
    loops, tables, flexible, drives, u, z = (
        scene.loops,
        scene.tables,
        scene.flexible,
        state.drives,
        state.u,
        state.z,
    )
    m, count, rows = len(loops.rows), len(u), work.frames.numbers
    kept = loop_factors_in(workspace, loops)
    at = _closing_in(workspace[factors_size(loops) :], tables, loops)
    copy(state.q, at.place)
    here = State(state.t, at.place, u, z, drives, state.inputs)
    sweep_outward(scene, here, work, False)
    worst, total = openings(loops, tables, drives, at.place, z, rows, kept.exerted.met, at.residuals)
    start, weakest = worst, 1.0
    # whether there are factors, and those of the place; whether both works have no more than a sweep there
    is_factored = is_here = False
    is_swept, is_tried = True, False
    for _ in range(LARGEST_ITERATIONS):
        if worst <= ROUND_OFF:
            break
        if not is_factored:
            if not is_swept:
                sweep_outward(scene, here, work, False)
            # rows that depend on each other in closed loops seem not to, by the square of how far these are open
            tolerance = min(UNKNOWN * worst * worst, LARGEST_UNKNOWN)
            weakest = _eliminate(
                scene, here, share_stiffness, work, Held(loops, kept, work.multipliers, z, True, tolerance), at.step
            )
            if weakest == 0.0:
                return WITHOUT_INERTIA, 0.0
            is_factored, is_here, is_swept = True, True, False
        _move(scene, work, share_stiffness, Held(loops, kept, work.multipliers, z, False, 0.0), at.residuals, at.step)
        shrink = 1.0
        for i in range(count):
            shrink = max(shrink, abs(at.step[i]) / loops.moves[i])
        share = -1.0 / shrink
        # what is closed but for round-off gets better by a whole step or not at all
        tries = MOST_HALVINGS if is_here and worst > TOLERANCE else 1
        is_better, is_tried = False, False
        for _half in range(tries):
            advance(tables, flexible, at.place, at.step, share, at.trial)
            sweep_outward(scene, State(state.t, at.trial, u, z, drives, state.inputs), other, False)
            opening, square = openings(
                loops, tables, drives, at.trial, z, other.frames.numbers, at.exerted.met, at.trial_residuals
            )
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
    if is_swept and not is_tried and _has_closed_speeds(loops, tables, drives, u, z, rows, at):
        return CLOSED, weakest
    holds_speeds = loops.rows[:, HOLDS_PLACE].sum() < m
    if not is_factored or holds_speeds or (start > FAR * weakest and not is_here):
        if not is_swept:
            sweep_outward(scene, here, work, False)
        weakest = _eliminate(
            scene, here, share_stiffness, work, Held(loops, kept, work.multipliers, z, False, 0.0), at.step
        )
        if weakest == 0.0:
            return WITHOUT_INERTIA, 0.0
        is_here = True
    copy(u, at.speeds)
    for again in range(1 if is_here or start <= NEAR * weakest else 2):
        if again > 0 or not is_tried:
            sweep_outward(scene, State(state.t, at.place, at.speeds, z, drives, state.inputs), other, False)
        write_rows(loops, tables.gravity, drives, z, count, other.frames.numbers, at.exerted)
        for j in range(m):
            at.residuals[j] = 0.0
            if holds(loops, j, z):
                at.residuals[j] = rate_of_row(loops, j, drives, other.frames.numbers, at.exerted, at.speeds)
        _move(scene, work, share_stiffness, Held(loops, kept, work.multipliers, z, False, 0.0), at.residuals, at.step)
        for i in range(count):
            at.speeds[i] -= at.step[i]
    copy(at.place, state.q)
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
def close_state(share_stiffness: float, scene: Scene, drives: RealRows, y: Reals, memory: Reals) -> tuple[int, float]:
    """Close the loops of a state ``(q, u, z, ...)``; return how it ended and the weakest pivot: see `close`.

    `memory` has as many numbers as `closing_memory_size` tells.
    """
    state, work = state_in(scene.tables, 0.0, y, drives, memory), work_in(scene, memory)
    other = work_in(scene, memory[work.size :])
    return close(scene, state, share_stiffness, work, other, memory[2 * work.size :])


def closing_memory_size(scene: Scene) -> int:
    """Return how many numbers the memory of `close_state` has."""
    return 2 * memory_size(scene) + int(close_size(scene.tables, scene.loops))


@kernel
def _eliminate(scene: Scene, state: State, share_stiffness: float, work: Work, held: Held, none: np.ndarray) -> float:
    """Eliminate tree and loops after an outward sweep; return the weakest pivot, 0 where something has no inertia."""
    is_implicit, kept = share_stiffness > 0.0, held.kept
    write_rows(
        scene.loops, scene.tables.gravity, state.drives, state.z, len(state.u), work.frames.numbers, kept.exerted
    )
    kept.rest[:] = 0.0
    set_inertia(scene, work)
    work.applied[:] = 0.0
    if is_implicit:
        none[:] = 0.0
        pushes = Pushes(0.0, share_stiffness, none, none)
        stiffen_joints(scene.tables, state, pushes, work.applied, work.added)
        stiffen_modes(scene, work, pushes)
    scale_beams(scene, work)
    is_regular, weakest = sweep_inward(scene, work, is_implicit, held)
    return weakest if is_regular else 0.0


@kernel
def _move(
    scene: Scene, work: Work, share_stiffness: float, held: Held, residuals: np.ndarray, step: np.ndarray
) -> None:
    """Write the nearest step that moves the rows by the residuals."""
    copy(residuals, held.kept.rest)
    clear_all_forces(scene, work)
    sweep_forces_inward(scene, work, share_stiffness > 0.0, held)
    sweep_accelerations(scene, work, share_stiffness > 0.0, held, step)
