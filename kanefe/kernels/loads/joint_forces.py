"""Forces along single joint coordinates: springs, dampers, stops and motors."""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.vectors import Numbers
from kanefe.kernels.compiler._numba import kernel
from kanefe.kernels.loads.coordinate_law import coordinate_force
from kanefe.kernels.planar.layout import PlanarTables
from kanefe.kernels.scene import State
from kanefe.kernels.tables import Tables


@kernel
def add_joint_forces(tables: Tables | PlanarTables, state: State, applied: np.ndarray) -> Numbers:
    """Add the forces along joint coordinates to `applied`; return the power dissipated and that of motors."""
    dissipated = work = 0.0 * applied.sum()
    for n in range(len(tables.joint_forces)):
        at, speed, law, motor = tables.joint_forces[n]
        if at >= 0:
            position, rate = state.q[at], state.u[speed]
        else:
            zero = 0.0 * dissipated
            position, rate = zero + state.drives[-1 - at, 0], zero + state.drives[-1 - at, 1]
        if law >= 0:
            conservative, dissipative = coordinate_force(tables.laws[law], position, rate)
            applied[speed] += conservative + dissipative
            dissipated -= dissipative * rate
        if motor >= 0:
            applied[speed] += state.inputs[motor]
            work += state.inputs[motor] * rate
    return dissipated, work
