"""Dry friction along joint coordinates that falls with the speed of slipping (Eq. 11)."""

from typing import Any

from kanefe.kernels.contact.falling import slip_speed
from kanefe.kernels.force_elements import coordinate_friction
from kanefe.kernels.force_elements.places import SIGNATURE, WATCH_SIGNATURE, Done
from kanefe.kernels.language import called_by_address, kernel


@called_by_address(*SIGNATURE)
def falling_friction(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write the forces along the coordinates, and the rates of the stretches."""
    own = coordinate_friction.FrictionNumbers(numbers)
    size, kept = coordinate_friction.pull_size(own, ends, states), coordinate_friction.share_kept(own, ends, states)
    if not coordinate_friction.is_held(own, states):
        slips = slip_force(own, size, states)
        kept = 1.0 - slips / size if slips.real > 0.0 else 0.0 * size + 1.0
    coordinate_friction.friction_along(own, ends, states, kept, Done(out))


@called_by_address(*WATCH_SIGNATURE)
def falling_friction_watch(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write how far the pull is above the cap at which it slips, and what of it slips."""
    own = coordinate_friction.FrictionNumbers(numbers)
    size, held = coordinate_friction.pull_size(own, ends, states), coordinate_friction.is_held(own, states)
    out[0] = size - own.static * coordinate_friction.load_on(own, states) if held else own.static
    out[1] = own.static if held else slip_force(own, size, states)


@kernel
def slip_force(own: coordinate_friction.FrictionNumbers, size: Any, states: Any) -> Any:
    """Return what friction leaves of a pull, N; below 0 it holds."""
    load = coordinate_friction.load_on(own, states)
    below = size - own.static * load
    if coordinate_friction.is_held(own, states) or size.real <= 0.0:
        return below
    fall = (own.static - own.sliding) * load
    s = slip_speed(size, own.sliding * load, fall, own.damping, own.stribeck_speed, 2.0)
    return own.damping * s if s.real > 0.0 else below
