"""The second outward sweep: du of every joint and mode (Eq. 18)."""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.vectors import (
    cross,
    dot,
    matrix,
    minus,
    plus,
    put,
    put_three,
    rotated,
    rotated_back,
    symmetric,
    symmetric_times,
    three,
    times,
    vector,
)
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.layout import (
    ACCELERATION,
    ALPHA,
    DRIVE,
    DRIVING,
    FIXED,
    FLEXIBLE,
    FORCE,
    GIVEN,
    INTERFACE,
    KIND,
    MOMENT,
    OFFSET,
    PARENT,
    PIVOT,
    REVOLUTE,
    SPEED,
    SPHERICAL,
    FlexibleTables,
    H,
    J,
    M,
    R,
    Tables,
    U,
)
from kanefe.kernels.sweeps.inward import moved_freely
from kanefe.kernels.sweeps.link_motion import fixed_axes, partials
from kanefe.kernels.sweeps.modal_elimination import modal_accelerations


@kernel
def sweep_accelerations(
    tables: Tables,
    flexible: FlexibleTables,
    applied: np.ndarray,
    work: np.ndarray,
    modal: np.ndarray,
    border: np.ndarray,
    is_implicit: bool,
    du: np.ndarray,
) -> None:
    """Write du of the free speeds, and the share of du in the acceleration of every row."""
    rows = tables.rows
    for i in range(len(rows)):
        if rows[i, KIND] == INTERFACE:  # its body has written it
            continue
        accelerate_link(tables, i, applied, work, du)
        if rows[i, FLEXIBLE] >= 0:
            modal_accelerations(flexible, rows[i, FLEXIBLE], work, modal, border, is_implicit, du)


@inlined
def accelerate_link(tables: Tables, i: int, applied: np.ndarray, work: np.ndarray, du: np.ndarray) -> None:
    """Write du of the joint of a link, and the share of du in the acceleration of the link."""
    rows, geometry = tables.rows, tables.geometry
    kind, parent, speed = rows[i, KIND], rows[i, PARENT], rows[i, SPEED]
    zero = 0.0 * work[i, R]
    a, alpha = (zero, zero, zero), (zero, zero, zero)
    if parent >= 0:
        alpha = vector(work, parent, ALPHA)
        a = plus(vector(work, parent, ACCELERATION), cross(alpha, vector(work, i, OFFSET)))
    if kind == FIXED or (kind <= GIVEN and rows[i, DRIVE] >= 0):
        pass
    elif kind <= GIVEN:
        linear, angular = vector(work, i, U), vector(work, i, U + 3)
        rate = work[i, DRIVING] - work[i, PIVOT] * (dot(linear, a) + dot(angular, alpha))
        du[speed] = rate
        if kind == REVOLUTE:
            alpha = plus(alpha, times(rate, (work[i, R + 2], work[i, R + 5], work[i, R + 8])))
        else:
            v, w = partials(rows, geometry, i, work)
            a, alpha = plus(a, times(rate, v)), plus(alpha, times(rate, w))
    elif kind == SPHERICAL:
        axes, carried = matrix(work, i, R), alpha
        turning = minus(rotated(axes, three(applied, speed)), vector(work, i, MOMENT))
        turning = minus(turning, rotated_back(matrix(work, i, H), a))
        alpha = symmetric_times(symmetric(work, i, U), turning)
        put_three(du, speed, rotated_back(axes, minus(alpha, carried)))
    else:  # FREE: the body moves as if alone
        axes, carried, moving = matrix(work, i, R), alpha, a
        fixed = fixed_axes(tables, i, work)
        force = minus(rotated(fixed, three(applied, speed)), vector(work, i, FORCE))
        moment = minus(rotated(axes, three(applied, speed + 3)), vector(work, i, MOMENT))
        a, alpha = moved_freely(i, force, moment, work)
        put_three(du, speed, rotated_back(fixed, minus(a, moving)))
        put_three(du, speed + 3, rotated_back(axes, minus(alpha, carried)))
    put(work, i, ACCELERATION, a)
    put(work, i, ALPHA, alpha)


@kernel
def put_driving_forces(tables: Tables, applied: np.ndarray, work: np.ndarray, forces: np.ndarray) -> None:
    """Write the forces that driven coordinates need beyond what is applied to them."""
    rows, geometry = tables.rows, tables.geometry
    for i in range(len(rows)):
        drive = rows[i, DRIVE]
        if drive < 0:
            continue
        v, w = partials(rows, geometry, i, work)
        a, alpha = vector(work, i, ACCELERATION), vector(work, i, ALPHA)
        h = matrix(work, i, H)
        force = plus(vector(work, i, FORCE), plus(symmetric_times(symmetric(work, i, M), a), rotated(h, alpha)))
        moment = plus(vector(work, i, MOMENT), plus(rotated_back(h, a), symmetric_times(symmetric(work, i, J), alpha)))
        forces[drive] = dot(v, force) + dot(w, moment) - applied[rows[i, SPEED]]
