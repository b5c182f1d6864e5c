"""Multipliers of scenes with rigid contacts, from sweeps that give the unit responses of the rows.

With du_0 of the tree alone and x_j its answer to row j, ``A lambda = -(J du_0 + remainder)`` and
``du = du_0 + sum lambda_j x_j``, where ``A_ij = J_i x_j``. A row that rubs acts along another direction than it holds,
and points in contact share forces that are not determined: all of A counts. A sweep of forces alone costs less than
half of an evaluation, so that m rows cost some m/2 evaluations and a system of m unknowns. Rows that depend on others
drop out. Scenes without rigid contacts do with less: `kanefe.kernels.constraints.holding`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels.algebra.pivoted import factor, solve
from kanefe.kernels.algebra.vectors import vector
from kanefe.kernels.compiler._numba import kernel
from kanefe.kernels.constraints.constraint_jacobian import row_scale, walk_inward
from kanefe.kernels.constraints.constraint_rows import COUPLER_ROW
from kanefe.kernels.constraints.least_forces import share_forces
from kanefe.kernels.constraints.loop_tables import (
    FIRST_TERM,
    KIND_OF,
    LEAST_SHARE,
    LIVE,
    RANK_TOLERANCE,
    ROW_A,
    TERM_COUNT,
    UnitResponses,
    has_loops,
    holds,
    is_rubbing,
    unit_responses_in,
)
from kanefe.kernels.constraints.row_wrenches import along_row, clear_all_forces, push_row, write_rows
from kanefe.kernels.constraints.tree_sweeps import sweep_accelerations, sweep_forces_inward
from kanefe.kernels.scene import Scene, State, Work
from kanefe.kernels.sweeps.driving_forces import put_driving_forces


@kernel
def hold(scene: Scene, state: State, work: Work, is_implicit: bool, du: np.ndarray) -> Any:
    """Add to du and driving forces of the tree what the constraints need; return the weakest pivot that counts.

    Parameters
    ----------
    work : Work
        `multipliers` of each row on return; what is `applied` is lost.
    is_implicit : bool
        Whether the inertias are those of a linearly implicit sweep.
    """
    loops, z, multipliers, driving, rows = scene.loops, state.z, work.multipliers, work.driving, work.frames.numbers
    m, count = len(loops.rows), len(du)
    kept = unit_responses_in(work.holding, loops, len(work.applied))
    is_skew = False
    write_rows(loops, scene.tables.gravity, state.drives, z, count, rows, kept.exerted)
    for j in range(m):
        if holds(loops, j, z):
            kept.rest[j] = -kept.exerted.remainders[j] - along_row(loops, j, rows, kept.exerted.wrenches, du)
            is_skew = is_skew or is_rubbing(loops, j, z)
    respond_to_rows(scene, work, z, is_implicit, True, kept)
    if is_skew:
        weakest = share_forces(loops, z, True, multipliers, kept)
    else:
        rank, weakest = factor(
            kept.A, kept.scale, loops.limits[RANK_TOLERANCE], kept.L, kept.inverses, kept.order, kept.column
        )
        solve(kept.L, kept.inverses, kept.order, rank, kept.scale, kept.rest, kept.column, multipliers)
        kept.told[LIVE] = -1
        if not has_loops(loops, kept):
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
    scene: Scene, work: Work, z: np.ndarray, is_implicit: bool, rubs: bool, kept: UnitResponses
) -> None:
    """Write what the unit multiplier of each row causes, and A; the rows are written and the inertias eliminated.

    A row that does not hold is left out: its scale is zero.

    Parameters
    ----------
    z : ndarray, shape (states,)
    rubs : bool
        Whether what slips is rubbed by the multiplier of its normal row.
    """
    loops, rows = scene.loops, work.frames.numbers
    m, driven, reach, is_skew = len(loops.rows), len(work.driving), kept.reach, False
    count = len(work.applied) - driven
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
                force, moment = vector(kept.exerted.wrenches, j, 6 * end), vector(kept.exerted.wrenches, j, 6 * end + 3)
                walk_inward(scene, work, loops.rows[j, ROW_A + end], force, moment, J, reach)
        share = row_scale(J, reach, loops.extents, rows)
        # its pivot would be below all that count, and its sweeps would be for nothing
        kept.scale[j] = share if share.real > LEAST_SHARE else 0.0 * share
    for j in range(m):
        if kept.scale[j] == 0.0:
            continue
        response = kept.unit_responses[j, :count]  # the driven entries keep the answer of the driving forces
        is_rubbed = rubs and is_rubbing(loops, j, z)
        if is_rubbed:
            clear_all_forces(scene, work)
            push_row(scene, work, j, 1.0, False, kept.exerted)
            sweep_forces_inward(scene, work, is_implicit, None)
            sweep_accelerations(scene, work, is_implicit, None, response)
            kept.plain[j] = along_row(loops, j, rows, kept.exerted.wrenches, response)
        clear_all_forces(scene, work)
        push_row(scene, work, j, 1.0, is_rubbed, kept.exerted)
        sweep_forces_inward(scene, work, is_implicit, None)
        sweep_accelerations(scene, work, is_implicit, None, response)
        if driven > 0:
            put_driving_forces(scene, work, kept.unit_responses[j, count:])
        for i in range(0 if is_skew else j, m):
            if kept.scale[i] != 0.0:
                kept.A[i, j] = along_row(loops, i, rows, kept.exerted.wrenches, response)
        if not is_rubbed:
            kept.plain[j] = kept.A[j, j]
    for j in range(m):
        # a row of unit length if it pointed along the motion of its ends
        if kept.scale[j] != 0.0:
            size = kept.plain[j].real
            kept.scale[j] = np.sqrt(kept.scale[j] / size) if size > 0.0 else 0.0 * kept.scale[j]


@kernel
def respond_to_multipliers(scene: Scene, work: Work, is_implicit: bool, count: int) -> None:
    """Sweep what all multipliers cause together, after `hold`: forces and accelerations of rows are theirs alone then.

    `count` is of free speeds. What is `applied` is lost.
    """
    kept = unit_responses_in(work.holding, scene.loops, len(work.applied))
    clear_all_forces(scene, work)
    for j in range(len(scene.loops.rows)):
        if work.multipliers[j] != 0.0:
            push_row(scene, work, j, work.multipliers[j], True, kept.exerted)
    sweep_forces_inward(scene, work, is_implicit, None)
    sweep_accelerations(scene, work, is_implicit, None, kept.reach[:count])
