"""How often a step of a run is looked at for events, where points of rigid contacts take turns."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kanefe.frames import Vector
from kanefe.kernels.events.watched_run import FIRST_SHARES, SHARES

if TYPE_CHECKING:
    from kanefe.tree.model_data import ModelData

MOST_LOOKS = 32
"""Number of looks at a step that is enough: where it turns by a third of a radian, each sees a hundredth."""


def look_shares(model: ModelData) -> Vector:
    """Return where in a step, relative to its length, functions of events are evaluated; the last one is its end.

    What touches is seen by the smallest of the gaps of all points. Each corner of a hull that turns past a surface
    makes a dip of its own in it, of which one look in each is needed; half of the corners are on the other side.
    """
    if not model.rigid_contacts:
        return SHARES
    points = max(len(model.rigid_contact(k).probes) for k in range(len(model.rigid_contacts)))
    count = min(max(len(SHARES), points // 2), MOST_LOOKS)
    return np.arange(1, count + 1) / count


def first_look_shares(model: ModelData) -> Vector:
    """Return the same of a step after an event, for a function that starts at zero."""
    return np.append(FIRST_SHARES[: -len(SHARES)], look_shares(model))
