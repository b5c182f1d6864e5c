"""The sweeps of a tree whose loops are held: they are eliminated where the links between their ends meet.

At that link, with V the share of du in its acceleration, its loops need multipliers

    lambda = A^-1 (rest - b + K^T V),

b the accelerations of the rows with the link at rest, and K what it feels of unit multipliers: they add ``K A^-1 K^T``
to its articulated inertia and ``K A^-1 (rest - b)`` to the force that it needs. Inward, a loop is complete where its
ends meet; outward, its multipliers are known as the sweep leaves that link. Loops in a row, or one upon the other, then
cost as many numbers as there are loops. (Vereshchagin 1974 for loops through N; Chignoli et al. 2022 for the idea of
elimination where a loop closes.)
"""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels.algebra.envelope import factor_envelope, solve_envelope
from kanefe.kernels.algebra.vectors import (
    accumulate,
    dot,
    matrix,
    minus,
    rotated,
    rotated_back,
    three,
    times,
    vector,
)
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.constraints.constraint_rows import COUPLER_ROW
from kanefe.kernels.constraints.loop_factors import TURN, LoopFactors, factors_size, loop_factors_in
from kanefe.kernels.constraints.loop_system import put_loop_system
from kanefe.kernels.constraints.loop_tables import (
    FIRST_TERM,
    KIND_OF,
    RANK_TOLERANCE,
    TERM_COUNT,
    Loops,
    unit_responses_in,
    unit_responses_size,
)
from kanefe.kernels.constraints.row_paths import OF_JOINT, OF_MODES, VISITED
from kanefe.kernels.layout import (
    ACCELERATION,
    ALPHA,
    CARRIED,
    CARRIED_COUNT,
    COUNT,
    DRIVING,
    FLEXIBLE,
    FORCE,
    FREE,
    INTERFACE,
    KIND,
    MOMENT,
    PIVOT,
    ROW,
    SPEED,
    SPHERICAL,
    WORK_FORCE,
    FlexibleTables,
    H,
    J,
    M,
    R,
    Tables,
)
from kanefe.kernels.sweeps.accelerations import accelerate_link
from kanefe.kernels.sweeps.border import border_in
from kanefe.kernels.sweeps.elastic import span, total
from kanefe.kernels.sweeps.inward import eliminate_joint, hand_through_joint
from kanefe.kernels.sweeps.link_motion import fixed_axes
from kanefe.kernels.sweeps.modal_elimination import eliminate_modal_forces, eliminate_modes, modal_accelerations


@kernel
def sweep_inward_held(
    loops: Loops,
    tables: Tables,
    flexible: FlexibleTables,
    z: np.ndarray,
    applied: np.ndarray,
    work: np.ndarray,
    modal: np.ndarray,
    border: np.ndarray,
    is_implicit: bool,
    added: np.ndarray,
    places_only: bool,
    tolerance: float,
    kept: LoopFactors,
    multipliers: np.ndarray,
) -> tuple[bool, Any]:
    """Eliminate all rows of the scene, and of loops where they close.

    Parameters
    ----------
    z : ndarray, shape (states,)
        Internal states, of which the switches say which rows hold.
    applied, is_implicit, added
        See `kanefe.kernels.sweeps.inward.sweep_inward`.
    places_only : bool
        Whether rows that hold speeds alone are left out.
    tolerance : float
        Pivot, of a row of unit length, below which it depends on others; that of the scene at least.
    kept : LoopFactors
        With what rows exert, and the acceleration that each needs.
    multipliers : ndarray, shape (m,)
        On return: with the link that carries the loop at rest.

    Returns
    -------
    is_regular : bool
        Whether every joint has inertia along it.
    weakest : float
        The least pivot that counts, of the largest.
    """
    rows, paths, is_regular, weakest, largest = tables.rows, loops.paths, True, np.inf, 0.0
    tolerance = max(tolerance, loops.limits[RANK_TOLERANCE])
    for i in range(len(rows) - 1, -2, -1):
        is_link = i >= 0 and rows[i, KIND] != INTERFACE
        if is_link and rows[i, FLEXIBLE] >= 0:
            eliminate_modes(rows, flexible, rows[i, FLEXIBLE], work, modal, border, is_implicit)
        begin, end = paths.places[i + 1], paths.places[i + 2]
        if end > begin:
            put_loop_system(loops, tables, flexible, i, z, places_only, work, modal, border, is_implicit, kept)
            least, most = factor_envelope(kept.system, tolerance, begin, end)
            weakest, largest = min(weakest, least), max(largest, most)
            if i >= 0:
                _add_inertia(loops, i, work, kept)
            _hold(loops, tables, flexible, i, applied, work, modal, kept, multipliers)
        if is_link:
            is_regular = eliminate_joint(tables, i, applied, work, is_implicit, added) and is_regular
    return is_regular, min(1.0, weakest / largest) if largest > 0.0 else 1.0


