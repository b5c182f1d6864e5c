"""Forces along single joint coordinates: springs, dampers, stops and motors."""

from typing import Any

import numpy as np

from kanefe.kernels.language import Record, Rows, inlined
from kanefe.kernels.loads.coordinate_law import CoordinateLaws, coordinate_force
from kanefe.kernels.scene import State


class JointForce(Record):
    """A force along a joint coordinate."""

    coordinate: int  # -1 - drive: the coordinate is driven
    speed: int
    law: int  # its law and its input; -1: it has none
    motor: int


class JointForces(Rows[JointForce]):
    """All forces along joint coordinates: of `Tables.joint_forces`."""


@inlined
def add_joint_forces(rows: np.ndarray, laws: CoordinateLaws, state: State, applied: np.ndarray) -> tuple[Any, Any]:
    """Add the forces along joint coordinates, in rows of a table; return the power dissipated and that of motors."""
    dissipated, work, forces = 0.0, 0.0, JointForces(rows)
    for n in range(len(forces)):
        force, at = forces[n], forces[n].speed
        position, rate = along(state, force.coordinate, at)
        if force.law >= 0:
            conservative, dissipative = coordinate_force(laws[force.law], position, rate)
            applied[at] += conservative + dissipative
            dissipated -= dissipative * rate
        if force.motor >= 0:
            applied[at] += state.inputs[force.motor]
            work += state.inputs[force.motor] * rate
    return dissipated, work


@inlined
def along(state: State, coordinate: int, speed: int) -> tuple[Any, Any]:
    """Return a joint coordinate and its rate; it is driven where it is -1 - drive."""
    if coordinate >= 0:
        return state.q[coordinate], state.u[speed]
    return state.drives[-1 - coordinate, 0], state.drives[-1 - coordinate, 1]
