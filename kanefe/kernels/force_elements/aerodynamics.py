"""Forces of the wind on a moving frame by tables over the angle of the wind (Eq. 11)."""

from __future__ import annotations

import math
from collections import namedtuple
from typing import Any

import numpy as np

from kanefe.kernels.algebra.vectors import Numbers, minus, rotated_back, three
from kanefe.kernels.compiler._numba import inlined
from kanefe.kernels.compiler.addresses import called_by_address
from kanefe.kernels.force_elements.blocks import places
from kanefe.kernels.force_elements.bushing import nine
from kanefe.kernels.force_elements.periodic_load import put_own
from kanefe.kernels.force_elements.places import SIGNATURE, A, V

AerodynamicsNumbers = namedtuple("AerodynamicsNumbers", "density flat_area pieces wind_and_table")
"""Numbers of the forces of wind: kg/m3, m2, how many pieces its table has; the wind, and then the pieces.

Of each piece where it begins, and four powers of each of six parts. The wind is `WindNumbers`.
"""

WindNumbers = namedtuple("WindNumbers", "gusts harmonics mean gusts_and_harmonics")
"""Numbers of a wind: how many gusts and harmonics of turbulence, the mean (3,), and these.

Of each gust start, duration and velocity; of each harmonic its frequency and three parts with the cosine and three
with the sine.
"""

AT = places(AerodynamicsNumbers)
OF = places(WindNumbers, mean=3)
GUST, HARMONIC, PIECE = 5, 7, 25
"""Numbers of values of a gust, of a harmonic of turbulence and of a piece of the table."""


@called_by_address(*SIGNATURE)
def aerodynamics(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write force and moment; see `AerodynamicsNumbers`."""
    x, y, z = blown(t, numbers, ends)
    pressure = 0.5 * numbers[AT.density] * (x * x + y * y)
    up = z if z.real >= 0.0 else -z
    lift = 0.5 * numbers[AT.density] * numbers[AT.flat_area] * up * z
    zero = 0.0 * x
    if pressure.real == 0.0:
        put_own((zero, zero, lift), (zero, zero, zero), ends, out)
        return
    # where the wind comes from; the angle to the nearest real direction makes it right for complex numbers
    near = np.arctan2(-y.real, -x.real)
    c, s = -np.cos(near), -np.sin(near)
    areas = areas_at(numbers, near, near + np.arctan((c * y - s * x) / (c * x + s * y)))
    force = pressure * areas[0], pressure * areas[1], pressure * areas[2] + lift
    put_own(force, (pressure * areas[3], pressure * areas[4], pressure * areas[5]), ends, out)


@inlined
def blown(t: float, numbers: Any, ends: Any) -> Numbers:
    """Return the wind relative to the frame, in its axes."""
    return rotated_back(nine(ends, A), minus(wind_at(t, numbers, AT.wind_and_table), three(ends, V)))


@inlined
def areas_at(numbers: Any, near: Any, angle: Any) -> Numbers:
    """Return the areas for wind from an angle, that may be complex, near a real one."""
    first = AT.wind_and_table
    count, table = int(numbers[AT.pieces]), first + OF.gusts_and_harmonics
    table += GUST * int(numbers[first + OF.gusts]) + HARMONIC * int(numbers[first + OF.harmonics])
    if near < numbers[table]:
        angle, near = angle + 2.0 * np.pi, near + 2.0 * np.pi
    at = table + PIECE * piece_of(near, numbers, table, count)
    h = angle - numbers[at]
    return (
        cubic(numbers, at + 1, h),
        cubic(numbers, at + 5, h),
        cubic(numbers, at + 9, h),
        cubic(numbers, at + 13, h),
        cubic(numbers, at + 17, h),
        cubic(numbers, at + 21, h),
    )


@inlined
def wind_at(t: float, numbers: Any, first: int) -> Numbers:
    """Return the velocity of a wind whose numbers begin at some place: mean, gusts and turbulence."""
    mean, at = first + OF.mean, first + OF.gusts_and_harmonics
    vx, vy, vz = numbers[mean], numbers[mean + 1], numbers[mean + 2]
    for _ in range(int(numbers[first + OF.gusts])):
        since = t - numbers[at]
        if since > 0.0 and since < numbers[at + 1]:
            grown = 0.5 * (1.0 - math.cos(2.0 * math.pi * since / numbers[at + 1]))
            vx += grown * numbers[at + 2]
            vy += grown * numbers[at + 3]
            vz += grown * numbers[at + 4]
        at += GUST
    for _ in range(int(numbers[first + OF.harmonics])):
        c, s = math.cos(numbers[at] * t), math.sin(numbers[at] * t)
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
