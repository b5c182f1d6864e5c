"""Dry friction along joint coordinates that falls with the speed of slipping (Eq. 11)."""

from __future__ import annotations

from typing import Any

from kanefe.kernels.compiler._numba import kernel
from kanefe.kernels.compiler.addresses import called_by_address
from kanefe.kernels.contact.falling import slip_speed
from kanefe.kernels.force_elements.coordinate_friction import (
    AT,
    friction_along,
    is_held,
    load_on,
    pull_size,
    share_kept,
)
from kanefe.kernels.force_elements.places import SIGNATURE, WATCH_SIGNATURE


@called_by_address(*SIGNATURE)
def falling_friction(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write the forces along the coordinates, and the rates of the stretches."""
    size = pull_size(numbers, ends, states)
    kept = share_kept(numbers, ends, states)
    if not is_held(numbers, states):
        slips = slip_force(numbers, size, ends, states)
        kept = 1.0 - slips / size if slips.real > 0.0 else 0.0 * size + 1.0
    friction_along(numbers, ends, states, kept, out)


@called_by_address(*WATCH_SIGNATURE)
def falling_friction_watch(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write how far the pull is above the cap at which it slips, and what of it slips."""
    size, held = pull_size(numbers, ends, states), is_held(numbers, states)
    out[0] = size - numbers[AT.static] * load_on(numbers, states) if held else numbers[AT.static]
    out[1] = numbers[AT.static] if held else slip_force(numbers, size, ends, states)


@kernel
def slip_force(numbers: Any, size: Any, ends: Any, states: Any) -> Any:
    """Return what friction leaves of a pull, N; below 0 it holds."""
    load, c = load_on(numbers, states), numbers[AT.damping]
    below = size - numbers[AT.static] * load
    if is_held(numbers, states):
        return below
    if size.real <= 0.0:
        return below
    fall = (numbers[AT.static] - numbers[AT.sliding]) * load
    s = slip_speed(size, numbers[AT.sliding] * load, fall, c, numbers[AT.stribeck_speed], 2.0)
    return c * s if s.real > 0.0 else below
