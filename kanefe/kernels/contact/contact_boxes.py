"""A box on a box: along one axis, of least overlap, their faces meet in a polygon, or two edges cross.

The axis is found among those of the faces and the products of edges (the separating axis theorem; Gottschalk, Lin and
Manocha 1996). Where a face leads, what touches are corners of both faces that lie over the other face, and the places
where their edges cross: corners of the polygon that they share. Each is a slot, so that friction knows it again.
"""

from collections import namedtuple
from typing import Any, NamedTuple

from kanefe.kernels.force_elements.places import A
from kanefe.kernels.language import Vector, cross, dot, inlined, norm, numbers_from


class Slots(NamedTuple):
    """First slots of the places where boxes may touch, and their number."""

    own_corners: int = 0
    other_corners: int = 4
    crossings: int = 8
    edges: int = 16
    slots: int = 17
    """First slots: corners of the touching box, corners of the touched box, crossings of the edges of their faces, and
    edges that cross in space; last the number of slots."""


SLOT = Slots()


class Limits(NamedTuple):
    """From where on numbers count between boxes."""

    parallel: float = 1e-6
    """Sine of the angle between edges below which their product is not an axis."""
    preferred: float = 1e-6
    """Overlap, relative to the size of the boxes, by which edges must overlap less than faces to be chosen."""
    on_edge: float = 1e-6
    """Distance relative to the size of the boxes within which a corner outside a face counts as over the face."""


LIMITS = Limits()


HalfBox = namedtuple("HalfBox", "end half")
"""A box at an end: half its sizes, m."""

BoxesMet = namedtuple("BoxesMet", "normal overlap first second")
"""How boxes meet: normal, overlap, and the axes of the edges that cross (-1: a face leads)."""

Face = namedtuple("Face", "axis side")
"""A face of a box: its axis, and on which side it is."""


@inlined
def boxes_meet(own: HalfBox, other: HalfBox) -> BoxesMet:
    """Return how two boxes meet."""
    between = own.end.p - other.end.p
    size = size_of(own) + size_of(other)
    n = axis_of(other, 0)
    overlap, first, second, is_first = 0.0 * n.x, -1, -1, True
    for k in range(6):
        axis = axis_of(other if k < 3 else own, k % 3)
        found = overlap_along(axis, between, own, other)
        if is_first or found.real < overlap.real:
            n, overlap, is_first = axis, found, False
    least = overlap.real - LIMITS.preferred * size
    for i in range(3):
        for j in range(3):
            axis = cross(axis_of(own, i), axis_of(other, j))
            length = norm(axis)
            if length.real > LIMITS.parallel:
                axis = (1.0 / length) * axis
                found = overlap_along(axis, between, own, other)
                if found.real < least:
                    n, overlap, first, second, least = axis, found, i, j, found.real
    if dot(n, between).real < 0.0:
        n = -n
    return BoxesMet(n, overlap, first, second)


@inlined
def axis_of(box: HalfBox, i: int) -> Vector:
    """Return an axis of a box."""
    numbers = numbers_from(box.end)
    return Vector(numbers[A + i], numbers[A + 3 + i], numbers[A + 6 + i])


@inlined
def half_of(box: HalfBox, i: int) -> float:
    """Return half of its size along an axis."""
    return box.half.x if i == 0 else box.half.y if i == 1 else box.half.z  # type: ignore[no-any-return]


@inlined
def size_of(box: HalfBox) -> float:
    """Return the sum of half its sizes."""
    return box.half.x + box.half.y + box.half.z  # type: ignore[no-any-return]


@inlined
def without_sign(x: Any) -> Any:
    """Return the size of a number, whose derivative is that of its sign."""
    return -x if x.real < 0.0 else x


@inlined
def overlap_along(axis: Vector, between: Vector, own: HalfBox, other: HalfBox) -> Any:
    """Return how far two boxes overlap along an axis."""
    reach = -without_sign(dot(axis, between))
    for i in range(3):
        reach += half_of(other, i) * without_sign(dot(axis, axis_of(other, i)))
        reach += half_of(own, i) * without_sign(dot(axis, axis_of(own, i)))
    return reach


