"""Where convex shapes touch: the polygon that their faces share, seen along the normal, by places round its edge.

Each edge of either face is cut off where it leaves the other face. What is left carries its share of the length of all
that is left, half at either end: a trapezium rule round the edge of the polygon. Its ends move, and its share changes,
continuously with the state; corners that come and go do so with a share of zero. What is left of a straight line, that
of a capsule or of the side of a cylinder, over a face has half of the contact at either end. Two lines share their ends
as far as they are parallel, and the place where they cross as far as they are not. A cylinder has the face of its end
and the line of its side, and goes from one to the other with its angle to the normal. Where hardly anything is left, or
is not where the shapes are the deepest, the deepest place carries the rest.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels.algebra.vectors import (
    Numbers,
    cross,
    dot,
    norm,
    plus,
    put_three,
    rotated,
    rotated_back,
    three,
    times,
)
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.compiler.local_numbers import local_numbers
from kanefe.kernels.contact.convex_distance import gap_and_normal
from kanefe.kernels.contact.convex_edges import (
    DEPTH,
    NORMAL,
    OF_SLOT,
    PLACE,
    SHARE,
    put_edge,
    put_edges,
    put_lines,
    put_slot,
)
from kanefe.kernels.contact.convex_shapes import (
    AXIS,
    CORNERS,
    DISC,
    FACES,
    MARGIN,
    SIZE,
    in_axes,
    outward,
    put_corners,
    put_place,
    vertex,
)

ON_EDGE = 1e-7
"""Distance, relative to the size of the shapes, within which what is beside a face counts as over it."""

STEEP = 1e-2
"""Cosine of the angle between the normals of a contact and of a face below which the face is seen from its edge."""

NARROW = 0.02
"""Length that is left, relative to the smaller shape, below which the deepest place carries what is not shared."""

MISSED = 0.1
"""Difference of the largest depth of some places and that of the contact, relative to it, by which they carry less."""

LEAST = 1e-9
"""Fraction of the force below which a place carries nothing."""

UNTURNED = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
UNMOVED = (0.0, 0.0, 0.0)


@inlined
def has_face(numbers: Any, at: int) -> bool:
    """Return whether a shape may touch with a face."""
    return bool(numbers[at + FACES] > 0.0 or numbers[at + DISC] > 0.0)


@inlined
def has_line(numbers: Any, at: int) -> bool:
    """Return whether a shape may touch with a straight line."""
    return bool(numbers[at + FACES] == 0.0)


@inlined
def face_share(numbers: Any, at: int, direction: Numbers) -> float:
    """Return how much of a shape that touches along a direction in its axes are faces; the rest is a line."""
    if numbers[at + FACES] > 0.0:
        return 1.0
    if numbers[at + DISC] == 0.0:
        return 0.0
    cosine = dot(three(numbers, at + AXIS), direction)
    square = min(cosine * cosine, 1.0)
    return square * square * (3.0 - 2.0 * square)


@inlined
def put_line(
    numbers: Any, at: int, R: Numbers, x: Numbers, direction: Numbers, on_surface: bool, axes: Any, out: Any
) -> None:
    """Write the ends of the axis of a shape, or of the line of its side that is farthest along a direction."""
    side = (0.0, 0.0, 0.0)
    if on_surface and numbers[at + DISC] > 0.0:
        side = times(numbers[at + DISC], outward(numbers, at, rotated_back(R, direction)))
    for i in range(2):
        put_place(plus(x, rotated(R, plus(vertex(numbers, at, i), side))), axes, out, 3 * i)


@kernel
def put_slots(numbers: Any, own: int, other: int, R: Numbers, x: Numbers, count: int, slots: Any) -> float:
    """Write how deep, where and by what share two shapes touch, the own one turned by R at x; return the gap.

    There is room for a number of places, that of `kanefe.contact.convex_numbers.slots_of`. Places and normals are in
    the axes of the other one. Places that carry nothing have a share of zero, and do not touch.
    """
    close = ON_EDGE * (numbers[own + SIZE] + numbers[other + SIZE])
    gap, n, deepest = gap_and_normal(numbers, own, other, R, x, slots)
    narrow = NARROW * min(numbers[own + SIZE], numbers[other + SIZE])
    down = times(-1.0, n)
    helper = (0.0, 0.0, 1.0) if abs(n[2]) < 0.5 else (1.0, 0.0, 0.0)
    across = cross(helper, n)
    across = times(1.0 / norm(across), across)
    axes = (across, cross(n, across), n)
    P, Q, line = local_numbers(), local_numbers(), local_numbers()
    p_share, q_share = face_share(numbers, own, rotated_back(R, down)), face_share(numbers, other, n)
    p_count, q_count, p_normal, q_normal = 0, 0, (0.0, 0.0, -1.0), (0.0, 0.0, 1.0)
    if has_face(numbers, own):
        p_count, p_normal = put_corners(numbers, own, R, x, down, axes, P)
        p_share = p_share if p_normal[2] < -STEEP else 0.0
    if has_face(numbers, other):
        q_count, q_normal = put_corners(numbers, other, UNTURNED, UNMOVED, n, axes, Q)
        q_share = q_share if q_normal[2] > STEEP else 0.0
    for i in range(count):
        put_slot(slots, i, -abs(gap) - close, (0.0, 0.0, 1.0), (0.0, 0.0, 0.0), 0.0)
    at, total = 1, 0.0
    if has_face(numbers, own) and has_face(numbers, other):
        most, share = int(numbers[own + CORNERS]), p_share * q_share
        edges = 2 * (most + int(numbers[other + CORNERS]))
        if share > 0.0:
            left = put_edges(P, p_count, Q, q_count, q_normal, close, 1.0, slots, at)
            left += put_edges(Q, q_count, P, p_count, p_normal, close, -1.0, slots, at + 2 * most)
            total += carried(slots, at, edges, share, left, narrow, gap, close)
        at += edges
    if has_face(numbers, own) and has_line(numbers, other):
        share = p_share * (1.0 - q_share)
        if share > 0.0:
            put_line(numbers, other, UNTURNED, UNMOVED, n, True, axes, line)
            left = put_edge(line, 0, 3, numbers[other + MARGIN], P, p_count, p_normal, close, -1.0, slots, at)
            total += carried(slots, at, 2, share, left, narrow, gap, close)
        at += 2
    if has_line(numbers, own) and has_face(numbers, other):
        share = (1.0 - p_share) * q_share
        if share > 0.0:
            put_line(numbers, own, R, x, down, True, axes, line)
            left = put_edge(line, 0, 3, numbers[own + MARGIN], Q, q_count, q_normal, close, 1.0, slots, at)
            total += carried(slots, at, 2, share, left, narrow, gap, close)
        at += 2
    if has_line(numbers, own) and has_line(numbers, other):
        share = (1.0 - p_share) * (1.0 - q_share)
        if share > 0.0:
            put_line(numbers, own, R, x, down, False, axes, P)
            put_line(numbers, other, UNTURNED, UNMOVED, n, False, axes, Q)
            put_lines(
                P,
                numbers[own + MARGIN] + numbers[own + DISC],
                Q,
                numbers[other + MARGIN] + numbers[other + DISC],
                gap,
                slots,
                at,
            )
            total += carried(slots, at, 3, share, 1.0, 0.0, gap, close)
        at += 3
    put_slot(slots, 0, -gap, (0.0, 0.0, 1.0), in_axes(deepest, axes), 1.0 - total if total < 1.0 - LEAST else 0.0)
    for i in range(count):
        # where a line only stands for an edge that is round, it may be deeper than the shapes are in each other
        largest = -gap if slots[OF_SLOT * i + SHARE] > 0.0 else -abs(gap) - close
        slots[OF_SLOT * i + DEPTH] = min(slots[OF_SLOT * i + DEPTH], largest)
        turn(slots, OF_SLOT * i + NORMAL, axes)
        turn(slots, OF_SLOT * i + PLACE, axes)
    return gap


@kernel
def carried(
    slots: Any, first: int, count: int, share: float, left: float, narrow: float, gap: float, close: float
) -> float:
    """Have some places carry a share of the contact by the lengths that are their shares; return what they carry.

    It is less where hardly any length is left, and where they are not as deep as the shapes are in each other.
    """
    deepest, whole = -np.inf, 0.0
    for i in range(first, first + count):
        if slots[OF_SLOT * i + SHARE] > 0.0:
            deepest, whole = max(deepest, slots[OF_SLOT * i + DEPTH]), whole + slots[OF_SLOT * i + SHARE]
    if whole > 0.0:
        missed = (deepest + gap) / (MISSED * abs(gap) + close)
        share *= np.exp(-missed * missed)
        if narrow > 0.0:
            share *= 1.0 - np.exp(-((left / narrow) ** 2))
        whole = share / whole
    total = 0.0
    for i in range(first, first + count):
        carries = slots[OF_SLOT * i + SHARE] * whole
        slots[OF_SLOT * i + SHARE] = carries if carries > LEAST else 0.0
        total += slots[OF_SLOT * i + SHARE]
    return total


@inlined
def turn(slots: Any, at: int, axes: Any) -> None:
    """Replace a vector in axes by that in the axes in which these are."""
    x = three(slots, at)
    put_three(slots, at, plus(times(x[0], axes[0]), plus(times(x[1], axes[1]), times(x[2], axes[2]))))
