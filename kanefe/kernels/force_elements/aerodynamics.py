"""Forces of the wind on a moving frame by tables over the angle of the wind (Eq. 11)."""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels.algebra.vectors import Numbers, minus, rotated_back, three
from kanefe.kernels.compiler._numba import inlined
from kanefe.kernels.compiler.addresses import called_by_address
from kanefe.kernels.force_elements.bushing import nine
from kanefe.kernels.force_elements.periodic_load import put_own
from kanefe.kernels.force_elements.places import SIGNATURE, A, V

DENSITY, FLAT_AREA, GUSTS, HARMONICS, PIECES, MEAN = range(6)
FIRST = MEAN + 3
GUST, HARMONIC, PIECE = 5, 7, 25
"""Numbers of a gust (start, duration, velocity), of a harmonic of turbulence (frequency, parts with cosine and sine)
and of a piece of the table (where it begins, four powers of each of six parts)."""


@called_by_address(*SIGNATURE)
def aerodynamics(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write force and moment; `numbers` are those of `kanefe.loads.aerodynamics.Aerodynamics.kernel`."""
    blown = rotated_back(nine(ends, A), minus(wind_at(t, numbers), three(ends, V)))
    x, y, z = blown
    pressure = 0.5 * numbers[DENSITY] * (x * x + y * y)
    up = z if z.real >= 0.0 else -z
    lift = 0.5 * numbers[DENSITY] * numbers[FLAT_AREA] * up * z
    zero = 0.0 * x
    if pressure.real == 0.0:
        put_own((zero, zero, lift), (zero, zero, zero), ends, out)
        return
    # where the wind comes from; the angle to the nearest real direction makes it right for complex numbers
    near = np.arctan2(-y.real, -x.real)
    c, s = -np.cos(near), -np.sin(near)
    angle = near + np.arctan((c * y - s * x) / (c * x + s * y))
    count, table = int(numbers[PIECES]), FIRST + GUST * int(numbers[GUSTS]) + HARMONIC * int(numbers[HARMONICS])
    if near < numbers[table]:
        angle, near = angle + 2.0 * np.pi, near + 2.0 * np.pi
    at = table + PIECE * piece_of(near, numbers, table, count)
    h = angle - numbers[at]
    force = (
        pressure * cubic(numbers, at + 1, h),
        pressure * cubic(numbers, at + 5, h),
        pressure * cubic(numbers, at + 9, h) + lift,
    )
    moment = (
        pressure * cubic(numbers, at + 13, h),
        pressure * cubic(numbers, at + 17, h),
        pressure * cubic(numbers, at + 21, h),
    )
    put_own(force, moment, ends, out)


@inlined
def wind_at(t: float, numbers: Any) -> Numbers:
    """Return the velocity of the wind, mean, gusts and turbulence."""
    vx, vy, vz = numbers[MEAN], numbers[MEAN + 1], numbers[MEAN + 2]
    at = FIRST
    for _ in range(int(numbers[GUSTS])):
        since = t - numbers[at]
        if since > 0.0 and since < numbers[at + 1]:
            grown = 0.5 * (1.0 - np.cos(2.0 * np.pi * since / numbers[at + 1]))
            vx += grown * numbers[at + 2]
            vy += grown * numbers[at + 3]
            vz += grown * numbers[at + 4]
        at += GUST
    for _ in range(int(numbers[HARMONICS])):
        c, s = np.cos(numbers[at] * t), np.sin(numbers[at] * t)
        vx += c * numbers[at + 1] + s * numbers[at + 4]
        vy += c * numbers[at + 2] + s * numbers[at + 5]
        vz += c * numbers[at + 3] + s * numbers[at + 6]
        at += HARMONIC
    return vx, vy, vz


@inlined
def piece_of(angle: float, numbers: Any, table: int, count: int) -> int:
    """Return the last piece that begins at an angle or before it, by halving."""
    low, high = 0, count
    while high - low > 1:
        middle = (low + high) // 2
        if numbers[table + PIECE * middle] <= angle:
            low = middle
        else:
            high = middle
    return low


@inlined
def cubic(numbers: Any, at: int, h: Any) -> Any:
    """Return a cubic of h, coefficients of rising powers from `at`."""
    return numbers[at] + h * (numbers[at + 1] + h * (numbers[at + 2] + h * numbers[at + 3]))
