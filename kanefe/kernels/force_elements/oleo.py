"""Oleo struts: a gas spring and oil through an orifice, along the line between two ends (Eq. 11)."""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels.algebra.vectors import dot, minus, three, times
from kanefe.kernels.compiler.addresses import called_by_address
from kanefe.kernels.force_elements.places import END_NUMBERS, POTENTIAL, SIGNATURE, TAKEN, WRENCH, WRENCHES, P, V

EXTENDED, AREA, PRESSURE, VOLUME, EXPONENT, AMBIENT, ORIFICE, REBOUND = range(8)


@called_by_address(*SIGNATURE)
def oleo(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write what pushes both ends apart; `numbers` are those of `kanefe.loads.oleo.Oleo.kernel`."""
    line = minus(three(ends, END_NUMBERS + P), three(ends, P))
    length = np.sqrt(dot(line, line))
    e = times(1.0 / length, line)
    closing = -dot(e, minus(three(ends, END_NUMBERS + V), three(ends, V)))
    stroke = numbers[EXTENDED] - length
    n, p, A = numbers[EXPONENT], numbers[PRESSURE], numbers[AREA]
    room = 1.0 - stroke * A / numbers[VOLUME]  # share of the volume that is left
    inverse = np.exp(-n * np.log(room))
    gas = (p * inverse - numbers[AMBIENT]) * A
    if n == 1.0:
        energy = -p * numbers[VOLUME] * np.log(room)
    else:
        energy = p * numbers[VOLUME] / (n - 1.0) * (room * inverse - 1.0)
    oil = closing * closing
    if closing.real < 0.0:
        oil *= -numbers[REBOUND]
    else:
        oil *= numbers[ORIFICE]
    out[POTENTIAL] = energy - numbers[AMBIENT] * A * stroke
    out[TAKEN] = oil * closing
    for c in range(3):
        out[WRENCHES + c] = -(gas + oil) * e[c]
        out[WRENCHES + WRENCH + c] = (gas + oil) * e[c]
