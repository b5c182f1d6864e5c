"""The numbers of convex shapes for compiled code: see `kanefe.kernels.contact.convex_shapes`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kanefe.contact.geometry.convex import Convex
from kanefe.contact.shapes import Box, Capsule, Cylinder
from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector
from kanefe.kernels.compiler.local_numbers import LOCAL_NUMBERS
from kanefe.kernels.contact.convex_edges import Slot
from kanefe.kernels.contact.convex_shapes import ConvexShape
from kanefe.kernels.values.filled import filled

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kanefe.contact.geometry.shape import SurfaceShape

DISC_CORNERS = 6
"""Number of corners by which the end of a cylinder is represented."""


def convex_numbers(shape: SurfaceShape) -> Vector:
    """Return the numbers of a box, a capsule, a cylinder or a hull."""
    none = np.zeros(3)
    if isinstance(shape, (Capsule, Cylinder)):
        ends, half = 0.5 * shape.length * np.outer((-1.0, 1.0), shape.axis), 0.5 * shape.length
        if isinstance(shape, Capsule):
            return _numbers(shape.radius, 0.0, shape.axis, half + shape.radius, ends, ())
        size = float(np.hypot(half, shape.radius))
        return _numbers(0.0, shape.radius, shape.axis, size, ends, (), DISC_CORNERS)
    if isinstance(shape, Box):
        shape = Convex([probe.point for probe in shape.probes()])
    if not isinstance(shape, Convex):
        raise TypeError(f"{shape.title} is not convex")
    size = float(np.linalg.norm(shape.vertices, axis=1).max())
    return _numbers(0.0, 0.0, none, size, shape.vertices, shape.faces)


def _numbers(
    margin: float,
    disc: float,
    axis: Vector,
    size: float,
    vertices: Matrix,
    faces: Sequence[tuple[Vector, Vector]],
    corners: int = 0,
) -> Vector:
    firsts = np.cumsum([0, *(len(loop) for _, loop in faces)])
    most = max((len(loop) for _, loop in faces), default=corners)
    rows = [(*normal, first, len(loop)) for (normal, loop), first in zip(faces, firsts, strict=False)]
    return filled(
        ConvexShape,
        margin=margin,
        disc=disc,
        axis=axis,
        centre=vertices.mean(axis=0),
        size=size,
        count=len(vertices),
        faces=len(faces),
        corners=most,
        vertices=np.concatenate((vertices.ravel(), np.ravel(rows), *(loop for _, loop in faces))),
    )


def slots_of(one: SurfaceShape, other: SurfaceShape, label: str) -> int:
    """Return at how many places two convex shapes may touch at once: see `kanefe.kernels.contact.convex_patch`.

    Raises
    ------
    ModelError
        If their faces have too many corners; the message begins with the label.
    """
    edges = [_corners(shape) for shape in (one, other)]
    lines = [isinstance(shape, (Capsule, Cylinder)) for shape in (one, other)]
    count = 1 + (2 * sum(edges) if all(edges) else 0)
    count += 2 * bool(edges[0] and lines[1]) + 2 * bool(lines[0] and edges[1]) + 3 * all(lines)
    if Slot.number_count * count > LOCAL_NUMBERS:
        raise ModelError(
            f"{label}: faces of a {one.title} and a {other.title} have {sum(edges)} corners, more than "
            f"{LOCAL_NUMBERS // Slot.number_count // 2 - 2}. Remedy: fewer points, or a Cylinder"
        )
    return count


def _corners(shape: SurfaceShape) -> int:
    if isinstance(shape, Convex):
        return max(len(loop) for _, loop in shape.faces)
    return 0 if isinstance(shape, Capsule) else DISC_CORNERS
