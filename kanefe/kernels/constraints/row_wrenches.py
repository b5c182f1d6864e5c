"""What rows of constraints exert on the two things they are between, and what acts along them."""

from typing import Any

import numpy as np

from kanefe.kernels.constraints.constraint_rows import Action, ConstraintRow, RowKind, exert
from kanefe.kernels.constraints.loop_tables import RowWork, holds, is_normal, rows_of, terms_of
from kanefe.kernels.contact.rigid_points import along, given_points, meet, part_of, rub_along
from kanefe.kernels.language import Vector, cross, dot, inlined, kernel
from kanefe.kernels.loads.markers import motion_of
from kanefe.kernels.loads.point_and_field_loads import push
from kanefe.kernels.scene import Scene, State, Work, bodies_of
from kanefe.kernels.sweeps.body_inertia import clear_forces
from kanefe.kernels.tables import Loops


@kernel
def write_rows(scene: Scene, state: State, work: Work, kept: RowWork) -> None:
    """Write what the rows that hold exert, about the origins of their links, and their bias accelerations."""
    rows, j = rows_of(scene.loops), 0
    while j < len(rows):
        row, last = rows[j], j + 1
        while last < len(rows) and rows[last].goes_on:
            last += 1
        if holds(row, state.z):
            if row.kind == RowKind.CONTACT:
                _write_contact(scene, state, work, kept, j)
            elif row.kind == RowKind.COUPLER:
                kept.actions[j].remainder = over_drives(scene.loops, row, state.drives, 2)
            else:
                _write_joint(scene, work, kept, j, last)
        j = last


@inlined
def _write_contact(scene: Scene, state: State, work: Work, kept: RowWork, j: int) -> None:
    """Write a row of a contact point that touches: its normal row comes first."""
    row, action, points, frames = rows_of(scene.loops)[j], kept.actions[j], scene.loops.points, work.frames
    met = kept.met[row.point]
    if row.direction == 0:
        given = given_points(points)[row.point]
        meet(given, points.shapes, frames, met)
        rub_along(given, state.z, met)
    force = along(met, row.direction)
    action.force, action.remainder = force, part_of(met.remainder, row.direction)
    action.moment_a = cross(force, met.point - frames[row.a.row].p)
    action.moment_b = cross(met.point - frames[row.b.row].p, force)


@inlined
def _write_joint(scene: Scene, work: Work, kept: RowWork, first: int, last: int) -> None:
    """Write the rows of a constraint between two markers."""
    rows, frames = rows_of(scene.loops), work.frames
    at_a, at_b = rows[first].a, rows[first].b
    a, b = motion_of(at_a, frames), motion_of(at_b, frames)
    lever_a, lever_b = frames[at_a.row].R @ at_a.point, frames[at_b.row].R @ at_b.point
    for j in range(first, last):
        action = kept.actions[j]
        exert(rows[j], a, b, action)
        action.moment_a -= cross(lever_a, action.force)
        action.moment_b += cross(lever_b, action.force)


@inlined
def over_speeds(loops: Loops, row: ConstraintRow, u: np.ndarray) -> Any:
    """Return the sum of the free terms of a coupler, of speeds or their rates u."""
    terms, total = terms_of(loops), u.dtype.type(0.0)
    for n in range(row.first_term, row.first_term + row.term_count):
        if terms[n].coordinate >= 0:
            total += terms[n].coefficient * u[terms[n].speed]
    return total


@inlined
def over_drives(loops: Loops, row: ConstraintRow, drives: np.ndarray, rate: int) -> float:
    """Return the sum of the driven terms of a coupler: of positions, speeds or accelerations (0, 1, 2)."""
    terms, total = terms_of(loops), 0.0
    for n in range(row.first_term, row.first_term + row.term_count):
        if terms[n].coordinate < 0:
            total += terms[n].coefficient * drives[-1 - terms[n].coordinate, rate]
    return total


@inlined
def along_ends(action: Action, v_a: Vector, w_a: Vector, v_b: Vector, w_b: Vector) -> Any:
    """Return what two ends, whose motions are given, move along a row."""
    return dot(action.force, v_b - v_a) + dot(action.moment_a, w_a) + dot(action.moment_b, w_b)


@inlined
def along_row(scene: Scene, work: Work, kept: RowWork, j: int, du: np.ndarray) -> Any:
    """Return J_j du from the share of du in the acceleration of the rows, after a sweep of accelerations."""
    row = rows_of(scene.loops)[j]
    if row.kind == RowKind.COUPLER:
        found = over_speeds(scene.loops, row, du)
    else:
        a, b = work.frames[row.a.row], work.frames[row.b.row]
        found = along_ends(kept.actions[j], a.a, a.alpha, b.a, b.alpha)
    return found


@kernel
def push_row(scene: Scene, work: Work, kept: RowWork, j: int, multiplier: Any, rubs: bool) -> None:
    """Apply what a multiplier of a row exerts, with what it rubs where that is asked for."""
    row, terms = rows_of(scene.loops)[j], terms_of(scene.loops)
    if row.kind == RowKind.COUPLER:
        for n in range(row.first_term, row.first_term + row.term_count):
            work.applied[terms[n].speed] += multiplier * terms[n].coefficient
        return
    for end in range(2):
        force, moment = wrench_on(scene, work, kept, j, end, rubs)
        i = row.b.row if end == 1 else row.a.row
        push(scene, work, i, multiplier * force, multiplier * moment)


@inlined
def wrench_on(scene: Scene, work: Work, kept: RowWork, j: int, end: int, rubs: bool) -> tuple[Vector, Vector]:
    """Return force and moment of a unit multiplier on a or b (0, 1), about its row's origin, with what it rubs."""
    row, action = rows_of(scene.loops)[j], kept.actions[j]
    if end == 1:
        force, moment, i, sign = action.force, action.moment_b, row.b.row, 1.0
    else:
        force, moment, i, sign = -action.force, action.moment_a, row.a.row, -1.0
    if rubs and is_normal(row):
        met = kept.met[row.point]
        rubbed = sign * met.tangential
        force = force + rubbed
        moment = moment + cross(met.point - work.frames[i].p, rubbed)
    return force, moment


@kernel
def clear_all_forces(scene: Scene, work: Work) -> None:
    """Write no forces on rows, modes and joints."""
    bodies = bodies_of(scene, work)
    for i in range(len(work.frames) - 1):
        clear_forces(work.frames[i])
    for f in range(len(bodies)):
        bodies[f].p[:] = 0.0
    work.applied[:] = 0.0