@kernel
def sweep_forces_inward_held(
    loops: Loops,
    tables: Tables,
    flexible: FlexibleTables,
    applied: np.ndarray,
    work: np.ndarray,
    modal: np.ndarray,
    border: np.ndarray,
    is_implicit: bool,
    kept: LoopFactors,
    multipliers: np.ndarray,
) -> None:
    """Hand other forces inward, and other needs of the rows, over what `sweep_inward_held` has left."""
    rows, paths = tables.rows, loops.paths
    for i in range(len(rows) - 1, -2, -1):
        is_link = i >= 0 and rows[i, KIND] != INTERFACE
        if is_link and rows[i, FLEXIBLE] >= 0:
            eliminate_modal_forces(flexible, rows[i, FLEXIBLE], work, modal, border, is_implicit)
        if paths.places[i + 2] > paths.places[i + 1]:
            _hold(loops, tables, flexible, i, applied, work, modal, kept, multipliers)
        if is_link:
            hand_through_joint(tables, i, applied, work)


@kernel
def sweep_accelerations_held(
    loops: Loops,
    tables: Tables,
    flexible: FlexibleTables,
    applied: np.ndarray,
    work: np.ndarray,
    modal: np.ndarray,
    border: np.ndarray,
    is_implicit: bool,
    kept: LoopFactors,
    multipliers: np.ndarray,
    du: np.ndarray,
) -> None:
    """Write du, and the multipliers, after a sweep inward; see `kanefe.kernels.sweeps.accelerations`.

    What links need from their parents counts the multipliers then. `applied` has what couplers exert on drives.
    """
    rows, paths = tables.rows, loops.paths
    for i in range(-1, len(rows)):
        is_link = i >= 0 and rows[i, KIND] != INTERFACE  # the body of an interface has written its acceleration
        if is_link:
            accelerate_link(tables, i, applied, work, du)
        for place in range(paths.places[i + 1], paths.places[i + 2]):
            j = paths.order[place]
            if kept.system.scale[j] == 0.0:
                continue
            if i >= 0:
                multipliers[j] += dot(vector(kept.asked, j, 0), vector(work, i, ACCELERATION))
                multipliers[j] += dot(vector(kept.asked, j, TURN), vector(work, i, ALPHA))
            if multipliers[j] != 0.0:
                _exert(loops, tables, flexible, j, multipliers[j], len(du), applied, work, modal, border, kept)
        if is_link and rows[i, FLEXIBLE] >= 0:
            modal_accelerations(flexible, rows[i, FLEXIBLE], work, modal, border, is_implicit, du)


@inlined
def _add_inertia(loops: Loops, i: int, work: np.ndarray, kept: LoopFactors) -> None:
    """Add what the loops that a link carries make it feel of its own acceleration: K A^-1 K^T."""
    paths = loops.paths
    begin, end = paths.places[i + 1], paths.places[i + 2]
    solve_envelope(kept.system, kept.felt, begin, end, kept.asked)
    for place in range(begin, end):
        j = paths.order[place]
        if kept.system.scale[j] == 0.0:
            continue
        felt, asked = kept.felt[j], kept.asked[j]
        at = 0
        for a in range(3):
            for b in range(a, 3):
                work[i, M + at] += felt[a] * asked[b]
                work[i, J + at] += felt[TURN + a] * asked[TURN + b]
                at += 1
            for b in range(3):
                work[i, H + 3 * a + b] += felt[a] * asked[TURN + b]


@inlined
def _hold(
    loops: Loops,
    tables: Tables,
    flexible: FlexibleTables,
    i: int,
    applied: np.ndarray,
    work: np.ndarray,
    modal: np.ndarray,
    kept: LoopFactors,
    multipliers: np.ndarray,
) -> None:
    """Write the multipliers with a link at rest, and add what it feels of them."""
    paths = loops.paths
    begin, end = paths.places[i + 1], paths.places[i + 2]
    for place in range(begin, end):
        j = paths.order[place]
        kept.right[j, 0] = 0.0
        if kept.system.scale[j] != 0.0:
            kept.right[j, 0] = kept.rest[j] - _acceleration(loops, tables, flexible, j, applied, work, modal, kept)
    solve_envelope(kept.system, kept.right, begin, end, multipliers.reshape(len(multipliers), 1))
    if i < 0:
        return
    for place in range(begin, end):
        j = paths.order[place]
        if multipliers[j] != 0.0:
            accumulate(work, i, FORCE, times(multipliers[j], vector(kept.felt, j, 0)))
            accumulate(work, i, MOMENT, times(multipliers[j], vector(kept.felt, j, TURN)))


