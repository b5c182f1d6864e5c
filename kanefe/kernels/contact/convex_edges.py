"""What is left of edges of a face, and of straight lines, over the face of another shape, seen along the normal.

All is in axes of which the third is the normal, away from the other shape.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels.algebra.vectors import Numbers, cross, dot, minus, norm, plus, put_three, three, times
from kanefe.kernels.compiler._numba import inlined, kernel

DEPTH, NORMAL, PLACE, SHARE = 0, 1, 4, 7
OF_SLOT = 8
"""Numbers of a place where shapes touch: depth, normal and place, and the share of the stiffness."""

NOTHING_LEFT = -1.0


@inlined
def put_slot(slots: Any, i: int, depth: float, normal: Numbers, place: Numbers, share: float) -> None:
    """Write a place where shapes touch."""
    at = OF_SLOT * i
    slots[at + DEPTH], slots[at + SHARE] = depth, share
    put_three(slots, at + NORMAL, normal)
    put_three(slots, at + PLACE, place)


@kernel
def put_edges(
    P: Any, p_count: int, Q: Any, q_count: int, q_normal: Numbers, close: float, side: float, slots: Any, first: int
) -> float:
    """Write both ends of what is left of all edges of a face over another; return the length of all that is left."""
    total = 0.0
    for i in range(p_count):
        end = 3 * ((i + 1) % p_count)
        total += max(put_edge(P, 3 * i, end, 0.0, Q, q_count, q_normal, close, side, slots, first + 2 * i), 0.0)
    return total


@kernel
def put_edge(
    P: Any,
    start: int,
    end: int,
    margin: float,
    Q: Any,
    count: int,
    normal: Numbers,
    close: float,
    side: float,
    slots: Any,
    first: int,
) -> float:
    """Write both ends of what is left of an edge over a face, each with half of its length as share.

    Parameters
    ----------
    P, start, end : array, int
        The ends of the edge, whose margin rounds it.
    Q, count, normal : array, int, tuple
        Corners of the face, and its normal.
    close : float
        What is no farther beside the face counts as over it, m.
    side : float
        1: the edge is that of the own shape, which is above; -1: of the other.

    Returns
    -------
    float
        The length that is left, m, half of it where the edge lies along one of the face; `NOTHING_LEFT`.
    """
    a, b = three(P, start), three(P, end)
    way, turn = minus(b, a), 1.0 if area(Q, count) > 0.0 else -1.0
    low, high, factor = 0.0, 1.0, 1.0
    for j in range(count):
        c, d = three(Q, 3 * j), three(Q, 3 * ((j + 1) % count))
        along_x, along_y = d[0] - c[0], d[1] - c[1]
        length = np.sqrt(along_x * along_x + along_y * along_y)
        if length <= close:
            continue
        in_x, in_y = -turn * along_y / length, turn * along_x / length
        inside = in_x * (a[0] - c[0]) + in_y * (a[1] - c[1])
        change = in_x * way[0] + in_y * way[1]
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
    left = factor * (high - low) * norm(way)
    origin = three(Q, 0)
    for k in range(2):
        p = plus(a, times(low if k == 0 else high, way))
        own = p[2] - side * margin
        face = origin[2] - (normal[0] * (p[0] - origin[0]) + normal[1] * (p[1] - origin[1])) / normal[2]
        place = (p[0], p[1], 0.5 * (own + face))
        put_slot(slots, first + k, side * (face - own), (0.0, 0.0, 1.0), place, 0.5 * left)
    return left


@inlined
def area(Q: Any, count: int) -> float:
    """Return twice the area of a polygon, seen along the normal; below 0: it goes round clockwise."""
    twice = 0.0
    for j in range(count):
        k = (j + 1) % count
        twice += Q[3 * j] * Q[3 * k + 1] - Q[3 * k] * Q[3 * j + 1]
    return twice


@kernel
def put_lines(P: Any, p_margin: float, Q: Any, q_margin: float, gap: float, slots: Any, first: int) -> None:
    """Write where two rounded lines touch: where they cross, and both ends of how far they lie along each other."""
    a, c = three(P, 0), three(Q, 0)
    u, v = minus(three(P, 3), a), minus(three(Q, 3), c)
    uu, vv, uv = dot(u, u), dot(v, v), dot(u, v)
    turned = cross(u, v)
    crossing = min(dot(turned, turned) / (uu * vv), 1.0)
    from_c = minus(a, c)
    along_u, along_v = dot(u, from_c), dot(v, from_c)
    square = uu * vv - uv * uv
    s = clipped((uv * along_v - along_u * vv) / square) if square > 0.0 else 0.5
    t = (uv * s + along_v) / vv
    if t < 0.0 or t > 1.0:
        t = clipped(t)
        s = clipped((uv * t - along_u) / uu)
    margins = p_margin + q_margin
    put_near(plus(a, times(s, u)), p_margin, plus(c, times(t, v)), margins, gap, crossing, slots, first)
    one, other = -along_u / uu, (uv - along_u) / uu
    for k in range(2):
        s = clipped(min(one, other) if k == 0 else max(one, other))
        p = plus(a, times(s, u))
        t = clipped(dot(v, minus(p, c)) / vv)
        q = plus(c, times(t, v))
        put_near(p, p_margin, q, margins, gap, 0.5 * (1.0 - crossing), slots, first + 1 + k)


@inlined
def clipped(share: float) -> float:
    """Return a number between 0 and 1."""
    return min(max(share, 0.0), 1.0)


@inlined
def put_near(
    p: Numbers, p_margin: float, q: Numbers, margins: float, gap: float, share: float, slots: Any, i: int
) -> None:
    """Write how balls about two places touch."""
    between = minus(p, q)
    length = norm(between)
    normal = times(1.0 / length, between) if length > 0.0 else (0.0, 0.0, 1.0)
    depth = margins - length if length > 0.0 else -gap
    put_slot(slots, i, depth, normal, plus(p, times(0.5 * depth - p_margin, normal)), share)
