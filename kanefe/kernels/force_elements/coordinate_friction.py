"""Dry friction along joint coordinates, with an anchor that holds (Eq. 11)."""

from __future__ import annotations

from typing import Any

from kanefe.kernels._numba import inlined
from kanefe.kernels.addresses import called_by_address
from kanefe.kernels.force_elements.places import POTENTIAL, SIGNATURE, TAKEN, WATCH_SIGNATURE, WRENCH, WRENCHES, P, V

HAS_MEMORY, SLIDING, STATIC, STIFFNESS, DAMPING, AT_REST, REST = range(7)
STRETCH, HELD = range(2)


@called_by_address(*SIGNATURE)
def coordinate_friction(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write the force along the coordinate; `numbers`: `kanefe.loads.coordinate_friction.CoordinateFriction.kernel`."""
    stretch, rate = states[STRETCH], ends[V]
    if numbers[AT_REST] > 0.0:
        stretch = stretch + ends[P] - numbers[REST]
    elastic = numbers[STIFFNESS] * stretch
    drag = elastic + numbers[DAMPING] * rate
    cap = numbers[STATIC] if is_held(numbers, states) else numbers[SLIDING]
    if drag.real > cap:
        drag = 0.0 * drag + cap
    elif drag.real < -cap:
        drag = 0.0 * drag - cap
    stretching = (drag - elastic) / numbers[DAMPING]
    out[POTENTIAL] = 0.5 * elastic * stretch
    out[TAKEN] = drag * rate - elastic * stretching
    out[WRENCHES] = -drag
    if numbers[AT_REST] == 0.0:
        out[WRENCHES + WRENCH + STRETCH] = stretching


@called_by_address(*WATCH_SIGNATURE)
def coordinate_friction_watch(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write how far the pull is above the cap at which it slips, and above that at which it sticks."""
    size = abs(numbers[STIFFNESS] * states[STRETCH] + numbers[DAMPING] * ends[V])
    held = is_held(numbers, states)
    out[0] = size - numbers[STATIC] if held else numbers[STATIC]
    out[1] = numbers[STATIC] if held and numbers[HAS_MEMORY] > 0.0 else size - numbers[SLIDING]


@inlined
def is_held(numbers: Any, states: Any) -> bool:
    """Tell whether it sticks, as far as that is remembered."""
    return numbers[HAS_MEMORY] == 0.0 or states[HELD].real > 0.5