@inlined
def _acceleration(
    loops: Loops,
    tables: Tables,
    flexible: FlexibleTables,
    j: int,
    applied: np.ndarray,
    work: np.ndarray,
    modal: np.ndarray,
    kept: LoopFactors,
) -> Any:
    """Return the acceleration along a row by the forces on what it visits: answers of the row, times these."""
    paths, rows, numbers = loops.paths, tables.rows, kept.numbers
    along = 0.0 * work[0, R]
    for s in range(paths.first[j], paths.first[j + 1]):
        i, at, of_modes = paths.visits[s, VISITED], paths.visits[s, OF_JOINT], paths.visits[s, OF_MODES]
        kind, speed = rows[i, KIND], rows[i, SPEED]
        if of_modes >= 0 and kind != INTERFACE:
            along += _modal_acceleration(flexible, rows[i, FLEXIBLE], of_modes, work, modal, numbers)
        if at < 0:
            continue
        if kind == SPHERICAL:
            torque = rotated(matrix(work, i, R), three(applied, speed))
            along += dot(three(numbers, at), minus(vector(work, i, MOMENT), torque))
        elif kind == FREE:
            force = minus(vector(work, i, FORCE), rotated(fixed_axes(tables, i, work), three(applied, speed)))
            moment = minus(vector(work, i, MOMENT), rotated(matrix(work, i, R), three(applied, speed + 3)))
            along -= dot(three(numbers, at), force) + dot(three(numbers, at + TURN), moment)
        else:
            along += numbers[at] * work[i, DRIVING] / work[i, PIVOT]
    return along


@inlined
def _modal_acceleration(
    flexible: FlexibleTables, f: int, at: int, work: np.ndarray, modal: np.ndarray, numbers: np.ndarray
) -> Any:
    """Return the same of the modes of a body and of what it carries."""
    body = flexible.bodies[f]
    k, G = body[COUNT], matrix(work, body[ROW], R)
    along = total(numbers[at + k : at + 2 * k], modal[span(body, WORK_FORCE)])
    moved = at + 2 * k + 6 * body[CARRIED_COUNT]
    for c in range(body[CARRIED_COUNT]):
        i = flexible.carrying[body[CARRIED] + c]
        along -= dot(three(numbers, moved + 6 * c), rotated_back(G, vector(work, i, FORCE)))
        along -= dot(three(numbers, moved + 6 * c + 3), rotated_back(G, vector(work, i, MOMENT)))
    return along


@inlined
def _exert(
    loops: Loops,
    tables: Tables,
    flexible: FlexibleTables,
    j: int,
    multiplier: Any,
    count: int,
    applied: np.ndarray,
    work: np.ndarray,
    modal: np.ndarray,
    border: np.ndarray,
    kept: LoopFactors,
) -> None:
    """Add what a multiplier does to all that its row visits."""
    paths, rows, numbers = loops.paths, tables.rows, kept.numbers
    if loops.rows[j, KIND_OF] == COUPLER_ROW:
        for term in range(loops.rows[j, FIRST_TERM], loops.rows[j, FIRST_TERM] + loops.rows[j, TERM_COUNT]):
            if loops.speeds[term] >= count:
                applied[loops.speeds[term]] += multiplier * loops.coefficients[term]
    for s in range(paths.first[j], paths.first[j + 1]):
        i, at, of_modes, of_wrench = paths.visits[s]
        if of_wrench >= 0:
            accumulate(work, i, FORCE, times(multiplier, three(numbers, of_wrench)))
            accumulate(work, i, MOMENT, times(multiplier, three(numbers, of_wrench + TURN)))
            if at >= 0 and rows[i, KIND] != SPHERICAL and rows[i, KIND] != FREE:
                work[i, DRIVING] += multiplier * numbers[at]
        if of_modes >= 0 and rows[i, KIND] != INTERFACE:
            body = flexible.bodies[rows[i, FLEXIBLE]]
            k, n, p = body[COUNT], 6 * body[CARRIED_COUNT], modal[span(body, WORK_FORCE)]
            for c in range(k):
                p[c] += multiplier * numbers[of_modes + c]
            if n > 0:
                held = border_in(border, body).held
                for c in range(n):
                    held[c] += multiplier * numbers[of_modes + 2 * k + 2 * n + c]


@kernel
def hold_size(loops: Loops, n: int) -> int:
    """Return how many numbers what holds the rows in an evaluation has, with n free and driven speeds.

    `LoopFactors`, or `UnitResponses` where there are rigid contacts.
    """
    return unit_responses_size(loops, n) if len(loops.points.places) > 0 else factors_size(loops)


@inlined
def scale_of_rows(workspace: np.ndarray, loops: Loops, n: int) -> np.ndarray:
    """Return the scales of rows in a workspace of `hold_size`."""
    if len(loops.points.places) > 0:
        return unit_responses_in(workspace, loops, n).scale
    return loop_factors_in(workspace, loops).system.scale
