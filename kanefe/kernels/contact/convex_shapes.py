"""Convex shapes as numbers: the core of one is the hull of vertices, or an axis that carries discs; a margin rounds it.

Numbers of a shape: see `kanefe.contact.convex_numbers`.
"""

import math
from collections import namedtuple
from typing import Annotated, Any, NamedTuple

import numpy as np

from kanefe.kernels.language import Behind, Matrix, Record, Rows, Vector, across, cross, dot, inlined, norm


class Limits(NamedTuple):
    """From where on numbers count at a shape."""

    same_height: float = 1e-9
    """Difference in height, relative to the size, within which vertices are the highest ones together."""
    straight_down: float = 1e-12
    """Sine of the angle between the axis of a disc and a direction below which all of its edge is as far."""


LIMITS = Limits()


class ConvexShape(Record):
    """Numbers of a convex shape; faces, and the lists of their corners, follow its vertices.

    Attributes
    ----------
    margin, disc : float
        Radius of the margin, and of the discs at the ends of the axis, m; 0: none.
    axis : Vector
        Zero of hulls.
    centre : Vector
        A place inside.
    size : float
        Radius about the origin, m.
    count, faces, corners : float
        Numbers of vertices, of faces, and of corners of the face that has most.
    vertices : list
        `Vertices`.
    """

    margin: float
    disc: float
    axis: Vector
    centre: Vector
    size: float
    count: float
    faces: float
    corners: float
    vertices: Annotated[Any, Behind()]


class Vertex(Record):
    """A place, m."""

    p: Vector


Vertices = Rows[Vertex]


class ShapeFace(Record):
    """A face: its normal, where its corners begin in the list of corners, and how many they are."""

    normal: Vector
    first: float
    count: float


FACE = ShapeFace.number_count

Posed = namedtuple("Posed", "shape R x")
"""A shape that is turned and moved."""


@inlined
def vertex(shape: ConvexShape, i: int) -> Vector:
    """Return a vertex of a shape."""
    return Vertices(shape.vertices)[i].p


@inlined
def outward(shape: ConvexShape, direction: Vector) -> Vector:
    """Return the unit vector from the axis to the edge of the discs that is farthest along a direction, or zero."""
    axis = shape.axis
    way = across(across(direction, axis), axis)  # of a direction near the axis there was little left but round-off
    length = norm(way)
    return (1.0 / length if length > LIMITS.straight_down * norm(direction) else 0.0) * way


@inlined
def farthest(shape: ConvexShape, direction: Vector) -> Vector:
    """Return the place of the core that is farthest along a direction, in the axes of the shape."""
    best, found, vertices = -np.inf, 0, Vertices(shape.vertices)
    for i in range(int(shape.count)):
        height = dot(vertices[i].p, direction)
        if height > best:
            best, found = height, i
    p = vertices[found].p
    if shape.disc > 0.0:
        p += shape.disc * outward(shape, direction)
    return p


@inlined
def farthest_of_posed(own: Posed, direction: Vector) -> Vector:
    """Return the same of a shape that is turned and moved."""
    return own.x + own.R @ farthest(own.shape, own.R.T @ direction)


@inlined
def face_of(shape: ConvexShape, i: int) -> ShapeFace:
    """Return a face of a shape."""
    return ShapeFace(shape.vertices, 3 * int(shape.count) + FACE * i)


@inlined
def corner(shape: ConvexShape, face: ShapeFace, i: int) -> Vector:
    """Return a corner of a face."""
    corners = 3 * int(shape.count) + FACE * int(shape.faces)
    return vertex(shape, int(shape.vertices[corners + int(face.first) + i]))


@inlined
def face_along(shape: ConvexShape, direction: Vector) -> ShapeFace:
    """Return the face that looks most along a direction, of those with most of the highest vertices."""
    level = dot(farthest(shape, direction), direction) - LIMITS.same_height * shape.size
    found, most, best = face_of(shape, 0), -1, -np.inf
    for k in range(int(shape.faces)):
        face = face_of(shape, k)
        high, share = 0, dot(face.normal, direction)
        for i in range(int(face.count)):
            high += 1 if dot(corner(shape, face, i), direction) >= level else 0
        if high > most or (high == most and share > best):
            found, most, best = face, high, share
    return found


@inlined
def put_corners(own: Posed, direction: Vector, axes: Matrix, out: Any) -> tuple[int, Vector]:
    """Write the corners of the face, or of the polygon in the disc, that looks most along a direction.

    The polygon is fixed in the disc. Turned to the highest place of the disc it would follow round-off where that lies
    flat, and a moment with it; that place is the deepest of the contact, and carries what the polygon misses.

    Parameters
    ----------
    own : Posed
    direction : Vector
        Along which it looks, after that.
    axes : Matrix
        Those, as rows, in which corners are written, one after the other.

    Returns
    -------
    count : int
        Of corners.
    normal : Vector
        Of the face, in these axes.
    """
    shape, along, places = own.shape, own.R.T @ direction, Vertices(out)
    if shape.disc > 0.0:
        axis, count = shape.axis, int(shape.corners)
        normal = axis if dot(axis, along) >= 0.0 else -axis
        end, other = vertex(shape, 0), vertex(shape, 1)
        end = end if dot(end, normal) >= dot(other, normal) else other
        u = outward(shape, Vector(0.0, 0.0, 1.0) if abs(axis.z) < 0.5 else Vector(1.0, 0.0, 0.0))
        w = cross(normal, u)
        for i in range(count):
            angle = 2.0 * math.pi / count * i
            side = math.cos(angle) * u + math.sin(angle) * w
            places[i].p = axes @ (own.x + own.R @ (end + shape.disc * side))
    else:
        face = face_along(shape, along)
        normal, count = face.normal, int(face.count)
        for i in range(count):
            places[i].p = axes @ (own.x + own.R @ corner(shape, face, i))
    return count, axes @ (own.R @ normal)
