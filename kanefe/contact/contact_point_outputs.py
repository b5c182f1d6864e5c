"""Outputs of each point of a compliant contact."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from kanefe.contact.contact import OPEN, SLIPS, STICKS
from kanefe.contact.touching_point import along_surface, velocity_past
from kanefe.frames import Matrix, Vector
from kanefe.loads.action import End

if TYPE_CHECKING:
    from kanefe.contact.contact import Contact
    from kanefe.contact.touching_point import Touch

POINT_OUTPUTS = 12
"""Number of outputs of a contact point: normal force and friction (N), depth and stretch (m), slip (m/s), status;
vectors in axes of the surface."""


def contact_point_outputs(contact: Contact, ends: Sequence[End], states: Vector) -> Matrix:
    """Return what each point does, (points, 12): see `kanefe.results.contact_points`."""
    return np.array([_told(contact, ends, touch) for touch in contact.touches(ends, states)])


def _told(contact: Contact, ends: Sequence[End], touch: Touch) -> Vector:
    law, n, back = contact.friction, touch.normal, ends[0].A.T
    found = np.zeros(POINT_OUTPUTS)
    found[4], found[5:8] = touch.depth, back @ along_surface(touch.stretch, n)
    if touch.depth <= 0.0:
        found[11] = OPEN
        return found
    sticks = law is not None and touch.slip_margin <= 0.0
    found[0], found[1:4] = touch.normal_force, -back @ touch.tangential
    if law is None:
        found[8:11] = back @ along_surface(velocity_past(ends[0], ends[touch.end], touch.point), n)
    elif not (sticks and law.holds):  # bristles creep; of what sticks there is round-off alone
        found[8:11] = back @ along_surface(touch.along - touch.stretch_rate, n)
    found[11] = STICKS if sticks else SLIPS
    return found
