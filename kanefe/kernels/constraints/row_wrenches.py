"""What rows of constraints exert on the two things they are between, and what acts along them."""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels.algebra.vectors import Numbers, cross, dot, minus, plus, put, times, vector
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.constraints.constraint_rows import CONTACT_ROW, COUPLER_ROW, row_terms
from kanefe.kernels.constraints.loop_tables import (
    DIRECTION,
    FIRST_TERM,
    FORCE_A,
    FORCE_B,
    GOES_ON,
    IS_BALL,
    KIND_OF,
    MOMENT_A,
    MOMENT_B,
    POINT,
    ROW_A,
    ROW_B,
    TERM_COUNT,
    RowWrenches,
    holds,
)
from kanefe.kernels.contact.rigid_points import MET, meet, motion_of_marker, rub_along
from kanefe.kernels.layout import ACCELERATION, ALPHA, POSITION, R
from kanefe.kernels.loads.markers import lever_of
from kanefe.kernels.loads.point_and_field_loads import push
from kanefe.kernels.scene import Scene, Work, bodies_of
from kanefe.kernels.sweeps.body_inertia import clear_forces
from kanefe.kernels.tables import Loops


@kernel
def write_rows(
    loops: Loops,
    gravity: np.ndarray,
    drives: np.ndarray,
    z: np.ndarray,
    count: int,
    work: np.ndarray,
    exerted: RowWrenches,
) -> None:
    """Write the wrenches of the rows that hold about the origins of their links, and their bias accelerations.

    Parameters
    ----------
    count : int
        Of free speeds.
    """
    m, j = len(loops.rows), 0
    while j < m:
        last = j + 1
        while last < m and loops.rows[last, GOES_ON]:
            last += 1
        if holds(loops, j, z):
            kind = loops.rows[j, KIND_OF]
            if kind == CONTACT_ROW:
                _write_contact(loops, j, gravity, z, work, exerted)
            elif kind == COUPLER_ROW:
                exerted.remainders[j] = _coupled(loops, j, drives, count, work)
            else:
                _write_joint(loops, j, last, gravity, work, exerted)
        j = last


@inlined
def _write_contact(
    loops: Loops, j: int, gravity: np.ndarray, z: np.ndarray, work: np.ndarray, exerted: RowWrenches
) -> None:
    """Write a row of a contact point that touches: its normal row comes first."""
    met, p, direction = exerted.met, loops.rows[j, POINT], loops.rows[j, DIRECTION]
    if direction == 0:
        meet(loops.points, p, gravity, work, met)
        rub_along(loops.points, p, z, work, met)
    along = vector(met, p, int(MET.normal) + 3 * direction)
    for end in range(2):
        row, force = loops.rows[j, ROW_A + end], times(1.0 if end else -1.0, along)
        arm = vector(met, p, MET.point)
        if row >= 0:
            arm = minus(arm, vector(work, row, POSITION))
        put(exerted.wrenches, j, 6 * end, force)
        put(exerted.wrenches, j, 6 * end + 3, cross(arm, force))
    exerted.remainders[j] = met[p, int(MET.remainder) + direction]


@inlined
def _coupled(loops: Loops, j: int, drives: np.ndarray, count: int, work: np.ndarray) -> Any:
    """Return the bias acceleration of a coupler: of its driven coordinates."""
    remainder = 0.0 * work[0, R]
    for term in range(loops.rows[j, FIRST_TERM], loops.rows[j, FIRST_TERM] + loops.rows[j, TERM_COUNT]):
        if loops.speeds[term] >= count:
            remainder += loops.coefficients[term] * drives[loops.speeds[term] - count, 2]
    return remainder


