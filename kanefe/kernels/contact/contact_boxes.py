"""A box on a box: along one axis, of least overlap, their faces meet in a polygon, or two edges cross.

The axis is found among those of the faces and the products of edges (the separating axis theorem; Gottschalk, Lin and
Manocha 1996). Where a face leads, what touches are corners of both faces that lie over the other face, and the places
where their edges cross: corners of the polygon that they share. Each is a slot, so that friction knows it again.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels.algebra.vectors import Numbers, cross, dot, minus, plus, three, times
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.force_elements.places import A, P

OWN_CORNERS, OTHER_CORNERS, CROSSINGS, EDGES, SLOTS = 0, 4, 8, 16, 17
"""First slots: corners of the touching box, corners of the touched box, crossings of the edges of their faces, and
edges that cross in space; last the number of slots."""

PARALLEL = 1e-6
"""Sine of the angle between edges below which their product is not an axis."""

PREFERRED = 1e-6
"""Overlap, relative to the size of the boxes, by which edges must overlap less than faces to be chosen."""

ON_EDGE = 1e-6
"""Distance relative to the size of the boxes within which a corner outside a face counts as over the face."""


@kernel
def boxes_meet(ends: Any, end: int, own: Numbers, other: Numbers) -> Any:
    """Return normal, overlap, and the axes of the edges that cross (-1: a face leads) of two boxes of half sizes."""
    between = minus(three(ends, end + P), three(ends, P))
    size = own[0] + own[1] + own[2] + other[0] + other[1] + other[2]
    n = column(ends, 0, 0)
    overlap, first, second, is_first = 0.0 * n[0], -1, -1, True
    for k in range(6):
        axis = column(ends, 0 if k < 3 else end, k % 3)
        found = overlap_along(axis, between, ends, end, own, other)
        if is_first or found.real < overlap.real:
            n, overlap, is_first = axis, found, False
    least = overlap.real - PREFERRED * size
    for i in range(3):
        for j in range(3):
            axis = cross(column(ends, end, i), column(ends, 0, j))
            length = np.sqrt(dot(axis, axis))
            if length.real > PARALLEL:
                axis = times(1.0 / length, axis)
                found = overlap_along(axis, between, ends, end, own, other)
                if found.real < least:
                    n, overlap, first, second, least = axis, found, i, j, found.real
    if dot(n, between).real < 0.0:
        n = times(-1.0, n)
    return n[0], n[1], n[2], overlap, first, second


@inlined
def column(ends: Any, end: int, i: int) -> Numbers:
    """Return an axis of an end."""
    return ends[end + A + i], ends[end + A + 3 + i], ends[end + A + 6 + i]


@inlined
def size_of(x: Any) -> Any:
    """Return the size of a number, whose derivative is that of its sign."""
    return -x if x.real < 0.0 else x


@inlined
def overlap_along(axis: Numbers, between: Numbers, ends: Any, end: int, own: Numbers, other: Numbers) -> Any:
    """Return how far two boxes overlap along an axis."""
    reach = -size_of(dot(axis, between))
    for i in range(3):
        reach += pick(other, i) * size_of(dot(axis, column(ends, 0, i)))
        reach += pick(own, i) * size_of(dot(axis, column(ends, end, i)))
    return reach


@inlined
def pick(x: Numbers, i: int) -> Any:
    """Return one of three numbers."""
    return x[0] if i == 0 else x[1] if i == 1 else x[2]


@kernel
def box_slot(met: Numbers, slot: int, ends: Any, end: int, own: Numbers, other: Numbers) -> Any:
    """Return depth and place in N of a slot."""
    n, overlap, first, second = (met[0], met[1], met[2]), met[3], met[4], met[5]
    p = three(ends, end + P)
    if first >= 0 or slot == EDGES:
        if first < 0 or slot != EDGES:
            return -size_of(overlap), p[0], p[1], p[2]
        p, q = on_edge(ends, end, own, first, n, -1.0), on_edge(ends, 0, other, second, n, 1.0)
        a, b, d = column(ends, end, first), column(ends, 0, second), minus(q, p)
        c = dot(a, b)
        p = plus(p, times((dot(d, a) - c * dot(d, b)) / (1.0 - c * c), a))
        return overlap, p[0], p[1], p[2]
    margin = ON_EDGE * (own[0] + own[1] + own[2] + other[0] + other[1] + other[2])
    back = times(-1.0, n)
    of_own, of_other = face_along(ends, end, back), face_along(ends, 0, n)
    if slot < OTHER_CORNERS:
        p = corner(ends, end, own, of_own, slot)
        return over(p, ends, 0, other, of_other, n, margin), p[0], p[1], p[2]
    if slot < CROSSINGS:
        p = corner(ends, 0, other, of_other, slot - OTHER_CORNERS)
        return over(p, ends, end, own, of_own, back, margin), p[0], p[1], p[2]
    side, is_end = (slot - CROSSINGS) // 2, (slot - CROSSINGS) % 2
    start, stop = corner(ends, end, own, of_own, side), corner(ends, end, own, of_own, (side + 1) % 4)
    depth, change = below(start, ends, 0, other, of_other, n), below(stop, ends, 0, other, of_other, n)
    one, two = plus(start, times(depth, n)), plus(stop, times(change, n))
    change -= depth
    low, high = 0.0 * depth, 0.0 * depth + 1.0
    for along in range(2):
        axis, half = (of_other[0] + 1 + along) % 3, pick(other, (of_other[0] + 1 + along) % 3)
        x = dot(column(ends, 0, axis), minus(one, three(ends, P)))
        way = dot(column(ends, 0, axis), minus(two, one))
        if abs(way.real) <= margin:
            if abs(x.real) > half + margin:
                return -size_of(size_of(x) - half), start[0], start[1], start[2]
        else:
            enters, leaves = (-half - x) / way, (half - x) / way
            if enters.real > leaves.real:
                enters, leaves = leaves, enters
            low = enters if enters.real > low.real else low
            high = leaves if leaves.real < high.real else high
    offset = minus(stop, start)
    length, share = np.sqrt(dot(offset, offset)), high if is_end else low
    away = ((1.0 - share) if is_end else share) * length - margin
    short = (high - low) * length - margin
    away = short if short.real < away.real else away
    depth += share * change
    p = plus(start, times(share, offset))
    if away.real <= 0.0 and away.real < depth.real:
        depth = away
    return depth, p[0], p[1], p[2]


@inlined
def on_edge(ends: Any, end: int, half: Numbers, along: int, n: Numbers, sign: float) -> Numbers:
    """Return the middle of the edge of a box, along one of its axes, that lies furthest along n, or against it."""
    p = three(ends, end + P)
    for i in range(3):
        if i != along:
            axis = column(ends, end, i)
            towards = sign if dot(axis, n).real >= 0.0 else -sign
            p = plus(p, times(towards * pick(half, i), axis))
    return p


@inlined
def face_along(ends: Any, end: int, direction: Numbers) -> tuple[int, float]:
    """Return axis and side of the face of a box that looks most along a direction."""
    best, axis, side = -1.0, 0, 1.0
    for i in range(3):
        share = dot(column(ends, end, i), direction).real
        if abs(share) > best:
            best, axis, side = abs(share), i, 1.0 if share >= 0.0 else -1.0
    return axis, side


@inlined
def middle_of(ends: Any, end: int, half: Numbers, face: tuple[int, float]) -> Numbers:
    """Return the middle of a face."""
    return plus(three(ends, end + P), times(face[1] * pick(half, face[0]), column(ends, end, face[0])))


@inlined
def corner(ends: Any, end: int, half: Numbers, face: tuple[int, float], i: int) -> Numbers:
    """Return a corner of a face, round it."""
    first, second = (face[0] + 1) % 3, (face[0] + 2) % 3
    x, y = (1.0 if i in (1, 2) else -1.0), (1.0 if i > 1 else -1.0)
    p = plus(middle_of(ends, end, half, face), times(x * pick(half, first), column(ends, end, first)))
    return plus(p, times(y * pick(half, second), column(ends, end, second)))


@inlined
def below(p: Numbers, ends: Any, end: int, half: Numbers, face: tuple[int, float], n: Numbers) -> Any:
    """Return how far below a face a place is, along n."""
    normal = column(ends, end, face[0])
    return dot(normal, minus(middle_of(ends, end, half, face), p)) / dot(normal, n)


@inlined
def over(p: Numbers, ends: Any, end: int, half: Numbers, face: tuple[int, float], n: Numbers, margin: float) -> Any:
    """Return how far below a face a place is, along n; of a place beside the face how far beside, below 0."""
    depth = below(p, ends, end, half, face, n)
    offset = minus(plus(p, times(depth, n)), three(ends, end + P))
    first, second = (face[0] + 1) % 3, (face[0] + 2) % 3
    x = pick(half, first) - size_of(dot(column(ends, end, first), offset)) + margin
    y = pick(half, second) - size_of(dot(column(ends, end, second), offset)) + margin
    beside = y if y.real < x.real else x
    return beside if beside.real < 0.0 and beside.real < depth.real else depth
