"""Winches: a cable that is paid out or drawn in towards a tension, as fast as the winch can (Eq. 11)."""

from __future__ import annotations

from collections import namedtuple
from typing import Any

from kanefe.kernels.compiler._numba import inlined
from kanefe.kernels.compiler.addresses import called_by_address
from kanefe.kernels.force_elements.blocks import places
from kanefe.kernels.force_elements.places import GIVEN, POTENTIAL, SIGNATURE, WATCH_SIGNATURE, WRENCH, WRENCHES
from kanefe.kernels.force_elements.rope import pull, put_gradient, put_margins, way_over
from kanefe.kernels.force_elements.spring import interpolated

WinchNumbers = namedtuple(
    "WinchNumbers",
    "ends stiffness length speed damping is_settled breaking_load looks_for_slack table_size table parts",
)
"""Numbers of a winch; `length` is that without tension at the start, the table has times (s) and tensions (N). The
others, and the parts of its way, are as in `RopeNumbers`."""

AT = places(WinchNumbers)


@called_by_address(*SIGNATURE)
def winch(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write the pull on all points and how fast cable is paid out; see `WinchNumbers`."""
    count = int(numbers[AT.ends])
    length, rate = put_gradient(count, ends, out)
    tension = tension_of(t, numbers, length, states)
    if numbers[AT.is_settled] > 0.0:
        out[POTENTIAL] = tension * length
        out[GIVEN] = 0.0 * rate
        pull(count, tension, out)
        return
    out_speed = (tension - wanted_at(t, numbers)) / numbers[AT.damping]
    if out_speed.real > numbers[AT.speed]:
        out_speed = 0.0 * out_speed + numbers[AT.speed]
    elif out_speed.real < -numbers[AT.speed]:
        out_speed = 0.0 * out_speed - numbers[AT.speed]
    if has_broken(numbers, states):
        out_speed = 0.0 * out_speed
    out[POTENTIAL] = 0.5 * tension * tension / numbers[AT.stiffness]
    out[GIVEN] = -tension * out_speed
    out[WRENCHES + WRENCH * count] = out_speed
    pull(count, tension, out)


@called_by_address(*WATCH_SIGNATURE)
def winch_watch(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write how far it is from wound up, how far it is stretched (twice), and how far it is from its break."""
    length, breaking = way_over(int(numbers[AT.ends]), ends)[0], numbers[AT.breaking_load]
    is_broken = has_broken(numbers, states)
    stretch = -numbers[AT.length] if is_broken else length - numbers[AT.length] - states[0]
    margin = breaking - tension_of(t, numbers, length, states)
    parts, count = AT.table + 2 * int(numbers[AT.table_size]), int(numbers[AT.ends])
    put_margins(numbers, parts, count, ends, (1.0, numbers[AT.looks_for_slack]), stretch, breaking, margin, out)


@called_by_address(*WATCH_SIGNATURE)
def winch_change(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write that the cable is gone, and its strain energy with it."""
    tension = tension_of(t, numbers, way_over(int(numbers[AT.ends]), ends)[0], states)
    out[0], out[2] = -0.5 * tension * tension / numbers[AT.stiffness], 0.0


@inlined
def has_broken(numbers: Any, states: Any) -> bool:
    """Return whether the cable is gone."""
    return numbers[AT.breaking_load] > 0.0 and states[1].real <= 0.0


@inlined
def wanted_at(t: float, numbers: Any) -> float:
    """Return the tension that the winch is to hold, the same before its table and after it."""
    size = int(numbers[AT.table_size])
    within = min(max(t, numbers[AT.table]), numbers[AT.table + size - 1])
    return interpolated(numbers, AT.table, size, within)


@inlined
def tension_of(t: float, numbers: Any, length: Any, states: Any) -> Any:
    """Return the tension of the cable: that which is wanted, of a winch that is settled."""
    tension = 0.0 * length
    if numbers[AT.is_settled] > 0.0:
        return tension + wanted_at(t, numbers)
    stretch = length - numbers[AT.length] - states[0]
    if stretch.real > 0.0 and not has_broken(numbers, states):
        tension += numbers[AT.stiffness] * stretch
    return tension
