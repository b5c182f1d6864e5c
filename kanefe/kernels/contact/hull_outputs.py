"""Outputs of contacts of hulls of points: see `kanefe.kernels.contact.contact_outputs`."""

from __future__ import annotations

from typing import Any

from kanefe.kernels.compiler.addresses import called_by_address
from kanefe.kernels.contact.contact_outputs import tell_points, tell_whole
from kanefe.kernels.contact.hull_shares import hull_corner, hull_met
from kanefe.kernels.force_elements.places import WATCH_SIGNATURE


@called_by_address(*WATCH_SIGNATURE)
def hull_outputs(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write what `kanefe.contact.contact.Contact.columns` name."""
    tell_whole(hull_corner, hull_met(numbers, ends), numbers, ends, states, out)


@called_by_address(*WATCH_SIGNATURE)
def hull_point_outputs(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write `POINT_OUTPUTS` of each corner."""
    tell_points(hull_corner, hull_met(numbers, ends), numbers, ends, states, out)
