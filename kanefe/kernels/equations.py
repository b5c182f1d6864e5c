"""The order-n equations: what Python calls."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from kanefe.kernels._numba import entry, kernel
from kanefe.kernels.accelerations import put_driving_forces, sweep_accelerations
from kanefe.kernels.constraints import Loops, hold, hold_size
from kanefe.kernels.elastic import span, total
from kanefe.kernels.inertia import set_inertia
from kanefe.kernels.interactions import Interactions, add_interactions
from kanefe.kernels.inward import sweep_inward
from kanefe.kernels.joint_forces import add_joint_forces
from kanefe.kernels.layout import (
    AXIS,
    BORDER_SIZE,
    COORDINATE,
    COORDINATES,
    COUNT,
    DAMPING,
    DETA,
    DRIVE,
    DRIVES,
    ETA,
    FIXED,
    FREE,
    KIND,
    MODAL_SIZE,
    SPEED,
    SPEEDS,
    SPHERICAL,
    WORK,
    WORK_DETA,
    FlexibleTables,
    Tables,
)
from kanefe.kernels.loads import add_field_loads, add_point_loads
from kanefe.kernels.outward import sweep_outward
from kanefe.kernels.runge_kutta import NO_INERTIA, NOT_FINITE, finish_stage, is_finite, stage_time
from kanefe.kernels.vectors import put_euler_rates, three


@kernel
def rates_of_coordinates(
    tables: Tables, flexible: FlexibleTables | None, q: np.ndarray, u: np.ndarray, rates: np.ndarray
) -> None:
    """Write dq/dt."""
    rows = tables.rows
    for i in range(len(rows)):
        kind, at, speed = rows[i, KIND], rows[i, COORDINATE], rows[i, SPEED]
        if FIXED < kind <= AXIS:
            if rows[i, DRIVE] < 0:
                rates[at] = u[speed]
        elif kind == SPHERICAL:
            put_euler_rates(rates, at, q, three(u, speed))
        elif kind == FREE:
            rates[at], rates[at + 1], rates[at + 2] = u[speed], u[speed + 1], u[speed + 2]
            put_euler_rates(rates, at + 3, q, three(u, speed + 3))
    if flexible is not None:
        for f in range(len(flexible.bodies)):
            at, speed = flexible.bodies[f, ETA], flexible.bodies[f, DETA]
            for j in range(flexible.bodies[f, COUNT]):
                rates[at + j] = u[speed + j]


@kernel
def modal_dissipation(flexible: FlexibleTables, modal: np.ndarray, powers: np.ndarray) -> float:
    """Return deta^T C deta of all flexible bodies."""
    power = 0.0 * powers[1]
    for f in range(len(flexible.bodies)):
        body = flexible.bodies[f]
        if body[DAMPING] >= 0:
            k = body[COUNT]
            deta = modal[span(body, WORK_DETA)]
            C = flexible.pool[body[DAMPING] : body[DAMPING] + k * k].reshape(k, k)
            for j in range(k):
                power += deta[j] * total(C[j], deta)
    return power


@entry
def march(
    tables: Tables,
    flexible: FlexibleTables | None,
    between: Interactions | None,
    loops: Loops | None,
    drives: np.ndarray,
    fill: Callable[..., None] | None,
    t: float,
    inputs: np.ndarray,
    y: np.ndarray,
    rates: np.ndarray,
    h: float,
    steps: int,
    states: np.ndarray,
) -> tuple[int, float]:
    """Evaluate dy/dt once (steps = 0), or take steps of the classical Runge-Kutta method of order 4.

    One function for both, since the time to compile a function includes all that it calls.

    Parameters
    ----------
    tables : Tables
    flexible, between, loops : FlexibleTables, Interactions, Loops or None
        None leaves out their code.
    drives : ndarray, shape (driven, 3)
        Position, speed and acceleration of the driven coordinates.
    fill : function (t, y, inputs) or None
        Writes the values of loads that are compiled functions.
    t : float
        Time at the start, s.
    inputs : ndarray
        Values of loads.
    y : ndarray, shape (coordinates + free + 2,)
        q, u, energy dissipated and work; at the end of the steps on return.
    rates : ndarray, shape of y
        dy/dt at the last stage, on return.
    h : float
        Step in s.
    steps : int
    states : ndarray, shape (outputs, state)
        Every ``steps / outputs``-th state is stored.

    Returns
    -------
    steps : int
        Steps taken; NO_INERTIA along a joint at the start, or rates that are NOT_FINITE. Fewer than asked: the state
        is no longer finite.
    weakest : float
        Smallest pivot of a constraint met, of 1: it falls to zero towards a singular position.
    """
    sizes = tables.sizes
    n, m = sizes[COORDINATES], sizes[SPEEDS]
    speeds, rows, modes, borders, held, weakest = m + sizes[DRIVES], WORK * len(tables.rows), 0, 0, 0, 1.0
    if flexible is not None:
        modes, borders = flexible.sizes[MODAL_SIZE], flexible.sizes[BORDER_SIZE]
    if loops is not None:
        held = len(loops.rows)
    closings = hold_size(held, speeds)
    room = np.empty(rows + modes + borders + speeds + held + closings + sizes[DRIVES] + 2 * len(y), dtype=y.dtype)
    work = room[:rows].reshape(-1, WORK)
    modal = room[rows : rows + modes]
    border = room[rows + modes : rows + modes + borders]
    applied = room[rows + modes + borders : rows + modes + borders + speeds]
    room = room[rows + modes + borders + speeds :]
    multipliers, closing = room[:held], room[held : held + closings]
    driving = room[held + closings : held + closings + sizes[DRIVES]]
    room = room[held + closings + sizes[DRIVES] :]
    at, slope, sums = room[: len(y)], rates, room[len(y) :]
    at[:] = y
    sums[:] = y
    q, u, du, powers = at[:n], at[n : n + m], slope[n : n + m], slope[n + m :]
    stages = 4 * steps if steps > 0 else 1
    every = steps // len(states) if len(states) > 0 else steps + 1
    for evaluation in range(stages):
        rates_of_coordinates(tables, flexible, q, u, slope)
        sweep_outward(tables, flexible, drives, q, u, work, modal)
        set_inertia(tables, flexible, work, modal)
        applied[:] = 0.0
        if fill is not None:
            fill(t + h * stage_time(evaluation), at, inputs)
        powers[1] = add_point_loads(tables, flexible, inputs, work, modal)
        dissipated, motors = add_joint_forces(tables, drives, inputs, q, u, applied)
        powers[0] = dissipated
        powers[1] += motors
        if flexible is not None:
            powers[0] += modal_dissipation(flexible, modal, powers)
            powers[1] += add_field_loads(flexible, inputs, work, modal)
        if between is not None:
            taken, given = add_interactions(between, tables.rows, flexible, inputs, work, modal)
            powers[0] += taken
            powers[1] += given
        is_regular = sweep_inward(tables, flexible, applied, work, modal, border)
        sweep_accelerations(tables, flexible, applied, work, modal, border, du)
        if len(driving) > 0:
            put_driving_forces(tables, applied, work, driving)
        if loops is not None:
            pivot = hold(
                loops, tables, flexible, drives, applied, work, modal, border, du, driving, multipliers, closing
            )
            weakest = min(weakest, pivot)
        for i in range(len(driving)):
            powers[1] += driving[i] * drives[i, 1]
        if not is_regular:
            return NO_INERTIA if evaluation == 0 else evaluation // 4, weakest
        if steps > 0:
            finish_stage(evaluation % 4, h, y, slope, at, sums)
            taken = (evaluation + 1) // 4
            if evaluation % 4 == 3 and taken % every == 0 and taken // every <= len(states):
                states[taken // every - 1] = y
    if steps == 0 and not is_finite(slope):
        return NOT_FINITE, weakest
    return steps, weakest
