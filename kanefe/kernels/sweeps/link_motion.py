"""Links of one coordinate: the coordinate, partial velocities in N, and links whose motion a C function gives."""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels.algebra.vectors import Numbers, matrix, plus, product, put, rotated, times, vector
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.compiler.calls import call_address
from kanefe.kernels.layout import (
    ABOUT,
    ALONG,
    AXES,
    COMPLEX_FUNCTION,
    COORDINATE,
    DRIVE,
    FIRST_NUMBER,
    FUNCTION,
    GIVEN,
    GIVEN_MOTION,
    KIND,
    PARENT,
    PARTIAL,
    SPEED,
    R,
    Tables,
)
from kanefe.kernels.links.places import DV, DW, MOTION_NUMBERS, A, P, V, W


@inlined
def motion_along(
    rows: np.ndarray, i: int, drives: np.ndarray, q: np.ndarray, u: np.ndarray, zero: Any
) -> tuple[Any, Any, Any]:
    """Return coordinate, rate and what the drive gives of the acceleration of a link of one coordinate."""
    if rows[i, DRIVE] < 0:
        return q[rows[i, COORDINATE]], u[rows[i, SPEED]], zero
    drive = drives[rows[i, DRIVE]]
    return zero + drive[0], zero + drive[1], zero + drive[2]


@inlined
def partials(rows: np.ndarray, geometry: np.ndarray, i: int, work: np.ndarray) -> tuple[Numbers, Numbers]:
    """Return the partial velocity of the origin and the partial angular velocity of a link of one coordinate, in N."""
    if rows[i, KIND] == GIVEN:
        return vector(work, i, PARTIAL), vector(work, i, PARTIAL + 3)
    axis = (work[i, R + 2], work[i, R + 5], work[i, R + 8])
    return times(geometry[i, ALONG], axis), times(geometry[i, ABOUT], axis)


@inlined
def fixed_axes(tables: Tables, i: int, work: np.ndarray) -> Numbers:
    """Return the axes of the fixed frame of a link's joint, to N."""
    axes, parent = matrix(tables.geometry, i, AXES), tables.rows[i, PARENT]
    return product(matrix(work, parent, R), axes) if parent >= 0 else axes


@kernel
def given_motion(
    tables: Tables, i: int, axes: Numbers, position: Any, rate: Any, acceleration: Any, work: np.ndarray
) -> tuple[Numbers, Numbers, Numbers, Numbers, Numbers, Numbers]:
    """Write the partial velocities of a given link in N; return its motion seen from its frame F (Eq. 13-16).

    Parameters
    ----------
    axes : tuple
        Of F, to N.
    position, rate, acceleration : number
        As `motion_along` gives them.

    Returns
    -------
    offset, velocity, spin, pull, twist : tuple
        Position, velocity, angular velocity and remainders of M, in N.
    turned : tuple
        Axes of M, to N.
    """
    first = GIVEN_MOTION + 1
    work[i, GIVEN_MOTION] = position
    work[i, first : first + MOTION_NUMBERS] = 0.0
    address = tables.rows[i, COMPLEX_FUNCTION if np.iscomplexobj(work) else FUNCTION]
    own = tables.numbers[tables.rows[i, FIRST_NUMBER] :]
    call_address(address, (own, work[i, GIVEN_MOTION:first], work[i, first : first + MOTION_NUMBERS]))
    v, w = rotated(axes, vector(work, i, first + V)), rotated(axes, vector(work, i, first + W))
    put(work, i, PARTIAL, v)
    put(work, i, PARTIAL + 3, w)
    square = rate * rate
    return (
        rotated(axes, vector(work, i, first + P)),
        times(rate, v),
        times(rate, w),
        plus(times(square, rotated(axes, vector(work, i, first + DV))), times(acceleration, v)),
        plus(times(square, rotated(axes, vector(work, i, first + DW))), times(acceleration, w)),
        product(axes, matrix(work, i, first + A)),
    )
