"""Bushings: springs and dampers in all six directions between two ends (Eq. 11)."""

from __future__ import annotations

from collections import namedtuple
from typing import Any

import numpy as np

from kanefe.kernels.algebra.vectors import (
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
from kanefe.kernels.compiler._numba import inlined
from kanefe.kernels.compiler.addresses import called_by_address
from kanefe.kernels.force_elements.blocks import places
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
from kanefe.kernels.sweeps.slopes import slope_motion

BushingNumbers = namedtuple("BushingNumbers", "stiffness damping inputs")
"""Numbers of a bushing: matrices (6, 6) row by row, and whether a law of the user gives forces too."""

AT = places(BushingNumbers, stiffness=36, damping=36)


@called_by_address(*SIGNATURE)
def bushing(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write what it exerts on a and b; see `BushingNumbers`."""
    d, theta, rate, spin = seen_from_a(ends)
    zero = 0.0 * theta[0]
    tangent = slope_motion(0, theta, (zero, zero, zero))[1]
    turning = solved(tangent, spin)
    x, moved = (*d, *theta), (*rate, *turning)
    spring, spring_r = six_by_six(numbers, AT.stiffness, x)
    beside, beside_r = six_by_six(numbers, AT.stiffness, moved)
    brake, brake_r = six_by_six(numbers, AT.damping, (*rate, *spin))
    force = minus(times(-1.0, spring), brake)
    moment = minus(times(-1.0, solved(transposed(tangent), spring_r)), brake_r)
    out[POTENTIAL] = 0.5 * (dot(spring, d) + dot(spring_r, theta))
    out[TAKEN] = dot(brake, rate) + dot(brake_r, spin)
    # of the skew part of the stiffness
    out[GIVEN] = 0.5 * (dot(d, beside) + dot(theta, beside_r) - dot(rate, spring) - dot(turning, spring_r))
    if numbers[AT.inputs] > 0.0:
        more, more_r = three(inputs, 0), three(inputs, 3)
        force, moment = plus(force, more), plus(moment, more_r)
        out[GIVEN] += dot(rate, more) + dot(spin, more_r)
    put_on_both(ends, force, moment, out)


@inlined
def seen_from_a(ends: Any) -> tuple[Numbers, Numbers, Numbers, Numbers]:
    """Return where b is seen from a, in the axes of a: offset, rotation vector, rate, angular velocity."""
    A_a, A_b = nine(ends, A), nine(ends, END_NUMBERS + A)
    w_a = three(ends, W)
    offset = minus(three(ends, END_NUMBERS + P), three(ends, P))
    rate = minus(minus(three(ends, END_NUMBERS + V), three(ends, V)), cross(w_a, offset))
    spin = minus(three(ends, END_NUMBERS + W), w_a)
    theta = rotation_vector_of(product(transposed(A_a), A_b))
    return rotated_back(A_a, offset), theta, rotated_back(A_a, rate), rotated_back(A_a, spin)


@inlined
def put_on_both(ends: Any, force: Numbers, moment: Numbers, out: Any) -> None:
    """Write a force and moment on b at its origin, in the axes of a, and the reverse on a at the same point."""
    A_a, offset = nine(ends, A), minus(three(ends, END_NUMBERS + P), three(ends, P))
    force, moment = rotated(A_a, force), rotated(A_a, moment)
    on_a = plus(moment, cross(offset, force))
    for i in range(3):
        out[WRENCHES + i], out[WRENCHES + 3 + i] = -force[i], -on_a[i]
        out[WRENCHES + WRENCH + i], out[WRENCHES + WRENCH + 3 + i] = force[i], moment[i]


@inlined
def six_by_six(numbers: Any, at: int, x: Numbers) -> tuple[Numbers, Numbers]:
    """Return the upper and lower three of the product of a matrix (6, 6), row by row from `at` on, with six numbers."""
    return (
        (row(numbers, at, x), row(numbers, at + 6, x), row(numbers, at + 12, x)),
        (row(numbers, at + 18, x), row(numbers, at + 24, x), row(numbers, at + 30, x)),
    )


@inlined
def row(numbers: Any, at: int, x: Numbers) -> Any:
    """Return the sum of six products."""
    return (
        numbers[at] * x[0]
        + numbers[at + 1] * x[1]
        + numbers[at + 2] * x[2]
        + numbers[at + 3] * x[3]
        + numbers[at + 4] * x[4]
        + numbers[at + 5] * x[5]
    )


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
