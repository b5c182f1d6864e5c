"""Where a point of a contact is to the surface: depth, normal, place, and how fast it moves past it."""

from __future__ import annotations

from typing import Any

from kanefe.kernels.algebra.vectors import (
    Numbers,
    cross,
    dot,
    minus,
    norm,
    plus,
    product,
    rotated,
    rotated_back,
    three,
    times,
    transposed,
)
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.contact.contact_boxes import box_slot, boxes_meet
from kanefe.kernels.contact.contact_places import AT, OF_POINT, POINT_NUMBERS, POINTS
from kanefe.kernels.contact.contact_shapes import PLANE, distance
from kanefe.kernels.force_elements.bushing import nine
from kanefe.kernels.force_elements.places import END_NUMBERS, A, P, V, W

ON_ITS_AXIS, MOST_TURNS, SAME_NORMAL = 1e-9, 100, 1e-15
"""Sine of the angle between the axis of a ring and the normal below which the ring has no lowest point, largest number
of iterations, and tolerance of the normal in the search for that point on curved ground, in which the normal at a point
gives the next point. The error decreases by the radius of the ring over that of the ground, and its square enters the
depth."""


@inlined
def met_by(numbers: Any, ends: Any) -> Any:
    """Return how boxes meet, where a box touches one: see `boxes_meet`."""
    zero = 0.0 * ends[P]
    if numbers[POINTS + OF_POINT.ring] >= 0.0:
        return zero, zero, zero, zero, -1, -1
    return boxes_meet(
        ends,
        END_NUMBERS * int(numbers[POINTS + OF_POINT.end]),
        three(numbers, POINTS + OF_POINT.axis),
        times(0.5, three(numbers, int(numbers[AT.shape]) + 1)),
    )


@inlined
def located(numbers: Any, i: int, ends: Any, met: Numbers) -> Any:
    """Return the place of a point: depth, normal, where it is in N, and its share of the stiffness."""
    own = POINTS + POINT_NUMBERS * i
    share = float(numbers[own + OF_POINT.share])
    at, ring = END_NUMBERS * int(numbers[own + OF_POINT.end]), numbers[own + OF_POINT.ring]
    shape = int(numbers[AT.shape])
    if ring < 0.0:
        axis, other = three(numbers, own + OF_POINT.axis), times(0.5, three(numbers, shape + 1))
        found = box_slot(met, -1 - int(ring), ends, at, axis, other)
        return found[0], (met[0], met[1], met[2]), (found[1], found[2], found[3]), share
    A_s, p_s, A_p = nine(ends, A), three(ends, P), nine(ends, at + A)
    centre = plus(three(ends, at + P), rotated(A_p, three(numbers, own + OF_POINT.point)))
    radius = numbers[own + OF_POINT.radius]
    if int(numbers[shape]) == PLANE and ring == 0.0:  # most often
        normal = rotated(A_s, three(numbers, shape + 1))
        phi = dot(normal, minus(centre, p_s))
        return radius - phi, normal, minus(centre, times(radius, normal)), share
    found = distance(numbers, shape, rotated_back(A_s, minus(centre, p_s)))
    normal, phi = rotated(A_s, (found[1], found[2], found[3])), found[0]
    if ring > 0.0:
        axis, middle = rotated(A_p, three(numbers, own + OF_POINT.axis)), centre
        for _ in range(1 if int(numbers[shape]) == PLANE else MOST_TURNS):
            down = minus(times(dot(axis, normal), axis), normal)
            length = norm(down)
            if length.real <= ON_ITS_AXIS:
                break
            before, centre = normal, plus(middle, times(ring / length, down))
            found = distance(numbers, shape, rotated_back(A_s, minus(centre, p_s)))
            normal, phi = rotated(A_s, (found[1], found[2], found[3])), found[0]
            turned = minus(normal, before)
            if dot(turned, turned).real <= SAME_NORMAL * SAME_NORMAL:
                break
    return radius - phi, normal, minus(centre, times(radius, normal)), share


@inlined
def velocity(ends: Any, end: int, arm: Numbers, arm_s: Numbers) -> Numbers:
    """Return the velocity of what touches, seen from what is touched, where they meet."""
    own = plus(three(ends, end + V), cross(three(ends, end + W), arm))
    return minus(own, plus(three(ends, V), cross(three(ends, W), arm_s)))


@inlined
def gone_since(numbers: Any, at: int, ends: Any, end: int) -> Numbers:
    """Return how far a point of what touches has gone along with what is touched since a state of rest."""
    material, mark = three(numbers, at), three(numbers, at + 3)
    point = plus(three(ends, end + P), rotated(nine(ends, end + A), material))
    return minus(minus(point, three(ends, P)), rotated(nine(ends, A), mark))


@kernel
def turned_since(numbers: Any, at: int, ends: Any, end: int) -> Numbers:
    """Return how far what touches has turned past the surface since a state of rest, to first order."""
    A_s = nine(ends, A)
    R = product(product(transposed(A_s), nine(ends, end + A)), transposed(nine(numbers, at)))
    return rotated(A_s, (0.5 * (R[7] - R[5]), 0.5 * (R[2] - R[6]), 0.5 * (R[3] - R[1])))
