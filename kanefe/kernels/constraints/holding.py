"""How loops hold the tree: they are eliminated where the links between their ends meet.

At that link, with V the share of du in its acceleration, its loops need multipliers

    lambda = A^-1 (rest - b + K^T V),

b the accelerations of the rows with the link at rest, and K what it feels of unit multipliers: they add ``K A^-1 K^T``
to its articulated inertia and ``K A^-1 (rest - b)`` to the force that it needs. Inward, a loop is complete where its
ends meet; outward, its multipliers are known as the sweep leaves that link. Loops in a row, or one upon the other, then
cost as many numbers as there are loops. (Vereshchagin 1974 for loops through N; Chignoli et al. 2022 for the idea of
elimination where a loop closes.)
"""

from typing import Any

import numpy as np

from kanefe.kernels.algebra.envelope import factor_envelope, solve_envelope
from kanefe.kernels.constraints.constraint_rows import RowKind
from kanefe.kernels.constraints.loop_system import put_loop_system
from kanefe.kernels.constraints.loop_tables import (
    Held,
    Limits,
    LoopFactors,
    RowWork,
    factors_in,
    rows_of,
    system_of,
    terms_of,
)
from kanefe.kernels.constraints.row_paths import Visit, Visits
from kanefe.kernels.constraints.row_wrenches import write_rows
from kanefe.kernels.joints.by_kind import answer_along, answer_further
from kanefe.kernels.joints.motion import three
from kanefe.kernels.language import dot, expanded, inlined, outer, square
from kanefe.kernels.scene import Scene, State, Work, bodies_of, links_of
from kanefe.kernels.sweeps.elastic import total
from kanefe.kernels.tree import Frame, Kind


@expanded
def accelerations_to_hold(scene: Scene, state: State, work: Work) -> Held:
    """Write what rows exert, and the acceleration that each needs; return what sweeps hold then."""
    kept = factors_in(work.holding, scene.loops)
    write_rows(scene, state, work, RowWork(kept))
    rest, actions = kept.rest, kept.actions
    for j in range(len(rest)):
        rest[j] = -actions[j].remainder
    return Held(kept, state.z, False, 0.0)


@inlined
def carries_loops(scene: Scene, i: int) -> bool:
    """Return whether loops close at a row, -1 the ground."""
    places = scene.loops.paths.places
    return places[i + 2] > places[i + 1]


@inlined
def close_at(scene: Scene, work: Work, held: Held, i: int, is_implicit: bool) -> tuple[Any, Any]:
    """Eliminate the loops that a row carries, -1 the ground; return the least and the largest pivot."""
    kept, paths = held.kept, scene.loops.paths
    begin, end, system = paths.places[i + 1], paths.places[i + 2], system_of(scene.loops, kept)
    put_loop_system(scene, work, held, i, is_implicit)
    least, most = factor_envelope(system, max(held.tolerance, Limits(scene.loops.limits).rank_tolerance), begin, end)
    if i >= 0:
        solve_envelope(system, kept.felt, begin, end, kept.asked)
        for place in range(begin, end):
            if kept.scale[paths.order[place]] != 0.0:
                _add_inertia(kept.felt[paths.order[place]], kept.asked[paths.order[place]], work.frames[i])
    hold_at(scene, work, held, i)
    return least, most


@inlined
def _add_inertia(felt: np.ndarray, asked: np.ndarray, frame: Frame) -> None:
    """Add what a row makes the link that carries it feel of its own acceleration: K A^-1 K^T."""
    force, moment, by_a, by_alpha = three(felt, 0), three(felt, 3), three(asked, 0), three(asked, 3)
    frame.M += square(force, by_a)
    frame.H += outer(force, by_alpha)
    frame.J += square(moment, by_alpha)


