"""Multipliers of scenes with rigid contacts, from sweeps that give the unit responses of the rows.

With du_0 of the tree alone and x_j its answer to row j, ``A lambda = -(J du_0 + remainder)`` and
``du = du_0 + sum lambda_j x_j``, where ``A_ij = J_i x_j``. A row that rubs acts along another direction than it holds,
and points in contact share forces that are not determined: all of A counts. A sweep of forces alone costs less than
half of an evaluation, so that m rows cost some m/2 evaluations and a system of m unknowns. Rows that depend on others
drop out. Scenes without rigid contacts do with less: `kanefe.kernels.constraints.holding`.
"""

from typing import Any

import numpy as np

from kanefe.kernels.algebra.pivoted import factor, pivots_of, solve
from kanefe.kernels.constraints.constraint_jacobian import row_scale, walk_inward
from kanefe.kernels.constraints.constraint_rows import RowKind
from kanefe.kernels.constraints.least_forces import share_forces
from kanefe.kernels.constraints.loop_tables import (
    LEAST_SHARE,
    Limits,
    RowWork,
    UnitResponses,
    has_loops,
    holds,
    rows_of,
    rubs_at,
    terms_of,
    unit_responses_in,
)
from kanefe.kernels.constraints.row_wrenches import along_row, clear_all_forces, push_row, wrench_on, write_rows
from kanefe.kernels.constraints.tree_sweeps import sweep_accelerations, sweep_forces_inward
from kanefe.kernels.language import kernel
from kanefe.kernels.scene import Scene, State, Work, links_of
from kanefe.kernels.sweeps.driving_forces import put_driving_forces


@kernel
def hold(scene: Scene, state: State, work: Work, is_implicit: bool, du: np.ndarray) -> Any:
    """Add to du and driving forces of the tree what the constraints need; return the weakest pivot that counts.

    Writes their multipliers. What is applied along joints is lost.
    """
    loops, rows = scene.loops, rows_of(scene.loops)
    multipliers, kept = work.multipliers, unit_responses_in(work.holding, loops)
    exerted, driving, count, is_skew = RowWork(kept), work.driving, len(du), False
    write_rows(scene, state, work, exerted)
    for j in range(len(rows)):
        if holds(rows[j], state.z):
            kept.rest[j] = -exerted.actions[j].remainder - along_row(scene, work, exerted, j, du)
            is_skew = is_skew or rubs_at(loops, rows[j], state.z)
    respond_to_rows(scene, state.z, work, kept, is_implicit)
    if is_skew:
        weakest = share_forces(loops, state.z, True, multipliers, kept)
    else:
        tolerance = Limits(loops.limits).rank_tolerance
        rank, weakest = factor(kept.A, kept.scale, tolerance, pivots_of(kept))
        solve(pivots_of(kept), rank, kept.scale, kept.rest, multipliers)
        kept.live_count = -1.0
        if not has_loops(loops, kept):
            weakest = 0.0 * weakest + 1.0
    responses = kept.unit_responses
    for j in range(len(rows)):
        if multipliers[j] != 0.0:
            for i in range(count):
                du[i] += multipliers[j] * responses[j, i]
            for i in range(len(driving)):
                driving[i] += multipliers[j] * responses[j, count + i]
    return weakest


@kernel
def respond_to_rows(scene: Scene, z: np.ndarray, work: Work, kept: UnitResponses, is_implicit: bool) -> None:
    """Write what the unit multiplier of each row causes, and A; the rows are written and the inertias eliminated.

    A row that does not hold is left out: its scale is zero. What slips is rubbed by the multiplier of its normal row.
    """
    rows, A, scale, plain, is_skew = rows_of(scene.loops), kept.A, kept.scale, kept.plain, False
    for j in range(len(rows)):
        scale[j] = 0.0
        if holds(rows[j], z):
            is_skew = is_skew or rubs_at(scene.loops, rows[j], z)
            _put_row(scene, work, kept, j)
            share = row_scale(kept.J[j], kept.reach, scene.loops.extents)
            # its pivot would be below all that count, and its sweeps would be for nothing
            scale[j] = share if share.real > LEAST_SHARE else 0.0 * share
    for j in range(len(rows)):
        if scale[j] == 0.0:
            continue
        is_rubbed = rubs_at(scene.loops, rows[j], z)
        if is_rubbed:
            plain[j] = _respond(scene, work, kept, j, False, is_implicit)
        own = _respond(scene, work, kept, j, is_rubbed, is_implicit)
        if not is_rubbed:
            plain[j] = own
        response = kept.unit_responses[j, : kept.free]
        for i in range(0 if is_skew else j, len(rows)):
            if scale[i] != 0.0:
                A[i, j] = along_row(scene, work, RowWork(kept), i, response)
    for j in range(len(rows)):
        # a row of unit length if it pointed along the motion of its ends
        if scale[j] != 0.0:
            size = plain[j].real
            scale[j] = np.sqrt(scale[j] / size) if size > 0.0 else 0.0 * scale[j]


@kernel
def _put_row(scene: Scene, work: Work, kept: UnitResponses, j: int) -> None:
    """Write a row of J, and the largest it could be."""
    row, terms, J, reach = rows_of(scene.loops)[j], terms_of(scene.loops), kept.J[j], kept.reach
    J[:] = 0.0
    reach[:] = 0.0
    if row.kind == RowKind.COUPLER:
        for n in range(row.first_term, row.first_term + row.term_count):
            J[terms[n].speed] += terms[n].coefficient
            reach[terms[n].speed] += abs(terms[n].coefficient)
    else:
        for end in range(2):
            i = row.b.row if end == 1 else row.a.row
            walk_inward(scene, work, i, wrench_on(scene, work, RowWork(kept), j, end, False), J, reach)


@kernel
def _respond(scene: Scene, work: Work, kept: UnitResponses, j: int, rubs: bool, is_implicit: bool) -> Any:
    """Write what the unit multiplier of a row causes, and return what that does along the row."""
    exerted, response, drive = RowWork(kept), kept.unit_responses[j, : kept.free], kept.unit_responses[j, kept.free :]
    clear_all_forces(scene, work)
    push_row(scene, work, exerted, j, 1.0, rubs)
    sweep_forces_inward(scene, work, is_implicit, None)
    sweep_accelerations(scene, work, is_implicit, None, response)  # the driven entries keep the driving forces
    if len(drive) > 0:
        put_driving_forces(links_of(scene), work.frames, work.applied, drive)
    return along_row(scene, work, exerted, j, response)


@kernel
def respond_to_multipliers(scene: Scene, work: Work, is_implicit: bool) -> None:
    """Sweep what all multipliers cause together, after `hold`: forces and accelerations are theirs alone then."""
    kept = unit_responses_in(work.holding, scene.loops)
    clear_all_forces(scene, work)
    for j in range(len(work.multipliers)):
        if work.multipliers[j] != 0.0:
            push_row(scene, work, RowWork(kept), j, work.multipliers[j], True)
    sweep_forces_inward(scene, work, is_implicit, None)
    sweep_accelerations(scene, work, is_implicit, None, kept.reach[: kept.free])
