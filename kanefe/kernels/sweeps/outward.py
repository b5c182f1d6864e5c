"""The outward sweep: pose, velocity and remainder accelerations of every link (Eq. 3, 13-16, 22, 24-26).

Where the rows are and how they move: for functions of the user that look at the state, and for views.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels.algebra.vectors import (
    Numbers,
    accumulate,
    cross,
    matrix,
    plus,
    product,
    put,
    put_matrix,
    rotated,
    rotation,
    three,
    times,
    turned_about_z,
    vector,
)
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.compiler.arrays import RealBlocks, RealRows, Reals
from kanefe.kernels.compiler.entries import entry
from kanefe.kernels.layout import (
    ABOUT,
    ALONG,
    AXES,
    AXIS,
    BASIS,
    BENDING,
    BENT,
    COORDINATE,
    COORDINATES,
    COUNT,
    EXACT,
    FIXED,
    FLEXIBLE,
    FREE,
    INTERFACE,
    KIND,
    MODAL_SIZE,
    OFFSET,
    OMEGA,
    PARENT,
    PLACE,
    POSITION,
    REVOLUTE,
    SLOPES,
    SPEED,
    SPEEDS,
    SPHERICAL,
    TANGENT,
    VELOCITY,
    WORK,
    WORK_DETA,
    WORK_ETA,
    FlexibleTables,
    R,
    Tables,
    Y,
    Z,
)
from kanefe.kernels.sweeps.elastic import modal_state, project, span, transposed_product
from kanefe.kernels.sweeps.exact_beams import is_as_before, move_sections, section_motion
from kanefe.kernels.sweeps.link_motion import given_motion, motion_along
from kanefe.kernels.sweeps.slopes import slope_motion


@inlined
def carried(
    work: np.ndarray, i: int, parent: int, offset: Numbers, gravity: np.ndarray
) -> tuple[Numbers, Numbers, Numbers]:
    """Write offset, position and the rigid part of velocity and Z of a row; return w, Y and Z of what carries it."""
    put(work, i, OFFSET, offset)
    if parent < 0:
        zero = 0.0 * offset[0]
        w = (zero, zero, zero)
        remainder = (zero - gravity[0], zero - gravity[1], zero - gravity[2])
        put(work, i, POSITION, offset)
        put(work, i, VELOCITY, w)
        return w, w, remainder
    w, turn = vector(work, parent, OMEGA), vector(work, parent, Y)
    swing = cross(w, offset)
    put(work, i, POSITION, plus(vector(work, parent, POSITION), offset))
    put(work, i, VELOCITY, plus(vector(work, parent, VELOCITY), swing))
    remainder = plus(vector(work, parent, Z), plus(cross(turn, offset), cross(w, swing)))
    return w, turn, remainder


@inlined
def moved(work: np.ndarray, i: int, w: Numbers, remainder: Numbers, velocity: Numbers) -> Numbers:
    """Add a relative velocity of the origin to a row and return Z with its Coriolis part."""
    put(work, i, VELOCITY, plus(vector(work, i, VELOCITY), velocity))
    return plus(remainder, times(2.0, cross(w, velocity)))


@kernel
def sweep_outward(
    tables: Tables,
    flexible: FlexibleTables,
    drives: np.ndarray,
    q: np.ndarray,
    u: np.ndarray,
    work: np.ndarray,
    modal: np.ndarray,
) -> None:
    """Write pose, velocity and remainder accelerations of all links, and the state of the modes."""
    sweep_outward_again(tables, flexible, drives, q, u, False, work, modal)


@kernel
def sweep_outward_again(
    tables: Tables,
    flexible: FlexibleTables,
    drives: np.ndarray,
    q: np.ndarray,
    u: np.ndarray,
    keeps: bool,
    work: np.ndarray,
    modal: np.ndarray,
) -> None:
    """Do what `sweep_outward` does; with `keeps`, `modal` is of the last evaluation of a scene.

    Beams whose coordinates have not changed then keep the motion of their sections, and their mass.
    """
    work[0, 0] = 0.0
    zero = work[0, 0]  # of the type of the state, real or complex
    identity = (zero + 1.0, zero, zero, zero, zero + 1.0, zero, zero, zero, zero + 1.0)
    rows, geometry, gravity = tables.rows, tables.geometry, tables.gravity
    for i in range(len(rows)):
        kind, parent, at = rows[i, KIND], rows[i, PARENT], rows[i, COORDINATE]
        axes_of_parent = identity if parent < 0 else matrix(work, parent, R)
        if kind == INTERFACE:
            _interface(flexible, rows, i, vector(geometry, i, PLACE), matrix(geometry, i, AXES), work, modal)
            continue
        axes = product(axes_of_parent, matrix(geometry, i, AXES))
        offset = rotated(axes_of_parent, vector(geometry, i, PLACE))
        if kind <= AXIS:  # fixed, revolute, or along or about an axis: the axis is z
            position, rate, acceleration = zero, zero, zero
            if kind != FIXED:
                position, rate, acceleration = motion_along(rows, i, drives, q, u, zero)
            axis = (axes[2], axes[5], axes[8])
            along, about = geometry[i, ALONG], geometry[i, ABOUT]
            if kind == AXIS:
                offset = plus(offset, times(along * position, axis))
            w, turn, remainder = carried(work, i, parent, offset, gravity)
            if kind == AXIS:
                remainder = moved(work, i, w, remainder, times(along * rate, axis))
                remainder = plus(remainder, times(along * acceleration, axis))
                rate, acceleration = about * rate, about * acceleration
                if about != 0.0:
                    axes = turned_about_z(axes, about * position)
            elif kind == REVOLUTE:
                axes = turned_about_z(axes, position)
            if kind != FIXED:
                spin = times(rate, axis)
                turn = plus(turn, plus(cross(w, spin), times(acceleration, axis)))
                w = plus(w, spin)
        elif kind == SPHERICAL:
            w, turn, remainder = carried(work, i, parent, offset, gravity)
            axes = product(axes, rotation(q, at))
            spin = rotated(axes, three(u, rows[i, SPEED]))
            turn = plus(turn, cross(w, spin))
            w = plus(w, spin)
        elif kind == FREE:
            speed = rows[i, SPEED]
            offset = plus(offset, rotated(axes, three(q, at)))
            w, turn, remainder = carried(work, i, parent, offset, gravity)
            remainder = moved(work, i, w, remainder, rotated(axes, three(u, speed)))
            axes = product(axes, rotation(q, at + 3))
            spin = rotated(axes, three(u, speed + 3))
            turn = plus(turn, cross(w, spin))
            w = plus(w, spin)
        else:  # GIVEN
            position, rate, acceleration = motion_along(rows, i, drives, q, u, zero)
            place, velocity, spin, pull, twist, axes = given_motion(tables, i, axes, position, rate, acceleration, work)
            w, turn, remainder = carried(work, i, parent, plus(offset, place), gravity)
            remainder = plus(moved(work, i, w, remainder, velocity), pull)
            turn = plus(turn, plus(cross(w, spin), twist))
            w = plus(w, spin)
        put_matrix(work, i, R, axes)
        put(work, i, OMEGA, w)
        put(work, i, Z, remainder)
        put(work, i, Y, turn)
        if rows[i, FLEXIBLE] >= 0:
            is_exact = flexible.bodies[rows[i, FLEXIBLE], EXACT] >= 0
            is_kept = keeps and is_exact and is_as_before(flexible, rows[i, FLEXIBLE], q, u, modal)
            modal_state(flexible, rows[i, FLEXIBLE], q, u, modal)
            if is_exact:
                move_sections(flexible, rows[i, FLEXIBLE], is_kept, modal)


@inlined
def _by_modes(
    flexible: FlexibleTables, rows: np.ndarray, i: int, body: np.ndarray, modal: np.ndarray, zero: Any
) -> tuple[Numbers, Numbers, Numbers, Numbers, Numbers, Numbers]:
    """Return displacement, slopes, their rates and their remainders of an interface in G, from the modes."""
    k = body[COUNT]
    displacement = shift = slopes = rates = pull = twist = (zero, zero, zero)
    if k > 0:
        eta, deta = modal[span(body, WORK_ETA)], modal[span(body, WORK_DETA)]
        basis = flexible.pool[rows[i, BASIS] : rows[i, BASIS] + 6 * k].reshape(6, k)
        displacement, slopes = project(basis, 0, eta), project(basis, 3, eta)
        if rows[i, BENDING] < 0:
            shift, rates = project(basis, 0, deta), project(basis, 3, deta)
        else:
            bending = flexible.pool[rows[i, BENDING] : rows[i, BENDING] + 6 * k * k].reshape(k, 6 * k)
            bent = modal[rows[i, BENT] : rows[i, BENT] + 12 * k].reshape(12, k)
            transposed_product(bending, 0, eta, modal[rows[i, BENT] : rows[i, BENT] + 6 * k])
            transposed_product(bending, 0, deta, modal[rows[i, BENT] + 6 * k : rows[i, BENT] + 12 * k])
            displacement = plus(displacement, times(0.5, project(bent, 0, eta)))
            slopes = plus(slopes, times(0.5, project(bent, 3, eta)))
            pull, twist = project(bent, 6, deta), project(bent, 9, deta)
            for c in range(6):
                for j in range(k):
                    bent[c, j] += basis[c, j]
            shift, rates = project(bent, 0, deta), project(bent, 3, deta)
    return displacement, slopes, shift, rates, pull, twist


@kernel
def _interface(
    flexible: FlexibleTables,
    rows: np.ndarray,
    i: int,
    place: Numbers,
    at_rest: Numbers,
    work: np.ndarray,
    modal: np.ndarray,
) -> None:
    """Write the motion of an interface frame n of a flexible body (Eq. 22, 24-26)."""
    body = flexible.bodies[rows[i, FLEXIBLE]]
    parent = rows[i, PARENT]
    zero = 0.0 * work[parent, R]
    if body[EXACT] >= 0:
        offset_G, A, shift, spin_G, pull, bend = section_motion(body, rows[i, BASIS], at_rest, modal)
        T = (zero + 1.0, zero, zero, zero, zero + 1.0, zero, zero, zero, zero + 1.0)
    else:
        displacement, slopes, shift, rates, pull, twist = _by_modes(flexible, rows, i, body, modal, zero)
        A, T, bend = slope_motion(flexible.sizes[SLOPES], slopes, rates)
        bend, spin_G, offset_G = plus(bend, rotated(T, twist)), rotated(T, rates), plus(place, displacement)
    G, w, turn = matrix(work, parent, R), vector(work, parent, OMEGA), vector(work, parent, Y)
    offset, velocity, spin = rotated(G, offset_G), rotated(G, shift), rotated(G, spin_G)
    swing = cross(w, offset)
    put(work, i, OFFSET, offset)
    put(work, i, POSITION, plus(vector(work, parent, POSITION), offset))
    put(work, i, VELOCITY, plus(vector(work, parent, VELOCITY), plus(swing, velocity)))
    put(
        work,
        i,
        Z,
        plus(
            plus(plus(vector(work, parent, Z), cross(turn, offset)), cross(w, plus(swing, times(2.0, velocity)))),
            rotated(G, pull),
        ),
    )
    put(work, i, Y, plus(turn, plus(cross(w, spin), rotated(G, bend))))
    put(work, i, OMEGA, plus(w, spin))
    put_matrix(work, i, R, product(G, A))
    put_matrix(work, i, TANGENT, T)


@entry()
def motions_of_rows(
    tables: Tables,
    flexible: FlexibleTables,
    drives: RealBlocks,
    states: RealRows,
    rates: RealRows,
    found: RealBlocks,
    given: RealRows,
    memory: Reals,
) -> None:
    """Write how every row moves in all of some states.

    Parameters
    ----------
    drives : ndarray, shape (T, driven, 3)
    states : ndarray, shape (T, state)
        Each begins with q and u.
    rates : ndarray, shape (T, free), or (0, free)
        du, where accelerations are asked for.
    found : ndarray, shape (T, rows, 18 or 24)
        Position, axes to N (9), velocity, angular velocity and, with rates, acceleration and angular acceleration of
        every row, in N.
    given : ndarray, shape (driven, 3)
        Workspace, as is `memory`: WORK numbers a row, and those of the modal work.
    """
    size = WORK * len(tables.rows)
    work, modal = memory[:size].reshape(-1, WORK), memory[size:]
    n = tables.sizes[COORDINATES]
    m = n + tables.sizes[SPEEDS]
    for k in range(len(states)):
        q = states[k, :n]
        sweep_outward(tables, flexible, drives[k], q, states[k, n:m], work, modal)
        for i in range(len(tables.rows)):
            put(found[k], i, 0, vector(work, i, POSITION))
            put_matrix(found[k], i, 3, matrix(work, i, R))
            put(found[k], i, 12, vector(work, i, VELOCITY))
            put(found[k], i, 15, vector(work, i, OMEGA))
        if len(rates) == 0:
            continue
        fall = three(tables.gravity, 0)
        for i in range(len(tables.rows)):
            put(found[k], i, 18, plus(vector(work, i, Z), fall))
            put(found[k], i, 21, vector(work, i, Y))
        # a = V du + Z, alpha = W du + Y (Eq. 15, 16): the partial velocities times du are the velocities that du causes
        given[:, :] = 0.0
        for i in range(len(given)):
            given[i, 0] = drives[k, i, 0]
        sweep_outward(tables, flexible, given, q, rates[k], work, modal)
        for i in range(len(tables.rows)):
            accumulate(found[k], i, 18, vector(work, i, VELOCITY))
            accumulate(found[k], i, 21, vector(work, i, OMEGA))


def motion_memory_size(tables: Tables, flexible: FlexibleTables) -> int:
    """Return how many numbers the memory of `motions_of_rows` has."""
    return WORK * len(tables.rows) + int(flexible.sizes[MODAL_SIZE])
