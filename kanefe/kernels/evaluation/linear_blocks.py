"""Blocks of the linearised equations of a tree: what is known of its structure, and of loads between frames."""

import numpy as np

from kanefe.kernels.bodies import BorderedBody
from kanefe.kernels.evaluation.derivatives import COMPLEX_STEP
from kanefe.kernels.evaluation.linear_unknowns import (
    Linearised,
    Part,
    Place,
    Places,
    Size,
    along_joint,
    component_of,
    displace,
    put_changes,
    put_entry,
    restore,
    unit_vector,
    vector_of,
)
from kanefe.kernels.force_elements.places import Done, Wrenches, rates_of
from kanefe.kernels.language import ZERO, cross, inlined, kernel
from kanefe.kernels.loads.acting import COORDINATE, acting_in, ends_of, loads_of
from kanefe.kernels.loads.loads_between import evaluate_load
from kanefe.kernels.loads.point_and_field_loads import share_of_modes
from kanefe.kernels.scene import bodies_of, links_of
from kanefe.kernels.sweeps.elastic import combination, total
from kanefe.kernels.tree import Kind, Link


@kernel
def put_tree(given: Linearised) -> None:
    """Put what is known of the structure: ones, needs of children, and what needs do along joints and to modes."""
    scene, work, unknowns = given.scene, given.work, given.unknowns
    links, frames, places, bodies = links_of(scene), work.frames, Places(unknowns.places), bodies_of(scene, work)
    known, masses = given.known, given.masses
    for i in range(len(links)):
        link, place, frame = links[i], places[i], frames[i]
        parent = frames[link.parent]
        for c in range(Size.MOTION):
            put_entry(known, place.motion + c, place.motion + c, 1.0)
        for c in range(Size.NEED):
            put_entry(known, place.need + c, place.need + c, 1.0)
        for c in range(place.joint):
            row = unknowns.speeds[link.speed + c]
            put_entry(masses, row, row, link.armature)
            for k in range(Size.NEED):
                if not _acts(link, c, k):
                    continue
                unit = (unit_vector(k), ZERO) if k < 3 else (ZERO, unit_vector(k - 3))
                put_entry(known, row, place.need + k, along_joint(link, frame, parent, unit, c).real)
        if link.parent >= 0 and link.kind != Kind.FREE:
            _hand(given, i, places[link.parent])
        if link.kind == Kind.INTERFACE:
            _put_share(given, i, bodies[link.flexible])
        elif place.modes > 0:
            _put_modal_mass(given, i, bodies[link.flexible])


@inlined
def _acts(link: Link, c: int, k: int) -> bool:
    """Return whether a component k of force and moment may act along speed c of a joint."""
    if link.kind == Kind.FREE:
        return (c < 3) == (k < 3)
    if link.kind == Kind.SPHERICAL or link.kind == Kind.REVOLUTE:
        return k >= 3
    return True


@kernel
def _hand(given: Linearised, i: int, carrier: Place) -> None:
    """Put what the parent of a row needs for it: its force and, about the parent's origin, its moment."""
    known, place, kept = given.known, Places(given.unknowns.places)[i], given.kept[i]
    for c in range(3):
        unit = unit_vector(c)
        put_entry(known, carrier.need + c, place.need + c, -1.0)
        put_entry(known, carrier.need + 3 + c, place.need + 3 + c, -1.0)
        by_force = cross(kept.r, unit)
        for k in range(3):
            if k == c:
                continue
            put_entry(known, carrier.need + 3 + k, place.need + c, -component_of(by_force, k).real)


@kernel
def _put_share(given: Linearised, i: int, body: BorderedBody) -> None:
    """Put what the need of an interface does to the modes of its body."""
    scene, work, place, p = given.scene, given.work, Places(given.unknowns.places)[i], body.p
    for k in range(Size.NEED):
        p[:] = 0.0
        unit = (unit_vector(k), ZERO) if k < 3 else (ZERO, unit_vector(k - 3))
        share_of_modes(
            scene, work.frames, work.modal, i, (unit[0] + 0.0 * work.frames[i].p, unit[1] + 0.0 * work.frames[i].p), p
        )
        for j in range(body.k):
            found = p[j] if body.transform < 0 else total(body.to_modes[j], p)
            put_entry(given.known, given.unknowns.speeds[body.first_deta + j], place.need + k, found.real)


