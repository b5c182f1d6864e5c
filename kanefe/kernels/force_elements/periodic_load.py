"""Loads that repeat with the turns of a rotor, in the axes of their frame (Eq. 11)."""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels.algebra.vectors import Numbers, dot, rotated, three
from kanefe.kernels.compiler._numba import inlined
from kanefe.kernels.compiler.addresses import called_by_address
from kanefe.kernels.force_elements.bushing import nine
from kanefe.kernels.force_elements.places import GIVEN, SIGNATURE, WRENCHES, A, V, W
from kanefe.kernels.force_elements.spring import interpolated

RATE, AZIMUTH, HARMONICS, TABLE_SIZE, MEAN = range(5)
FIRST = MEAN + 6
HARMONIC = 13
"""Numbers of a harmonic: how many per turn, then the six parts with the cosine, then those with the sine."""


@called_by_address(*SIGNATURE)
def periodic_load(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write force and moment; `numbers` are those of `kanefe.loads.periodic_load.PeriodicLoad.kernel`."""
    count, size = int(numbers[HARMONICS]), int(numbers[TABLE_SIZE])
    turned = numbers[AZIMUTH] + numbers[RATE] * t
    table = FIRST + HARMONIC * count
    share = interpolated(numbers, table, size, min(max(t, numbers[table]), numbers[table + size - 1]))
    f0, f1, f2 = numbers[MEAN], numbers[MEAN + 1], numbers[MEAN + 2]
    m0, m1, m2 = numbers[MEAN + 3], numbers[MEAN + 4], numbers[MEAN + 5]
    for i in range(count):
        at = FIRST + HARMONIC * i
        c, s = np.cos(numbers[at] * turned), np.sin(numbers[at] * turned)
        f0 += c * numbers[at + 1] + s * numbers[at + 7]
        f1 += c * numbers[at + 2] + s * numbers[at + 8]
        f2 += c * numbers[at + 3] + s * numbers[at + 9]
        m0 += c * numbers[at + 4] + s * numbers[at + 10]
        m1 += c * numbers[at + 5] + s * numbers[at + 11]
        m2 += c * numbers[at + 6] + s * numbers[at + 12]
    own = (share * f0, share * f1, share * f2), (share * m0, share * m1, share * m2)
    put_own(own[0], own[1], ends, out)


@inlined
def put_own(force: Numbers, moment: Numbers, ends: Any, out: Any) -> None:
    """Write a force and a moment in the axes of the first end, and the power that they give."""
    axes = nine(ends, A)
    force, moment = rotated(axes, force), rotated(axes, moment)
    out[GIVEN] = dot(force, three(ends, V)) + dot(moment, three(ends, W))
    for c in range(3):
        out[WRENCHES + c], out[WRENCHES + 3 + c] = force[c], moment[c]
