"""Forces and torques on the rows of a planar scene (Eq. 11): what of them acts in the plane."""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels._numba import inlined
from kanefe.kernels.planar_layout import FORCE, MOMENT, VELOCITY, C, PlanarTables, S, W


@inlined
def add_point_loads(tables: PlanarTables, inputs: np.ndarray, work: np.ndarray) -> Any:
    """Apply forces and torques; return their power."""
    loads, points = tables.loads, tables.points
    power = 0.0 * work[0, W]
    for n in range(len(loads)):
        i, at, is_torque, follows = loads[n, 0], loads[n, 1], loads[n, 2], loads[n, 3]
        x = points[n, 2] * inputs[at] + points[n, 3] * inputs[at + 1] + points[n, 4] * inputs[at + 2]
        y = points[n, 5] * inputs[at] + points[n, 6] * inputs[at + 1] + points[n, 7] * inputs[at + 2]
        if is_torque:
            work[i, MOMENT] -= x
            power += x * work[i, W]
            continue
        c, s = work[i, C], work[i, S]
        force_x, force_y = (c * x - s * y, s * x + c * y) if follows else (x + 0.0 * c, y + 0.0 * c)
        moment = (c * points[n, 0] - s * points[n, 1]) * force_y - (s * points[n, 0] + c * points[n, 1]) * force_x
        work[i, FORCE] -= force_x
        work[i, FORCE + 1] -= force_y
        work[i, MOMENT] -= moment
        power += force_x * work[i, VELOCITY] + force_y * work[i, VELOCITY + 1] + moment * work[i, W]
    return power
