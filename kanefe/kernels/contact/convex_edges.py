"""What is left of edges of a face, and of straight lines, over the face of another shape, seen along the normal.

All is in axes of which the third is the normal, away from the other shape.
"""

from collections import namedtuple

import numpy as np

from kanefe.kernels.language import Record, Rows, Vector, cross, dot, inlined, kernel, norm

NOTHING_LEFT = -1.0

UP = Vector(0.0, 0.0, 1.0)


class Slot(Record):
    """A place where shapes touch: depth, normal and place, and the share of the stiffness."""

    depth: float
    normal: Vector
    place: Vector
    share: float


Slots = Rows[Slot]

Polygon = namedtuple("Polygon", "corners count normal")
"""A face: its corners, how many they are, and its normal."""

Edge = namedtuple("Edge", "a b margin side")
"""A straight line that a margin rounds, from a to b; its side is 1 of the own shape, which is above, or -1."""


@inlined
def put_slot(slots: Slots, i: int, depth: float, normal: Vector, place: Vector, share: float) -> None:
    """Write a place where shapes touch."""
    slot = slots[i]
    slot.depth, slot.normal, slot.place, slot.share = depth, normal, place, share


@inlined
def put_edges(face: Polygon, over: Polygon, close: float, side: float, slots: Slots, first: int) -> float:
    """Write both ends of what is left of all edges of a face over another; return the length of all that is left."""
    total = 0.0
    for i in range(face.count):
        edge = Edge(face.corners[i].p, face.corners[(i + 1) % face.count].p, 0.0, side)
        total += max(put_edge(edge, over, close, slots, first + 2 * i), 0.0)
    return total


@kernel
def put_edge(edge: Edge, over: Polygon, close: float, slots: Slots, first: int) -> float:
    """Write both ends of what is left of an edge over a face, each with half of its length as share.

    Parameters
    ----------
    edge : Edge
    over : Polygon
    close : float
        What is no farther beside the face counts as over it, m.

    Returns
    -------
    float
        The length that is left, m, half of it where the edge lies along one of the face; `NOTHING_LEFT`.
    """
    a, corners, count = edge.a, over.corners, over.count
    way, turn = edge.b - a, 1.0 if area(over) > 0.0 else -1.0
    low, high, factor = 0.0, 1.0, 1.0
    for j in range(count):
        c, d = corners[j].p, corners[(j + 1) % count].p
        along_x, along_y = d.x - c.x, d.y - c.y
        length = np.sqrt(along_x * along_x + along_y * along_y)
        if length <= close:
            continue
        in_x, in_y = -turn * along_y / length, turn * along_x / length
        inside = in_x * (a.x - c.x) + in_y * (a.y - c.y)
        change = in_x * way.x + in_y * way.y
        if abs(change) <= close:
            if inside < -close:
                return NOTHING_LEFT
            if inside <= close:
                factor = 0.5
        elif change > 0.0:
            low = max(low, -(inside + close) / change)
        else:
            high = min(high, -(inside + close) / change)
    if low > high:
        return NOTHING_LEFT
    left, origin, normal = factor * (high - low) * norm(way), corners[0].p, over.normal
    for k in range(2):
        p = a + (low if k == 0 else high) * way
        own = p.z - edge.side * edge.margin
        face = origin.z - (normal.x * (p.x - origin.x) + normal.y * (p.y - origin.y)) / normal.z
        put_slot(slots, first + k, edge.side * (face - own), UP, Vector(p.x, p.y, 0.5 * (own + face)), 0.5 * left)
    return left  # type: ignore[no-any-return]


@inlined
def area(face: Polygon) -> float:
    """Return twice the area of a polygon, seen along the normal; below 0: it goes round clockwise."""
    twice = 0.0
    for j in range(face.count):
        a, b = face.corners[j].p, face.corners[(j + 1) % face.count].p
        twice += a.x * b.y - b.x * a.y
    return twice


@inlined
def put_lines(one: Edge, other: Edge, gap: float, slots: Slots, first: int) -> None:
    """Write where two rounded lines touch: where they cross, and both ends of how far they lie along each other."""
    u, v, from_c = one.b - one.a, other.b - other.a, one.a - other.a
    uu, vv, uv = dot(u, u), dot(v, v), dot(u, v)
    turned = cross(u, v)
    crossing = min(dot(turned, turned) / (uu * vv), 1.0)
    along_u, along_v = dot(u, from_c), dot(v, from_c)
    square = uu * vv - uv * uv
    s = clipped((uv * along_v - along_u * vv) / square) if square > 0.0 else 0.5
    t = (uv * s + along_v) / vv
    if t < 0.0 or t > 1.0:
        t = clipped(t)
        s = clipped((uv * t - along_u) / uu)
    near, far = -along_u / uu, (uv - along_u) / uu
    for k in range(3):
        if k > 0:
            s = clipped(min(near, far) if k == 1 else max(near, far))
            t = clipped(dot(v, one.a + s * u - other.a) / vv)
        p, q = one.a + s * u, other.a + t * v
        length = norm(p - q)
        normal = (1.0 / length) * (p - q) if length > 0.0 else UP
        depth = one.margin + other.margin - length if length > 0.0 else -gap
        share = crossing if k == 0 else 0.5 * (1.0 - crossing)
        put_slot(slots, first + k, depth, normal, p + (0.5 * depth - one.margin) * normal, share)


@inlined
def clipped(share: float) -> float:
    """Return a number between 0 and 1."""
    return min(max(share, 0.0), 1.0)
