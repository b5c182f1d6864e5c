"""Forces along single joint coordinates: springs, dampers, stops and motors."""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels.algebra.vectors import Numbers
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.layout import Tables
from kanefe.kernels.planar.layout import PlanarTables

STIFFNESS_OF, DAMPING_OF, REST, LOWER, UPPER, STOP_STIFFNESS, STOP_DAMPING = range(7)


@kernel
def add_joint_forces(
    tables: Tables | PlanarTables,
    drives: np.ndarray,
    inputs: np.ndarray,
    q: np.ndarray,
    u: np.ndarray,
    applied: np.ndarray,
) -> Numbers:
    """Add the forces along joint coordinates to `applied`; return the power dissipated and that of motors."""
    dissipated = work = 0.0 * applied.sum()
    for n in range(len(tables.joint_forces)):
        at, speed, law, motor = tables.joint_forces[n]
        if at >= 0:
            position, rate = q[at], u[speed]
        else:
            zero = 0.0 * dissipated
            position, rate = zero + drives[-1 - at, 0], zero + drives[-1 - at, 1]
        if law >= 0:
            conservative, dissipative = coordinate_force(tables.laws[law], position, rate)
            applied[speed] += conservative + dissipative
            dissipated -= dissipative * rate
        if motor >= 0:
            applied[speed] += inputs[motor]
            work += inputs[motor] * rate
    return dissipated, work


@inlined
def coordinate_force(law: np.ndarray, position: Any, rate: Any) -> Numbers:
    """Return the conservative and the dissipative force along a coordinate."""
    conservative = -law[STIFFNESS_OF] * (position - law[REST])
    dissipative = -law[DAMPING_OF] * rate
    beyond = 0.0 * position
    if position.real > law[UPPER]:
        beyond = position - law[UPPER]
    elif position.real < law[LOWER]:
        beyond = position - law[LOWER]
    if beyond.real != 0.0:
        stop, brake = -law[STOP_STIFFNESS] * beyond, -law[STOP_DAMPING] * rate
        if (stop + brake).real * beyond.real > 0.0:  # a stop never pulls
            brake = -stop
        conservative += stop
        dissipative += brake
    return conservative, dissipative
