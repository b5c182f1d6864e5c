"""How convex shapes are to each other: the distance apart, or the least way out, and its direction.

Apart, the nearest place of the difference of both cores to the origin is found by simplices of it (Gilbert, Johnson
and Keerthi 1988). Where cores overlap they are moved apart along a guess of the normal, and the direction of the
distance is the next one: what it comes to is a least way out. Margins are added to the result, so that what is rounded
is exact.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels.algebra.vectors import Numbers, cross, dot, minus, norm, plus, put_three, rotated, three, times
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.contact.convex_shapes import (
    AXIS,
    CENTRE,
    DISC,
    FACE,
    FACES,
    MARGIN,
    SIZE,
    farthest,
    farthest_of_posed,
    first_face,
)

MOST_TRIALS, CLOSE = 100, 1e-16
"""Largest number of simplices, and relative difference of the square of the distance and its lower bound at the end:
the square of the error of the normal where shapes are round. Between corners the search ends when it comes back."""

SLIVER = 1e-6
"""Sine of an angle of a triangle below which two of its vertices count as one where a place in it is sought."""

OVERLAP = 1e-9
"""Distance of the cores, relative to their size, below which they count as overlapping."""

ASIDE = 1e-4
"""Distance by which overlapping cores are moved apart, relative to their size: well above OVERLAP, and short, since a
turn of the normal is known up to the depth and this distance over the radius of a round place."""

MOST_TURNS, SAME_NORMAL = 30, 1e-10
"""Largest number of guesses of the normal, and difference of two of them that counts as none."""

NO_DIRECTION = 1e-9
"""Length, relative to the size, below which a vector is no guess of a direction."""


@kernel
def way_between(
    numbers: Any, own: int, other: int, R: Numbers, x: Numbers, simplex: Any
) -> tuple[bool, Numbers, Numbers]:
    """Return whether cores are apart, the shortest way from the other to the own one, turned by R at x, and its end."""
    least = OVERLAP * (numbers[own + SIZE] + numbers[other + SIZE])
    v = x if dot(x, x) > 0.0 else (1.0, 0.0, 0.0)
    a = farthest_of_posed(numbers, own, R, x, times(-1.0, v))
    v = minus(a, farthest(numbers, other, v))
    put_three(simplex, 0, v)
    put_three(simplex, 3, a)
    count = 1
    for _ in range(MOST_TRIALS):
        square = dot(v, v)
        if square <= least * least:
            return False, v, a
        a = farthest_of_posed(numbers, own, R, x, times(-1.0, v))
        w = minus(a, farthest(numbers, other, v))
        if dot(v, minus(v, w)) <= CLOSE * square:
            break
        is_known = False
        for i in range(count):
            p = three(simplex, 6 * i)
            is_known = is_known or (p[0] == w[0] and p[1] == w[1] and p[2] == w[2])
        if is_known:
            break
        place = place_between(simplex, count, v)
        put_three(simplex, 6 * count, w)
        put_three(simplex, 6 * count + 3, a)
        # where the new vertex lies ahead, the origin is not all around, whatever a tetrahedron that is flat says
        count, nearer = reduce_simplex(simplex, count + 1, dot(v, w) > 0.0)
        if count == 0:
            return False, v, a
        if dot(nearer, nearer) >= square:  # by round-off
            return True, v, place
        v = nearer
    return True, v, place_between(simplex, count, v)


@inlined
def difference(numbers: Any, own: int, other: int, R: Numbers, x: Numbers, v: Numbers) -> Numbers:
    """Return the place of the difference of two cores that is farthest against a direction."""
    return minus(farthest_of_posed(numbers, own, R, x, times(-1.0, v)), farthest(numbers, other, v))


@kernel
def reduce_simplex(simplex: Any, count: int, is_outside: bool) -> tuple[int, Numbers]:
    """Keep the vertices that the place nearest to the origin lies between; return how many, and it; 0: all around.

    `is_outside`: whether it is known that they do not lie all around.
    """
    a, b = three(simplex, 0), three(simplex, 6)
    if count == 2:
        v, kept = on_segment(a, b)
    elif count == 3:
        v, kept = on_triangle(a, b, three(simplex, 12))
    else:
        v, kept, least, is_around = a, 0, np.inf, not is_outside
        for left_out in range(4):
            i, j, k = (0 if left_out > 0 else 1), (1 if left_out > 1 else 2), (2 if left_out > 2 else 3)
            p, q, r = three(simplex, 6 * i), three(simplex, 6 * j), three(simplex, 6 * k)
            n = cross(minus(q, p), minus(r, p))
            is_inner = -dot(n, p) * dot(n, minus(three(simplex, 6 * left_out), p)) > 0.0
            is_around = is_around and is_inner
            found, mask = on_triangle(p, q, r)
            square = dot(found, found)
            if square < least:
                v, least = found, square
                kept = (mask & 1) << i | ((mask >> 1) & 1) << j | ((mask >> 2) & 1) << k
        if is_around:
            return 0, v
    left = 0
    for i in range(count):
        if (kept >> i) & 1:
            put_three(simplex, 6 * left, three(simplex, 6 * i))
            put_three(simplex, 6 * left + 3, three(simplex, 6 * i + 3))
            left += 1
    return left, v


@kernel
def place_between(simplex: Any, count: int, v: Numbers) -> Numbers:
    """Return the place of the own core that a place v between vertices of the simplex belongs to."""
    a, own = three(simplex, 0), three(simplex, 3)
    if count == 1:
        return own
    ab, along = minus(three(simplex, 6), a), minus(three(simplex, 9), own)
    av = minus(v, a)
    ac, other = minus(three(simplex, 12), a), minus(three(simplex, 15), own)
    n = cross(ab, ac)
    square = dot(n, n)
    if count == 2 or square <= SLIVER * SLIVER * dot(ab, ab) * dot(ac, ac):
        return plus(own, times(dot(av, ab) / dot(ab, ab), along))
    s, t = dot(cross(av, ac), n) / square, dot(cross(ab, av), n) / square
    return plus(own, plus(times(s, along), times(t, other)))


@inlined
def on_segment(a: Numbers, b: Numbers) -> tuple[Numbers, int]:
    """Return the place of a segment nearest to the origin, and the ends that it lies between, by bits."""
    side = minus(b, a)
    square, share = dot(side, side), -dot(a, side)
    if share <= 0.0 or square == 0.0:
        return a, 1
    if share >= square:
        return b, 2
    return plus(a, times(share / square, side)), 3


@kernel
def on_triangle(a: Numbers, b: Numbers, c: Numbers) -> tuple[Numbers, int]:
    """Return the same of a triangle (Ericson, Real-Time Collision Detection, 2005, 5.1.5)."""
    ab, ac = minus(b, a), minus(c, a)
    d1, d2 = -dot(ab, a), -dot(ac, a)
    if d1 <= 0.0 and d2 <= 0.0:
        return a, 1
    d3, d4 = -dot(ab, b), -dot(ac, b)
    if d3 >= 0.0 and d4 <= d3:
        return b, 2
    if d1 * d4 - d3 * d2 <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        return plus(a, times(d1 / (d1 - d3), ab)), 3
    d5, d6 = -dot(ab, c), -dot(ac, c)
    if d6 >= 0.0 and d5 <= d6:
        return c, 4
    if d5 * d2 - d1 * d6 <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        return plus(a, times(d2 / (d2 - d6), ac)), 5
    if d3 * d6 - d5 * d4 <= 0.0 and d4 >= d3 and d5 >= d6:
        return plus(b, times((d4 - d3) / ((d4 - d3) + (d5 - d6)), minus(c, b))), 6
    bc = minus(c, b)
    if dot(ab, ab) > dot(bc, bc) and dot(ab, ab) >= dot(ac, ac):
        return within(c, a, b), 7
    return (within(b, c, a) if dot(ac, ac) > dot(bc, bc) else within(a, b, c)), 7


@inlined
def within(a: Numbers, b: Numbers, c: Numbers) -> Numbers:
    """Return the place of a triangle nearest to the origin, which lies over it; its longest side is opposite to a.

    What is between the vertices is right to round-off, also where two of them are close together and the normal of the
    triangle is hardly known.
    """
    ab, ac = minus(b, a), minus(c, a)
    n = cross(ab, ac)
    square = dot(n, n)
    if square == 0.0:
        return a
    s = min(max(-dot(cross(a, ac), n) / square, 0.0), 1.0)
    t = min(max(-dot(cross(ab, a), n) / square, 0.0), 1.0 - s)
    return plus(a, plus(times(s, ab), times(t, ac)))


@inlined
def gap_along(numbers: Any, own: int, other: int, R: Numbers, x: Numbers, n: Numbers) -> float:
    """Return how far cores are apart along a unit vector."""
    return dot(n, difference(numbers, own, other, R, x, n))


@kernel
def gap_and_normal(
    numbers: Any, own: int, other: int, R: Numbers, x: Numbers, simplex: Any
) -> tuple[float, Numbers, Numbers]:
    """Return the gap between shapes, below 0 how deep they overlap, the normal away from the other, and where.

    The place is in the middle between both surfaces, where they are nearest or deepest.
    """
    size = numbers[own + SIZE] + numbers[other + SIZE]
    margin, margins, aside = numbers[own + MARGIN], numbers[own + MARGIN] + numbers[other + MARGIN], ASIDE * size
    is_apart, way, place = way_between(numbers, own, other, R, x, simplex)
    length = norm(way)
    if is_apart:
        n = times(1.0 / length, way)
        if length > aside:
            return length - margins, n, minus(place, times(margin + 0.5 * (length - margins), n))
    else:
        n = first_guess(numbers, own, other, R, x, NO_DIRECTION * size)
    gap = gap_along(numbers, own, other, R, x, n)
    for _ in range(MOST_TURNS):
        moved = times(aside - gap, n)
        is_apart, way, place = way_between(numbers, own, other, R, plus(x, moved), simplex)
        place = minus(place, moved)
        if not is_apart:
            break
        turned = times(1.0 / norm(way), way)
        change, found = norm(minus(turned, n)), gap_along(numbers, own, other, R, x, turned)
        if found <= gap:
            break
        n, gap = turned, found
        if change < SAME_NORMAL:
            break
    return gap - margins, n, minus(place, times(margin + 0.5 * (gap - margins), n))


@kernel
def first_guess(numbers: Any, own: int, other: int, R: Numbers, x: Numbers, least: float) -> Numbers:
    """Return the direction in which overlapping cores are the least in each other, of those of faces and of axes."""
    best, n = -np.inf, (0.0, 0.0, 1.0)
    face = first_face(numbers, other)
    for _ in range(int(numbers[other + FACES])):
        best, n = better(numbers, own, other, R, x, three(numbers, face), 0.0, best, n)
        face += FACE
    face = first_face(numbers, own)
    for _ in range(int(numbers[own + FACES])):
        best, n = better(numbers, own, other, R, x, times(-1.0, rotated(R, three(numbers, face))), 0.0, best, n)
        face += FACE
    a, b = rotated(R, three(numbers, own + AXIS)), three(numbers, other + AXIS)
    between = minus(plus(x, rotated(R, three(numbers, own + CENTRE))), three(numbers, other + CENTRE))
    crossed = cross(a, b)
    for sign in (1.0, -1.0):
        if numbers[own + DISC] > 0.0:
            best, n = better(numbers, own, other, R, x, times(sign, a), 0.0, best, n)
        if numbers[other + DISC] > 0.0:
            best, n = better(numbers, own, other, R, x, times(sign, b), 0.0, best, n)
        best, n = better(numbers, own, other, R, x, times(sign, crossed), least, best, n)
    best, n = better(numbers, own, other, R, x, minus(between, times(dot(between, a), a)), least, best, n)
    best, n = better(numbers, own, other, R, x, minus(between, times(dot(between, b), b)), least, best, n)
    return n


@inlined
def better(
    numbers: Any,
    own: int,
    other: int,
    R: Numbers,
    x: Numbers,
    direction: Numbers,
    least: float,
    best: float,
    n: Numbers,
) -> tuple[float, Numbers]:
    """Return the gap along a direction and that, if it is larger than the best one and longer than the least."""
    length = norm(direction)
    if length <= least:
        return best, n
    unit = times(1.0 / length, direction)
    gap = gap_along(numbers, own, other, R, x, unit)
    return (gap, unit) if gap > best else (best, n)
