"""Winches: a cable that is paid out or drawn in towards a tension, as fast as the winch can (Eq. 11)."""

from typing import Annotated, Any

from kanefe.kernels.force_elements.places import SIGNATURE, WATCH_SIGNATURE, Done, rates_of
from kanefe.kernels.force_elements.rope import Cable, pull, put_gradient, put_margins, way_over
from kanefe.kernels.force_elements.spring import interpolated
from kanefe.kernels.language import Behind, Record, called_by_address, inlined


class WinchNumbers(Record):
    """Numbers of a winch; `length` is that without tension at the start.

    The table has times (s) and tensions (N), and the lengths of the parts of its way at the start (m) follow.
    """

    cable: Cable
    stiffness: float
    length: float
    speed: float
    damping: float
    is_settled: float
    table_size: float
    table: Annotated[Any, Behind()]


@called_by_address(*SIGNATURE)
def winch(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write the pull on all points and how fast cable is paid out; see `WinchNumbers`."""
    own, done = WinchNumbers(numbers), Done(out)
    count = int(own.cable.ends)
    length, _ = put_gradient(count, ends, done)
    tension = tension_of(t, own, length, states)
    if own.is_settled > 0.0:
        done.potential = tension * length
    else:
        out_speed = (tension - wanted_at(t, own)) / own.damping
        if abs(out_speed.real) > own.speed:
            out_speed = 0.0 * out_speed + (own.speed if out_speed.real > 0.0 else -own.speed)
        if has_broken(own, states):
            out_speed = 0.0 * out_speed
        done.potential = 0.5 * tension * tension / own.stiffness
        done.given = -tension * out_speed
        rates_of(done, count)[0] = out_speed
    pull(count, tension, done)


@called_by_address(*WATCH_SIGNATURE)
def winch_watch(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write how far it is from wound up, how far it is stretched (twice), and how far it is from its break."""
    own = WinchNumbers(numbers)
    length, _ = way_over(int(own.cable.ends), ends)
    stretch = -own.length if has_broken(own, states) else length - own.length - states[0]
    margin = own.cable.breaking_load - tension_of(t, own, length, states)
    put_margins(own.cable, own.table, 2 * int(own.table_size), ends, (stretch, margin), out)


@called_by_address(*WATCH_SIGNATURE)
def winch_change(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write that the cable is gone, and its strain energy with it."""
    own = WinchNumbers(numbers)
    tension = tension_of(t, own, way_over(int(own.cable.ends), ends)[0], states)
    out[0], out[2] = -0.5 * tension * tension / own.stiffness, 0.0


@inlined
def has_broken(own: WinchNumbers, states: Any) -> bool:
    """Return whether the cable is gone."""
    return own.cable.breaking_load > 0.0 and states[1].real <= 0.0


@inlined
def wanted_at(t: float, own: WinchNumbers) -> float:
    """Return the tension that the winch is to hold, the same before its table and after it."""
    table, size = own.table, int(own.table_size)
    return interpolated(table, size, min(max(t, table[0]), table[size - 1]))


@inlined
def tension_of(t: float, own: WinchNumbers, length: Any, states: Any) -> Any:
    """Return the tension of the cable: that which is wanted, of a winch that is settled."""
    tension = 0.0 * length
    if own.is_settled > 0.0:
        return tension + wanted_at(t, own)
    stretch = length - own.length - states[0]
    if stretch.real > 0.0 and not has_broken(own, states):
        tension += own.stiffness * stretch
    return tension
