"""Winches: a cable that is paid out or drawn in towards a tension, as fast as the winch can (Eq. 11)."""

from __future__ import annotations

from typing import Any

from kanefe.kernels.compiler._numba import inlined
from kanefe.kernels.compiler.addresses import called_by_address
from kanefe.kernels.force_elements.places import GIVEN, POTENTIAL, SIGNATURE, WATCH_SIGNATURE, WRENCH, WRENCHES
from kanefe.kernels.force_elements.rope import pull, put_gradient
from kanefe.kernels.force_elements.spring import interpolated

ENDS, STIFFNESS, LENGTH, SPEED, DAMPING, IS_SETTLED, BREAKING_LOAD, TABLE_SIZE, TABLE = range(9)


@called_by_address(*SIGNATURE)
def winch(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write the pull on all points and how fast cable is paid out; `numbers`: `kanefe.loads.winch.Winch.kernel`."""
    count, size = int(numbers[ENDS]), int(numbers[TABLE_SIZE])
    length, rate = put_gradient(count, ends, out)
    tension = 0.0 * length
    wanted = interpolated(numbers, TABLE, size, min(max(t, numbers[TABLE]), numbers[TABLE + size - 1]))
    if numbers[IS_SETTLED] > 0.0:
        tension += wanted
        out[POTENTIAL] = tension * length
        out[GIVEN] = 0.0 * rate
        pull(count, tension, out)
        return
    k, is_broken = numbers[STIFFNESS], has_broken(numbers, states)
    stretch = length - numbers[LENGTH] - states[0]
    if stretch.real > 0.0 and not is_broken:
        tension += k * stretch
    out_speed = (tension - wanted) / numbers[DAMPING]
    if out_speed.real > numbers[SPEED]:
        out_speed = 0.0 * out_speed + numbers[SPEED]
    elif out_speed.real < -numbers[SPEED]:
        out_speed = 0.0 * out_speed - numbers[SPEED]
    if is_broken:
        out_speed = 0.0 * out_speed
    out[POTENTIAL] = 0.5 * tension * tension / k
    out[GIVEN] = -tension * out_speed
    out[WRENCHES + WRENCH * count] = out_speed
    pull(count, tension, out)


@called_by_address(*WATCH_SIGNATURE)
def winch_watch(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write twice how far the cable is stretched, and what its tension is below that at which it breaks."""
    length, _ = put_gradient(int(numbers[ENDS]), ends, out)  # what that leaves behind is not read
    is_broken = has_broken(numbers, states)
    stretch = -numbers[LENGTH] if is_broken else length - numbers[LENGTH] - states[0]
    out[0] = out[1] = stretch
    if numbers[BREAKING_LOAD] > 0.0:
        out[2] = numbers[BREAKING_LOAD] - max(numbers[STIFFNESS] * stretch, 0.0)


@inlined
def has_broken(numbers: Any, states: Any) -> bool:
    """Tell whether the cable is gone."""
    return numbers[BREAKING_LOAD] > 0.0 and states[1].real <= 0.0
