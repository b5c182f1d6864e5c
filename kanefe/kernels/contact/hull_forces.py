"""Contacts of hulls of points on planes and in rooms: the laws act at their corners, by shares that change."""

from __future__ import annotations

from typing import Any

from kanefe.kernels.compiler.addresses import called_by_address
from kanefe.kernels.contact.contact_forces import change_points, put_points, watch_points
from kanefe.kernels.contact.hull_shares import hull_corner, hull_met
from kanefe.kernels.force_elements.places import SIGNATURE, WATCH_SIGNATURE


@called_by_address(*SIGNATURE)
def hull_contact(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write the forces on the surface, the first end, and on the hull, and the rates of the states."""
    put_points(hull_corner, hull_met(numbers, ends), numbers, ends, states, out)


@called_by_address(*WATCH_SIGNATURE)
def hull_watch(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write its event values: see `kanefe.contact.contact_events.Watched`."""
    watch_points(hull_corner, hull_met(numbers, ends), numbers, ends, states, out)


@called_by_address(*WATCH_SIGNATURE)
def hull_change(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write the states after an event: see `kanefe.kernels.contact.contact_forces.contact_change`."""
    change_points(hull_corner, hull_met(numbers, ends), int(inputs[0]), numbers, ends, states, out)
