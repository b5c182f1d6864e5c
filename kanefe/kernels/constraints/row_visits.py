"""What a unit multiplier of a row of constraints does to all that it visits on its way inward."""

from typing import Any

import numpy as np

from kanefe.kernels.constraints.constraint_rows import RowKind
from kanefe.kernels.constraints.loop_tables import LEAST_SHARE, Held, LoopFactors, rows_of, terms_of
from kanefe.kernels.constraints.row_paths import Visit, Visits
from kanefe.kernels.joints.by_kind import give_way, moved_by
from kanefe.kernels.joints.handing import Carried, CarriedRows, hand_force_inward
from kanefe.kernels.joints.motion import put_three
from kanefe.kernels.language import ZERO, Vector, copy, cross, dot, inlined, vector_kernel
from kanefe.kernels.loads.markers import Marker
from kanefe.kernels.loads.point_and_field_loads import share_of_modes
from kanefe.kernels.scene import Scene, Work, bodies_of, links_of
from kanefe.kernels.sweeps.elastic import total
from kanefe.kernels.sweeps.modal_elimination import push_through_modes, scale, subtract
from kanefe.kernels.tree import Frames, InterfaceFrame, InterfaceLink, Kind


@inlined
def put_visits(scene: Scene, work: Work, held: Held, j: int, is_implicit: bool) -> Any:
    """Write what a unit multiplier of a row does at all it visits; return how much of its reach it has, squared.

    That is ``|J|^2`` relative to that of a row whose wrench pointed along all motions on its way, over displacements of
    the scene's size, whatever the inertias. Modes count as what they have: a light body could move the row far by its
    high modes or its twist, which says nothing of a singular position. Zero for what is round-off of all.

    Wrenches are those that a link needs from its parent, against what acts on it.
    """
    kept, links, frames, extents = held.kept, links_of(scene), work.frames, scene.loops.extents
    row, ways, visits = rows_of(scene.loops)[j], kept.carried, Visits(scene.loops.paths.visits, kept.visited)
    _begin(scene, work, kept, j)
    own = reach = own_of_modes = reach_of_modes = 0.0 * frames[-1].p.x
    for s in range(row.first_visit, row.last_visit):
        visit, moves = visits[s], s < row.common  # what carries both ends does not move the row
        link, frame, way = links[visit.row], frames[visit.row], ways[visit.row]
        f, n = way.f, way.n
        if link.kind == Kind.INTERFACE and not visit.is_end:
            if visit.k > 0:
                moved, could = _bend(scene, work, visit, way, moves)
                own_of_modes += moved
                reach_of_modes += could
                if link.carries:
                    f, n = 0.0 * f, 0.0 * n
        else:
            if visit.modes >= 0:
                a, b, moved = _give_way(scene, work, visit, is_implicit)
                f, n = f + a, n + b
                if s <= row.common:
                    own_of_modes += moved
            if visit.is_end:
                put_three(kept.felt[j], 0, f)
                put_three(kept.felt[j], 3, n)
                break
            visit.force, visit.moment = f, n
            if visit.speeds > 0:
                if moves:
                    moved, could = moved_by(link, frame, way, visit.answer[0], extents)
                    own += moved
                    reach += could
                f, n = give_way(link, frame, visit.answer, f, n)
        if link.parent >= 0 and link.kind != Kind.FREE:
            up = ways[link.parent]
            hand_force_inward(up, frame.r, f, n)
            up.pull, up.couple, up.lever = way.pull, way.couple, way.lever + frame.r
    whole = own + own_of_modes
    if not whole.real > LEAST_SHARE * (reach + reach_of_modes).real:  # else its pivot would be below all that count
        return 0.0 * whole
    return whole / (reach + own_of_modes)


@inlined
def _begin(scene: Scene, work: Work, kept: LoopFactors, j: int) -> None:
    """Write what acts where the way of a row begins, and nothing on all else that it visits."""
    row, links, ways, action = rows_of(scene.loops)[j], links_of(scene), kept.carried, kept.actions[j]
    terms, visits = terms_of(scene.loops), Visits(scene.loops.paths.visits, kept.visited)
    for s in range(row.first_visit, row.last_visit):
        visit, way = visits[s], ways[visits[s].row]
        way.f, way.n, way.pull, way.couple, way.lever = ZERO, ZERO, ZERO, ZERO, ZERO
        visit.answer[:] = 0.0
        if visit.modes >= 0:
            visit.p[:] = 0.0
            visit.on[:] = 0.0
    if row.kind == RowKind.COUPLER:  # its driven coordinates do not give way
        for term in range(row.first_term, row.first_term + row.term_count):
            for s in range(row.first_visit, row.last_visit):
                if visits[s].speeds > 0 and links[visits[s].row].speed == terms[term].speed:
                    visits[s].answer[0] += terms[term].coefficient
    else:
        _set_out(row.a, work.frames, ways, -action.force, action.moment_a)
        _set_out(row.b, work.frames, ways, action.force, action.moment_b)


