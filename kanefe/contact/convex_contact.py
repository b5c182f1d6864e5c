"""Contacts of convex shapes on each other, at the places of a patch that are found at each state."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from kanefe.contact.contact import Contact
from kanefe.contact.convex_numbers import convex_numbers, slots_of
from kanefe.contact.geometry.convex import Convex
from kanefe.contact.geometry.shape import Probe, SurfaceShape
from kanefe.contact.shapes import Box, Capsule, Cylinder
from kanefe.frames import Vector
from kanefe.kernels.contact.contact_places import Kind
from kanefe.kernels.contact.convex_places import PAIR
from kanefe.kernels.contact.convex_shapes import ConvexShape

if TYPE_CHECKING:
    from kanefe.contact.wanted_contact import WantedContact

NO_SHAPE = 9.0
"""Kind of what the numbers of two shapes stand for, behind those of `kanefe.kernels.contact.contact_shapes`."""


@dataclass(frozen=True, eq=False)
class ConvexContact(Contact):
    """A contact of two convex shapes: see `Contact`, and `kanefe.kernels.contact.convex_patch` for its points.

    Attributes
    ----------
    touching : SurfaceShape
        That of the probes.
    """

    unbooked: ClassVar[str] = "where the face that both shapes share changes while they press on each other"

    touching: Any = None

    @classmethod
    def of(cls, wanted: WantedContact) -> Self | None:
        """Return the contact that a scene wants, if it is one of two convex shapes."""
        return None if wanted.convex is None else cls.made(wanted, touching=wanted.convex)

    @property
    def surface_numbers(self) -> Vector:
        """The numbers of both shapes, behind where those of the touched one begin."""
        own = convex_numbers(self.touching)
        return np.concatenate(((NO_SHAPE, PAIR + len(own)), own, convex_numbers(self.shape)))

    @property
    def found_as(self) -> Kind:
        """By what kernels know where its points are."""
        return Kind.CONVEX


def are_convex(*shapes: SurfaceShape) -> bool:
    """Return whether it is known how shapes are to each other."""
    known = (Box, Capsule, Cylinder, Convex)
    return all(isinstance(shape, known) and not getattr(shape, "inside", False) for shape in shapes)


def convex_probes(one: SurfaceShape, other: SurfaceShape, label: str) -> tuple[Probe, ...]:
    """Return what stands for the places at which a convex shape touches another; each may be anywhere on it."""
    count, extent = slots_of(one, other, label), np.array((ConvexShape(convex_numbers(one)).size, 0.0, 0.0))
    radius = one.radius if isinstance(one, Capsule) else 0.0
    return tuple(Probe(np.zeros(3), radius, 1.0 / count, -1.0 - i, extent) for i in range(count))
