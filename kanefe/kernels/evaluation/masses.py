"""The mass matrix of a scene (Eq. 18, 39) by one inward sweep: inertias of links with all that they carry.

The column of a speed is the wrench that its unit acceleration needs, from the composite inertia of its link, seen by
the joints and modes between the link and the ground (Featherstone, "Rigid Body Dynamics Algorithms", section 6.2;
modes as in `kanefe.kernels.sweeps.modal_elimination`, where nothing gives way here). `kanefe.kane.assemble` computes
the same from dense partial velocities.
"""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.vectors import (
    Numbers,
    copy,
    cross,
    dot,
    matrix,
    plus,
    rotated,
    rotated_back,
    symmetric,
    symmetric_times,
    transposed,
    vector,
)
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.compiler.arrays import RealRows, Reals
from kanefe.kernels.compiler.entries import entry
from kanefe.kernels.layout import (
    BASIS,
    BENT,
    CARRIED,
    CARRIED_COUNT,
    COORDINATES,
    COUNT,
    DETA,
    EXACT,
    FIXED,
    FLEXIBLE,
    FREE,
    GIVEN,
    INTERFACE,
    KIND,
    MODAL_SIZE,
    OFFSET,
    PARENT,
    SPEED,
    SPEEDS,
    TANGENT,
    TRANSFORM,
    WORK,
    FlexibleTables,
    H,
    J,
    M,
    R,
    Tables,
)
from kanefe.kernels.sweeps.body_inertia import hand_inward
from kanefe.kernels.sweeps.elastic import coupling_span, total
from kanefe.kernels.sweeps.exact_beam_layout import beam_work_in
from kanefe.kernels.sweeps.inertia import set_inertia
from kanefe.kernels.sweeps.link_motion import fixed_axes, partials
from kanefe.kernels.sweeps.outward import sweep_outward


@entry()
def put_masses(
    tables: Tables, flexible: FlexibleTables, drives: RealRows, y: Reals, found: RealRows, memory: Reals
) -> None:
    """Write the mass matrix of a state ``(q, u, ...)`` over its free and driven speeds.

    Parameters
    ----------
    drives : ndarray, shape (driven, 3)
    y : ndarray
    found : ndarray, shape (free + driven, free + driven)
    memory : ndarray, shape (`masses_memory_size`,)
    """
    rows, n, size = tables.rows, tables.sizes[COORDINATES], WORK * len(tables.rows)
    work, rest = memory[:size].reshape(-1, WORK), memory[size:]
    modal, column = rest[: flexible.sizes[MODAL_SIZE]], rest[flexible.sizes[MODAL_SIZE] :]
    sweep_outward(tables, flexible, drives, y[:n], y[n : n + tables.sizes[SPEEDS]], work, modal)
    set_inertia(tables, flexible, work, modal)
    found[:, :] = 0.0
    zero = (0.0, 0.0, 0.0)
    for i in range(len(rows) - 1, -1, -1):
        if rows[i, KIND] != INTERFACE:
            if rows[i, FLEXIBLE] >= 0:
                _put_modes(tables, flexible, i, work, modal, found)
            _put_joint(tables, flexible, i, work, modal, found)
        if rows[i, PARENT] >= 0:
            m, h, j = symmetric(work, i, M), matrix(work, i, H), symmetric(work, i, J)
            hand_inward(work, rows[i, PARENT], vector(work, i, OFFSET), m, h, j, zero, zero)
    for f in range(len(flexible.bodies)):
        body = flexible.bodies[f]
        if body[TRANSFORM] >= 0:
            k, at, first = body[COUNT], body[TRANSFORM], body[DETA]
            transform = flexible.pool[at : at + k * k].reshape(k, k)
            _transform_columns(found, first, transform, column[:k])
            _transform_rows(found, first, transform, column[:k])


