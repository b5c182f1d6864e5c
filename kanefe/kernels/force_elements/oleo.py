"""Oleo struts: a gas spring and oil through an orifice, along the line between two ends (Eq. 11)."""

from typing import Any

import numpy as np

from kanefe.kernels.force_elements.places import SIGNATURE, Done
from kanefe.kernels.force_elements.spring import draw_together, line_between
from kanefe.kernels.language import Record, called_by_address, inlined


class OleoNumbers(Record):
    """Numbers of an oleo strut, in the words and units of `kanefe.Oleo`."""

    extended: float
    area: float
    pressure: float
    volume: float
    exponent: float
    ambient: float
    orifice: float
    rebound: float


@called_by_address(*SIGNATURE)
def oleo(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write the force that separates both ends; see `OleoNumbers`."""
    own, done = OleoNumbers(numbers), Done(out)
    length, rate, e = line_between(ends)
    stroke = own.extended - length
    gas, energy = gas_in(own, stroke)
    oil = oil_through(own, -rate)
    done.potential = energy - own.ambient * own.area * stroke
    done.taken = oil * -rate
    draw_together(-(gas + oil), e, done)


@inlined
def room_left(own: OleoNumbers, stroke: Any) -> Any:
    """Return the share of the volume that is left to the gas."""
    return 1.0 - stroke * own.area / own.volume


@inlined
def gas_in(own: OleoNumbers, stroke: Any) -> tuple[Any, Any]:
    """Return the force of the gas against the air around, and its energy above that at full extension."""
    n, p, room = own.exponent, own.pressure, room_left(own, stroke)
    inverse = np.exp(-n * np.log(room))
    if n == 1.0:
        energy = -p * own.volume * np.log(room)
    else:
        energy = p * own.volume / (n - 1.0) * (room * inverse - 1.0)
    return (p * inverse - own.ambient) * own.area, energy


@inlined
def oil_through(own: OleoNumbers, closing: Any) -> Any:
    """Return the force of the oil at a rate of the stroke."""
    return closing * closing * (-own.rebound if closing.real < 0.0 else own.orifice)
