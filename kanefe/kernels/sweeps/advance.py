"""Coordinates moved along the speeds: rotations by the exponential map."""

from __future__ import annotations

import numpy as np

from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.layout import (
    COORDINATE,
    COUNT,
    DETA,
    DRIVE,
    ETA,
    FIXED,
    FREE,
    GIVEN,
    KIND,
    SPEED,
    SPHERICAL,
    FlexibleTables,
    Tables,
)


@kernel
def advance(
    tables: Tables, flexible: FlexibleTables, q: np.ndarray, step: np.ndarray, share: float, moved: np.ndarray
) -> None:
    """Write q moved by a share of a step (free,), a vector in the directions of the free speeds times a time."""
    rows = tables.rows
    for i in range(len(rows)):
        kind, at, speed = rows[i, KIND], rows[i, COORDINATE], rows[i, SPEED]
        if FIXED < kind <= GIVEN:
            if rows[i, DRIVE] < 0:
                moved[at] = q[at] + share * step[speed]
        elif kind == SPHERICAL:
            put_turned(moved, at, q, share * step[speed], share * step[speed + 1], share * step[speed + 2])
        elif kind == FREE:
            for c in range(3):
                moved[at + c] = q[at + c] + share * step[speed + c]
            put_turned(moved, at + 3, q, share * step[speed + 3], share * step[speed + 4], share * step[speed + 5])
    for f in range(len(flexible.bodies)):
        at, speed = flexible.bodies[f, ETA], flexible.bodies[f, DETA]
        for j in range(flexible.bodies[f, COUNT]):
            moved[at + j] = q[at + j] + share * step[speed + j]


@inlined
def put_turned(moved: np.ndarray, at: int, q: np.ndarray, x: float, y: float, z: float) -> None:
    """Write unit Euler parameters turned by a rotation vector in the moving frame."""
    x, y, z = 0.5 * x, 0.5 * y, 0.5 * z
    square = x * x + y * y + z * z
    if square < 1e-8:  # the next terms of the series are below round-off
        c, s = 1.0 - square * (0.5 - square / 24.0), 1.0 - square * (1.0 / 6.0 - square / 120.0)
    else:
        angle = np.sqrt(square)
        c, s = np.cos(angle), np.sin(angle) / angle
    x, y, z = s * x, s * y, s * z
    e0, e1, e2, e3 = q[at], q[at + 1], q[at + 2], q[at + 3]
    a, b, d, e = (
        e0 * c - e1 * x - e2 * y - e3 * z,
        e0 * x + e1 * c + e2 * z - e3 * y,
        e0 * y - e1 * z + e2 * c + e3 * x,
        e0 * z + e1 * y - e2 * x + e3 * c,
    )
    length = 1.0 / np.sqrt(a * a + b * b + d * d + e * e)
    moved[at], moved[at + 1], moved[at + 2], moved[at + 3] = length * a, length * b, length * d, length * e
