"""What the corners of a hull of points share of the stiffness, on a plane and in a room.

The corners of the face that looks along the surface share all of it, however many other corners and faces there are.
As the hull turns, faces take over from each other by the inverse fourth powers of their angles to the surface. What
touches less deep than the deepest corner has less, and what is in the air leaves its part to the others.
"""

from collections import namedtuple
from typing import Any

from kanefe.kernels.contact.contact_places import AtState, Place, end_of, point_of, softened
from kanefe.kernels.contact.contact_shapes import ShapeKind
from kanefe.kernels.contact.detection import away_from
from kanefe.kernels.force_elements.places import Ends
from kanefe.kernels.language import Record, Vector, dot, inlined, kernel

FLAT = 1e-20
"""Fourth power of an angle, rad4, that is added to that of a face to the surface: it may be zero."""


class CornerFaces(Record):
    """Where the faces at a corner of a hull begin, after where all begin, and how many they are."""

    start: float
    count: float


class HullFace(Record):
    """A face at a corner: its normal, and one over how many corners it has."""

    normal: Vector
    part: float


CORNER_FACES, HULL_FACE = CornerFaces.number_count, HullFace.number_count

HullMet = namedtuple("HullMet", "deepest total")
"""The largest depth and the sum of the weights of all corners, on a plane the same for each."""


@inlined
def hull_met(at: AtState) -> HullMet:
    """Return what is known of all corners: nothing in a room."""
    if int(at.numbers[int(at.own.shape)]) != ShapeKind.PLANE:
        zero = 0.0 * Ends(at.ends)[0].p.x
        return HullMet(zero, zero)
    return alike(at, corner(at, 0).normal)


@kernel
def corner(at: AtState, i: int) -> Place:
    """Return the place of a corner with its share in the air."""
    own, end = point_of(at, i), end_of(at, i)
    point = end.p + end.A @ own.point
    found = away_from(at, point)
    return Place(-found.gap, found.normal, point, own.share + 0.0 * found.gap)


@kernel
def hull_corner(at: AtState, i: int, met: HullMet) -> Place:
    """Return the place of a corner with its share."""
    place = corner(at, i)
    pressed = softened(at.own, place.depth)
    if pressed.real <= 0.0:
        return place
    if met.total.real <= 0.0:
        met = alike(at, place.normal)
    return Place(place.depth, place.normal, place.point, weight(at, i, place.normal, pressed, met.deepest) / met.total)


@kernel
def alike(at: AtState, normal: Vector) -> HullMet:
    """Return the largest depth along a normal, and the sum of the weights of all corners there.

    The corners that touch another wall of a room count by the cosine of the angle between both.
    """
    deepest = total = 0.0 * normal.x
    for i in range(int(at.own.count)):
        place = corner(at, i)
        pressed = softened(at.own, place.depth) * dot(place.normal, normal)
        if pressed.real > deepest.real:
            deepest = pressed
    if deepest.real > 0.0:
        for i in range(int(at.own.count)):
            place = corner(at, i)
            pressed, cosine = softened(at.own, place.depth), dot(place.normal, normal)
            if pressed.real > 0.0 and cosine.real > 0.0:
                total += cosine * weight(at, i, place.normal, cosine * pressed, deepest)
    return HullMet(deepest, total)


@inlined
def weight(at: AtState, i: int, normal: Vector, pressed: Any, deepest: Any) -> Any:
    """Return what a corner has before it is shared out: of its faces, and as far as it is as deep as the deepest."""
    first = int(at.own.faces)
    faces = CornerFaces(at.numbers, first + CORNER_FACES * i)
    along, x = end_of(at, i).A.T @ normal, pressed / deepest
    of_faces = 0.0 * x
    for k in range(int(faces.count)):
        face = HullFace(at.numbers, first + int(faces.start) + HULL_FACE * k)
        square = 2.0 + 2.0 * dot(along, face.normal)
        of_faces += face.part / (square * square + FLAT)
    return of_faces * x * x * (3.0 - 2.0 * x) if x.real < 1.0 else of_faces + 0.0 * x
