"""Outputs of each point of a compliant contact."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from kanefe.contact.contact_evaluation import InPython
from kanefe.frames import Matrix, Vector
from kanefe.kernels.contact.output_places import POINT_OUTPUTS
from kanefe.loads.action import End

if TYPE_CHECKING:
    from kanefe.contact.contact import Contact

__all__ = ["POINT_OUTPUTS", "contact_point_outputs"]


def contact_point_outputs(contact: Contact, ends: Sequence[End], states: Vector) -> Matrix:
    """Return what each point does, (points, 12): see `kanefe.results.contact_points`."""
    return np.array(InPython(contact, ends, states).point_outputs()).reshape(-1, POINT_OUTPUTS)
