"""Loads that repeat with the turns of a rotor, in the axes of their frame (Eq. 11)."""

from __future__ import annotations

import math
from collections import namedtuple
from typing import Any

from kanefe.kernels.algebra.vectors import Numbers, dot, rotated, three
from kanefe.kernels.compiler._numba import inlined
from kanefe.kernels.compiler.addresses import called_by_address
from kanefe.kernels.force_elements.blocks import places
from kanefe.kernels.force_elements.bushing import nine
from kanefe.kernels.force_elements.places import GIVEN, SIGNATURE, WRENCHES, A, V, W
from kanefe.kernels.force_elements.spring import interpolated

PeriodicLoadNumbers = namedtuple("PeriodicLoadNumbers", "rate azimuth harmonics table_size mean harmonics_and_table")
"""Numbers of a load of a hub: rad/s, rad, how many harmonics and points of its table, the mean (6,).

Of each harmonic how many per turn, six parts with the cosine and six with the sine; then times and shares.
"""

AT = places(PeriodicLoadNumbers, mean=6)
HARMONIC = 13
"""Number of values of a harmonic."""


@called_by_address(*SIGNATURE)
def periodic_load(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write force and moment; see `PeriodicLoadNumbers`."""
    force, moment = own_at(t, numbers)
    put_own(force, moment, ends, out)


@inlined
def own_at(t: float, numbers: Any) -> tuple[Numbers, Numbers]:
    """Return force and moment in the axes of the hub."""
    count, size = int(numbers[AT.harmonics]), int(numbers[AT.table_size])
    turned = numbers[AT.azimuth] + numbers[AT.rate] * t
    table = AT.harmonics_and_table + HARMONIC * count
    share = interpolated(numbers, table, size, min(max(t, numbers[table]), numbers[table + size - 1]))
    f0, f1, f2 = numbers[AT.mean], numbers[AT.mean + 1], numbers[AT.mean + 2]
    m0, m1, m2 = numbers[AT.mean + 3], numbers[AT.mean + 4], numbers[AT.mean + 5]
    for i in range(count):
        at = AT.harmonics_and_table + HARMONIC * i
        c, s = math.cos(numbers[at] * turned), math.sin(numbers[at] * turned)
        f0 += c * numbers[at + 1] + s * numbers[at + 7]
        f1 += c * numbers[at + 2] + s * numbers[at + 8]
        f2 += c * numbers[at + 3] + s * numbers[at + 9]
        m0 += c * numbers[at + 4] + s * numbers[at + 10]
        m1 += c * numbers[at + 5] + s * numbers[at + 11]
        m2 += c * numbers[at + 6] + s * numbers[at + 12]
    return (share * f0, share * f1, share * f2), (share * m0, share * m1, share * m2)


@inlined
def put_own(force: Numbers, moment: Numbers, ends: Any, out: Any) -> None:
    """Write a force and a moment in the axes of the first end, and the power that they give."""
    axes = nine(ends, A)
    force, moment = rotated(axes, force), rotated(axes, moment)
    out[GIVEN] = dot(force, three(ends, V)) + dot(moment, three(ends, W))
    for c in range(3):
        out[WRENCHES + c], out[WRENCHES + 3 + c] = force[c], moment[c]