@inlined
def hold_at(scene: Scene, work: Work, held: Held, i: int) -> None:
    """Write the multipliers of the loops that a row carries with that row at rest, and add what it feels of them."""
    kept, paths, multipliers, frame = held.kept, scene.loops.paths, work.multipliers, work.frames[i]
    right, felt, begin, end = kept.right, kept.felt, paths.places[i + 1], paths.places[i + 2]
    for place in range(begin, end):
        j = paths.order[place]
        right[j, 0] = 0.0
        if kept.scale[j] != 0.0:
            right[j, 0] = kept.rest[j] - _acceleration(scene, work, kept, j)
    solve_envelope(system_of(scene.loops, kept), right, begin, end, multipliers.reshape(len(multipliers), 1))
    for place in range(begin, end if i >= 0 else begin):
        j = paths.order[place]
        if multipliers[j] != 0.0:
            frame.f += multipliers[j] * three(felt[j], 0)
            frame.n += multipliers[j] * three(felt[j], 3)


@inlined
def _acceleration(scene: Scene, work: Work, kept: LoopFactors, j: int) -> Any:
    """Return the acceleration along a row by the forces on what it visits: answers of the row, times these."""
    row, visits = rows_of(scene.loops)[j], Visits(scene.loops.paths.visits, kept.visited)
    links, frames, along = links_of(scene), work.frames, 0.0 * work.frames[-1].p.x
    for s in range(row.first_visit, row.last_visit):
        visit = visits[s]
        link = links[visit.row]
        if visit.modes >= 0 and link.kind != Kind.INTERFACE:
            along += _modal_acceleration(scene, work, link.flexible, visit)
        if visit.speeds > 0:
            along += answer_along(link, frames[visit.row], frames[link.parent], work.applied, visit.answer)
    return along


@inlined
def _modal_acceleration(scene: Scene, work: Work, f: int, visit: Visit) -> Any:
    """Return the same of the modes of a body and of what it carries."""
    body, frames = bodies_of(scene, work)[f], work.frames
    back, moved, along = frames[body.link].R.T, visit.moved, total(visit.x, body.p)
    for c in range(body.carried_count):
        frame = frames[scene.flexible.carrying[body.carried + c]]
        along -= dot(three(moved, 6 * c), back @ frame.f) + dot(three(moved, 6 * c + 3), back @ frame.n)
    return along


@inlined
def exert_at(scene: Scene, work: Work, held: Held, i: int) -> None:
    """Write the multipliers of the loops that a row carries, whose acceleration is known, and add what they do."""
    kept, paths, multipliers, frame = held.kept, scene.loops.paths, work.multipliers, work.frames[i]
    asked = kept.asked
    for place in range(paths.places[i + 1], paths.places[i + 2]):
        j = paths.order[place]
        if kept.scale[j] == 0.0:
            continue
        if i >= 0:
            multipliers[j] += dot(three(asked[j], 0), frame.a) + dot(three(asked[j], 3), frame.alpha)
        if multipliers[j] != 0.0:
            _exert(scene, work, kept, j)


@inlined
def _exert(scene: Scene, work: Work, kept: LoopFactors, j: int) -> None:
    """Add what a multiplier does to all that its row visits, and to what drives its coordinates."""
    links, frames, applied, multiplier = links_of(scene), work.frames, work.applied, work.multipliers[j]
    row, terms, visits = rows_of(scene.loops)[j], terms_of(scene.loops), Visits(scene.loops.paths.visits, kept.visited)
    if row.kind == RowKind.COUPLER:
        for term in range(row.first_term, row.first_term + row.term_count):
            if terms[term].coordinate < 0:
                applied[terms[term].speed] += multiplier * terms[term].coefficient
    for s in range(row.first_visit, row.last_visit):
        visit = visits[s]
        link, frame = links[visit.row], frames[visit.row]
        if link.kind == Kind.INTERFACE:
            continue
        if visit.wrench >= 0:
            frame.f += multiplier * visit.force
            frame.n += multiplier * visit.moment
        if visit.speeds > 0:
            answer_further(link, frame, multiplier, visit.answer)
        if visit.modes >= 0:
            _exert_on_modes(scene, work, link.flexible, multiplier, visit)


@inlined
def _exert_on_modes(scene: Scene, work: Work, f: int, multiplier: Any, visit: Visit) -> None:
    """Add what a multiplier does to the modes of a body, and to what it carries."""
    body = bodies_of(scene, work)[f]
    p, held, of_p, of_y = body.p, body.held, visit.p, visit.y
    for c in range(len(p)):
        p[c] += multiplier * of_p[c]
    for c in range(len(held)):
        held[c] += multiplier * of_y[c]
