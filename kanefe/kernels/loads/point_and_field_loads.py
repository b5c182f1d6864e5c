"""Forces and torques on rows, and distributed loads on flexible bodies (Eq. 11, 30, 35)."""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels.algebra.vectors import (
    Numbers,
    accumulate,
    cross,
    dot,
    matrix,
    plus,
    rotated,
    rotated_back,
    three,
    times,
    vector,
)
from kanefe.kernels.compiler._numba import inlined, kernel, vector_kernel
from kanefe.kernels.layout import (
    BASIS,
    BENT,
    CARRIES,
    COUNT,
    FLEXIBLE,
    FORCE,
    INTERFACE,
    KIND,
    MOMENT,
    OFFSET,
    OMEGA,
    PARENT,
    ROW,
    TANGENT,
    VELOCITY,
    WORK_DETA,
    WORK_ETA,
    WORK_FORCE,
    R,
)
from kanefe.kernels.scene import Scene, State, Work
from kanefe.kernels.sweeps.elastic import project, span, transposed_product
from kanefe.kernels.tables import FlexibleTables, Tables


@kernel
def push(scene: Scene, work: Work, i: int, force: Numbers, moment: Numbers) -> None:
    """Apply a force and a moment, about the row's origin in N, to a row; i = -1 is N, which does not move."""
    if i < 0:
        return
    rows, frames = scene.tables.rows, work.frames.numbers
    if rows[i, KIND] == INTERFACE and not rows[i, CARRIES]:
        parent = rows[i, PARENT]
        body = scene.flexible.bodies[rows[i, FLEXIBLE]]
        share_of_modes(scene.flexible, rows, i, force, moment, frames, work.modal, work.modal[span(body, WORK_FORCE)])
        moment = plus(moment, cross(vector(frames, i, OFFSET), force))
        i = parent
    accumulate(frames, i, FORCE, (-force[0], -force[1], -force[2]))
    accumulate(frames, i, MOMENT, (-moment[0], -moment[1], -moment[2]))


@inlined
def wrench_on_slopes(
    rows: np.ndarray, i: int, force: Numbers, moment: Numbers, work: np.ndarray
) -> tuple[Numbers, Numbers]:
    """Return a force in N on an interface in G, and a moment as it acts on the rates of its slopes."""
    G = matrix(work, rows[i, PARENT], R)
    return rotated_back(G, force), rotated_back(matrix(work, i, TANGENT), rotated_back(G, moment))


@kernel
def share_of_modes(
    flexible: FlexibleTables,
    rows: np.ndarray,
    i: int,
    force: Numbers,
    moment: Numbers,
    work: np.ndarray,
    modal: np.ndarray,
    p: np.ndarray,
) -> None:
    """Add the share of the modes in what acts on an interface to the forces p on them."""
    k, at, bent = len(p), rows[i, BASIS], rows[i, BENT]
    a, b = wrench_on_slopes(rows, i, force, moment, work)
    if bent < 0:
        _add_share(flexible.pool[at : at + 6 * k].reshape(6, k), a, b, p)
    else:
        _add_share(modal[bent : bent + 6 * k].reshape(6, k), a, b, p)


@vector_kernel
def _add_share(basis: np.ndarray, a: Numbers, b: Numbers, p: np.ndarray) -> None:
    for j in range(len(p)):
        p[j] += (
            basis[0, j] * a[0]
            + basis[1, j] * a[1]
            + basis[2, j] * a[2]
            + basis[3, j] * b[0]
            + basis[4, j] * b[1]
            + basis[5, j] * b[2]
        )


@inlined
def point_load(tables: Tables, n: int, inputs: np.ndarray, work: np.ndarray) -> tuple[Numbers, Numbers]:
    """Return a force and its moment about the origin of its row, or a torque, in N."""
    i = tables.loads[n, 0]
    axes = matrix(work, i, R)
    zero = 0.0 * axes[0]
    value = three(inputs, tables.loads[n, 1])
    value = (zero + value[0], zero + value[1], zero + value[2])
    if tables.loads[n, 3]:  # follows
        value = rotated(axes, rotated(matrix(tables.points, n, 3), value))
    if tables.loads[n, 2]:  # a torque
        return (zero, zero, zero), value
    return value, cross(rotated(axes, vector(tables.points, n, 0)), value)


@kernel
def add_point_loads(scene: Scene, state: State, work: Work) -> Any:
    """Apply forces and torques; return their power."""
    tables, rows = scene.tables, work.frames.numbers
    power = 0.0 * rows[0, R]
    for n in range(len(tables.loads)):
        i = tables.loads[n, 0]
        force, moment = point_load(tables, n, state.inputs, rows)
        power += dot(force, vector(rows, i, VELOCITY)) + dot(moment, vector(rows, i, OMEGA))
        push(scene, work, i, force, moment)
    return power


@kernel
def add_field_loads(scene: Scene, state: State, work: Work) -> Any:
    """Apply tractions, line loads and pressures; return their power."""
    flexible, inputs, frames, modal = scene.flexible, state.inputs, work.frames.numbers, work.modal
    power = 0.0 * frames[0, R]
    for n in range(len(flexible.fields)):
        f, at, is_pressure, follows, pool, bending, bent = flexible.fields[n]
        body = flexible.bodies[f]
        k, i = body[COUNT], body[ROW]
        G = matrix(frames, i, R)
        zero = 0.0 * G[0]
        eta, deta, p = modal[span(body, WORK_ETA)], modal[span(body, WORK_DETA)], modal[span(body, WORK_FORCE)]
        if is_pressure:
            pressure = inputs[at]
            force = times(zero + pressure, three(flexible.pool, pool))
            moment = times(zero + pressure, three(flexible.pool, pool + 3))
            shapes = flexible.pool[pool + 6 : pool + 6 + k]
            for j in range(k):
                p[j] += pressure * shapes[j]
                power += pressure * shapes[j] * deta[j]
        else:
            t = three(inputs, at)
            t = (zero + t[0], zero + t[1], zero + t[2])
            if not follows:
                t = rotated_back(G, t)
            basis = flexible.pool[pool + 4 : pool + 4 + 3 * k].reshape(3, k)
            force = times(flexible.pool[pool], t)
            place = plus(three(flexible.pool, pool + 1), project(basis, 0, eta))
            rate = project(basis, 0, deta)
            for j in range(k):
                p[j] += t[0] * basis[0, j] + t[1] * basis[1, j] + t[2] * basis[2, j]
            if bending >= 0:
                rows = modal[bent : bent + 3 * k].reshape(3, k)
                moments = flexible.pool[bending : bending + 3 * k * k].reshape(k, 3 * k)
                transposed_product(moments, 0, eta, modal[bent : bent + 3 * k])
                place = plus(place, times(0.5, project(rows, 0, eta)))
                rate = plus(rate, project(rows, 0, deta))
                for j in range(k):
                    p[j] += t[0] * rows[0, j] + t[1] * rows[1, j] + t[2] * rows[2, j]
            moment = cross(place, t)
            power += dot(t, rate)
        force, moment = rotated(G, force), rotated(G, moment)
        power += dot(force, vector(frames, i, VELOCITY)) + dot(moment, vector(frames, i, OMEGA))
        accumulate(frames, i, FORCE, (-force[0], -force[1], -force[2]))
        accumulate(frames, i, MOMENT, (-moment[0], -moment[1], -moment[2]))
    return power
