"""Guides: a point that is held on a line through other points, and slides along it (Eq. 11).

The line ``r(s) = sum b_i(s) p_i`` is a spline through the points p_i, of which the weights b_i are constants. The foot
of the runner at P is the nearest of all places where ``(P - r(s)) . r'(s) = 0``: as s makes ``|P - r(s)|`` least there,
the forces ``-k (P - r)`` on the runner and ``k b_i (P - r)`` on the points are the gradient of ``k/2 |P - r|^2``,
without the derivative of s.
"""

from __future__ import annotations

from collections import namedtuple
from typing import Any

import numpy as np

from kanefe.kernels.algebra.vectors import Numbers, dot, minus, plus, three, times
from kanefe.kernels.compiler._numba import inlined
from kanefe.kernels.compiler.addresses import called_by_address
from kanefe.kernels.compiler.local_numbers import local_numbers
from kanefe.kernels.force_elements.blocks import places
from kanefe.kernels.force_elements.nearest_on_line import nearest_on_pieces
from kanefe.kernels.force_elements.places import (
    END_NUMBERS,
    POTENTIAL,
    SIGNATURE,
    TAKEN,
    WATCH_SIGNATURE,
    WRENCH,
    WRENCHES,
    P,
    V,
)
from kanefe.kernels.links.polynomials import POWERS, piece_at

GuideNumbers = namedtuple("GuideNumbers", "points pieces stiffness damping drag table")
"""Numbers of a guide: of the points of its line and of the pieces of its spline, N/m, and N s/m across and along. The
table has the arc lengths of the points, those at which the pieces start and the last ends, and of each piece the
coefficients of the powers 0 to 5, with a weight for each point."""

AT = places(GuideNumbers)

SHARP = 1e-9
"""Rate at which the foot's equation changes, relative to that of a straight line, at which the runner is taken to be at
the centre of curvature, where the foot has no derivatives."""

EDGE = 1e-9
"""Distance of a runner beyond the end of a line, relative to the line's length, that is round-off of a start there.
"""

Place = tuple[int, Any, Any]
"""Number of the first weight of a piece of the line, and the arc lengths from its start and beyond the ends, m."""

Foot = tuple[Any, Numbers, Numbers, Numbers]
"""Arc length of a foot; and there the line and its first two derivatives by the arc length."""


