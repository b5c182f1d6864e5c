"""How loops hold the tree: they are eliminated where the links between their ends meet.

At that link, with V the share of du in its acceleration, its loops need multipliers

    lambda = A^-1 (rest - b + K^T V),

b the accelerations of the rows with the link at rest, and K what it feels of unit multipliers: they add ``K A^-1 K^T``
to its articulated inertia and ``K A^-1 (rest - b)`` to the force that it needs. Inward, a loop is complete where its
ends meet; outward, its multipliers are known as the sweep leaves that link. Loops in a row, or one upon the other, then
cost as many numbers as there are loops. (Vereshchagin 1974 for loops through N; Chignoli et al. 2022 for the idea of
elimination where a loop closes.)
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from kanefe.kernels.algebra.envelope import factor_envelope, solve_envelope
from kanefe.kernels.bodies import BorderedBodies, ModalBodies
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.constraints.constraint_rows import COUPLER_ROW
from kanefe.kernels.constraints.loop_factors import TURN, LoopFactors, factors_size, loop_factors_in
from kanefe.kernels.constraints.loop_system import put_loop_system
from kanefe.kernels.constraints.loop_tables import (
    FIRST_TERM,
    KIND_OF,
    RANK_TOLERANCE,
    TERM_COUNT,
    unit_responses_in,
    unit_responses_size,
)
from kanefe.kernels.constraints.row_paths import OF_JOINT, OF_MODES, VISITED
from kanefe.kernels.joints.by_kind import answer_along, answer_further
from kanefe.kernels.joints.motion import three
from kanefe.kernels.sweeps.elastic import total
from kanefe.kernels.tables import FlexibleTables, Loops, Tables
from kanefe.kernels.tree import Frames, Kind, Links
from kanefe.kernels.values.tensors import dot, outer, square


class Held(NamedTuple):
    """The loops that sweeps hold.

    Attributes
    ----------
    loops : Loops
    kept : LoopFactors
        With what rows exert, and the acceleration that each needs.
    multipliers : ndarray, shape (m,)
        After a sweep inward with the link that carries the loop at rest.
    z : ndarray, shape (states,)
        Internal states, of which the switches say which rows hold.
    places_only : bool
        Whether rows that hold speeds alone are left out.
    tolerance : float
        Pivot, of a row of unit length, below which it depends on others; that of the scene at least.
    """

    loops: Loops
    kept: LoopFactors
    multipliers: np.ndarray
    z: np.ndarray
    places_only: bool
    tolerance: float


@inlined
def carries_loops(held: Held, i: int) -> bool:
    """Return whether loops close at a row, -1 the ground."""
    places = held.loops.paths.places
    return places[i + 2] > places[i + 1]


@inlined
def close_at(
    held: Held,
    tables: Tables,
    flexible: FlexibleTables,
    i: int,
    applied: np.ndarray,
    work: np.ndarray,
    modal: np.ndarray,
    border: np.ndarray,
    is_implicit: bool,
) -> tuple[Any, Any]:
    """Eliminate the loops that a row carries, -1 the ground; return the least and the largest pivot."""
    loops, kept = held.loops, held.kept
    begin, end = loops.paths.places[i + 1], loops.paths.places[i + 2]
    tolerance = max(held.tolerance, loops.limits[RANK_TOLERANCE])
    put_loop_system(loops, tables, flexible, i, held.z, held.places_only, work, modal, border, is_implicit, kept)
    least, most = factor_envelope(kept.system, tolerance, begin, end)
    if i >= 0:
        _add_inertia(loops, i, work, kept)
    hold_at(held, tables, flexible, i, applied, work, modal)
    return least, most


@inlined
def _add_inertia(loops: Loops, i: int, work: np.ndarray, kept: LoopFactors) -> None:
    """Add what the loops that a link carries make it feel of its own acceleration: K A^-1 K^T."""
    paths, frame = loops.paths, Frames(work)[i]
    begin, end = paths.places[i + 1], paths.places[i + 2]
    solve_envelope(kept.system, kept.felt, begin, end, kept.asked)
    for place in range(begin, end):
        j = paths.order[place]
        if kept.system.scale[j] == 0.0:
            continue
        force, moment = three(kept.felt[j], 0), three(kept.felt[j], TURN)
        by_a, by_alpha = three(kept.asked[j], 0), three(kept.asked[j], TURN)
        frame.M += square(force, by_a)
        frame.H += outer(force, by_alpha)
        frame.J += square(moment, by_alpha)


@inlined
def hold_at(
    held: Held,
    tables: Tables,
    flexible: FlexibleTables,
    i: int,
    applied: np.ndarray,
    work: np.ndarray,
    modal: np.ndarray,
) -> None:
    """Write the multipliers of the loops that a row carries with that row at rest, and add what it feels of them."""
    loops, kept, multipliers = held.loops, held.kept, held.multipliers
    paths, frame = loops.paths, Frames(work)[i]
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
            frame.f += multipliers[j] * three(kept.felt[j], 0)
            frame.n += multipliers[j] * three(kept.felt[j], TURN)


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
    paths, numbers, links, frames = loops.paths, kept.numbers, Links(tables.rows, tables.geometry), Frames(work)
    along = 0.0 * work[0, 0]
    for s in range(paths.first[j], paths.first[j + 1]):
        i, at, of_modes = paths.visits[s, VISITED], paths.visits[s, OF_JOINT], paths.visits[s, OF_MODES]
        link = links[i]
        if of_modes >= 0 and link.kind != Kind.INTERFACE:
            along += _modal_acceleration(flexible, link.flexible, of_modes, frames, modal, numbers)
        if at >= 0:
            along += answer_along(link, frames[i], frames[link.parent], applied, numbers, at)
    return along


@inlined
def _modal_acceleration(
    flexible: FlexibleTables, f: int, at: int, frames: Frames, modal: np.ndarray, numbers: np.ndarray
) -> Any:
    """Return the same of the modes of a body and of what it carries."""
    body = ModalBodies(flexible.bodies, flexible.pool, modal)[f]
    k, back = body.k, frames[body.link].R.T
    along = total(numbers[at + k : at + 2 * k], body.p)
    moved = at + 2 * k + 6 * body.carried_count
    for c in range(body.carried_count):
        frame = frames[flexible.carrying[body.carried + c]]
        along -= dot(three(numbers, moved + 6 * c), back @ frame.f)
        along -= dot(three(numbers, moved + 6 * c + 3), back @ frame.n)
    return along


@inlined
def exert_at(
    held: Held,
    tables: Tables,
    flexible: FlexibleTables,
    i: int,
    count: int,
    applied: np.ndarray,
    work: np.ndarray,
    modal: np.ndarray,
    border: np.ndarray,
) -> None:
    """Write the multipliers of the loops that a row carries, whose acceleration is known, and add what they do.

    Parameters
    ----------
    count : int
        Of free speeds.
    """
    loops, kept, multipliers = held.loops, held.kept, held.multipliers
    paths, frame = loops.paths, Frames(work)[i]
    for place in range(paths.places[i + 1], paths.places[i + 2]):
        j = paths.order[place]
        if kept.system.scale[j] == 0.0:
            continue
        if i >= 0:
            multipliers[j] += dot(three(kept.asked[j], 0), frame.a) + dot(three(kept.asked[j], TURN), frame.alpha)
        if multipliers[j] != 0.0:
            _exert(loops, tables, flexible, j, multipliers[j], count, applied, work, modal, border, kept)


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
    paths, numbers, links, frames = loops.paths, kept.numbers, Links(tables.rows, tables.geometry), Frames(work)
    if loops.rows[j, KIND_OF] == COUPLER_ROW:
        for term in range(loops.rows[j, FIRST_TERM], loops.rows[j, FIRST_TERM] + loops.rows[j, TERM_COUNT]):
            if loops.speeds[term] >= count:
                applied[loops.speeds[term]] += multiplier * loops.coefficients[term]
    for s in range(paths.first[j], paths.first[j + 1]):
        i, at, of_modes, of_wrench = paths.visits[s]
        link, frame = links[i], frames[i]
        if of_wrench >= 0:
            frame.f += multiplier * three(numbers, of_wrench)
            frame.n += multiplier * three(numbers, of_wrench + TURN)
            if at >= 0:
                answer_further(link, frame, multiplier, numbers, at)
        if of_modes >= 0 and link.kind != Kind.INTERFACE:
            body = BorderedBodies(flexible.bodies, flexible.pool, modal, border)[link.flexible]
            p, held, y = body.p, body.held, of_modes + 2 * body.k + 2 * len(body.held)
            for c in range(len(p)):
                p[c] += multiplier * numbers[of_modes + c]
            for c in range(len(held)):
                held[c] += multiplier * numbers[y + c]


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
