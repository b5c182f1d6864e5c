"""Springs and dampers along the line between two ends (Eq. 11)."""

from __future__ import annotations

from collections import namedtuple
from typing import Any

import numpy as np

from kanefe.kernels.algebra.vectors import Numbers, dot, minus, three, times
from kanefe.kernels.compiler._numba import inlined
from kanefe.kernels.compiler.addresses import called_by_address
from kanefe.kernels.force_elements.blocks import places
from kanefe.kernels.force_elements.places import END_NUMBERS, GIVEN, POTENTIAL, SIGNATURE, TAKEN, WRENCH, WRENCHES, P, V

SpringNumbers = namedtuple("SpringNumbers", "stiffness damping rest_length inputs table_size table")
"""Numbers of a spring: coefficients, whether a function of the user gives tension, and the table of another part.

The table has its lengths and then its forces.
"""

AT = places(SpringNumbers)


@called_by_address(*SIGNATURE)
def spring(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write the pull on both ends; see `SpringNumbers`."""
    length, rate, e = line_between(ends)
    elastic, brake, extra = tensions(numbers, inputs, length, rate)
    tension = elastic + brake + extra
    stretch = length - numbers[AT.rest_length]
    out[POTENTIAL] = 0.5 * numbers[AT.stiffness] * stretch * stretch
    out[TAKEN] = brake * rate
    out[GIVEN] = -extra * rate
    for c in range(3):
        out[WRENCHES + c] = tension * e[c]
        out[WRENCHES + WRENCH + c] = -tension * e[c]


@inlined
def line_between(ends: Any) -> tuple[Any, Any, Numbers]:
    """Return length, rate and direction of the line from the first end to the second."""
    line = minus(three(ends, END_NUMBERS + P), three(ends, P))
    length = np.sqrt(dot(line, line))
    e = times(1.0 / length, line)
    return length, dot(e, minus(three(ends, END_NUMBERS + V), three(ends, V))), e


@inlined
def tensions(numbers: Any, inputs: Any, length: Any, rate: Any) -> tuple[Any, Any, Any]:
    """Return the tension of spring and damper, and what a function of the user or a table gives."""
    extra = 0.0 * length
    if numbers[AT.inputs] > 0.0:
        extra += inputs[0]
    if numbers[AT.table_size] > 0.0:
        extra += interpolated(numbers, AT.table, int(numbers[AT.table_size]), length)
    return numbers[AT.stiffness] * (length - numbers[AT.rest_length]), numbers[AT.damping] * rate, extra


@inlined
def interpolated(numbers: Any, at: int, count: int, x: Any) -> Any:
    """Return a table's value at x, straight between its points and beyond its ends: places, then values, from `at`."""
    i = 1
    while i < count - 1 and numbers[at + i] < x.real:
        i += 1
    x0, f0 = numbers[at + i - 1], numbers[at + count + i - 1]
    return f0 + (numbers[at + count + i] - f0) / (numbers[at + i] - x0) * (x - x0)
