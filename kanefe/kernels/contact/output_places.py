"""What contacts have as outputs, status and margins: without the code that writes them."""

from enum import IntEnum

from kanefe.kernels.language import Record, Rows, Vector


class Status(IntEnum):
    """Status of a point, and of what several have together the largest."""

    OPEN = 0
    STICKS = 1
    SLIPS = 2


class Margins(Record):
    """How far points of rigid contacts are from their next events.

    Attributes
    ----------
    gap : float
        To a touch, m.
    normal, slip_margin : float
        The normal force, with which they lift, and the friction that is left until they slip, N.
    left_of_slip : float
        What is zero where they stick, m/s.
    """

    gap: float
    normal: float
    slip_margin: float
    left_of_slip: float


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
ContactsOutputs = Rows[ContactOutputs]


CONTACT_OUTPUTS, POINT_OUTPUTS = ContactOutputs.number_count, PointOutputs.number_count
"""Numbers of outputs of a contact and of a point."""
