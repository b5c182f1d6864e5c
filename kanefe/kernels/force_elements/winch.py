"""Winches: a cable that is paid out or drawn in towards a tension, as fast as the winch can (Eq. 11)."""

from __future__ import annotations

from typing import Any

from kanefe.kernels.addresses import called_by_address
from kanefe.kernels.force_elements.places import GIVEN, POTENTIAL, SIGNATURE, WRENCH, WRENCHES
from kanefe.kernels.force_elements.rope import pull, put_gradient
from kanefe.kernels.force_elements.spring import interpolated

ENDS, STIFFNESS, LENGTH, SPEED, DAMPING, IS_SETTLED, CAN_BREAK, TABLE_SIZE, TABLE = range(9)


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
    k = numbers[STIFFNESS]
    stretch = length - numbers[LENGTH] - states[0]
    if stretch.real > 0.0 and not (numbers[CAN_BREAK] > 0.0 and states[1].real <= 0.0):
        tension += k * stretch
    out_speed = (tension - wanted) / numbers[DAMPING]
    if out_speed.real > numbers[SPEED]:
        out_speed = 0.0 * out_speed + numbers[SPEED]
    elif out_speed.real < -numbers[SPEED]:
        out_speed = 0.0 * out_speed - numbers[SPEED]
    if numbers[CAN_BREAK] > 0.0 and states[1].real <= 0.0:
        out_speed = 0.0 * out_speed
    out[POTENTIAL] = 0.5 * tension * tension / k
    out[GIVEN] = -tension * out_speed
    out[WRENCHES + WRENCH * count] = out_speed
    pull(count, tension, out)