@inlined
def box_slot(met: BoxesMet, slot: int, own: HalfBox, other: HalfBox) -> tuple[Any, Vector]:
    """Return depth and place in N of a slot."""
    n = met.normal
    if met.first >= 0 or slot == SLOT.edges:
        if met.first < 0 or slot != SLOT.edges:
            return -without_sign(met.overlap), own.end.p
        p, q = on_edge(own, met.first, n, -1.0), on_edge(other, met.second, n, 1.0)
        a, b, d = axis_of(own, met.first), axis_of(other, met.second), q - p
        c = dot(a, b)
        return met.overlap, p + ((dot(d, a) - c * dot(d, b)) / (1.0 - c * c)) * a
    margin = LIMITS.on_edge * (size_of(own) + size_of(other))
    of_own, of_other = face_along(own, -n), face_along(other, n)
    if slot < SLOT.other_corners:
        p = corner(own, of_own, slot)
        return over(p, other, of_other, n, margin), p
    if slot < SLOT.crossings:
        p = corner(other, of_other, slot - SLOT.other_corners)
        return over(p, own, of_own, -n, margin), p
    side = (slot - SLOT.crossings) // 2
    edge = corner(own, of_own, side), corner(own, of_own, (side + 1) % 4)
    return crossing((slot - SLOT.crossings) % 2, edge, other, of_other, n, margin)


@inlined
def crossing(
    is_end: int, edge: tuple[Vector, Vector], box: HalfBox, face: Face, n: Vector, margin: float
) -> tuple[Any, Vector]:
    """Return depth and place of where an edge comes over a face, or leaves it."""
    start, stop = edge
    depth, change = below(start, box, face, n), below(stop, box, face, n)
    one, two = start + depth * n, stop + change * n
    change -= depth
    low, high = 0.0 * depth, 0.0 * depth + 1.0
    for i in range(2):
        k = (face.axis + 1 + i) % 3
        axis, half = axis_of(box, k), half_of(box, k)
        x, way = dot(axis, one - box.end.p), dot(axis, two - one)
        if abs(way.real) <= margin:
            if abs(x.real) > half + margin:
                return -without_sign(without_sign(x) - half), start
        else:
            enters, leaves = (-half - x) / way, (half - x) / way
            if enters.real > leaves.real:
                enters, leaves = leaves, enters
            low = enters if enters.real > low.real else low
            high = leaves if leaves.real < high.real else high
    offset = stop - start
    length, share = norm(offset), high if is_end else low
    away = ((1.0 - share) if is_end else share) * length - margin
    short = (high - low) * length - margin
    away = short if short.real < away.real else away
    depth += share * change
    return away if away.real <= 0.0 and away.real < depth.real else depth, start + share * offset


@inlined
def on_edge(box: HalfBox, along: int, n: Vector, sign: float) -> Vector:
    """Return the middle of the edge of a box, along one of its axes, that lies furthest along n, or against it."""
    p = box.end.p
    for i in range(3):
        if i != along:
            axis = axis_of(box, i)
            p += (half_of(box, i) * (sign if dot(axis, n).real >= 0.0 else -sign)) * axis
    return p


@inlined
def face_along(box: HalfBox, direction: Vector) -> Face:
    """Return the face of a box that looks most along a direction."""
    best, axis, side = -1.0, 0, 1.0
    for i in range(3):
        share = dot(axis_of(box, i), direction).real
        if abs(share) > best:
            best, axis, side = abs(share), i, 1.0 if share >= 0.0 else -1.0
    return Face(axis, side)


@inlined
def middle_of(box: HalfBox, face: Face) -> Vector:
    """Return the middle of a face."""
    return box.end.p + (face.side * half_of(box, face.axis)) * axis_of(box, face.axis)


@inlined
def corner(box: HalfBox, face: Face, i: int) -> Vector:
    """Return a corner of a face, round it."""
    first, second = (face.axis + 1) % 3, (face.axis + 2) % 3
    x, y = (1.0 if i in (1, 2) else -1.0), (1.0 if i > 1 else -1.0)
    p = middle_of(box, face) + (x * half_of(box, first)) * axis_of(box, first)
    return p + (y * half_of(box, second)) * axis_of(box, second)


@inlined
def below(p: Vector, box: HalfBox, face: Face, n: Vector) -> Any:
    """Return how far below a face a place is, along n."""
    normal = axis_of(box, face.axis)
    return dot(normal, middle_of(box, face) - p) / dot(normal, n)


@inlined
def over(p: Vector, box: HalfBox, face: Face, n: Vector, margin: float) -> Any:
    """Return how far below a face a place is, along n; of a place beside the face how far beside, below 0."""
    depth = below(p, box, face, n)
    offset = p + depth * n - box.end.p
    first, second = (face.axis + 1) % 3, (face.axis + 2) % 3
    x = half_of(box, first) - without_sign(dot(axis_of(box, first), offset)) + margin
    y = half_of(box, second) - without_sign(dot(axis_of(box, second), offset)) + margin
    beside = y if y.real < x.real else x
    return beside if beside.real < 0.0 and beside.real < depth.real else depth
