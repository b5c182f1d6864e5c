"""The order-n equations: what Python calls."""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels._numba import entry_without_arrays, inlined
from kanefe.kernels.accelerations import put_driving_forces, sweep_accelerations
from kanefe.kernels.closing import close_size, close_state
from kanefe.kernels.constraints import Loops, hold
from kanefe.kernels.drives import put_drives
from kanefe.kernels.elastic import span, total
from kanefe.kernels.implicit import stiffen_joints, stiffen_modes
from kanefe.kernels.inertia import set_inertia
from kanefe.kernels.inward import sweep_inward
from kanefe.kernels.joint_forces import add_joint_forces
from kanefe.kernels.layout import (
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
    GIVEN,
    KIND,
    MODAL_SIZE,
    SPEED,
    SPEEDS,
    SPHERICAL,
    STATES,
    WORK,
    WORK_DETA,
    FlexibleTables,
    Tables,
)
from kanefe.kernels.loads import add_field_loads, add_point_loads
from kanefe.kernels.loads_between import LoadsBetween, add_loads_between
from kanefe.kernels.momenta import put_balance
from kanefe.kernels.outward import sweep_outward
from kanefe.kernels.stepping import (
    AT,
    BALANCE,
    IMPLICIT,
    IS_LEFT_OPEN,
    LARGEST_OF_DRIVES,
    NO_INERTIA,
    NOT_FINITE,
    PROJECT,
    PUSH_DAMPING,
    PUSH_STIFFNESS,
    RATES,
    SHARE_DAMPING,
    SHARE_STIFFNESS,
    SLOPE,
    STATE,
    STORED,
    TIME,
    TIME_AT,
    WEAKEST,
    Run,
    go_on,
    is_finite,
)
from kanefe.kernels.tolerances import NEAR_SINGULAR
from kanefe.kernels.vectors import copy, put_euler_rates, three


@inlined
def rates_of_coordinates(
    tables: Tables, flexible: FlexibleTables | None, q: np.ndarray, u: np.ndarray, rates: np.ndarray
) -> None:
    """Write dq/dt."""
    rows = tables.rows
    for i in range(len(rows)):
        kind, at, speed = rows[i, KIND], rows[i, COORDINATE], rows[i, SPEED]
        if FIXED < kind <= GIVEN:
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


@inlined
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


def room_size(
    tables: Tables,
    flexible: FlexibleTables | None,
    between: LoadsBetween | None,
    loops: Loops | None,
    state: int,
) -> int:
    """Return how many numbers `march` needs room for, with so many in a state."""
    speeds = tables.sizes[SPEEDS] + tables.sizes[DRIVES]
    size = WORK * len(tables.rows) + 2 * speeds + tables.sizes[DRIVES] + state
    if flexible is not None:
        size += flexible.sizes[MODAL_SIZE] + flexible.sizes[BORDER_SIZE]
    if between is not None:
        size += between.room[0]
    if loops is not None:
        size += len(loops.rows) + close_size(len(loops.rows), speeds, tables.sizes[COORDINATES])
    return size


