"""Surfaces of a scene, and which pairs of shapes touch by what."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from kanefe.contact.box_pair import box_probes
from kanefe.contact.convex import Convex
from kanefe.contact.convex_contact import are_convex, convex_probe
from kanefe.contact.shapes import Box, Capsule, Cylinder, Plane, Points, Sphere
from kanefe.errors import ModelError

if TYPE_CHECKING:
    from kanefe.contact.shape import Probe, SurfaceShape


class Surface(NamedTuple):
    """A shape that sits on a frame of a scene.

    Attributes
    ----------
    name : str
    frame : Frame
        Its axes are those of the shape.
    shape : SurfaceShape
    """

    name: str
    frame: Any
    shape: SurfaceShape


BALLS: tuple[type[SurfaceShape], ...] = (Sphere, Points)
"""Shapes whose probes touch all others: points and balls."""


def probes_on(one: SurfaceShape, other: SurfaceShape) -> tuple[Probe, ...] | None:
    """Return by what a shape touches another, or None where it does so by no fixed number of points and rings.

    Points and balls touch all shapes. Ends of a capsule, rings of a torus and of a cylinder, and corners of a box touch
    planes exactly, since the lowest place is always one of them. Boxes touch boxes by slots, which take on what meets.
    """
    if isinstance(one, Box) and isinstance(other, Box) and not one.inside and not other.inside:
        return box_probes(0.5 * one.size)
    probes = one.probes()
    if not probes or isinstance(other, Points):
        return None
    if isinstance(one, BALLS) or isinstance(other, Plane):
        return probes
    if (
        isinstance(one, (Capsule, Box, Convex))
        and getattr(other, "inside", False)
        and isinstance(other, (Box, Cylinder, Sphere))
    ):
        return probes  # a room that is convex meets corners first
    return None


def paired(a: Surface, b: Surface, label: str) -> tuple[Surface, Surface, tuple[Probe, ...]]:
    """Return which of two surfaces touches, which is touched, and by what; a pair of convex ones by one deepest place.

    Raises
    ------
    ModelError
        If neither order is served; the message says which shapes are.
    MissingDependency
        If a library finds where they meet, which is not installed.
    """
    for one, other in ((a, b), (b, a)):
        probes = probes_on(one.shape, other.shape)
        if probes is not None:
            return one, other, probes
    if are_convex(a.shape, b.shape):
        return a, b, (convex_probe(a.shape, b.shape, label),)
    raise ModelError(
        f"{label}: {a.shape.title} {a.name!r} and {b.shape.title} {b.name!r} do not touch by points that are known "
        "beforehand. Remedy: a plane, or balls (Sphere, Points) in the place of one, or two that are convex (Convex)"
    )
