"""Dry friction along joint coordinates that falls with the speed of slipping (Eq. 11)."""

from typing import Any

from kanefe.kernels.contact.falling import slip_speed
from kanefe.kernels.force_elements.coordinate_friction import (
    FrictionNumbers,
    friction_along,
    is_held,
    load_on,
    pull_size,
    share_kept,
)
from kanefe.kernels.force_elements.places import SIGNATURE, WATCH_SIGNATURE, Done
from kanefe.kernels.language import called_by_address, kernel


@called_by_address(*SIGNATURE)
def falling_friction(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write the forces along the coordinates, and the rates of the stretches."""
    own = FrictionNumbers(numbers)
    size, kept = pull_size(own, ends, states), share_kept(own, ends, states)
    if not is_held(own, states):
        slips = slip_force(own, size, states)
        kept = 1.0 - slips / size if slips.real > 0.0 else 0.0 * size + 1.0
    friction_along(own, ends, states, kept, Done(out))


@called_by_address(*WATCH_SIGNATURE)
def falling_friction_watch(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write how far the pull is above the cap at which it slips, and what of it slips."""
    own = FrictionNumbers(numbers)
    size, held = pull_size(own, ends, states), is_held(own, states)
    out[0] = size - own.static * load_on(own, states) if held else own.static
    out[1] = own.static if held else slip_force(own, size, states)


@kernel
def slip_force(own: FrictionNumbers, size: Any, states: Any) -> Any:
    """Return what friction leaves of a pull, N; below 0 it holds."""
    load = load_on(own, states)
    below = size - own.static * load
    if is_held(own, states) or size.real <= 0.0:
        return below
    fall = (own.static - own.sliding) * load
    s = slip_speed(size, own.sliding * load, fall, own.damping, own.stribeck_speed, 2.0)
    return own.damping * s if s.real > 0.0 else below