@inlined
def _set_out(end: Marker, frames: Frames, ways: CarriedRows, force: Vector, moment: Vector) -> None:
    """Write what acts at an end."""
    if end.row >= 0:
        way, arm = ways[end.row], frames[end.row].R @ end.point
        way.f -= force
        way.n -= moment
        way.pull, way.couple, way.lever = force, moment - cross(arm, force), arm


@inlined
def _bend(scene: Scene, work: Work, visit: Visit, way: Carried, moves: bool) -> tuple[Any, Any]:
    """Hand what acts on an interface to the modes of its body; return what it moves of them, and what it could.

    What it carries hands it on, and only then it moves modes by itself.
    """
    frames, pool, modal, link = work.frames, scene.flexible.pool, work.modal, InterfaceLink(links_of(scene)[visit.row])
    G, k, moved = frames[link.parent].R, visit.k, 0.0 * way.pull.x
    could = moved
    if moves:
        first, T = bodies_of(scene, work)[link.flexible].first_deta, InterfaceFrame(frames[visit.row]).tangent
        sizes = scene.loops.extents[first : first + k]
        a, b = G.T @ way.pull, T.T @ (G.T @ (way.couple + cross(way.lever, way.pull)))
        if link.bent < 0:
            moved, could = _over_modes(pool[link.basis : link.basis + 6 * k].reshape(6, k), sizes, a, b)
        else:
            moved, could = _over_modes(modal[link.bent : link.bent + 6 * k].reshape(6, k), sizes, a, b)
        could = could * dot(way.pull, way.pull)
    if link.carries:
        visit.force, visit.moment = G.T @ way.f, G.T @ way.n
    else:
        share_of_modes(scene, frames, modal, visit.row, (-way.f, -way.n), visit.p)
        moved = 0.0 * moved
    return moved, could


@vector_kernel
def _over_modes(basis: np.ndarray, sizes: np.ndarray, a: Vector, b: Vector) -> tuple[Any, Any]:
    """Return the squares of what a wrench on an interface in G, on its slopes, moves of the modes, and of its motion.

    The second is that of a unit force along the motion of the interface by each mode.
    """
    moved = could = 0.0 * a.x
    for m in range(len(sizes)):
        shift, turn = Vector(basis[0, m], basis[1, m], basis[2, m]), Vector(basis[3, m], basis[4, m], basis[5, m])
        p = sizes[m] * (dot(shift, a) + dot(turn, b))
        moved += p * p
        could += sizes[m] * sizes[m] * dot(shift, shift)
    return moved, could


@inlined
def _give_way(scene: Scene, work: Work, visit: Visit, is_implicit: bool) -> tuple[Vector, Vector, Any]:
    """Write how the modes of a body give way to a row; return what its link feels more, in N, and what the row moves.

    That is over the coordinates themselves, as what it could move is, and without what it moves by what is carried.
    See `kanefe.kernels.sweeps.modal_elimination`: with G at rest ``x = p - B^T y``, and y as there.
    """
    f, G, extents = links_of(scene)[visit.row].flexible, work.frames[visit.row].R, scene.loops.extents
    body = bodies_of(scene, work)[f]
    p, x, moved, y, basis, first, own = visit.p, visit.x, visit.moved, visit.y, body.basis, body.first_deta, 0.0 * G.x.x
    for d in range(len(p)):
        own += (extents[first + d] * p[d]) ** 2
    scale(body, p.reshape(1, len(p)), is_implicit)
    a, b = push_through_modes(body, p, visit.on, moved, y)
    copy(p, x)
    for c in range(len(y)):
        subtract(basis[c], y[c], x)
    for c in range(len(y)):
        moved[c] = total(basis[c], x)
    return G @ a, G @ b, own
