"""Loads that repeat with the turns of a rotor, in the axes of their frame (Eq. 11)."""

import math
from typing import Annotated, Any

from kanefe.kernels.force_elements.places import SIGNATURE, Done, Ends, Wrench, Wrenches
from kanefe.kernels.force_elements.spring import interpolated
from kanefe.kernels.language import Behind, Record, Rows, Vector, called_by_address, dot, inlined, numbers_from


class PeriodicLoadNumbers(Record):
    """Numbers of a load of a hub: rad/s, rad, how many harmonics and points of its table, the mean.

    The harmonics are followed by the times and shares of the table.
    """

    rate: float
    azimuth: float
    harmonic_count: float
    table_size: float
    mean: Wrench
    harmonics: Annotated[Any, Behind()]


class Harmonic(Record):
    """Part of such a load: how many per turn, and what goes with cosine and sine."""

    per_turn: float
    cosine: Wrench
    sine: Wrench


class Harmonics(Rows[Harmonic]):
    """Harmonics, and what follows them."""


@called_by_address(*SIGNATURE)
def periodic_load(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write force and moment; see `PeriodicLoadNumbers`."""
    force, moment = own_at(t, PeriodicLoadNumbers(numbers))
    put_own(force, moment, ends, Done(out))


@inlined
def own_at(t: float, own: PeriodicLoadNumbers) -> tuple[Vector, Vector]:
    """Return force and moment in the axes of the hub."""
    count, size, harmonics = int(own.harmonic_count), int(own.table_size), Harmonics(own.harmonics)
    turned, table = own.azimuth + own.rate * t, numbers_from(harmonics[count])
    share = interpolated(table, size, min(max(t, table[0]), table[size - 1]))
    force, moment = own.mean.force, own.mean.moment
    for i in range(count):
        one = harmonics[i]
        c, s = math.cos(one.per_turn * turned), math.sin(one.per_turn * turned)
        force += c * one.cosine.force + s * one.sine.force
        moment += c * one.cosine.moment + s * one.sine.moment
    return share * force, share * moment


@inlined
def put_own(force: Vector, moment: Vector, ends: Any, done: Done) -> None:
    """Write a force and a moment in the axes of the first end, and the power that they give."""
    end, on = Ends(ends)[0], Wrenches(done.wrenches)[0]
    on.force, on.moment = end.A @ force, end.A @ moment
    done.given = dot(on.force, end.v) + dot(on.moment, end.w)
