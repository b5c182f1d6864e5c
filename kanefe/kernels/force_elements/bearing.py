"""Bearings: a shaft that turns on and on, held by coefficients over its speed (Eq. 11)."""

from __future__ import annotations

from collections import namedtuple
from typing import Any

from kanefe.kernels.algebra.vectors import Numbers, cross, dot, minus, plus, rotated, rotated_back, three, times
from kanefe.kernels.compiler._numba import inlined
from kanefe.kernels.compiler.addresses import called_by_address
from kanefe.kernels.force_elements.blocks import places
from kanefe.kernels.force_elements.bushing import nine, put_on_both, six_by_six
from kanefe.kernels.force_elements.places import (
    END_NUMBERS,
    GIVEN,
    POTENTIAL,
    SIGNATURE,
    TAKEN,
    WATCH_SIGNATURE,
    A,
    P,
    V,
    W,
)

BearingNumbers = namedtuple("BearingNumbers", "axis ends speeds table")
"""Numbers of a bearing: which axis, how many ends and speeds, and a `BearingRow` for each speed, or for all."""

BearingRow = namedtuple("BearingRow", "speed stiffness damping stiffness_slopes damping_slopes")
"""Coefficients at a speed of rotation, matrices (6, 6) row by row, and their slopes over the speed."""

AT = places(BearingNumbers)
OF = places(BearingRow, stiffness=36, damping=36, stiffness_slopes=36, damping_slopes=36)
ROW = OF.damping_slopes + 36
SLOPES = OF.stiffness_slopes - OF.stiffness
"""Offset of columns from the coefficients of a row to their slopes."""

EDGE = 1e-9
"""Excess of a speed over the range of a table, relative to it, that still counts as its end."""


@called_by_address(*SIGNATURE)
def bearing(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write what it exerts on bearing and shaft; see `BearingNumbers`."""
    e, speed = unit(numbers, ends), speed_of(numbers, ends)
    d, axis = held_in(numbers, ends)
    A_a, w_a = nine(ends, A), three(ends, W)
    offset = minus(three(ends, END_NUMBERS + P), three(ends, P))
    velocity = minus(minus(three(ends, END_NUMBERS + V), three(ends, V)), cross(w_a, offset))
    turn = rotated_back(A_a, minus(three(ends, END_NUMBERS + W), w_a))
    tilt, tilting, rate = cross(e, axis), cross(e, cross(turn, axis)), rotated_back(A_a, velocity)
    x, moving = (*d, *tilt), (*rate, *tilting)
    spring, spring_r = coefficients_times(numbers, OF.stiffness, speed, x)
    beside, beside_r = coefficients_times(numbers, OF.stiffness, speed, moving)
    brake, brake_r = coefficients_times(numbers, OF.damping, speed, moving)
    about = times(dot(e, turn), e)
    friction_force = dot(e, coefficients_times(numbers, OF.damping, speed, (*times(0.0, e), *about))[1])
    force, forces_r = times(-1.0, plus(spring, brake)), times(-1.0, plus(spring_r, brake_r))
    moment = minus(cross(axis, cross(forces_r, e)), times(friction_force, axis))
    of_springs = dot(rate, spring) + dot(tilting, spring_r)
    out[TAKEN] = dot(rate, brake) + dot(tilting, brake_r) + friction_force * dot(axis, turn)
    if numbers[AT.speeds] > 0.0:
        out[GIVEN] = -of_springs
    else:
        out[POTENTIAL] = 0.5 * (dot(d, spring) + dot(tilt, spring_r))
        out[GIVEN] = 0.5 * (dot(d, beside) + dot(tilt, beside_r) - of_springs)
    put_on_both(ends, force, moment, out)


@called_by_address(*WATCH_SIGNATURE)
def watch_bearing(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write how far the speed is within the table."""
    low, high = numbers[AT.table], numbers[AT.table + ROW * (int(numbers[AT.speeds]) - 1)]
    speed = speed_of(numbers, ends)
    out[0] = min(speed - low, high - speed) + EDGE * (high - low)


@inlined
def held_in(numbers: Any, ends: Any) -> tuple[Numbers, Numbers]:
    """Return where the shaft is in the bearing, and its axis, in the axes of the bearing."""
    A_a = nine(ends, A)
    offset = minus(three(ends, END_NUMBERS + P), three(ends, P))
    axis = rotated_back(A_a, rotated(nine(ends, END_NUMBERS + A), unit(numbers, ends)))
    return rotated_back(A_a, offset), axis


@inlined
def unit(numbers: Any, ends: Any) -> Numbers:
    """Return the axis of rotation, in the axes of the bearing."""
    i, zero = int(numbers[AT.axis]), 0.0 * ends[0]
    return (1.0 * (i == 0) + zero, 1.0 * (i == 1) + zero, 1.0 * (i == 2) + zero)


@inlined
def speed_of(numbers: Any, ends: Any) -> Any:
    """Return the speed that the coefficients follow: of the last end about the axis, seen from the bearing."""
    spinning = three(ends, END_NUMBERS * (int(numbers[AT.ends]) - 1) + W)
    return dot(unit(numbers, ends), rotated_back(nine(ends, A), minus(spinning, three(ends, W))))


@inlined
def coefficients_times(numbers: Any, at: int, speed: Any, x: Numbers) -> tuple[Numbers, Numbers]:
    """Return the upper and lower three of the coefficients at a speed times six numbers."""
    count = int(numbers[AT.speeds])
    if count == 0:
        return six_by_six(numbers, AT.table + at, x)
    k = 0
    while k < count - 2 and speed.real > numbers[AT.table + ROW * (k + 1)]:
        k += 1
    low = AT.table + ROW * k
    span = numbers[low + ROW] - numbers[low]
    s = (speed - numbers[low]) / span
    if s.real < 0.0:
        s = 0.0 * s
    elif s.real > 1.0:
        s = 0.0 * s + 1.0
    # cubics by values and slopes at both ends
    weights = (
        (1.0 + 2.0 * s) * (1.0 - s) * (1.0 - s),
        s * s * (3.0 - 2.0 * s),
        span * s * (1.0 - s) * (1.0 - s),
        span * s * s * (s - 1.0),
    )
    base, slope = low + at, low + at + SLOPES
    a, b = six_by_six(numbers, base, x), six_by_six(numbers, base + ROW, x)
    c, d = six_by_six(numbers, slope, x), six_by_six(numbers, slope + ROW, x)
    return blended(weights, a[0], b[0], c[0], d[0]), blended(weights, a[1], b[1], c[1], d[1])


@inlined
def blended(weights: Numbers, a: Numbers, b: Numbers, c: Numbers, d: Numbers) -> Numbers:
    """Return the weighted sum of four vectors."""
    return plus(
        plus(times(weights[0], a), times(weights[1], b)),
        plus(times(weights[2], c), times(weights[3], d)),
    )
