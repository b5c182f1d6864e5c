"""Surfaces of a scene, and which pairs of shapes touch by what."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from kanefe.contact.box_pair import box_probes
from kanefe.contact.convex_contact import are_convex, convex_probes
from kanefe.contact.geometry.convex import Convex
from kanefe.contact.shapes import Box, Capsule, Cylinder, HeightField, Mesh, Plane, Points, Sphere, Torus
from kanefe.errors import ModelError

if TYPE_CHECKING:
    from kanefe.contact.geometry.shape import Probe, SurfaceShape


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
"""Shapes whose contact points touch all other shapes: points and balls."""


SAMPLED: tuple[type[SurfaceShape], ...] = (Capsule, Cylinder, Box, Convex)
"""Shapes that are represented by points or balls where the ground is not flat: see `SurfaceShape.sampled`."""

COARSEST, FINEST = 0.5, 0.125
"""Largest and smallest distance of these, relative to the radius of the ball around the shape; balls at most by their
own radius."""


def probes_on(one: SurfaceShape, other: SurfaceShape) -> tuple[Probe, ...] | None:
    """Return by what a shape touches another, or None where it does so by no fixed number of points and rings.

    Points and balls touch all shapes. Ends of a capsule, rings of a torus and of a cylinder, and corners of a box touch
    planes exactly, since the lowest place is always one of them; a torus rolls over heights that are less bent than it.
    Boxes touch boxes by slots, which take on what meets. For what is convex points stand on uneven ground.
    """
    if isinstance(one, Box) and isinstance(other, Box) and not one.inside and not other.inside:
        return box_probes(0.5 * one.size)
    probes = one.probes()
    if not probes or isinstance(other, Points):
        return None
    if (
        isinstance(one, BALLS)
        or isinstance(other, Plane)
        or (isinstance(one, Torus) and isinstance(other, HeightField))
    ):
        return probes
    inside = getattr(other, "inside", False)
    if isinstance(one, (Capsule, Box, Convex)) and inside and isinstance(other, (Box, Cylinder, Sphere)):
        return probes  # a room that is convex meets corners first
    if isinstance(one, SAMPLED) and is_uneven(other) and not getattr(one, "inside", False):
        return one.sampled(spacing_on(one, other)).probes()
    return None


def is_uneven(shape: SurfaceShape) -> bool:
    """Return whether a shape may touch another one anywhere, and in several places: it is not convex."""
    return isinstance(shape, HeightField) or (isinstance(shape, Mesh) and not isinstance(shape, Convex))


def spacing_on(one: SurfaceShape, other: SurfaceShape) -> float:
    """Return how far apart points are that stand for a shape on uneven ground, m: as far as places of its grid."""
    size = one.bounds.size
    widest = min(COARSEST * size, one.radius) if isinstance(one, Capsule) else COARSEST * size
    if isinstance(other, HeightField):
        step = min(float(places[1] - places[0]) for places in (other.x, other.y))
        return min(max(step, FINEST * size), widest)
    return widest


def paired(a: Surface, b: Surface, label: str) -> tuple[Surface, Surface, tuple[Probe, ...]]:
    """Return which of two surfaces touches, which is touched, and by what; a pair of convex ones by a patch.

    Raises
    ------
    ModelError
        If neither order is served; the message says which shapes are.
    """
    for one, other in ((a, b), (b, a)):
        probes = probes_on(one.shape, other.shape)
        if probes is not None:
            return one, other, probes
    if are_convex(a.shape, b.shape):
        return a, b, convex_probes(a.shape, b.shape, label)
    raise ModelError(
        f"{label}: {a.shape.title} {a.name!r} and {b.shape.title} {b.name!r} do not touch by points that are known "
        "beforehand. Remedy: a plane, or points instead of one, shape.sampled(spacing), or two that are convex "
        "(Convex)"
    )
