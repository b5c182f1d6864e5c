"""One row of a constraint between two markers: residual, wrenches, remainder; see `kanefe.constraints.rows`."""

from __future__ import annotations

from collections import namedtuple
from typing import Any

import numpy as np

from kanefe.kernels.algebra.vectors import Numbers, cross, dot, minus, plus, rotated, times, vector
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.force_elements.blocks import places

RowNumbers = namedtuple(
    "RowNumbers",
    "e f side cosine length lead radius constant",
    defaults=((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0, 0.0, 0.0, 0.0, 0.0),
)
"""Numbers of a row, in the words of `kanefe.constraints.rows`; zero where its kind has none such."""

AT = places(RowNumbers, e=3, f=3, side=3)
ROW_NUMBERS = int(AT.constant) + 1

POINT_ROW, DIRECTION_ROW, DISTANCE_ROW, SCREW_ROW, ROLLING_ROW, COUPLER_ROW, CONTACT_ROW = range(7)

Motion = tuple[Numbers, Numbers, Numbers, Numbers, Numbers, Numbers]
"""Motion of a marker in N: position, axes, velocity, angular velocity, Z and Y."""

Place = tuple[Numbers, Numbers]
"""Pose of a marker in N: position and axes."""


@kernel
def row_terms(
    kind: int, numbers: np.ndarray, n: int, is_ball: bool, a: Motion, b: Motion
) -> tuple[Numbers, Numbers, Numbers, Numbers, Any]:
    """Return force and moment on a and b of a unit multiplier, about the markers' origins, and the bias acceleration.

    Row n of the numbers is its `RowNumbers`.
    """
    p_a, A_a, v_a, w_a, Z_a, Y_a = a
    p_b, A_b, v_b, w_b, Z_b, Y_b = b
    zero = 0.0 * p_a[0]
    none = (zero, zero, zero)
    d, rate, jerk = minus(p_b, p_a), minus(v_b, v_a), minus(Z_b, Z_a)
    e = rotated(A_a, vector(numbers, n, AT.e))
    if kind == DIRECTION_ROW:
        f = rotated(A_b, vector(numbers, n, AT.f))
        moment = cross(f, e)
        turning = plus(cross(cross(w_b, f), e), cross(f, cross(w_a, e)))
        remainder = dot(moment, minus(Y_b, Y_a)) + dot(turning, minus(w_b, w_a))
        return none, times(-1.0, moment), none, moment, remainder
    if kind == DISTANCE_ROW:
        distance = np.sqrt(dot(d, d))
        direction = times(1.0 / distance, d)
        along = dot(direction, rate)
        remainder = dot(direction, jerk) + (dot(rate, rate) - along * along) / distance
        return times(-1.0, direction), none, direction, none, remainder
    if kind == ROLLING_ROW:
        spoke, spoke_rate = _spoke(numbers[n, AT.radius], is_ball, a, b)
        arm, arm_rate = plus(d, spoke), plus(rate, spoke_rate)
        slip = minus(plus(rate, cross(w_b, spoke)), cross(w_a, arm))
        of_b = plus(cross(Y_b, spoke), cross(w_b, spoke_rate))
        of_a = plus(cross(Y_a, arm), cross(w_a, arm_rate))
        remainder = dot(e, plus(jerk, minus(of_b, of_a))) + dot(cross(w_a, e), slip)
        return times(-1.0, e), times(-1.0, cross(arm, e)), e, cross(spoke, e), remainder
    turning = cross(w_a, e)
    bend = plus(cross(Y_a, e), cross(w_a, turning))
    remainder = dot(e, jerk) + 2.0 * dot(turning, rate) + dot(bend, d)
    moment_a, moment_b = cross(e, d), none
    if kind == SCREW_ROW:
        pitch = numbers[n, AT.lead] / (2.0 * np.pi)
        remainder -= pitch * (dot(e, minus(Y_b, Y_a)) + dot(turning, minus(w_b, w_a)))
        moment_a, moment_b = plus(moment_a, times(pitch, e)), times(-pitch, e)
    return times(-1.0, e), moment_a, e, moment_b, remainder


@kernel
def row_residual(kind: int, numbers: np.ndarray, n: int, is_ball: bool, a: Place, b: Place) -> Any:
    """Return g of a row that holds places, in its unit; numbers as for `row_terms`."""
    (p_a, A_a), (p_b, A_b) = a, b
    d = minus(p_b, p_a)
    if kind == DISTANCE_ROW:
        return np.sqrt(dot(d, d)) - numbers[n, AT.length]
    e = rotated(A_a, vector(numbers, n, AT.e))
    if kind == DIRECTION_ROW:
        return dot(e, rotated(A_b, vector(numbers, n, AT.f))) - numbers[n, AT.cosine]
    if kind == ROLLING_ROW:
        zero = 0.0 * d[0]
        still = (zero, zero, zero)
        spoke, _ = _spoke(
            numbers[n, AT.radius],
            is_ball,
            (p_a, A_a, still, still, still, still),
            (p_b, A_b, still, still, still, still),
        )
        return dot((A_a[2], A_a[5], A_a[8]), plus(d, spoke))
    if kind == SCREW_ROW:
        across = vector(numbers, n, AT.side)
        side, turned = rotated(A_a, across), rotated(A_b, across)
        angle = np.arctan2(dot(turned, cross(e, side)), dot(turned, side))
        open_turns = dot(e, d) / numbers[n, AT.lead] - angle / (2.0 * np.pi)
        return (open_turns - np.rint(open_turns)) * numbers[n, AT.lead]
    return dot(e, d)


@inlined
def _spoke(radius: float, is_ball: bool, a: Motion, b: Motion) -> tuple[Numbers, Numbers]:
    """Return the vector from the hub to the lowest point, and its rate."""
    A_a, A_b = a[1], b[1]
    n = (A_a[2], A_a[5], A_a[8])
    n_rate = cross(a[3], n)
    if is_ball:
        return times(-radius, n), times(-radius, n_rate)
    s = (A_b[2], A_b[5], A_b[8])
    s_rate = cross(b[3], s)
    lean = dot(n, s)
    lean_rate = dot(n_rate, s) + dot(n, s_rate)
    across = minus(n, times(lean, s))
    across_rate = minus(n_rate, plus(times(lean_rate, s), times(lean, s_rate)))
    size = np.sqrt(dot(across, across))
    unit = times(1.0 / size, across)
    return times(-radius, unit), times(-radius / size, minus(across_rate, times(dot(unit, across_rate), unit)))
