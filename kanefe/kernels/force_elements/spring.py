"""Springs and dampers along the line between two ends (Eq. 11)."""

from typing import Annotated, Any

import numpy as np

from kanefe.kernels.force_elements.places import SIGNATURE, Done, Ends, Wrenches
from kanefe.kernels.language import Behind, Record, Vector, called_by_address, dot, inlined


class SpringNumbers(Record):
    """Numbers of a spring: coefficients, whether a function of the user gives tension, and the table of another part.

    The table has its lengths and then its forces.
    """

    stiffness: float
    damping: float
    rest_length: float
    inputs: float
    table_size: float
    table: Annotated[Any, Behind()]


@called_by_address(*SIGNATURE)
def spring(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write the pull on both ends; see `SpringNumbers`."""
    own, done = SpringNumbers(numbers), Done(out)
    length, rate, e = line_between(ends)
    elastic, brake, extra = tensions(own, inputs, length, rate)
    stretch = length - own.rest_length
    done.potential = 0.5 * own.stiffness * stretch * stretch
    done.taken = brake * rate
    done.given = -extra * rate
    draw_together(elastic + brake + extra, e, done)


@inlined
def line_between(ends: Any, first: int = 0) -> tuple[Any, Any, Vector]:
    """Return length, rate and direction of the line from an end to the next."""
    a, b = Ends(ends)[first], Ends(ends)[first + 1]
    line = b.p - a.p
    length = np.sqrt(dot(line, line))
    e = (1.0 / length) * line
    return length, dot(e, b.v - a.v), e


@inlined
def draw_together(tension: Any, e: Vector, done: Done) -> None:
    """Write a tension along a line as forces on both ends."""
    on = Wrenches(done.wrenches)
    on[0].force = tension * e
    on[1].force = -tension * e


@inlined
def tensions(own: SpringNumbers, inputs: Any, length: Any, rate: Any) -> tuple[Any, Any, Any]:
    """Return the tension of spring and damper, and what a function of the user or a table gives."""
    extra = 0.0 * length
    if own.inputs > 0.0:
        extra += inputs[0]
    if own.table_size > 0.0:
        extra += interpolated(own.table, int(own.table_size), length)
    return own.stiffness * (length - own.rest_length), own.damping * rate, extra


@inlined
def interpolated(table: Any, count: int, x: Any) -> Any:
    """Return a table's value at x, straight between its points and beyond its ends: places, then values."""
    i = 1
    while i < count - 1 and table[i] < x.real:
        i += 1
    x0, f0 = table[i - 1], table[count + i - 1]
    return f0 + (table[count + i] - f0) / (table[i] - x0) * (x - x0)