@kernel
def _put_joint(
    tables: Tables, flexible: FlexibleTables, i: int, work: np.ndarray, modal: np.ndarray, found: np.ndarray
) -> None:
    """Write the columns of the joint of a link."""
    kind, speed, none = tables.rows[i, KIND], tables.rows[i, SPEED], (0.0, 0.0, 0.0)
    if kind == FIXED:
        return
    if kind <= GIVEN:
        v, w = partials(tables.rows, tables.geometry, i, work)
        _put_motion(tables, flexible, i, v, w, speed, work, modal, found)
        return
    if kind == FREE:
        axes = fixed_axes(tables, i, work)
        for c in range(3):
            _put_motion(tables, flexible, i, _column(axes, c), none, speed + c, work, modal, found)
        speed += 3
    axes = matrix(work, i, R)
    for c in range(3):
        _put_motion(tables, flexible, i, none, _column(axes, c), speed + c, work, modal, found)


@inlined
def _column(A: Numbers, c: int) -> Numbers:
    """Return a column of a 3 x 3 matrix."""
    B = transposed(A)
    return (B[0], B[1], B[2]) if c == 0 else ((B[3], B[4], B[5]) if c == 1 else (B[6], B[7], B[8]))


@kernel
def _put_motion(
    tables: Tables,
    flexible: FlexibleTables,
    i: int,
    v: Numbers,
    w: Numbers,
    speed: int,
    work: np.ndarray,
    modal: np.ndarray,
    found: np.ndarray,
) -> None:
    """Write the column of a speed with which a link, and all that it carries, moves as one rigid body."""
    force, moment = _wrench(i, v, w, work)
    _hand_to_ground(tables, flexible, i, force, moment, speed, work, modal, found)


@inlined
def _wrench(i: int, v: Numbers, w: Numbers, work: np.ndarray) -> tuple[Numbers, Numbers]:
    """Return the wrench that accelerations of a row need, about its origin."""
    h = matrix(work, i, H)
    force = plus(symmetric_times(symmetric(work, i, M), v), rotated(h, w))
    return force, plus(rotated_back(h, v), symmetric_times(symmetric(work, i, J), w))


@kernel
def _put_modes(
    tables: Tables, flexible: FlexibleTables, i: int, work: np.ndarray, modal: np.ndarray, found: np.ndarray
) -> None:
    """Write the columns of the modes of a flexible body: of unit mass, with what their interfaces carry."""
    rows, body = tables.rows, flexible.bodies[tables.rows[i, FLEXIBLE]]
    k, first = body[COUNT], body[DETA]
    if k == 0:
        return
    G, coupling = matrix(work, i, R), modal[coupling_span(body)].reshape(6, k)
    for j in range(k):
        if body[EXACT] < 0:
            found[first + j, first + j] += 1.0
        else:
            mass = beam_work_in(body, modal).mass
            found[first + j, first + j] += mass[j, j]
            for other in range(j):
                found[first + j, first + other] += mass[j, other]
                found[first + other, first + j] += mass[j, other]
        force = rotated(G, (coupling[0, j], coupling[1, j], coupling[2, j]))
        moment = rotated(G, (coupling[3, j], coupling[4, j], coupling[5, j]))
        for c in range(body[CARRIED], body[CARRIED] + body[CARRIED_COUNT]):
            row = flexible.carrying[c]
            v, w = _moved_by_mode(flexible, rows, row, body, j, work, modal)
            own, turning = _wrench(row, rotated(G, v), rotated(G, w), work)
            _add_to_modes(flexible, rows, row, body, G, own, turning, first + j, work, modal, found)
            force = plus(force, own)
            moment = plus(moment, plus(turning, cross(vector(work, row, OFFSET), own)))
        _hand_to_ground(tables, flexible, i, force, moment, first + j, work, modal, found)


@inlined
def _moved_by_mode(
    flexible: FlexibleTables, rows: np.ndarray, row: int, body: np.ndarray, j: int, work: np.ndarray, modal: np.ndarray
) -> tuple[Numbers, Numbers]:
    """Return velocity and angular velocity of an interface by the rate of a mode, in G."""
    k, at, bent = body[COUNT], rows[row, BASIS], rows[row, BENT]
    # one name for both, since `modal` is real here
    if bent < 0:
        basis = flexible.pool[at : at + 6 * k].reshape(6, k)
    else:
        basis = modal[bent : bent + 6 * k].reshape(6, k)
    turn = rotated(matrix(work, row, TANGENT), (basis[3, j], basis[4, j], basis[5, j]))
    return (basis[0, j], basis[1, j], basis[2, j]), turn


