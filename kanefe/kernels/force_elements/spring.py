"""Springs and dampers along the line between two ends (Eq. 11)."""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels.algebra.vectors import dot, minus, three, times
from kanefe.kernels.compiler._numba import inlined
from kanefe.kernels.compiler.addresses import called_by_address
from kanefe.kernels.force_elements.places import END_NUMBERS, GIVEN, POTENTIAL, SIGNATURE, TAKEN, WRENCH, WRENCHES, P, V

STIFFNESS, DAMPING, REST_LENGTH, INPUTS, TABLE_SIZE, TABLE = range(6)


@called_by_address(*SIGNATURE)
def spring(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write the pull on both ends; `numbers` are those of `kanefe.loads.spring.SpringDamper.kernel`."""
    line = minus(three(ends, END_NUMBERS + P), three(ends, P))
    length = np.sqrt(dot(line, line))
    e = times(1.0 / length, line)
    rate = dot(e, minus(three(ends, END_NUMBERS + V), three(ends, V)))
    extra = 0.0 * length
    if numbers[INPUTS] > 0.0:
        extra += inputs[0]
    if numbers[TABLE_SIZE] > 0.0:
        extra += interpolated(numbers, TABLE, int(numbers[TABLE_SIZE]), length)
    brake = numbers[DAMPING] * rate
    stretch = length - numbers[REST_LENGTH]
    tension = numbers[STIFFNESS] * stretch + brake + extra
    out[POTENTIAL] = 0.5 * numbers[STIFFNESS] * stretch * stretch
    out[TAKEN] = brake * rate
    out[GIVEN] = -extra * rate
    for c in range(3):
        out[WRENCHES + c] = tension * e[c]
        out[WRENCHES + WRENCH + c] = -tension * e[c]


@inlined
def interpolated(numbers: Any, at: int, count: int, x: Any) -> Any:
    """Return a table's value at x, straight between its points and beyond its ends: places, then values, from `at`."""
    i = 1
    while i < count - 1 and numbers[at + i] < x.real:
        i += 1
    x0, f0 = numbers[at + i - 1], numbers[at + count + i - 1]
    return f0 + (numbers[at + count + i] - f0) / (numbers[at + i] - x0) * (x - x0)
