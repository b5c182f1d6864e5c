"""Convex shapes as numbers: the core of one is the hull of vertices, or an axis that carries discs; a margin rounds it.

Numbers of a shape: see `kanefe.contact.convex_numbers`.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from kanefe.kernels.algebra.vectors import Numbers, cross, dot, minus, norm, plus, rotated, rotated_back, three, times
from kanefe.kernels.compiler._numba import inlined, kernel

MARGIN, DISC, AXIS, CENTRE, SIZE, VERTICES, FACES, CORNERS, FIRST_VERTEX = 0, 1, 2, 5, 8, 9, 10, 11, 12
"""Radius of the margin and of the discs at the ends of the axis (0: none), the axis (zero of hulls), a place inside,
the radius about the origin, numbers of vertices, faces, and corners of the face that has most; then the vertices."""

FACE = 5
"""Numbers of a face, after the vertices: its normal, where its corners begin in the list of corners, and how many."""

SAME_HEIGHT = 1e-9
"""Difference in height, relative to the size, within which vertices are the highest ones together."""

STRAIGHT_DOWN = 1e-12
"""Sine of the angle between the axis of a disc and a direction below which all of its edge is as far."""


@inlined
def vertex(numbers: Any, at: int, i: int) -> Numbers:
    """Return a vertex of a shape whose numbers begin at a place, in its axes."""
    return three(numbers, at + FIRST_VERTEX + 3 * i)


@inlined
def outward(numbers: Any, at: int, direction: Numbers) -> Numbers:
    """Return the unit vector from the axis to the edge of the discs that is farthest along a direction, or zero."""
    axis = three(numbers, at + AXIS)
    way = minus(direction, times(dot(direction, axis), axis))
    way = minus(way, times(dot(way, axis), axis))  # of a direction near the axis there was little left but round-off
    length = norm(way)
    return times(1.0 / length if length > STRAIGHT_DOWN * norm(direction) else 0.0, way)


@kernel
def farthest(numbers: Any, at: int, direction: Numbers) -> Numbers:
    """Return the place of the core that is farthest along a direction, in the axes of the shape."""
    best, found = -np.inf, 0
    for i in range(int(numbers[at + VERTICES])):
        height = dot(vertex(numbers, at, i), direction)
        if height > best:
            best, found = height, i
    p = vertex(numbers, at, found)
    if numbers[at + DISC] > 0.0:
        p = plus(p, times(numbers[at + DISC], outward(numbers, at, direction)))
    return p


@inlined
def farthest_of_posed(numbers: Any, at: int, R: Numbers, x: Numbers, direction: Numbers) -> Numbers:
    """Return the same of a shape that is turned by R and moved by x."""
    return plus(x, rotated(R, farthest(numbers, at, rotated_back(R, direction))))


@inlined
def first_face(numbers: Any, at: int) -> int:
    """Return where the faces of a shape begin."""
    return at + FIRST_VERTEX + 3 * int(numbers[at + VERTICES])


@inlined
def corner(numbers: Any, at: int, face: int, i: int) -> Numbers:
    """Return a corner of a face that begins at a place."""
    corners = first_face(numbers, at) + FACE * int(numbers[at + FACES])
    return vertex(numbers, at, int(numbers[corners + int(numbers[face + 3]) + i]))


@kernel
def face_along(numbers: Any, at: int, direction: Numbers) -> int:
    """Return where the face begins that looks most along a direction, of those with most of the highest vertices."""
    level = dot(farthest(numbers, at, direction), direction) - SAME_HEIGHT * numbers[at + SIZE]
    face = found = first_face(numbers, at)
    most, best = -1, -np.inf
    for _ in range(int(numbers[at + FACES])):
        high, share = 0, dot(three(numbers, face), direction)
        for i in range(int(numbers[face + 4])):
            high += 1 if dot(corner(numbers, at, face, i), direction) >= level else 0
        if high > most or (high == most and share > best):
            found, most, best = face, high, share
        face += FACE
    return found


@kernel
def put_corners(numbers: Any, at: int, R: Numbers, x: Numbers, direction: Numbers, axes: Numbers, out: Any) -> Any:
    """Write the corners of the face, or of the polygon in the disc, that looks most along a direction.

    The polygon is fixed in the disc. Turned to the highest place of the disc it would follow round-off where that lies
    flat, and a moment with it; that place is the deepest of the contact, and carries what the polygon misses.

    Parameters
    ----------
    R, x : tuple
        How the shape is turned and moved.
    direction : tuple
        Along which it looks, after that.
    axes : tuple
        Three axes in which corners are written, one after the other.

    Returns
    -------
    count : int
        Of corners.
    normal : tuple
        Of the face, in these axes.
    """
    along = rotated_back(R, direction)
    if numbers[at + DISC] > 0.0:
        axis, count = three(numbers, at + AXIS), int(numbers[at + CORNERS])
        normal = axis if dot(axis, along) >= 0.0 else times(-1.0, axis)
        end = vertex(numbers, at, 0)
        other = vertex(numbers, at, 1)
        end = end if dot(end, normal) >= dot(other, normal) else other
        u = outward(numbers, at, (0.0, 0.0, 1.0) if abs(axis[2]) < 0.5 else (1.0, 0.0, 0.0))
        w = cross(normal, u)
        for i in range(count):
            angle = 2.0 * math.pi / count * i
            side = plus(times(math.cos(angle), u), times(math.sin(angle), w))
            put_place(plus(x, rotated(R, plus(end, times(numbers[at + DISC], side)))), axes, out, 3 * i)
    else:
        face = face_along(numbers, at, along)
        normal, count = three(numbers, face), int(numbers[face + 4])
        for i in range(count):
            put_place(plus(x, rotated(R, corner(numbers, at, face, i))), axes, out, 3 * i)
    return count, in_axes(rotated(R, normal), axes)


@inlined
def in_axes(p: Numbers, axes: Numbers) -> Numbers:
    """Return a vector in axes."""
    return dot(axes[0], p), dot(axes[1], p), dot(axes[2], p)


@inlined
def put_place(p: Numbers, axes: Numbers, out: Any, at: int) -> None:
    """Write a place in axes."""
    q = in_axes(p, axes)
    out[at], out[at + 1], out[at + 2] = q[0], q[1], q[2]