@kernel
def _put_modal_mass(given: Linearised, i: int, body: BorderedBody) -> None:
    """Put what accelerations of modes need of their link and of themselves: force, moment, and their mass."""
    masses, speeds, x, R = given.masses, given.unknowns.speeds, body.even.numbers, given.kept[i].R
    need = Places(given.unknowns.places)[i].need
    for m in range(body.k):
        column = speeds[body.first_deta + m]
        for j in range(body.k):
            x[j] = 1.0 * (j == m)
            if body.transform >= 0:
                x[j] = body.to_modes[m, j]
        f, n = R @ combination(body.linear, x[: body.k]), R @ combination(body.angular, x[: body.k])
        for c in range(3):
            put_entry(masses, need + c, column, -component_of(f, c).real)
            put_entry(masses, need + 3 + c, column, -component_of(n, c).real)
        for j in range(body.k):
            if body.transform >= 0:
                put_entry(masses, speeds[body.first_deta + j], column, total(body.to_modes[j], x[: body.k]).real)
            elif j == m:
                put_entry(masses, column, column, 1.0)


@kernel
def put_load_changes(given: Linearised, n: int) -> None:
    """Put how what a load does, and the rates of its states, change with the motions of its ends and these states."""
    scene, state, work, unknowns = given.scene, given.state, given.work, given.unknowns
    load, ends, frames = loads_of(scene)[n], ends_of(scene), work.frames
    is_near = acting_in(scene, work).nearness[n].real > 0.0
    for e in range(load.end_count):
        end = ends[load.first_end + e]
        if end.row >= 0:
            is_known = unknowns.is_inner[n] > 0
            for other in range(e):
                is_known = is_known or ends[load.first_end + other].row == end.row
            if is_known:
                continue
            for c in range(3 * Part.PULL):
                displace(frames[end.row], c)
                put_answer(given, n, Places(unknowns.places)[end.row].motion + c, is_near)
                restore(frames[end.row], given.kept[end.row])
        elif end.row == COORDINATE and end.coordinate >= 0:
            _displace_number(state.q, end.coordinate)
            put_answer(given, n, unknowns.coordinates[end.speed], is_near)
            state.q[end.coordinate] = state.q[end.coordinate].real
            _displace_number(state.u, end.speed)
            put_answer(given, n, unknowns.speeds[end.speed], is_near)
            state.u[end.speed] = state.u[end.speed].real
    if len(unknowns.states) == 0:
        return
    for s in range(load.first_state, load.first_state + load.state_count):
        _displace_number(state.z, s)
        put_answer(given, n, unknowns.states[s], is_near)
        state.z[s] = state.z[s].real
        put_entry(given.masses, unknowns.states[s], unknowns.states[s], 1.0)


@inlined
def _displace_number(x: np.ndarray, i: int) -> None:
    x[i] = x[i] + complex(0.0, COMPLEX_STEP)


@kernel
def put_answer(given: Linearised, n: int, column: int, is_near: bool) -> None:
    """Put what a displacement changes of the wrenches of a load on its rows, and of the rates of its states."""
    scene, work, unknowns, known = given.scene, given.work, given.unknowns, given.known
    load, ends, acting = loads_of(scene)[n], ends_of(scene), acting_in(scene, work)
    done = Done(acting.done)
    if is_near:
        evaluate_load(scene, given.state, work, n, n)
    else:
        acting.done[:] = 0.0
    wrenches = Wrenches(done.wrenches)
    for i in range(load.end_count):
        end, on = ends[load.first_end + i], wrenches[i]
        if end.row == COORDINATE and end.coordinate >= 0:
            put_entry(known, unknowns.speeds[end.speed], column, -on.force.x.imag / COMPLEX_STEP)
        elif end.row >= 0:
            need = Places(unknowns.places)[end.row].need
            moment = on.moment + cross(work.frames[end.row].R @ end.point, on.force)
            turn = vector_of(work.frames[end.row], given.kept[end.row], Part.TURN)
            put_changes(known, need, column, on.force - cross(turn, on.force), 1.0)
            put_changes(known, need + 3, column, moment - cross(turn, moment), 1.0)
    if len(unknowns.states) == 0:
        return
    changes = rates_of(done, load.end_count)
    for s in range(load.state_count):
        row = unknowns.states[load.first_state + s]
        rate = changes[s].imag / COMPLEX_STEP
        if not is_near:
            rate = -scene.between.decay_rates[load.first_state + s] if row == column else 0.0
        put_entry(known, row, column, -rate)
