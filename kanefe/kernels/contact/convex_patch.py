"""Where convex shapes touch: the polygon that their faces share, seen along the normal, by places round its edge.

Each edge of either face is cut off where it leaves the other face. What is left carries its share of the length of all
that is left, half at either end: a trapezium rule round the edge of the polygon. Its ends move, and its share changes,
continuously with the state; corners that come and go do so with a share of zero. What is left of a straight line, that
of a capsule or of the side of a cylinder, over a face has half of the contact at either end. Two lines share their ends
as far as they are parallel, and the place where they cross as far as they are not. A cylinder has the face of its end
and the line of its side, and goes from one to the other with its angle to the normal. Where hardly anything is left, or
is not where the shapes are the deepest, the deepest place carries the rest.
"""

from collections import namedtuple
from typing import Any, NamedTuple

import numpy as np

from kanefe.kernels.compiler.local_numbers import local_numbers
from kanefe.kernels.contact.convex_distance import Simplex, gap_and_normal
from kanefe.kernels.contact.convex_edges import UP, Edge, Polygon, Slots, put_edge, put_edges, put_lines, put_slot
from kanefe.kernels.contact.convex_shapes import ConvexShape, Posed, Vertices, outward, put_corners, vertex
from kanefe.kernels.language import IDENTITY, ZERO, Matrix, Vector, cross, dot, inlined, kernel, unit


class Limits(NamedTuple):
    """From where on numbers count in a patch."""

    on_edge: float = 1e-7
    """Distance, relative to the size of the shapes, within which what is beside a face counts as over it."""
    steep: float = 1e-2
    """Cosine of the angle between the normals of a contact and of a face below which the face is seen from its edge."""
    narrow: float = 0.02
    """Length that is left, relative to the smaller shape, below which the deepest place carries what is not shared."""
    missed: float = 0.1
    """Difference of the largest depth of some places and that of the contact, relative to it, by which they carry
    less."""
    least: float = 1e-9
    """Fraction of the force below which a place carries nothing."""


LIMITS = Limits()


Seen = namedtuple("Seen", "has_face has_line face share line axis")
"""A shape seen along the normal: its face, how much of it that is, and the rest, a line. `has_face, has_line`: whether
it may touch with them; `share`: how much of a shape that touches there is the face; `line`: on its surface; `axis`: the
line between its ends, which discs and margin round."""

Patch = namedtuple("Patch", "gap close narrow")
"""Measures of the places of a patch: the gap; what is close beside a face, and a narrow length, m."""


@inlined
def face_share(shape: ConvexShape, direction: Vector) -> float:
    """Return how much of a shape that touches along a direction in its axes are faces; the rest is a line."""
    if shape.faces > 0.0:
        return 1.0
    if shape.disc == 0.0:
        return 0.0
    cosine = dot(shape.axis, direction)
    square = min(cosine * cosine, 1.0)
    return square * square * (3.0 - 2.0 * square)  # type: ignore[no-any-return]


@kernel
def seen_along(own: Posed, direction: Vector, side: float, axes: Matrix, room: Any) -> Seen:
    """Return a shape seen in axes of which the third is the normal; there is room for the corners of its face."""
    shape = own.shape
    along = own.R.T @ direction
    has_face, has_line = shape.faces > 0.0 or shape.disc > 0.0, shape.faces == 0.0
    share, count, normal = face_share(shape, along), 0, -side * UP
    if has_face:
        count, normal = put_corners(own, direction, axes, room)
        share = share if side * normal.z < -LIMITS.steep else 0.0
    a = b = out = ZERO
    if has_line:
        a, b = axes @ (own.x + own.R @ vertex(shape, 0)), axes @ (own.x + own.R @ vertex(shape, 1))
    if has_line and has_face:
        out = axes @ (own.R @ (shape.disc * outward(shape, along)))
    line, axis = Edge(a + out, b + out, shape.margin, side), Edge(a, b, shape.margin + shape.disc, side)
    return Seen(has_face, has_line, Polygon(Vertices(room), count, normal), share, line, axis)


