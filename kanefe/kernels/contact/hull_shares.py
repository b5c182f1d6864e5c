"""What the corners of a hull of points share of the stiffness, on a plane and in a room.

The corners of the face that looks along the surface share all of it, however many other corners and faces there are.
As the hull turns, faces take over from each other by the inverse fourth powers of their angles to the surface. What
touches less deep than the deepest corner has less, and what is in the air leaves its part to the others.
"""

from __future__ import annotations

from typing import Any

from kanefe.kernels.algebra.vectors import Numbers, dot, minus, plus, rotated, rotated_back, three
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.contact.contact_forces import end_of, softened
from kanefe.kernels.contact.contact_places import AT, OF_POINT, POINT_NUMBERS, POINTS
from kanefe.kernels.contact.contact_shapes import PLANE, distance
from kanefe.kernels.force_elements.bushing import nine
from kanefe.kernels.force_elements.places import A, P

OF_FACE = 4
"""Count of numbers of a face at a corner: its normal, and one over how many corners it has."""

FLAT = 1e-20
"""Fourth power of an angle, rad4, that is added to that of a face to the surface: it may be zero."""


@inlined
def hull_met(numbers: Any, ends: Any) -> Any:
    """Return the largest depth and the sum of the weights of all corners, on a plane the same for each."""
    if int(numbers[int(numbers[AT.shape])]) != PLANE:
        return 0.0 * ends[P], 0.0 * ends[P]
    return alike(numbers, corner(numbers, 0, ends)[1], ends)


@kernel
def corner(numbers: Any, i: int, ends: Any) -> Any:
    """Return the place of a corner with its share in the air, as `kanefe.kernels.contact.detection.located` does."""
    own, shape = POINTS + POINT_NUMBERS * i, int(numbers[AT.shape])
    at = end_of(numbers, i)
    A_s, p_s = nine(ends, A), three(ends, P)
    point = plus(three(ends, at + P), rotated(nine(ends, at + A), three(numbers, own + OF_POINT.point)))
    if int(numbers[shape]) == PLANE:
        normal = rotated(A_s, three(numbers, shape + 1))
        return -dot(normal, minus(point, p_s)), normal, point, float(numbers[own + OF_POINT.share])
    found = distance(numbers, shape, rotated_back(A_s, minus(point, p_s)))
    normal = rotated(A_s, (found[1], found[2], found[3]))
    return -found[0], normal, point, float(numbers[own + OF_POINT.share])


@kernel
def hull_corner(numbers: Any, i: int, ends: Any, met: Any) -> Any:
    """Return the place of a corner with its share."""
    depth, normal, point, share = corner(numbers, i, ends)
    deepest, total = met
    pressed = softened(numbers, depth)
    part = share + 0.0 * depth
    if pressed.real > 0.0:
        if total.real <= 0.0:
            deepest, total = alike(numbers, normal, ends)
        part = weight(numbers, i, normal, pressed, deepest, ends) / total
    return depth, normal, point, part


@kernel
def alike(numbers: Any, normal: Numbers, ends: Any) -> Any:
    """Return the largest depth along a normal, and the sum of the weights of all corners there.

    The corners that touch another wall of a room count by the cosine of the angle between both.
    """
    zero = 0.0 * ends[P]
    deepest, total, count = zero, zero, int(numbers[AT.points])
    for i in range(count):
        depth, own, _, _ = corner(numbers, i, ends)
        pressed = softened(numbers, depth) * dot(own, normal)
        if pressed.real > deepest.real:
            deepest = pressed
    if deepest.real <= 0.0:
        return deepest, total
    for i in range(count):
        depth, own, _, _ = corner(numbers, i, ends)
        pressed, cosine = softened(numbers, depth), dot(own, normal)
        if pressed.real > 0.0 and cosine.real > 0.0:
            total += cosine * weight(numbers, i, own, cosine * pressed, deepest, ends)
    return deepest, total


@kernel
def weight(numbers: Any, i: int, normal: Numbers, pressed: Any, deepest: Any, ends: Any) -> Any:
    """Return what a corner has before it is shared out: of its faces, and as far as it is as deep as the deepest."""
    first = int(numbers[AT.faces]) + 2 * i
    at, count = int(numbers[AT.faces] + numbers[first]), int(numbers[first + 1])
    along = rotated_back(nine(ends, end_of(numbers, i) + A), normal)
    x = pressed / deepest
    of_faces = 0.0 * x
    for face in range(at, at + OF_FACE * count, OF_FACE):
        square = 2.0 + 2.0 * dot(along, three(numbers, face))
        of_faces += numbers[face + 3] / (square * square + FLAT)
    return of_faces * x * x * (3.0 - 2.0 * x) if x.real < 1.0 else of_faces + 0.0 * x
