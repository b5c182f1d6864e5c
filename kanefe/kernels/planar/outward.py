"""The outward sweep of a planar scene: pose, velocity, and what each body brings to its row.

Forces and torques on the rows of a planar scene (Eq. 11): what of them acts in the plane.
"""

from typing import Any

import numpy as np

from kanefe.kernels.language import inlined
from kanefe.kernels.planar.layout import AT, ROW, SHAPE, PlanarTables, PlanarWork, RowKind
from kanefe.kernels.scene import State


@inlined
def set_ground(work: np.ndarray, angles: np.ndarray) -> None:
    """Write the row of N, which does not move and takes whatever is handed to it."""
    work[0, :] = 0.0
    work[0, AT.c] = 1.0
    angles[0] = 0.0


@inlined
def sweep_turns(tables: PlanarTables, state: State, own: PlanarWork) -> None:
    """Write angle and angular velocity of every row."""
    rows, geometry, q, u, drives = tables.rows, tables.geometry, state.q, state.u, state.drives
    angles, work = own.angles, own.work
    for i in range(1, len(rows)):
        kind, parent = rows[i, ROW.kind], rows[i, ROW.parent]
        angle, w = angles[parent], work[parent, AT.w]
        if kind != RowKind.SLIDE:
            sign, drive = geometry[i, SHAPE.sign], rows[i, ROW.drive]
            if drive < 0:
                last = 2 if kind == RowKind.FLOAT else 0
                angle += sign * q[rows[i, ROW.coordinate] + last]
                w += sign * u[rows[i, ROW.speed] + last]
            else:
                angle += sign * drives[drive, 0]
                w += sign * drives[drive, 1]
        angles[i], work[i, AT.w] = angle, w


@inlined
def sweep_outward(tables: PlanarTables, state: State, own: PlanarWork, rates: np.ndarray) -> None:
    """Write dq/dt, and the motion, inertia and force of all rows; velocities if loads ask for them."""
    rows, geometry, q, u, drives = tables.rows, tables.geometry, state.q, state.u, state.drives
    work, cosines, sines, has_velocities = own.work, own.cosines, own.sines, len(tables.loads) > 0
    zero = work[0, AT.w]
    for i in range(1, len(rows)):
        kind, parent, at, speed, drive = (
            rows[i, ROW.kind],
            rows[i, ROW.parent],
            rows[i, ROW.coordinate],
            rows[i, ROW.speed],
            rows[i, ROW.drive],
        )
        if drive < 0:
            position, rate, acceleration = q[at], u[speed], zero
            rates[at] = rate
        else:
            position, rate, acceleration = zero + drives[drive, 0], zero + drives[drive, 1], zero + drives[drive, 2]
        c, s, w = work[parent, AT.c], work[parent, AT.s], work[parent, AT.w]
        x, y = geometry[i, SHAPE.place], geometry[i, SHAPE.place + 1]
        if kind == RowKind.TURN:
            offset_x, offset_y = c * x - s * y, s * x + c * y
            velocity_x = velocity_y = bias_x = bias_y = zero
        else:
            axis_x, axis_y = geometry[i, SHAPE.axis], geometry[i, SHAPE.axis + 1]
            axis_x, axis_y = c * axis_x - s * axis_y, s * axis_x + c * axis_y
            offset_x, offset_y = c * x - s * y + position * axis_x, s * x + c * y + position * axis_y
            velocity_x, velocity_y = rate * axis_x, rate * axis_y
            if kind == RowKind.FLOAT:
                sign = geometry[i, SHAPE.sign]
                side_x, side_y = -sign * axis_y, sign * axis_x
                offset_x, offset_y = offset_x + q[at + 1] * side_x, offset_y + q[at + 1] * side_y
                velocity_x, velocity_y = velocity_x + u[speed + 1] * side_x, velocity_y + u[speed + 1] * side_y
                rates[at + 1], rates[at + 2] = u[speed + 1], u[speed + 2]
            bias_x = acceleration * axis_x - 2.0 * w * velocity_y
            bias_y = acceleration * axis_y + 2.0 * w * velocity_x
        c, s, spin = cosines[i], sines[i], work[i, AT.w]
        work[i, AT.c], work[i, AT.s] = c, s
        work[i, AT.offset], work[i, AT.offset + 1] = offset_x, offset_y
        if has_velocities:
            work[i, AT.velocity] = work[parent, AT.velocity] - w * offset_y + velocity_x
            work[i, AT.velocity + 1] = work[parent, AT.velocity + 1] + w * offset_x + velocity_y
        work[i, AT.bias], work[i, AT.bias + 1] = bias_x - w * w * offset_x, bias_y - w * w * offset_y
        x, y, mass = geometry[i, SHAPE.first], geometry[i, SHAPE.first + 1], zero + geometry[i, SHAPE.mass]
        first_x, first_y = c * x - s * y, s * x + c * y
        work[i, AT.m], work[i, AT.m + 1], work[i, AT.m + 2] = mass, zero, mass
        work[i, AT.h], work[i, AT.h + 1], work[i, AT.j] = -first_y, first_x, zero + geometry[i, SHAPE.second]
        force_x, force_y, moment = -spin * spin * first_x, -spin * spin * first_y, zero
        if rows[i, ROW.is_lifted]:
            gravity = tables.gravity
            x, y, mass = geometry[i, SHAPE.lifted + 1], geometry[i, SHAPE.lifted + 2], zero + geometry[i, SHAPE.lifted]
            force_x, force_y = force_x + mass * gravity[0], force_y + mass * gravity[1]
            moment = (c * x - s * y) * gravity[1] - (s * x + c * y) * gravity[0]
        work[i, AT.force], work[i, AT.force + 1], work[i, AT.moment] = force_x, force_y, moment


@inlined
def add_point_loads(tables: PlanarTables, inputs: np.ndarray, work: np.ndarray) -> Any:
    """Apply forces and torques; return their power."""
    loads, points = tables.loads, tables.points
    power = 0.0 * work[0, AT.w]
    for n in range(len(loads)):
        i, at, is_torque, follows = loads[n, 0], loads[n, 1], loads[n, 2], loads[n, 3]
        x = points[n, 2] * inputs[at] + points[n, 3] * inputs[at + 1] + points[n, 4] * inputs[at + 2]
        y = points[n, 5] * inputs[at] + points[n, 6] * inputs[at + 1] + points[n, 7] * inputs[at + 2]
        if is_torque:
            work[i, AT.moment] -= x
            power += x * work[i, AT.w]
            continue
        c, s = work[i, AT.c], work[i, AT.s]
        force_x, force_y = (c * x - s * y, s * x + c * y) if follows else (x + 0.0 * c, y + 0.0 * c)
        moment = (c * points[n, 0] - s * points[n, 1]) * force_y - (s * points[n, 0] + c * points[n, 1]) * force_x
        work[i, AT.force] -= force_x
        work[i, AT.force + 1] -= force_y
        work[i, AT.moment] -= moment
        power += force_x * work[i, AT.velocity] + force_y * work[i, AT.velocity + 1] + moment * work[i, AT.w]
    return power
