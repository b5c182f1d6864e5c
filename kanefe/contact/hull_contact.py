"""Contacts of hulls of points on planes and in rooms, at corners that share the stiffness by what looks down."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from kanefe.contact.contact import Contact
from kanefe.contact.geometry.convex import Convex
from kanefe.frames import Vector
from kanefe.kernels.contact.contact_places import Kind
from kanefe.kernels.contact.hull_shares import CORNER_FACES, HULL_FACE

if TYPE_CHECKING:
    from kanefe.contact.wanted_contact import WantedContact


@dataclass(frozen=True, eq=False)
class HullContact(Contact):
    """A contact of a hull of points: see `Contact`, and `kanefe.kernels.contact.hull_shares` for their shares.

    Attributes
    ----------
    touching : Convex
        The hull, whose corners are the probes.
    """

    unbooked: ClassVar[str] = "where it goes over from one face to another while these press on the surface"

    touching: Any = None

    @classmethod
    def of(cls, wanted: WantedContact) -> Self | None:
        """Return the contact that a scene wants, if a hull touches with its corners."""
        return None if wanted.hull is None else cls.made(wanted, touching=wanted.hull)

    @property
    def face_numbers(self) -> Vector:
        """Where those of each corner begin and how many faces it has; then these, `HullFace`."""
        return faces_at_corners(self.touching)

    @property
    def found_as(self) -> Kind:
        """By what kernels know where its points are."""
        return Kind.HULL


def faces_at_corners(hull: Convex) -> Vector:
    """Return the faces at each corner of a hull as numbers: see `HullContact.face_numbers`."""
    corners = np.concatenate([loop for _, loop in hull.faces])
    rows = np.concatenate([np.tile((*normal, 1.0 / len(loop)), (len(loop), 1)) for normal, loop in hull.faces])
    counts = np.bincount(corners, minlength=len(hull.vertices))
    starts = CORNER_FACES * len(counts) + HULL_FACE * (np.cumsum(counts) - counts)
    return np.concatenate((np.column_stack((starts, counts)).ravel(), rows[np.argsort(corners, kind="stable")].ravel()))
