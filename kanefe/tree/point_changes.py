"""What an event changes at a point of a rigid contact, and the names of its reported events."""

from __future__ import annotations

from typing import NamedTuple

from kanefe.contact.contact import OPEN, SLIPS, STICKS
from kanefe.contact.contact_events import of_point


class PointChange(NamedTuple):
    """What an event changes at a point of a contact.

    Attributes
    ----------
    contact : str
    point : int
    t : float
        s.
    before, after : int
        OPEN, STICKS or SLIPS.
    is_struck : bool
        Whether it took part in an impact, after which it may be open again.
    has_friction : bool
    """

    contact: str
    point: int
    t: float
    before: int
    after: int
    is_struck: bool
    has_friction: bool

    @property
    def names(self) -> list[str]:
        """Names of its reported events: a point that touches and slips at once has both."""
        has_touched = self.before == OPEN and (self.after != OPEN or self.is_struck)
        found = {
            "touch": has_touched,
            "lift": self.before != OPEN and self.after == OPEN,
            "slip": self.has_friction and self.after == SLIPS != self.before,
            "stick": self.has_friction and self.after == STICKS != self.before,
        }
        return [f"{self.contact} {of_point(what, self.point)}" for what, is_reported in found.items() if is_reported]