@kernel
def _add_to_modes(
    flexible: FlexibleTables,
    rows: np.ndarray,
    row: int,
    body: np.ndarray,
    G: Numbers,
    force: Numbers,
    moment: Numbers,
    column: int,
    work: np.ndarray,
    modal: np.ndarray,
    found: np.ndarray,
) -> None:
    """Add what a wrench on an interface, in N, does on the modes of its body."""
    own, turning = rotated_back(G, force), rotated_back(G, moment)
    for j in range(body[COUNT]):
        v, w = _moved_by_mode(flexible, rows, row, body, j, work, modal)
        found[body[DETA] + j, column] += dot(v, own) + dot(w, turning)


@kernel
def _hand_to_ground(
    tables: Tables,
    flexible: FlexibleTables,
    i: int,
    force: Numbers,
    moment: Numbers,
    column: int,
    work: np.ndarray,
    modal: np.ndarray,
    found: np.ndarray,
) -> None:
    """Write what a wrench on a link does along all speeds between the link and the ground, and the same as a row."""
    rows = tables.rows
    while i >= 0:
        if rows[i, KIND] == INTERFACE:
            body = flexible.bodies[rows[rows[i, PARENT], FLEXIBLE]]
            first, count = body[DETA], body[COUNT]
            G = matrix(work, rows[i, PARENT], R)
            _add_to_modes(flexible, rows, i, body, G, force, moment, column, work, modal, found)
        else:
            first, count = rows[i, SPEED], _add_to_joint(tables, i, force, moment, column, work, found)
        for s in range(first, first + count):
            found[column, s] = found[s, column]
        moment = plus(moment, cross(vector(work, i, OFFSET), force))
        i = rows[i, PARENT]


@inlined
def _add_to_joint(
    tables: Tables, i: int, force: Numbers, moment: Numbers, column: int, work: np.ndarray, found: np.ndarray
) -> int:
    """Write what a wrench on a link does along the speeds of its joint; return how many these are."""
    kind, speed = tables.rows[i, KIND], tables.rows[i, SPEED]
    if kind == FIXED:
        return 0
    if kind <= GIVEN:
        v, w = partials(tables.rows, tables.geometry, i, work)
        found[speed, column] = dot(v, force) + dot(w, moment)
        return 1
    count = 0
    if kind == FREE:
        along = rotated_back(fixed_axes(tables, i, work), force)
        found[speed, column], found[speed + 1, column], found[speed + 2, column] = along
        count = 3
    about, at = rotated_back(matrix(work, i, R), moment), speed + count
    found[at, column], found[at + 1, column], found[at + 2, column] = about
    return count + 3


@kernel
def _transform_columns(found: np.ndarray, first: int, transform: np.ndarray, column: np.ndarray) -> None:
    """Replace the entries of all columns that belong to the modes of a body by those of the user's coordinates."""
    k = len(column)
    for c in range(found.shape[1]):
        copy(found[first : first + k, c], column)
        for j in range(k):
            found[first + j, c] = total(transform[j], column)


@kernel
def _transform_rows(found: np.ndarray, first: int, transform: np.ndarray, row: np.ndarray) -> None:
    """Do the same in all rows."""
    k = len(row)
    for i in range(len(found)):
        copy(found[i, first : first + k], row)
        for j in range(k):
            found[i, first + j] = total(transform[j], row)


def masses_memory_size(tables: Tables, flexible: FlexibleTables) -> int:
    """Return how many numbers the memory of `put_masses` has."""
    return WORK * len(tables.rows) + int(flexible.sizes[MODAL_SIZE] + flexible.bodies[:, COUNT].max(initial=0))
