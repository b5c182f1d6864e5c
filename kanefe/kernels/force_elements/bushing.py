"""Bushings: springs and dampers in all six directions between two ends (Eq. 11)."""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels._numba import inlined
from kanefe.kernels.addresses import called_by_address
from kanefe.kernels.force_elements.places import (
    END_NUMBERS,
    GIVEN,
    POTENTIAL,
    SIGNATURE,
    TAKEN,
    WRENCH,
    WRENCHES,
    A,
    P,
    V,
    W,
)
from kanefe.kernels.slopes import slope_motion
from kanefe.kernels.vectors import (
    Numbers,
    cross,
    dot,
    minus,
    plus,
    product,
    rotated,
    rotated_back,
    three,
    times,
    transposed,
)

STIFFNESS, DAMPING, INPUTS = 0, 6, 12


@called_by_address(*SIGNATURE)
def bushing(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write what it exerts on a and b; `numbers` are those of `kanefe.loads.bushing.Bushing.kernel`."""
    A_a, A_b = nine(ends, A), nine(ends, END_NUMBERS + A)
    w_a = three(ends, W)
    offset = minus(three(ends, END_NUMBERS + P), three(ends, P))
    d = rotated_back(A_a, offset)
    rate = rotated_back(A_a, minus(minus(three(ends, END_NUMBERS + V), three(ends, V)), cross(w_a, offset)))
    spin = rotated_back(A_a, minus(three(ends, END_NUMBERS + W), w_a))
    theta = rotation_vector_of(product(transposed(A_a), A_b))
    zero = 0.0 * theta[0]
    tangent = slope_motion(0, theta, (zero, zero, zero))[1]
    k, c = three(numbers, STIFFNESS), three(numbers, DAMPING)
    k_r, c_r = three(numbers, STIFFNESS + 3), three(numbers, DAMPING + 3)
    brake = (c[0] * rate[0], c[1] * rate[1], c[2] * rate[2])
    brake_r = (c_r[0] * spin[0], c_r[1] * spin[1], c_r[2] * spin[2])
    spring = (-k[0] * d[0], -k[1] * d[1], -k[2] * d[2])
    spring_r = (-k_r[0] * theta[0], -k_r[1] * theta[1], -k_r[2] * theta[2])
    force = minus(spring, brake)
    moment = minus(solved(transposed(tangent), spring_r), brake_r)
    out[POTENTIAL] = -0.5 * (dot(spring, d) + dot(spring_r, theta))
    out[TAKEN] = dot(brake, rate) + dot(brake_r, spin)
    if numbers[INPUTS] > 0.0:
        more, more_r = three(inputs, 0), three(inputs, 3)
        force, moment = plus(force, more), plus(moment, more_r)
        out[GIVEN] = dot(rate, more) + dot(spin, more_r)
    force, moment = rotated(A_a, force), rotated(A_a, moment)
    # a feels the reverse at the same point, b's origin
    on_a = plus(moment, cross(offset, force))
    for i in range(3):
        out[WRENCHES + i], out[WRENCHES + 3 + i] = -force[i], -on_a[i]
        out[WRENCHES + WRENCH + i], out[WRENCHES + WRENCH + 3 + i] = force[i], moment[i]


@inlined
def nine(x: Any, at: int) -> Numbers:
    """Return a matrix, row by row."""
    return (x[at], x[at + 1], x[at + 2], x[at + 3], x[at + 4], x[at + 5], x[at + 6], x[at + 7], x[at + 8])


@inlined
def solved(A: Numbers, b: Numbers) -> Numbers:
    """Return A^-1 b by cofactors."""
    r0, r1, r2 = (A[0], A[1], A[2]), (A[3], A[4], A[5]), (A[6], A[7], A[8])
    c0, c1, c2 = cross(r1, r2), cross(r2, r0), cross(r0, r1)
    return times(1.0 / dot(r0, c0), plus(times(b[0], c0), plus(times(b[1], c1), times(b[2], c2))))


@inlined
def rotation_vector_of(A: Numbers) -> Numbers:
    """Return the rotation vector (at most half a turn) of a rotation matrix, through its largest Euler parameter."""
    trace = A[0] + A[4] + A[8]
    squares = (1.0 + trace, 1.0 + 2.0 * A[0] - trace, 1.0 + 2.0 * A[4] - trace, 1.0 + 2.0 * A[8] - trace)
    largest = max(squares[0].real, squares[1].real, squares[2].real, squares[3].real)
    x, y, z = A[7] - A[5], A[2] - A[6], A[3] - A[1]
    if squares[0].real == largest:
        e = (squares[0], x, y, z)
    elif squares[1].real == largest:
        e = (x, squares[1], A[1] + A[3], A[2] + A[6])
    elif squares[2].real == largest:
        e = (y, A[1] + A[3], squares[2], A[5] + A[7])
    else:
        e = (z, A[2] + A[6], A[5] + A[7], squares[3])
    square = e[1] * e[1] + e[2] * e[2] + e[3] * e[3]
    sign = -1.0 if e[0].real < 0.0 else 1.0
    cosine = sign * e[0]
    if square.real < 1e-16 * (cosine * cosine).real:
        return times(2.0 * sign / cosine, (e[1], e[2], e[3]))
    sine = np.sqrt(square)
    angle = 2.0 * np.arctan(sine / cosine) if cosine.real > sine.real else np.pi - 2.0 * np.arctan(cosine / sine)
    return times(sign * angle / sine, (e[1], e[2], e[3]))