@inlined
def _write_joint(
    loops: Loops, first: int, last: int, gravity: np.ndarray, work: np.ndarray, exerted: RowWrenches
) -> None:
    """Write the rows of a constraint between two markers."""
    wrenches, a, b = exerted.wrenches, loops.rows[first, ROW_A], loops.rows[first, ROW_B]
    lever_a, lever_b = lever_of(loops.markers, 2 * first, a, work), lever_of(loops.markers, 2 * first + 1, b, work)
    motion_a = motion_of_marker(loops.markers, 2 * first, a, lever_a, gravity, work)
    motion_b = motion_of_marker(loops.markers, 2 * first + 1, b, lever_b, gravity, work)
    for j in range(first, last):
        force_a, moment_a, force_b, moment_b, remainder = row_terms(
            loops.rows[j, KIND_OF], loops.numbers, j, loops.rows[j, IS_BALL] != 0, motion_a, motion_b
        )
        put(wrenches, j, FORCE_A, force_a)
        put(wrenches, j, MOMENT_A, plus(moment_a, cross(lever_a, force_a)))
        put(wrenches, j, FORCE_B, force_b)
        put(wrenches, j, MOMENT_B, plus(moment_b, cross(lever_b, force_b)))
        exerted.remainders[j] = remainder


@inlined
def along_row(loops: Loops, j: int, work: np.ndarray, wrenches: np.ndarray, du: np.ndarray) -> Any:
    """Return J_j du from the share of du in the acceleration of the rows, after a sweep of accelerations."""
    total = 0.0 * work[0, R]
    if loops.rows[j, KIND_OF] == COUPLER_ROW:
        for term in range(loops.rows[j, FIRST_TERM], loops.rows[j, FIRST_TERM] + loops.rows[j, TERM_COUNT]):
            if loops.speeds[term] < len(du):
                total += loops.coefficients[term] * du[loops.speeds[term]]
        return total
    for end in range(2):
        row = loops.rows[j, ROW_A + end]
        if row >= 0:
            total += dot(vector(wrenches, j, 6 * end), vector(work, row, ACCELERATION))
            total += dot(vector(wrenches, j, 6 * end + 3), vector(work, row, ALPHA))
    return total


@kernel
def push_row(scene: Scene, work: Work, j: int, multiplier: Any, rubs: bool, exerted: RowWrenches) -> None:
    """Apply what a multiplier of a row exerts, with what it rubs where that is asked for."""
    loops = scene.loops
    if loops.rows[j, KIND_OF] == COUPLER_ROW:
        for term in range(loops.rows[j, FIRST_TERM], loops.rows[j, FIRST_TERM] + loops.rows[j, TERM_COUNT]):
            work.applied[loops.speeds[term]] += multiplier * loops.coefficients[term]
        return
    for end in range(2):
        row = loops.rows[j, ROW_A + end]
        force, moment = wrench_on(loops, j, end, rubs, exerted, work.frames.numbers)
        push(scene, work, row, times(multiplier, force), times(multiplier, moment))


@inlined
def wrench_on(
    loops: Loops, j: int, end: int, rubs: bool, exerted: RowWrenches, work: np.ndarray
) -> tuple[Numbers, Numbers]:
    """Return force and moment of a unit multiplier on an end, about the origin of its row; with what it rubs there."""
    row, p = loops.rows[j, ROW_A + end], loops.rows[j, POINT]
    force, moment = vector(exerted.wrenches, j, 6 * end), vector(exerted.wrenches, j, 6 * end + 3)
    if rubs and row >= 0 and loops.rows[j, KIND_OF] == CONTACT_ROW and loops.rows[j, DIRECTION] == 0:
        rubbed = times(1.0 if end else -1.0, vector(exerted.met, p, MET.tangential))
        arm = minus(vector(exerted.met, p, MET.point), vector(work, row, POSITION))
        force, moment = plus(force, rubbed), plus(moment, cross(arm, rubbed))
    return force, moment


@kernel
def clear_all_forces(scene: Scene, work: Work) -> None:
    """Write no forces on rows, modes and joints."""
    frames, bodies = work.frames, bodies_of(scene, work)
    for i in range(len(scene.tables.rows)):
        clear_forces(frames[i])
    for f in range(len(bodies)):
        bodies[f].p[:] = 0.0
    work.applied[:] = 0.0