@kernel
def put_slots(own: Posed, other: ConvexShape, count: int, room: Any) -> float:
    """Write how deep, where and by what share two shapes touch; return the gap.

    There is room for a number of places, that of `kanefe.contact.convex_numbers.slots_of`. Places and normals are in
    the axes of the other one. Places that carry nothing have a share of zero, and do not touch.
    """
    slots = Slots(room)
    gap, n, deepest = gap_and_normal(own, other, Simplex(room))
    close = LIMITS.on_edge * (own.shape.size + other.size)
    patch = Patch(gap, close, LIMITS.narrow * min(own.shape.size, other.size))
    a = unit(cross(UP if abs(n.z) < 0.5 else Vector(1.0, 0.0, 0.0), n))
    b = cross(n, a)
    axes = Matrix(a.x, a.y, a.z, b.x, b.y, b.z, n.x, n.y, n.z)
    above = seen_along(own, -n, 1.0, axes, local_numbers())
    under = seen_along(Posed(other, IDENTITY, ZERO), n, -1.0, axes, local_numbers())
    for i in range(count):
        put_slot(slots, i, -abs(gap) - close, UP, ZERO, 0.0)
    most = int(own.shape.corners), int(other.corners)
    total = carried_by_all(above, under, patch, most, slots)
    put_slot(slots, 0, -gap, UP, axes @ deepest, 1.0 - total if total < 1.0 - LIMITS.least else 0.0)
    for i in range(count):
        # where a line only stands for an edge that is round, it may be deeper than the shapes are in each other
        slot = slots[i]
        slot.depth = min(slot.depth, -gap if slot.share > 0.0 else -abs(gap) - close)
        slot.normal, slot.place = axes.T @ slot.normal, axes.T @ slot.place
    return gap


@inlined
def carried_by_all(above: Seen, under: Seen, patch: Patch, most: tuple[int, int], slots: Slots) -> float:
    """Write the places where faces and lines of two shapes touch, after the first; return what they carry.

    `most`: corners that a face of either has at most.
    """
    at, total, close = 1, 0.0, patch.close
    if above.has_face and under.has_face:
        edges, share = 2 * (most[0] + most[1]), above.share * under.share
        if share > 0.0:
            left = put_edges(above.face, under.face, close, 1.0, slots, at)
            left += put_edges(under.face, above.face, close, -1.0, slots, at + 2 * most[0])
            total += carried(slots, at, edges, share, left, patch)
        at += edges
    if above.has_face and under.has_line:
        total += carried_by_line(slots, at, under.line, above.face, above.share * (1.0 - under.share), patch)
        at += 2
    if above.has_line and under.has_face:
        total += carried_by_line(slots, at, above.line, under.face, (1.0 - above.share) * under.share, patch)
        at += 2
    if above.has_line and under.has_line:
        share = (1.0 - above.share) * (1.0 - under.share)
        if share > 0.0:
            put_lines(above.axis, under.axis, patch.gap, slots, at)
            total += carried(slots, at, 3, share, np.inf, patch)
    return total


@kernel
def carried_by_line(slots: Slots, at: int, line: Edge, face: Polygon, share: float, patch: Patch) -> float:
    """Write where a line touches a face; return what it carries."""
    if share <= 0.0:
        return 0.0
    return carried(slots, at, 2, share, put_edge(line, face, patch.close, slots, at), patch)


@inlined
def carried(slots: Slots, first: int, count: int, share: float, left: float, patch: Patch) -> float:
    """Have some places carry a share of the contact by the lengths that are their shares; return what they carry.

    It is less where hardly any length is left, and where they are not as deep as the shapes are in each other.
    """
    deepest, whole = -np.inf, 0.0
    for i in range(first, first + count):
        if slots[i].share > 0.0:
            deepest, whole = max(deepest, slots[i].depth), whole + slots[i].share
    if whole > 0.0:
        missed = (deepest + patch.gap) / (LIMITS.missed * abs(patch.gap) + patch.close)
        share *= np.exp(-missed * missed) * (1.0 - np.exp(-((left / patch.narrow) ** 2)))
        whole = share / whole
    total = 0.0
    for i in range(first, first + count):
        carries = slots[i].share * whole
        slots[i].share = carries if carries > LIMITS.least else 0.0
        total += slots[i].share
    return total
