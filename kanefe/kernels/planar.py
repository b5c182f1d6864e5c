"""The order-n equations of planar scenes, with three speeds a body at most: what Python calls."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from kanefe.kernels._numba import entry
from kanefe.kernels.cosines import put_cosines
from kanefe.kernels.joint_forces import add_joint_forces
from kanefe.kernels.layout import COORDINATES, DRIVES, SPEEDS
from kanefe.kernels.planar_inward import sweep_accelerations, sweep_inward
from kanefe.kernels.planar_layout import WORK, PlanarTables
from kanefe.kernels.planar_loads import add_point_loads
from kanefe.kernels.planar_outward import set_ground, sweep_outward, sweep_turns
from kanefe.kernels.runge_kutta import NO_INERTIA, NOT_FINITE, finish_stage, is_finite, stage_time


@entry
def march_planar(
    tables: PlanarTables,
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
    """Evaluate dy/dt once (steps = 0), or take steps, as `kanefe.kernels.equations.march` does in space.

    State, drives, inputs and what is returned are the same; `weakest` is 1, as of a scene without constraints.
    """
    n, m = tables.sizes[COORDINATES], tables.sizes[SPEEDS]
    rows, speeds = len(tables.rows), m + tables.sizes[DRIVES]
    room = np.empty((WORK + 3) * rows + speeds + 2 * len(y))
    work = room[: WORK * rows].reshape(rows, WORK)
    room = room[WORK * rows :]
    angles, cosines, sines, room = room[:rows], room[rows : 2 * rows], room[2 * rows : 3 * rows], room[3 * rows :]
    applied, at, sums = room[:speeds], room[speeds : speeds + len(y)], room[speeds + len(y) :]
    set_ground(work, angles)
    q, u, du = at[:n], at[n : n + m], rates[n : n + m]
    at[:] = y
    sums[:] = y
    stages = 4 * steps if steps > 0 else 1
    every = steps // len(states) if len(states) > 0 else steps + 1
    for evaluation in range(stages):
        sweep_turns(tables, drives, q, u, angles, work)
        put_cosines(angles, cosines, sines)
        sweep_outward(tables, drives, q, u, rates, cosines, sines, len(tables.loads) > 0, work)
        applied[:] = 0.0
        if fill is not None:
            fill(t + h * stage_time(evaluation), at, inputs)
        work_of_loads = add_point_loads(tables, inputs, work)
        dissipated, work_of_motors = add_joint_forces(tables, drives, inputs, q, u, applied)
        is_regular = sweep_inward(tables, drives, applied, work)
        work_of_drives = sweep_accelerations(tables, drives, applied, work, du)
        rates[n + m] = dissipated
        rates[n + m + 1] = work_of_loads + work_of_motors + work_of_drives
        if not is_regular:
            return NO_INERTIA if evaluation == 0 else evaluation // 4, 1.0
        if steps > 0:
            finish_stage(evaluation % 4, h, y, rates, at, sums)
            taken = (evaluation + 1) // 4
            if evaluation % 4 == 3 and taken % every == 0 and taken // every <= len(states):
                states[taken // every - 1] = y
    if steps == 0 and not is_finite(rates):
        return NOT_FINITE, 1.0
    return steps, 1.0
