"""How convex shapes are to each other: the distance apart, or the least way out, and its direction.

Apart, the nearest place of the difference of both cores to the origin is found by simplices of it (Gilbert, Johnson
and Keerthi 1988). Where cores overlap they are moved apart along a guess of the normal, and the direction of the
distance is the next one: what it comes to is a least way out. Margins are added to the result, so that what is rounded
is exact.
"""

from collections import namedtuple
from typing import NamedTuple

import numpy as np

from kanefe.kernels.contact.convex_shapes import ConvexShape, Posed, face_of, farthest, farthest_of_posed
from kanefe.kernels.contact.nearest_places import on_segment, on_triangle
from kanefe.kernels.language import Record, Rows, Vector, across, cross, dot, inlined, kernel, norm


class Limits(NamedTuple):
    """From where on numbers count between convex shapes."""

    most_trials: int = 100
    close: float = 1e-16
    """Largest number of simplices, and relative difference of the square of the distance and its lower bound at the
    end: the square of the error of the normal where shapes are round. Between corners the search ends when it comes
    back."""
    sliver: float = 1e-6
    """Sine of an angle of a triangle below which two of its vertices count as one where a place in it is sought."""
    overlap: float = 1e-9
    """Distance of the cores, relative to their size, below which they count as overlapping."""
    aside: float = 1e-4
    """Distance by which overlapping cores are moved apart, relative to their size: well above `overlap`, and short: a
    turn of the normal is known up to the depth and this distance over the radius of a round place."""
    most_turns: int = 30
    same_normal: float = 1e-10
    """Largest number of guesses of the normal, and difference of two of them that counts as none."""
    no_direction: float = 1e-9
    """Length, relative to the size, below which a vector is no guess of a direction."""


LIMITS = Limits()


class Corner(Record):
    """A vertex of a simplex: a place of the difference of both cores, and the place of the own one."""

    v: Vector
    own: Vector


Simplex = Rows[Corner]

Way = namedtuple("Way", "is_apart way place")
"""Whether cores are apart, the shortest way from the other to the own one, and its end."""

GapFound = namedtuple("GapFound", "gap normal place")
"""The gap between shapes, below 0 how deep they overlap, the normal away from the other, and where that is."""


@kernel
def way_between(own: Posed, other: ConvexShape, simplex: Simplex) -> Way:
    """Return the shortest way between two cores."""
    least = LIMITS.overlap * (own.shape.size + other.size)
    v = own.x if dot(own.x, own.x) > 0.0 else Vector(1.0, 0.0, 0.0)
    a = farthest_of_posed(own, -v)
    v = a - farthest(other, v)
    simplex[0].v, simplex[0].own = v, a
    count = 1
    for _ in range(LIMITS.most_trials):
        square = dot(v, v)
        if square <= least * least:
            return Way(False, v, a)
        a = farthest_of_posed(own, -v)
        w = a - farthest(other, v)
        if dot(v, v - w) <= LIMITS.close * square:
            break
        is_known = False
        for i in range(count):
            p = simplex[i].v
            is_known = is_known or (p.x == w.x and p.y == w.y and p.z == w.z)
        if is_known:
            break
        place = place_between(simplex, count, v)
        simplex[count].v, simplex[count].own = w, a
        # where the new vertex lies ahead, the origin is not all around, whatever a tetrahedron that is flat says
        count, nearer = reduce_simplex(simplex, count + 1, dot(v, w) > 0.0)
        if count == 0:
            return Way(False, v, a)
        if dot(nearer, nearer) >= square:  # by round-off
            return Way(True, v, place)
        v = nearer
    return Way(True, v, place_between(simplex, count, v))


@inlined
def reduce_simplex(simplex: Simplex, count: int, is_outside: bool) -> tuple[int, Vector]:
    """Keep the vertices that the place nearest to the origin lies between; return how many, and it; 0: all around.

    `is_outside`: whether it is known that they do not lie all around.
    """
    a, b = simplex[0].v, simplex[1].v
    if count == 2:
        v, kept = on_segment(a, b)
    elif count == 3:
        v, kept = on_triangle(a, b, simplex[2].v)
    else:
        v, kept, least, is_around = a, 0, np.inf, not is_outside
        for left_out in range(4):
            i, j, k = (0 if left_out > 0 else 1), (1 if left_out > 1 else 2), (2 if left_out > 2 else 3)
            p, q, r = simplex[i].v, simplex[j].v, simplex[k].v
            n = cross(q - p, r - p)
            is_inner = -dot(n, p) * dot(n, simplex[left_out].v - p) > 0.0
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
            simplex[left].v, simplex[left].own = simplex[i].v, simplex[i].own
            left += 1
    return left, v


