"""Multipliers of loop joints and couplers: those of the tree's accelerations, and what they cause in one more sweep.

With du_0 of the tree alone, ``A lambda = -(J du_0 + remainder)``; ``du = du_0 + M^-1 J^T lambda``. Rows that depend on
others drop out.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels.algebra.envelope import solve_envelope
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.constraints.loop_system import (
    LoopFactors,
    factor_loops,
    factors_size,
    loop_factors_in,
    put_loop_system,
)
from kanefe.kernels.constraints.loop_tables import Loops, holds, unit_responses_in, unit_responses_size
from kanefe.kernels.constraints.row_wrenches import along_row, clear_all_forces, push_row, write_row
from kanefe.kernels.layout import FlexibleTables, Tables
from kanefe.kernels.sweeps.accelerations import put_driving_forces, sweep_accelerations
from kanefe.kernels.sweeps.inward import sweep_forces_inward


@kernel
def hold_loops(
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
    """Add to du and driving forces of the tree what loops need; return the weakest pivot that counts.

    Forces and accelerations of the rows of the scene are those of the multipliers alone then.

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
    count = len(du)
    kept = loop_factors_in(workspace, loops, len(applied))
    for j in range(len(loops.rows)):
        kept.rest[j] = 0.0
        if holds(loops, j, z):
            remainder = write_row(loops, j, tables.gravity, drives, z, count, work, kept.exerted)
            kept.rest[j] = -remainder - along_row(loops, j, work, kept.exerted.wrenches, du)
    put_loop_system(loops, tables, flexible, z, work, modal, border, is_implicit, kept)
    weakest = factor_loops(loops, kept.scale, 0.0, kept)
    solve_loops(loops, kept.scale, kept.rest, kept, multipliers)
    respond(loops, tables, flexible, multipliers, applied, work, modal, border, is_implicit, kept, count)
    for i in range(count):
        du[i] += kept.response[i]
    if len(driving) > 0:
        put_driving_forces(tables, applied, work, kept.response[count:])
        for i in range(len(driving)):
            driving[i] += kept.response[count + i]
    return weakest


@kernel
def solve_loops(
    loops: Loops, scale: np.ndarray, right: np.ndarray, kept: LoopFactors, multipliers: np.ndarray
) -> None:
    """Write ``A^-1 right`` of the rows that were factored with these scales; those of others are zero."""
    paths = loops.paths
    solve_envelope(kept.L, paths.ends, paths.order, kept.inverses, scale, right, kept.column, multipliers)


@kernel
def respond(
    loops: Loops,
    tables: Tables,
    flexible: FlexibleTables | None,
    multipliers: np.ndarray,
    applied: np.ndarray,
    work: np.ndarray,
    modal: np.ndarray,
    border: np.ndarray,
    is_implicit: bool,
    kept: LoopFactors,
    count: int,
) -> None:
    """Write what all multipliers cause together to ``kept.response``."""
    clear_all_forces(tables, flexible, applied, work, modal)
    for j in range(len(loops.rows)):
        if multipliers[j] != 0.0:
            push_row(loops, tables, flexible, j, multipliers[j], False, kept.exerted, applied, work, modal)
    sweep_forces_inward(tables, flexible, applied, work, modal, border, is_implicit)
    sweep_accelerations(tables, flexible, applied, work, modal, border, is_implicit, kept.response[:count])


@kernel
def hold_size(loops: Loops, n: int) -> int:
    """Return how many numbers the workspace of `hold_loops`, or of `hold` where there are rigid contacts, has."""
    return unit_responses_size(loops, n) if len(loops.points.places) > 0 else factors_size(loops, n)


@inlined
def scale_of_rows(workspace: np.ndarray, loops: Loops, n: int) -> np.ndarray:
    """Return the scales of rows in a workspace of `hold_size`."""
    if len(loops.points.places) > 0:
        return unit_responses_in(workspace, loops, n).scale
    return loop_factors_in(workspace, loops, n).scale
