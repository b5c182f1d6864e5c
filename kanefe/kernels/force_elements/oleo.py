"""Oleo struts: a gas spring and oil through an orifice, along the line between two ends (Eq. 11)."""

from __future__ import annotations

from collections import namedtuple
from typing import Any

import numpy as np

from kanefe.kernels.compiler._numba import inlined
from kanefe.kernels.compiler.addresses import called_by_address
from kanefe.kernels.force_elements.blocks import places
from kanefe.kernels.force_elements.places import POTENTIAL, SIGNATURE, TAKEN, WRENCH, WRENCHES
from kanefe.kernels.force_elements.spring import line_between

OleoNumbers = namedtuple("OleoNumbers", "extended area pressure volume exponent ambient orifice rebound")
"""Numbers of an oleo strut, in the words and units of `kanefe.Oleo`."""

AT = places(OleoNumbers)


@called_by_address(*SIGNATURE)
def oleo(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write the force that separates both ends; see `OleoNumbers`."""
    length, rate, e = line_between(ends)
    stroke = numbers[AT.extended] - length
    gas, energy = gas_in(numbers, stroke)
    oil = oil_through(numbers, -rate)
    out[POTENTIAL] = energy - numbers[AT.ambient] * numbers[AT.area] * stroke
    out[TAKEN] = oil * -rate
    for c in range(3):
        out[WRENCHES + c] = -(gas + oil) * e[c]
        out[WRENCHES + WRENCH + c] = (gas + oil) * e[c]


@inlined
def room_left(numbers: Any, stroke: Any) -> Any:
    """Return the share of the volume that is left to the gas."""
    return 1.0 - stroke * numbers[AT.area] / numbers[AT.volume]


@inlined
def gas_in(numbers: Any, stroke: Any) -> tuple[Any, Any]:
    """Return the force of the gas against the air around, and its energy above that at full extension."""
    n, p, room = numbers[AT.exponent], numbers[AT.pressure], room_left(numbers, stroke)
    inverse = np.exp(-n * np.log(room))
    if n == 1.0:
        energy = -p * numbers[AT.volume] * np.log(room)
    else:
        energy = p * numbers[AT.volume] / (n - 1.0) * (room * inverse - 1.0)
    return (p * inverse - numbers[AT.ambient]) * numbers[AT.area], energy


@inlined
def oil_through(numbers: Any, closing: Any) -> Any:
    """Return the force of the oil at a rate of the stroke."""
    oil = closing * closing
    if closing.real < 0.0:
        oil *= -numbers[AT.rebound]
    else:
        oil *= numbers[AT.orifice]
    return oil
