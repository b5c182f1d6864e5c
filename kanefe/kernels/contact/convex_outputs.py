"""Outputs of contacts of convex shapes: see `kanefe.kernels.contact.contact_outputs`."""

from __future__ import annotations

from typing import Any

from kanefe.kernels.compiler.addresses import called_by_address
from kanefe.kernels.compiler.local_numbers import local_numbers
from kanefe.kernels.contact.contact_outputs import tell_points, tell_whole
from kanefe.kernels.contact.convex_forces import meet, slot
from kanefe.kernels.force_elements.places import WATCH_SIGNATURE


@called_by_address(*WATCH_SIGNATURE)
def convex_outputs(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write what `kanefe.contact.contact.Contact.columns` name."""
    slots = local_numbers()
    tell_whole(slot, meet(numbers, ends, slots, slots, slots), numbers, ends, states, out)


@called_by_address(*WATCH_SIGNATURE)
def convex_point_outputs(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write `POINT_OUTPUTS` of each place."""
    slots = local_numbers()
    tell_points(slot, meet(numbers, ends, slots, slots, slots), numbers, ends, states, out)
