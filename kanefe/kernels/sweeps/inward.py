"""The inward sweep: each body's own speeds, elastic and of its joint, are eliminated from its articulated inertia.

The row's parent sees ``force = M a + H alpha + f`` and ``moment = H^T a + J alpha + n`` with a and alpha the share of
du in the parent's acceleration. (Featherstone 1983 for rigid bodies; the elastic border: `eliminate_modes`.)
"""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels.algebra.vectors import (
    Numbers,
    accumulate,
    cross,
    dot,
    matrix,
    minus,
    plus,
    put,
    put_symmetric,
    rotated,
    rotated_back,
    symmetric,
    symmetric_inverse,
    symmetric_times,
    three,
    times,
    vector,
)
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.layout import (
    DRIVE,
    DRIVING,
    FIXED,
    FLEXIBLE,
    FORCE,
    FREE,
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
from kanefe.kernels.sweeps.body_inertia import hand_force_inward, hand_inward
from kanefe.kernels.sweeps.link_motion import partials
from kanefe.kernels.sweeps.modal_elimination import eliminate_modal_forces, eliminate_modes

ROUND_OFF = 1e-14
"""Inertia along another direction, relative to the largest inertia of a body, below which it is round-off and counts as
zero."""


@inlined
def has_inverse(S: Numbers, inverse: Numbers) -> bool:
    """Return whether inertias along all directions are above the round-off of the largest: by the two traces."""
    spread = ((S[0] + S[3] + S[5]) * (inverse[0] + inverse[3] + inverse[5])).real
    return 0.0 < spread < 1.0 / ROUND_OFF  # also false for what is not a number


@kernel
def sweep_inward(
    tables: Tables,
    flexible: FlexibleTables,
    applied: np.ndarray,
    work: np.ndarray,
    modal: np.ndarray,
    border: np.ndarray,
    is_implicit: bool,
    added: np.ndarray,
) -> bool:
    """Eliminate all rows, children before parents; return whether every joint has inertia along it.

    Parameters
    ----------
    applied : ndarray, shape (free + driven,)
        Generalised forces at the joints.
    is_implicit : bool
        Whether the modes are scaled and `added` counts, see `kanefe.kernels.sweeps.implicit`.
    added : ndarray, shape (free + driven,)
        Inertia added along the joints.
    """
    rows, is_regular = tables.rows, True
    for i in range(len(rows) - 1, -1, -1):
        if rows[i, KIND] == INTERFACE:  # its body takes what it carries
            continue
        if rows[i, FLEXIBLE] >= 0:
            eliminate_modes(rows, flexible, rows[i, FLEXIBLE], work, modal, border, is_implicit)
        is_regular = eliminate_joint(tables, i, applied, work, is_implicit, added) and is_regular
    return is_regular


@inlined
def eliminate_joint(
    tables: Tables, i: int, applied: np.ndarray, work: np.ndarray, is_implicit: bool, added: np.ndarray
) -> bool:
    """Eliminate the joint of a link and hand what is left inward; return whether it has inertia along the joint."""
    rows, geometry, is_regular = tables.rows, tables.geometry, True
    kind, parent, speed = rows[i, KIND], rows[i, PARENT], rows[i, SPEED]
    if kind == FREE:
        m, h, j = symmetric(work, i, M), matrix(work, i, H), symmetric(work, i, J)
        inverse = symmetric_inverse(m)
        put_symmetric(work, i, U, inverse)
        kept = about_freely(j, h, inverse)
        turning = symmetric_inverse(kept)
        put_symmetric(work, i, J, turning)  # from here on
        is_regular = has_inverse(m, inverse) and has_inverse(kept, turning)
        return is_regular
    m, h, j = symmetric(work, i, M), matrix(work, i, H), symmetric(work, i, J)
    force, moment = vector(work, i, FORCE), vector(work, i, MOMENT)
    if kind == SPHERICAL:
        inverse = symmetric_inverse(j)
        put_symmetric(work, i, U, inverse)
        is_regular = has_inverse(j, inverse)
        if parent >= 0:
            torque = rotated(matrix(work, i, R), three(applied, speed))
            m, force = at_point(m, h, inverse, force, minus(moment, torque))
            hand_force_inward(work, parent, vector(work, i, OFFSET), m, force, torque)
        return is_regular
    if kind != FIXED and rows[i, DRIVE] < 0:
        if kind == REVOLUTE:
            axis = (work[i, R + 2], work[i, R + 5], work[i, R + 8])
            linear, angular = rotated(h, axis), symmetric_times(j, axis)
            inertia = dot(axis, angular)
            rest = applied[speed] - dot(axis, moment)
            largest = j[0] + j[3] + j[5]
        else:
            v, w = partials(rows, geometry, i, work)
            linear = plus(symmetric_times(m, v), rotated(h, w))
            angular = plus(rotated_back(h, v), symmetric_times(j, w))
            inertia = dot(v, linear) + dot(w, angular)
            rest = applied[speed] - dot(v, force) - dot(w, moment)
            largest = dot(v, v) * (m[0] + m[3] + m[5]) + dot(w, w) * (j[0] + j[3] + j[5])
        if is_implicit:
            inertia += added[speed]
        is_regular = inertia.real > ROUND_OFF * largest.real
        pivot = 1.0 / inertia
        rest = rest * pivot
        put(work, i, U, linear)
        put(work, i, U + 3, angular)
        work[i, PIVOT] = pivot
        work[i, DRIVING] = rest
        if parent < 0:
            return is_regular
        e, d = times(pivot, linear), times(pivot, angular)
        m = (
            m[0] - linear[0] * e[0], m[1] - linear[0] * e[1], m[2] - linear[0] * e[2],
            m[3] - linear[1] * e[1], m[4] - linear[1] * e[2], m[5] - linear[2] * e[2],
        )  # fmt: skip
        h = (
            h[0] - linear[0] * d[0], h[1] - linear[0] * d[1], h[2] - linear[0] * d[2],
            h[3] - linear[1] * d[0], h[4] - linear[1] * d[1], h[5] - linear[1] * d[2],
            h[6] - linear[2] * d[0], h[7] - linear[2] * d[1], h[8] - linear[2] * d[2],
        )  # fmt: skip
        j = (
            j[0] - angular[0] * d[0], j[1] - angular[0] * d[1], j[2] - angular[0] * d[2],
            j[3] - angular[1] * d[1], j[4] - angular[1] * d[2], j[5] - angular[2] * d[2],
        )  # fmt: skip
        force, moment = plus(force, times(rest, linear)), plus(moment, times(rest, angular))
    if parent >= 0:
        hand_inward(work, parent, vector(work, i, OFFSET), m, h, j, force, moment)
    return is_regular


@inlined
def about_freely(j: Numbers, h: Numbers, inverse: Numbers) -> Numbers:
    """Return the inertia that a free body shows against turning: J - H^T M^-1 H."""
    first, second, third = (h[0], h[3], h[6]), (h[1], h[4], h[7]), (h[2], h[5], h[8])
    x, y, z = symmetric_times(inverse, first), symmetric_times(inverse, second), symmetric_times(inverse, third)
    return (
        j[0] - dot(x, first), j[1] - dot(x, second), j[2] - dot(x, third),
        j[3] - dot(y, second), j[4] - dot(y, third), j[5] - dot(z, third),
    )  # fmt: skip


@inlined
def at_point(m: Numbers, h: Numbers, inverse: Numbers, force: Numbers, turning: Numbers) -> tuple[Numbers, Numbers]:
    """Return mass and force that a body on a spherical joint shows at the joint: M - H J^-1 H^T."""
    first, second, third = (h[0], h[1], h[2]), (h[3], h[4], h[5]), (h[6], h[7], h[8])
    x, y, z = symmetric_times(inverse, first), symmetric_times(inverse, second), symmetric_times(inverse, third)
    kept = (
        m[0] - dot(x, first), m[1] - dot(x, second), m[2] - dot(x, third),
        m[3] - dot(y, second), m[4] - dot(y, third), m[5] - dot(z, third),
    )  # fmt: skip
    return kept, minus(force, (dot(x, turning), dot(y, turning), dot(z, turning)))


@inlined
def through_axis(
    rows: np.ndarray, geometry: np.ndarray, i: int, applied: Any, force: Numbers, moment: Numbers, work: np.ndarray
) -> tuple[Any, Numbers, Numbers]:
    """Return the acceleration along a link's coordinate by what it needs from its parent, and what is left of that."""
    v, w = partials(rows, geometry, i, work)
    rest = work[i, PIVOT] * (applied - dot(v, force) - dot(w, moment))
    return rest, plus(force, times(rest, vector(work, i, U))), plus(moment, times(rest, vector(work, i, U + 3)))


@inlined
def through_ball(
    i: int, torque: Numbers, force: Numbers, moment: Numbers, work: np.ndarray
) -> tuple[Numbers, Numbers, Numbers]:
    """Return the same for a spherical joint: its turning is against its angular acceleration."""
    turning = symmetric_times(symmetric(work, i, U), minus(moment, torque))
    return turning, minus(force, rotated(matrix(work, i, H), turning)), torque


@inlined
def moved_freely(i: int, force: Numbers, moment: Numbers, work: np.ndarray) -> tuple[Numbers, Numbers]:
    """Return the accelerations of a free body by what acts on it, with the inverses that `eliminate_joint` has left."""
    h, inverse = matrix(work, i, H), symmetric(work, i, U)
    rest = minus(moment, rotated_back(h, symmetric_times(inverse, force)))
    alpha = symmetric_times(symmetric(work, i, J), rest)
    return symmetric_times(inverse, minus(force, rotated(h, alpha))), alpha


@kernel
def sweep_forces_inward(
    tables: Tables,
    flexible: FlexibleTables,
    applied: np.ndarray,
    work: np.ndarray,
    modal: np.ndarray,
    border: np.ndarray,
    is_implicit: bool,
) -> None:
    """Hand other forces inward over the inertias that `sweep_inward` has left: what follows are their accelerations."""
    rows = tables.rows
    for i in range(len(rows) - 1, -1, -1):
        if rows[i, KIND] == INTERFACE:
            continue
        if rows[i, FLEXIBLE] >= 0:
            eliminate_modal_forces(flexible, rows[i, FLEXIBLE], work, modal, border, is_implicit)
        hand_through_joint(tables, i, applied, work)


@inlined
def hand_through_joint(tables: Tables, i: int, applied: np.ndarray, work: np.ndarray) -> None:
    """Hand the force of a link inward through its joint, which gives way."""
    rows, geometry = tables.rows, tables.geometry
    kind, parent, speed = rows[i, KIND], rows[i, PARENT], rows[i, SPEED]
    if kind == FREE:
        return
    force, moment = vector(work, i, FORCE), vector(work, i, MOMENT)
    if kind == SPHERICAL:
        torque = rotated(matrix(work, i, R), three(applied, speed))
        _, force, moment = through_ball(i, torque, force, moment, work)
    elif kind != FIXED and rows[i, DRIVE] < 0:
        rest, force, moment = through_axis(rows, geometry, i, applied[speed], force, moment, work)
        work[i, DRIVING] = rest
    if parent >= 0:
        accumulate(work, parent, FORCE, force)
        accumulate(work, parent, MOMENT, plus(moment, cross(vector(work, i, OFFSET), force)))
