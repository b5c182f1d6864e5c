"""Contacts of convex shapes on each other, by the deepest place of both, which a library finds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from kanefe.contact.contact import Contact
from kanefe.contact.contact_data import Met
from kanefe.contact.geometry._coal import check_library, nearest
from kanefe.contact.geometry.convex import Convex
from kanefe.contact.geometry.shape import Probe, SurfaceShape
from kanefe.contact.shapes import Box, Capsule, Cylinder, Sphere
from kanefe.loads.action import End, LoadKernel

if TYPE_CHECKING:
    from kanefe.contact.wanted_contact import WantedContact
    from kanefe.loads.reach import LoadReach


@dataclass(frozen=True, eq=False)
class ConvexContact(Contact):
    """A contact of two convex shapes at one place: see `Contact`. It is evaluated from Python, on both routes.

    Attributes
    ----------
    touching : SurfaceShape
        That of the only probe.
    """

    touching: Any = None

    @classmethod
    def of(cls, wanted: WantedContact) -> Self | None:
        """Return the contact that a scene wants, if a library has to find where it touches."""
        return None if wanted.convex is None else cls.made(wanted, touching=wanted.convex)

    def found(self, ends: Sequence[End]) -> Met:
        """Return where its only point touches, found by a library."""
        surface, end = ends[0], ends[self.probes[0][0]]
        A = surface.A
        gap, normal, point = nearest(self.touching, A.T @ end.A, A.T @ (end.p - surface.p), self.shape)
        return Met(-gap, tuple((A @ normal).tolist()), tuple((surface.p + A @ point).tolist()))

    @property
    def reach(self) -> LoadReach | None:
        """The library tests bounds itself."""
        return None

    @property
    def kernel(self) -> LoadKernel | None:
        """None: no compiled code calls the library."""
        return None


def are_convex(*shapes: SurfaceShape) -> bool:
    """Return whether a library knows how shapes are to each other."""
    known = (Sphere, Box, Capsule, Cylinder, Convex)
    return all(isinstance(shape, known) and not getattr(shape, "inside", False) for shape in shapes)


def convex_probe(one: SurfaceShape, other: SurfaceShape, label: str) -> Probe:
    """Return what stands for a convex shape on another; a MissingDependency names the library where there is none."""
    check_library(f"{label}, of a {one.title} on a {other.title},")
    radius = one.radius if isinstance(one, (Sphere, Capsule)) else 0.0
    return Probe(np.zeros(3), radius)
