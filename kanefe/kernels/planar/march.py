"""The order-n equations of planar scenes, with three speeds a body at most: what Python calls."""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels._numba import entry_without_arrays
from kanefe.kernels.drives import put_drives
from kanefe.kernels.implicit import stiffen_joints
from kanefe.kernels.joint_forces import add_joint_forces
from kanefe.kernels.layout import COORDINATES, DRIVES, SPEEDS, STATES
from kanefe.kernels.planar.cosines import put_cosines
from kanefe.kernels.planar.inward import sweep_accelerations, sweep_inward
from kanefe.kernels.planar.layout import WORK, PlanarTables
from kanefe.kernels.planar.outward import add_point_loads, set_ground, sweep_outward, sweep_turns
from kanefe.kernels.stepping import (
    AT,
    IMPLICIT,
    LARGEST_OF_DRIVES,
    NO_INERTIA,
    NOT_FINITE,
    PUSH_DAMPING,
    PUSH_STIFFNESS,
    RATES,
    SHARE_DAMPING,
    SHARE_STIFFNESS,
    SLOPE,
    TIME_AT,
    Run,
    go_on,
    is_finite,
)


def room_size(tables: PlanarTables) -> int:
    """Return how many numbers `march_planar` needs room for."""
    return (WORK + 3) * len(tables.rows) + 2 * (tables.sizes[SPEEDS] + tables.sizes[DRIVES])


@entry_without_arrays
def march_planar(
    tables: PlanarTables,
    drives: np.ndarray,
    motions: Any,
    fill: Any,
    t: float,
    inputs: np.ndarray,
    vectors: np.ndarray,
    share_damping: float,
    share_stiffness: float,
    run: Run | None,
    room: np.ndarray,
) -> tuple[int, float]:
    """Evaluate dy/dt once, or go on with a run, as `kanefe.kernels.march.march` does in space.

    States, drives, inputs and what is returned are the same; `weakest` is 1, as of a scene without constraints.
    """
    n, m = tables.sizes[COORDINATES], tables.sizes[SPEEDS]
    first_work = n + m + tables.sizes[STATES]
    rows, speeds = len(tables.rows), m + tables.sizes[DRIVES]
    work = room[: WORK * rows].reshape(rows, WORK)
    room = room[WORK * rows :]
    angles, cosines, sines, room = room[:rows], room[rows : 2 * rows], room[2 * rows : 3 * rows], room[3 * rows :]
    applied, added = room[:speeds], room[speeds:]
    set_ground(work, angles)
    at, rates = vectors[AT], vectors[SLOPE]
    q, u, du = at[:n], at[n : n + m], rates[n : n + m]
    is_implicit = len(vectors) > PUSH_STIFFNESS
    while True:
        if run is not None:
            command = go_on(run, vectors)
            if command != RATES and command != IMPLICIT:
                return command, 1.0
            is_implicit = command == IMPLICIT
            t = run.reals[TIME_AT]
            share_damping, share_stiffness = run.reals[SHARE_DAMPING], run.reals[SHARE_STIFFNESS]
            run.reals[LARGEST_OF_DRIVES] = put_drives(motions, t, drives)
        sweep_turns(tables, drives, q, u, angles, work)
        put_cosines(angles, cosines, sines)
        sweep_outward(tables, drives, q, u, rates, cosines, sines, len(tables.loads) > 0, work)
        applied[:] = 0.0
        if run is not None:
            fill(t, at, inputs)
        work_of_loads = add_point_loads(tables, inputs, work)
        dissipated, work_of_motors = add_joint_forces(tables, drives, inputs, q, u, applied)
        if is_implicit:
            pushes = vectors[PUSH_DAMPING, n : n + m], vectors[PUSH_STIFFNESS, n : n + m]
            stiffen_joints(tables, share_damping, share_stiffness, pushes[0], pushes[1], q, u, applied, added)
        is_regular = sweep_inward(tables, drives, applied, work, is_implicit, added)
        work_of_drives = sweep_accelerations(tables, drives, applied, work, du)
        rates[n + m : first_work] = 0.0
        rates[first_work] = dissipated
        rates[first_work + 1] = work_of_loads + work_of_motors + work_of_drives
        if not is_regular:
            return NO_INERTIA, 1.0
        if run is None:
            return RATES if is_finite(rates) else NOT_FINITE, 1.0
