"""What stands for a box on a box: a slot for each of the places that may touch, so that friction knows them again."""

from __future__ import annotations

import numpy as np

from kanefe.contact.geometry.shape import Probe
from kanefe.frames import Vector
from kanefe.kernels.contact.contact_boxes import SLOT

CORNER_SHARE, EDGE_SHARE = 0.25, 0.5


def box_probes(half: Vector) -> tuple[Probe, ...]:
    """Return the slots of a box of given half sizes that touches a box: see `kanefe.kernels.contact.contact_boxes`."""
    return tuple(
        Probe(np.zeros(3), 0.0, EDGE_SHARE if slot == SLOT.edges else CORNER_SHARE, -1.0 - slot, half)
        for slot in range(SLOT.slots)
    )