@called_by_address(*SIGNATURE)
def guide(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write the forces on the runner, which comes first, and on the points of the line; see `GuideNumbers`."""
    count, k, c, drag = int(numbers[AT.points]), numbers[AT.stiffness], numbers[AT.damping], numbers[AT.drag]
    s, r, slope, _ = foot_of(numbers, ends)
    place = place_in(numbers, s)
    d, t_line = minus(three(ends, P), r), times(1.0 / np.sqrt(dot(slope, slope)), slope)
    rate = three(ends, V)
    for i in range(count):
        b, _, _ = weight(numbers, i, place)
        rate = minus(rate, times(b, three(ends, END_NUMBERS * (i + 1) + V)))
    along = dot(t_line, rate)
    across = minus(rate, times(along, t_line))
    force = plus(times(-k, d), plus(times(-c, across), times(-drag * along, t_line)))
    out[POTENTIAL] = 0.5 * k * dot(d, d)
    out[TAKEN] = c * dot(across, across) + drag * along * along
    for x in range(3):
        out[WRENCHES + x] += force[x]
    for i in range(count):
        b, _, _ = weight(numbers, i, place)
        for x in range(3):
            out[WRENCHES + WRENCH * (i + 1) + x] -= b * force[x]


@called_by_address(*WATCH_SIGNATURE)
def guide_watch(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write how far the foot is behind the start of the line, and before its end."""
    s, length = foot_of(numbers, ends)[0], line_length(numbers)
    out[0], out[1] = s + EDGE * length, length - s + EDGE * length


@called_by_address(*WATCH_SIGNATURE)
def guide_tell(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write the arc length, the runner's distance from the line, the rate of the arc length, and the force across."""
    s, r, slope, bend = foot_of(numbers, ends)
    d, rate, place = minus(three(ends, P), r), three(ends, V), place_in(numbers, s)
    turning = times(0.0, d)
    for i in range(int(numbers[AT.points])):
        b, db, _ = weight(numbers, i, place)
        v = three(ends, END_NUMBERS * (i + 1) + V)
        rate, turning = minus(rate, times(b, v)), plus(turning, times(db, v))
    size = dot(slope, slope)
    across = minus(rate, times(dot(slope, rate) / size, slope))
    force = plus(times(numbers[AT.stiffness], d), times(numbers[AT.damping], across))
    out[0], out[1] = s, np.sqrt(dot(d, d))
    out[2] = (dot(rate, slope) + dot(d, turning)) / (size - dot(d, bend))
    out[3] = np.sqrt(dot(force, force))


@inlined
def line_length(numbers: Any) -> float:
    """Return the arc length at the end of the line."""
    return float(numbers[AT.table + int(numbers[AT.points]) - 1])


@inlined
def place_in(numbers: Any, s: Any) -> Place:
    """Return the place of an arc length among the pieces of the line."""
    count, pieces, length = int(numbers[AT.points]), int(numbers[AT.pieces]), line_length(numbers)
    beyond = 0.0 * s
    if s.real < 0.0:
        beyond = s
    elif s.real > length:
        beyond = s - length
    inside, starts = s - beyond, AT.table + count
    piece = piece_at(numbers, starts, pieces, inside.real)
    return starts + pieces + 1 + piece * POWERS * count, inside - numbers[starts + piece], beyond


@inlined
def weight(numbers: Any, i: int, place: Place) -> tuple[Any, Any, Any]:
    """Return the weight of a point of the line at a place and its first two derivatives; straight beyond ends."""
    weights, x, beyond = place
    count, at = int(numbers[AT.points]), weights + i
    b = numbers[at + (POWERS - 1) * count] + 0.0 * x
    db = ddb = 0.0 * x
    for power in range(POWERS - 2, -1, -1):
        ddb, db, b = ddb * x + db, db * x + b, b * x + numbers[at + power * count]
    if beyond.real != 0.0:
        return b + beyond * db, db, 0.0 * ddb
    return b, db, 2.0 * ddb


@inlined
def foot_of(numbers: Any, ends: Any) -> Foot:
    """Return the foot of the runner: the nearest point of the line; straight beyond an end that is nearest."""
    place, length = three(ends, P), line_length(numbers)
    points, pieces = int(numbers[AT.points]), int(numbers[AT.pieces])
    s = nearest_on_pieces(numbers, AT.table, points, pieces, ends, local_numbers()) + 0.0 * ends[0]
    r, slope, bend = _line(numbers, points, s, ends)
    d, size = minus(place, r), dot(slope, slope)
    along = dot(d, slope)
    is_beyond = (s.real <= 0.0 and along.real < 0.0) or (s.real >= length and along.real > 0.0)
    rate = size if is_beyond else size - dot(d, bend)
    if rate.real > SHARP * size.real:
        s += along / rate  # from the last digits to the exact foot, and its derivatives
        r, slope, bend = _line(numbers, points, s, ends)
    return s, r, slope, bend


@inlined
def _line(numbers: Any, count: int, s: Any, ends: Any) -> tuple[Numbers, Numbers, Numbers]:
    """Return the line at an arc length, and its first two derivatives."""
    zero, place = 0.0 * ends[0], place_in(numbers, s)
    r = slope = bend = (zero, zero, zero)
    for i in range(count):
        b, db, ddb = weight(numbers, i, place)
        p = three(ends, END_NUMBERS * (i + 1) + P)
        r, slope, bend = plus(r, times(b, p)), plus(slope, times(db, p)), plus(bend, times(ddb, p))
    return r, slope, bend
