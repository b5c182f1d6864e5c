"""One evaluation of the right-hand side of a planar scene, with three speeds a body at most."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kanefe.kernels.algebra.cosines import put_cosines
from kanefe.kernels.compiler._numba import expanded
from kanefe.kernels.compiler.arrays import RealRows, Reals
from kanefe.kernels.compiler.entries import entry
from kanefe.kernels.evaluation.evaluation import Asked, pushes_in
from kanefe.kernels.layout import DRIVES, SPEEDS
from kanefe.kernels.loads.joint_forces import add_joint_forces
from kanefe.kernels.planar.inward import sweep_accelerations, sweep_inward
from kanefe.kernels.planar.layout import WORK, PlanarTables
from kanefe.kernels.planar.outward import add_point_loads, set_ground, sweep_outward, sweep_turns
from kanefe.kernels.scene import Rates, State, rates_in, state_in
from kanefe.kernels.steppers.step_commands import AT, NO_INERTIA, NOT_FINITE, RATES, SLOPE, is_finite
from kanefe.kernels.sweeps.implicit import stiffen_joints


class PlanarWorkspace(NamedTuple):
    """What an evaluation writes on its way.

    Attributes
    ----------
    work : ndarray, shape (rows, WORK)
    angles, cosines, sines : ndarray, shape (rows,)
    applied, added : ndarray, shape (free + driven,)
        Generalised forces at the joints, and inertia that a linearly implicit evaluation adds along them.
    """

    work: np.ndarray
    angles: np.ndarray
    cosines: np.ndarray
    sines: np.ndarray
    applied: np.ndarray
    added: np.ndarray


def planar_workspace_size(tables: PlanarTables) -> int:
    """Return how many numbers the workspace of a planar scene has."""
    return (WORK + 3) * len(tables.rows) + 2 * (tables.sizes[SPEEDS] + tables.sizes[DRIVES])


@expanded
def planar_workspace_in(memory: np.ndarray, tables: PlanarTables) -> PlanarWorkspace:
    """Return the parts of a memory of `planar_workspace_size`, of which those that stay the same are written."""
    rows, speeds = len(tables.rows), tables.sizes[SPEEDS] + tables.sizes[DRIVES]
    work, rest = memory[: WORK * rows].reshape(rows, WORK), memory[WORK * rows :]
    angles, cosines, sines, rest = rest[:rows], rest[rows : 2 * rows], rest[2 * rows : 3 * rows], rest[3 * rows :]
    set_ground(work, angles)
    return PlanarWorkspace(work, angles, cosines, sines, rest[:speeds], rest[speeds:])


@entry()
def evaluate_planar(
    asked: Asked, tables: PlanarTables, drives: RealRows, inputs: Reals, vectors: RealRows, memory: Reals
) -> tuple[int, float]:
    """Evaluate dy/dt, as `kanefe.kernels.evaluation.evaluation.evaluate` does in space.

    Arguments and what is returned are the same, with the tables of the plane for the scene;
    `weakest` is 1, as of a scene without constraints.
    """
    state, rates = state_in(tables, asked.t, vectors[AT], drives, inputs), rates_in(tables, vectors[SLOPE])
    if not put_planar_rates(tables, state, planar_workspace_in(memory, tables), rates, asked, vectors):
        return NO_INERTIA, 1.0
    return RATES if is_finite(vectors[SLOPE]) else NOT_FINITE, 1.0


@expanded
def put_planar_rates(
    tables: PlanarTables, state: State, workspace: PlanarWorkspace, rates: Rates, asked: Asked, vectors: np.ndarray
) -> bool:
    """Write dy/dt; return whether every joint has inertia along it."""
    work, angles, cosines, sines, applied, added = workspace
    q, u, drives = state.q, state.u, state.drives
    sweep_turns(tables, drives, q, u, angles, work)
    put_cosines(angles, cosines, sines)
    sweep_outward(tables, drives, q, u, rates.dq, cosines, sines, len(tables.loads) > 0, work)

    applied[:] = 0.0
    work_of_loads = add_point_loads(tables, state.inputs, work)
    dissipated, work_of_motors = add_joint_forces(tables, state, applied)
    if asked.is_implicit:
        stiffen_joints(tables, state, pushes_in(asked, vectors, len(q), len(u)), applied, added)

    is_regular = sweep_inward(tables, drives, applied, work, asked.is_implicit, added)
    work_of_drives = sweep_accelerations(tables, drives, applied, work, rates.du)
    rates.dz[:] = 0.0
    rates.powers[0] = dissipated
    rates.powers[1] = work_of_loads + work_of_motors + work_of_drives
    return is_regular
