"""Outputs of contacts of convex shapes: see `kanefe.kernels.contact.contact_outputs`."""

from __future__ import annotations

from typing import Any

from kanefe.kernels.compiler.addresses import called_by_address
from kanefe.kernels.compiler.local_numbers import local_numbers
from kanefe.kernels.contact.contact_outputs import nothing_told, put_told, tell_point, with_point
from kanefe.kernels.contact.contact_places import AT
from kanefe.kernels.contact.convex_forces import meet, slot
from kanefe.kernels.force_elements.bushing import nine
from kanefe.kernels.force_elements.places import WATCH_SIGNATURE, A


@called_by_address(*WATCH_SIGNATURE)
def convex_outputs(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write what `kanefe.contact.contact.Contact.columns` name."""
    slots = local_numbers()
    met, A_s = meet(numbers, ends, slots, slots, slots), nine(ends, A)
    seen = nothing_told()
    for i in range(int(numbers[AT.points])):
        depth, normal, place, share = slot(i, ends, met, slots, slots, slots)
        seen = with_point(numbers, i, depth, normal, place, share, A_s, ends, states, seen)
    put_told(numbers, states, seen, out)


@called_by_address(*WATCH_SIGNATURE)
def convex_point_outputs(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write `POINT_OUTPUTS` of each place."""
    slots = local_numbers()
    met, A_s = meet(numbers, ends, slots, slots, slots), nine(ends, A)
    for i in range(int(numbers[AT.points])):
        depth, normal, place, share = slot(i, ends, met, slots, slots, slots)
        tell_point(numbers, i, depth, normal, place, share, A_s, ends, states, out)
