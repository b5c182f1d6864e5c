"""Contacts of convex shapes on each other, by the deepest place of both, which a library finds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from kanefe.contact.contact import Contact
from kanefe.contact.geometry._coal import check_library, nearest
from kanefe.contact.geometry.convex import Convex
from kanefe.contact.geometry.shape import Probe, SurfaceShape
from kanefe.contact.shapes import Box, Capsule, Cylinder, Sphere
from kanefe.frames import Vector
from kanefe.loads.base import End, LoadKernel

if TYPE_CHECKING:
    from kanefe.contact.box_pair import BoxPair
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

    def _located(self, surface: End, end: End, probe: Probe, met: BoxPair | None) -> tuple[float, Vector, Vector]:
        """Return depth, normal and place."""
        A = surface.A
        gap, normal, point = nearest(self.touching, A.T @ end.A, A.T @ (end.p - surface.p), self.shape)
        return -gap, A @ normal, surface.p + A @ point

    @property
    def reach(self) -> LoadReach | None:
        """The library looks at bounds itself."""
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