@inlined
def place_between(simplex: Simplex, count: int, v: Vector) -> Vector:
    """Return the place of the own core that a place v between vertices of the simplex belongs to."""
    a, own = simplex[0].v, simplex[0].own
    if count == 1:
        return own
    ab, along, av = simplex[1].v - a, simplex[1].own - own, v - a
    ac, other = simplex[2].v - a, simplex[2].own - own
    n = cross(ab, ac)
    square = dot(n, n)
    if count == 2 or square <= LIMITS.sliver * LIMITS.sliver * dot(ab, ab) * dot(ac, ac):
        return own + (dot(av, ab) / dot(ab, ab)) * along
    return own + (dot(cross(av, ac), n) / square) * along + (dot(cross(ab, av), n) / square) * other


@inlined
def gap_along(own: Posed, other: ConvexShape, n: Vector) -> float:
    """Return how far cores are apart along a unit vector."""
    return dot(n, farthest_of_posed(own, -n) - farthest(other, n))  # type: ignore[no-any-return]


@kernel
def gap_and_normal(own: Posed, other: ConvexShape, simplex: Simplex) -> GapFound:
    """Return the gap between shapes, the normal, and the place.

    The place is in the middle between both surfaces, where they are nearest or deepest.
    """
    size = own.shape.size + other.size
    margin, margins, aside = own.shape.margin, own.shape.margin + other.margin, LIMITS.aside * size
    is_apart, way, place = way_between(own, other, simplex)
    if is_apart:
        length = norm(way)
        n = (1.0 / length) * way
        if length > aside:
            return GapFound(length - margins, n, place - (margin + 0.5 * (length - margins)) * n)
    else:
        n = first_guess(own, other, LIMITS.no_direction * size)
    gap = gap_along(own, other, n)
    for _ in range(LIMITS.most_turns):
        moved = (aside - gap) * n
        is_apart, way, place = way_between(Posed(own.shape, own.R, own.x + moved), other, simplex)
        place -= moved
        if not is_apart:
            break
        turned = (1.0 / norm(way)) * way
        change, found = norm(turned - n), gap_along(own, other, turned)
        if found <= gap:
            break
        n, gap = turned, found
        if change < LIMITS.same_normal:
            break
    return GapFound(gap - margins, n, place - (margin + 0.5 * (gap - margins)) * n)


Guess = namedtuple("Guess", "gap n")
"""The gap along a direction, and that."""


@inlined
def first_guess(own: Posed, other: ConvexShape, least: float) -> Vector:
    """Return the direction in which overlapping cores are the least in each other, of those of faces and of axes."""
    best = Guess(-np.inf, Vector(0.0, 0.0, 1.0))
    for i in range(int(other.faces)):
        best = better(own, other, face_of(other, i).normal, 0.0, best)
    for i in range(int(own.shape.faces)):
        best = better(own, other, -(own.R @ face_of(own.shape, i).normal), 0.0, best)
    a, b = own.R @ own.shape.axis, other.axis
    between = own.x + own.R @ own.shape.centre - other.centre
    crossed = cross(a, b)
    for sign in (1.0, -1.0):
        if own.shape.disc > 0.0:
            best = better(own, other, sign * a, 0.0, best)
        if other.disc > 0.0:
            best = better(own, other, sign * b, 0.0, best)
        best = better(own, other, sign * crossed, least, best)
    best = better(own, other, across(between, a), least, best)
    return better(own, other, across(between, b), least, best).n


@inlined
def better(own: Posed, other: ConvexShape, direction: Vector, least: float, best: Guess) -> Guess:
    """Return the gap along a direction and that, if it is larger than the best one and longer than the least."""
    length = norm(direction)
    if length <= least:
        return best
    unit = (1.0 / length) * direction
    gap = gap_along(own, other, unit)
    return Guess(gap, unit) if gap > best.gap else best
