"""One evaluation of the right-hand side of a planar scene, with three speeds a body at most."""

from typing import Any

import numpy as np

from kanefe.kernels.algebra.cosines import put_cosines
from kanefe.kernels.evaluation.evaluation import Asked, pushes_in
from kanefe.kernels.language import RealRows, Reals, entry, expanded, inlined
from kanefe.kernels.loads.coordinate_law import CoordinateLaws
from kanefe.kernels.loads.joint_forces import add_joint_forces
from kanefe.kernels.planar.inward import sweep_accelerations, sweep_inward
from kanefe.kernels.planar.layout import PlanarTables, PlanarWork
from kanefe.kernels.planar.outward import add_point_loads, set_ground, sweep_outward, sweep_turns
from kanefe.kernels.scene import Rates, State, rates_in, state_in
from kanefe.kernels.steppers.step_commands import NO_INERTIA, NOT_FINITE, RATES, VECTOR, is_finite
from kanefe.kernels.sweeps.implicit import stiffen_joints


def planar_memory_size(tables: PlanarTables) -> int:
    """Return how long the memory of an evaluation in the plane is."""
    return PlanarWork(tables.work, np.zeros(0)).size


@entry()
def evaluate_planar(
    asked: Asked, tables: PlanarTables, drives: RealRows, inputs: Reals, vectors: RealRows, memory: Reals
) -> tuple[int, float]:
    """Evaluate dy/dt, as `kanefe.kernels.evaluation.evaluation.evaluate` does in space.

    Arguments and what is returned are the same, with the tables of the plane for the scene;
    `weakest` is 1, as of a scene without constraints.
    """
    state = state_in(tables, asked.t, vectors[VECTOR.at], drives, inputs)
    rates = rates_in(tables, vectors[VECTOR.slope])
    work = PlanarWork(tables.work, memory)
    if not put_planar_rates(tables, state, work, rates, asked, vectors):
        return NO_INERTIA, 1.0
    return RATES if is_finite(vectors[VECTOR.slope]) else NOT_FINITE, 1.0


@expanded
def put_planar_rates(
    tables: PlanarTables, state: State, own: PlanarWork, rates: Rates, asked: Asked, vectors: np.ndarray
) -> bool:
    """Write dy/dt; return whether every joint has inertia along it."""
    apply_forces(tables, state, own, rates)
    if asked.is_implicit:
        pushes = pushes_in(asked, vectors, len(state.q), len(state.u))
        stiffen_joints(tables, state, pushes, own.applied, own.added)
    return accelerate_in_plane(tables, state, own, rates, asked.is_implicit)


@inlined
def apply_forces(tables: Any, state: State, own: PlanarWork, rates: Rates) -> None:
    """Write motion, inertia and forces of all rows, dq/dt, and the powers of loads.

    `tables` are `PlanarTables`, or `kanefe.kernels.planar.lanes.LanesInPlane`.
    """
    work, applied = own.work, own.applied
    set_ground(work, own.angles)
    sweep_turns(tables, state, own)
    put_cosines(own.angles, own.cosines, own.sines)
    sweep_outward(tables, state, own, rates.dq)
    applied[:] = 0.0
    rates.dz[:] = 0.0
    work_of_loads = add_point_loads(tables, state.inputs, work)
    laws = CoordinateLaws(tables.laws)
    dissipated, work_of_motors = add_joint_forces(tables.joint_forces, laws, state, applied)
    rates.powers[0] = dissipated
    rates.powers[1] = work_of_loads + work_of_motors


@inlined
def accelerate_in_plane(tables: Any, state: State, own: PlanarWork, rates: Rates, is_implicit: bool) -> bool:
    """Write du, and the power of the drives; return whether every joint has inertia along it."""
    is_regular = sweep_inward(tables, state.drives, own.applied, own.work, is_implicit, own.added)
    rates.powers[1] += sweep_accelerations(tables, state.drives, own.applied, own.work, rates.du)
    return is_regular
