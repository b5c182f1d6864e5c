"""What contacts have as outputs, and what they say of a status: without the code that writes them."""

from __future__ import annotations

from kanefe.kernels.values.records import Record, Rows
from kanefe.kernels.values.tensors import Vector

OPEN, STICKS, SLIPS = range(3)


class ContactOutputs(Record):
    """Outputs of a contact as a whole: see `kanefe.contact.contact.Contact.columns`."""

    force: Vector
    pressed: float
    rubbed: float
    depth: float
    slip: float
    place: Vector
    work: float
    status: float


class PointOutputs(Record):
    """Outputs of a contact point, vectors in axes of the surface: N, m, m/s, and its status."""

    pressed: float
    rubbed: Vector
    depth: float
    stretch: Vector
    slip: Vector
    status: float


PointsOutputs = Rows[PointOutputs]


CONTACT_OUTPUTS, POINT_OUTPUTS = ContactOutputs.number_count, PointOutputs.number_count
"""Numbers of outputs of a contact and of a point."""