@entry_without_arrays
def march(
    tables: Tables,
    flexible: FlexibleTables | None,
    between: LoadsBetween | None,
    loops: Loops | None,
    drives: np.ndarray,
    motions: Any,
    fill: Any,
    t: float,
    inputs: np.ndarray,
    vectors: np.ndarray,
    share_damping: float,
    share_stiffness: float,
    run: Run | None,
    numbers: np.ndarray,
) -> tuple[int, float]:
    """Evaluate dy/dt once, or go on with a run until its method wants what is not to be had here.

    One function for both, since the time to compile a function includes all that it calls. States are
    ``(q, u, z, energy dissipated, work)``, of `coordinates + free + states + 2` numbers.

    Parameters
    ----------
    tables : Tables
    flexible, between, loops : FlexibleTables, LoadsBetween, Loops or None
        None leaves out their code.
    drives : ndarray, shape (driven, 3)
        Position, speed and acceleration of the driven coordinates.
    motions : Drives
        Of a run, which writes `drives` by them. Of one evaluation None: the drives are as given.
    fill : function (t, y, inputs)
        Of a run: writes the values of loads that are compiled functions. Of one evaluation None.
    t : float
        Time of the one evaluation, s.
    inputs : ndarray
        Values of loads.
    vectors : ndarray, shape (2 or more, state)
        The state and, on return, dy/dt; two pushes follow for a linearly implicit evaluation, which gives ``z`` in the
        place of du: see `kanefe.kernels.implicit`. Of a run: all vectors of the method.
    share_damping, share_stiffness : float
        s and r of a linearly implicit evaluation.
    run : Run or None
        None: one evaluation.
    numbers : ndarray, shape (`room_size`,)
        Room, of the type of the vectors.

    Returns
    -------
    command : int
        Of one evaluation RATES, or NO_INERTIA along a joint, or rates that are NOT_FINITE. Of a run: what the method
        wants, ACCEPTED where the outputs or the steps have come to their end; RATES, IMPLICIT or PROJECT where the
        loops could not be closed, or only they hold what has no inertia.
    weakest : float
        Smallest pivot of a constraint met, of 1: it falls to zero towards a singular position.
    """
    sizes = tables.sizes
    n, m, k = sizes[COORDINATES], sizes[SPEEDS], sizes[STATES]
    speeds, rows, modes, borders, held, closings = m + sizes[DRIVES], WORK * len(tables.rows), 0, 0, 0, 0
    if flexible is not None:
        modes, borders = flexible.sizes[MODAL_SIZE], flexible.sizes[BORDER_SIZE]
    if loops is not None:
        held = len(loops.rows)
        closings = close_size(held, speeds, n)
    work, room = numbers[:rows].reshape(-1, WORK), numbers[rows:]
    modal, border, room = room[:modes], room[modes : modes + borders], room[modes + borders :]
    applied, added, room = room[:speeds], room[speeds : 2 * speeds], room[2 * speeds :]
    driving, multipliers, room = room[: len(drives)], room[len(drives) : len(drives) + held], room[len(drives) + held :]
    closing, asked = room[:closings], room[closings : closings + len(vectors[AT])]
    acting = room[closings + len(vectors[AT]) :]
    at, slope = vectors[AT], vectors[SLOPE]
    q, u, du, z = at[:n], at[n : n + m], slope[n : n + m], at[n + m : n + m + k]
    z_rates, powers = slope[n + m : n + m + k], slope[n + m + k :]
    is_implicit, is_beside, weakest, command = len(vectors) > PUSH_STIFFNESS, False, 1.0, RATES
    stored = 0 if run is None else run.integers[STORED]
    while True:
        if run is not None and not is_beside:
            command = go_on(run, vectors)
            if loops is not None:
                share = run.reals[SHARE_STIFFNESS]
                while stored < run.integers[STORED]:
                    if not close_state(
                        tables, flexible, loops, motions, drives, run.times[stored], share, run.states[stored],
                        work, modal, border, closing,
                    ):  # fmt: skip
                        run.integers[IS_LEFT_OPEN] = 1
                    stored += 1
                if command == PROJECT and close_state(
                    tables, flexible, loops, motions, drives, run.reals[TIME], share, vectors[STATE],
                    work, modal, border, closing,
                ):  # fmt: skip
                    continue
            if command != RATES and command != IMPLICIT and command != BALANCE:
                return command, weakest
            is_implicit = command == IMPLICIT
            t = run.reals[TIME_AT]
            share_damping, share_stiffness = run.reals[SHARE_DAMPING], run.reals[SHARE_STIFFNESS]
        if run is not None:
            run.reals[LARGEST_OF_DRIVES] = put_drives(motions, t, drives)
        rates_of_coordinates(tables, flexible, q, u, slope)
        sweep_outward(tables, flexible, drives, q, u, work, modal)
        set_inertia(tables, flexible, work, modal)
        if run is not None and command == BALANCE:
            kept = work, modal, acting
            put_balance(tables, flexible, between, t, drives, inputs, q, z, *kept, run.integers, run.reals, vectors)
            continue
        applied[:] = 0.0
        z_rates[:] = 0.0
        if run is not None:
            fill(t, at, inputs)
        powers[1] = add_point_loads(tables, flexible, inputs, work, modal)
        dissipated, motors = add_joint_forces(tables, drives, inputs, q, u, applied)
        powers[0] = dissipated
        powers[1] += motors
        if flexible is not None:
            powers[0] += modal_dissipation(flexible, modal, powers)
            powers[1] += add_field_loads(flexible, inputs, work, modal)
        if between is not None:
            taken, given = add_loads_between(between, tables.rows, flexible, t, inputs, z, z_rates, work, modal, acting)
            powers[0] += taken
            powers[1] += given
        if is_implicit:
            pushes = vectors[PUSH_DAMPING, n : n + m], vectors[PUSH_STIFFNESS, n : n + m]
            stiffen_joints(tables, share_damping, share_stiffness, pushes[0], pushes[1], q, u, applied, added)
            if flexible is not None:
                stiffen_modes(flexible, share_damping, share_stiffness, pushes[0], pushes[1], modal)
        is_regular = sweep_inward(tables, flexible, applied, work, modal, border, is_implicit, added)
        sweep_accelerations(tables, flexible, applied, work, modal, border, is_implicit, du)
        if len(driving) > 0:
            put_driving_forces(tables, applied, work, driving)
        if loops is not None:
            pivot = hold(
                loops, tables, flexible, drives, z, applied, work, modal, border, du, driving, multipliers, closing,
                is_implicit,
            )  # fmt: skip
            weakest = min(weakest, pivot)
            if run is not None:
                if is_beside:
                    copy(asked, at)
                    is_beside = False
                else:
                    run.reals[WEAKEST] = pivot
                    if pivot < NEAR_SINGULAR or not is_regular:
                        copy(at, asked)
                        is_beside = is_regular and close_state(
                            tables, flexible, loops, motions, drives, t, 0.0, at, work, modal, border, closing
                        )
                        if is_beside:
                            continue
                        return command, weakest
        for i in range(len(driving)):
            powers[1] += driving[i] * drives[i, 1]
        if not is_regular:
            return NO_INERTIA, weakest
        if run is None:
            return RATES if is_finite(slope) else NOT_FINITE, weakest
