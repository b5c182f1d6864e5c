"""Guides: a point that is held on a line through other points, and slides along it (Eq. 11).

The line ``r(s) = sum b_i(s) p_i`` is a spline through the points p_i, of which the weights b_i are constants. The foot
of the runner at P is the nearest of all places where ``(P - r(s)) . r'(s) = 0``: as s makes ``|P - r(s)|`` least there,
the forces ``-k (P - r)`` on the runner and ``k b_i (P - r)`` on the points are the gradient of ``k/2 |P - r|^2``,
without the derivative of s.
"""

from typing import Any, NamedTuple

import numpy as np

from kanefe.kernels.compiler.local_numbers import local_numbers
from kanefe.kernels.force_elements.nearest_on_line import Line, nearest_on_pieces
from kanefe.kernels.force_elements.places import SIGNATURE, WATCH_SIGNATURE, Done, Ends, Wrenches
from kanefe.kernels.language import Record, Vector, called_by_address, dot, inlined
from kanefe.kernels.links.polynomials import POWERS, piece_at


class GuideNumbers(Record):
    """Numbers of a guide: N/m, and N s/m across and along, and its line."""

    stiffness: float
    damping: float
    drag: float
    line: Line


SHARP = 1e-9
"""Rate at which the foot's equation changes, relative to that of a straight line, at which the runner is taken to be at
the centre of curvature, where the foot has no derivatives."""

EDGE = 1e-9
"""Distance of a runner beyond the end of a line, relative to the line's length, that is round-off of a start there.
"""

Place = tuple[int, Any, Any]
"""Number of the first weight of a piece of the line, and the arc lengths from its start and beyond the ends, m."""


class Foot(NamedTuple):
    """A place of a line."""

    s: Any  # its arc length
    r: Vector  # the line there, and its first two derivatives by the arc length
    slope: Vector
    bend: Vector


@called_by_address(*SIGNATURE)
def guide(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write the forces on the runner, which comes first, and on the points of the line; see `GuideNumbers`."""
    own, done = GuideNumbers(numbers), Done(out)
    foot = foot_of(own.line, ends)
    place, on = place_in(own.line, foot.s), Wrenches(done.wrenches)
    d, slope = Ends(ends)[0].p - foot.r, foot.slope
    tangent, (rate, _) = (1.0 / np.sqrt(dot(slope, slope))) * slope, rates_along(own.line, place, ends)
    along = dot(tangent, rate)
    across = rate - along * tangent
    force = -(own.stiffness * d + own.damping * across + own.drag * along * tangent)
    done.potential = 0.5 * own.stiffness * dot(d, d)
    done.taken = own.damping * dot(across, across) + own.drag * along * along
    on[0].force = force
    for i in range(int(own.line.points)):
        on[i + 1].force = -weight(own.line, i, place)[0] * force


@called_by_address(*WATCH_SIGNATURE)
def guide_watch(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write how far the foot is behind the start of the line, and before its end."""
    line = GuideNumbers(numbers).line
    s, length = foot_of(line, ends).s, line_length(line)
    out[0], out[1] = s + EDGE * length, length - s + EDGE * length


@called_by_address(*WATCH_SIGNATURE)
def guide_tell(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write the arc length, the runner's distance from the line, the rate of the arc length, and the force across."""
    own = GuideNumbers(numbers)
    foot = foot_of(own.line, ends)
    d, slope = Ends(ends)[0].p - foot.r, foot.slope
    rate, turning = rates_along(own.line, place_in(own.line, foot.s), ends)
    size = dot(slope, slope)
    force = own.stiffness * d + own.damping * (rate - (dot(slope, rate) / size) * slope)
    out[0], out[1] = foot.s, np.sqrt(dot(d, d))
    out[2] = (dot(rate, slope) + dot(d, turning)) / (size - dot(d, foot.bend))
    out[3] = np.sqrt(dot(force, force))


@inlined
def line_length(line: Line) -> float:
    """Return the arc length at the end of the line."""
    return line.table[int(line.points) - 1]


@inlined
def place_in(line: Line, s: Any) -> Place:
    """Return the place of an arc length among the pieces of the line."""
    count, pieces, length = int(line.points), int(line.pieces), line_length(line)
    beyond = 0.0 * s
    if s.real < 0.0:
        beyond = s
    elif s.real > length:
        beyond = s - length
    inside = s - beyond
    piece = piece_at(line.table, count, pieces, inside.real)
    return count + pieces + 1 + piece * POWERS * count, inside - line.table[count + piece], beyond


@inlined
def weight(line: Line, i: int, place: Place) -> tuple[Any, Any, Any]:
    """Return the weight of a point of the line at a place and its first two derivatives; straight beyond ends."""
    weights, x, beyond = place
    count, at, table = int(line.points), weights + i, line.table
    b = table[at + (POWERS - 1) * count] + 0.0 * x
    db = ddb = 0.0 * x
    for power in range(POWERS - 2, -1, -1):
        ddb, db, b = ddb * x + db, db * x + b, b * x + table[at + power * count]
    if beyond.real != 0.0:
        return b + beyond * db, db, 0.0 * ddb
    return b, db, 2.0 * ddb


@inlined
def rates_along(line: Line, place: Place, ends: Any) -> tuple[Vector, Vector]:
    """Return the runner's velocity seen from a place of the line, and how fast the line turns there."""
    rate = Ends(ends)[0].v
    turning = 0.0 * rate
    for i in range(int(line.points)):
        b, db, _ = weight(line, i, place)
        v = Ends(ends)[i + 1].v
        rate, turning = rate - b * v, turning + db * v
    return rate, turning


@inlined
def foot_of(line: Line, ends: Any) -> Foot:
    """Return the foot of the runner: the nearest point of the line; straight beyond an end that is nearest."""
    length = line_length(line)
    foot = _line_at(line, nearest_on_pieces(line, ends, local_numbers()) + 0.0 * ends[0], ends)
    d, size = Ends(ends)[0].p - foot.r, dot(foot.slope, foot.slope)
    along = dot(d, foot.slope)
    is_beyond = (foot.s.real <= 0.0 and along.real < 0.0) or (foot.s.real >= length and along.real > 0.0)
    rate = size if is_beyond else size - dot(d, foot.bend)
    if rate.real > SHARP * size.real:
        foot = _line_at(line, foot.s + along / rate, ends)  # to the exact foot, and its derivatives
    return foot


@inlined
def _line_at(line: Line, s: Any, ends: Any) -> Foot:
    """Return a place of the line."""
    place, r = place_in(line, s), 0.0 * Ends(ends)[0].p
    slope = bend = r
    for i in range(int(line.points)):
        b, db, ddb = weight(line, i, place)
        p = Ends(ends)[i + 1].p
        r, slope, bend = r + b * p, slope + db * p, bend + ddb * p
    return Foot(s, r, slope, bend)
