"""The point of a piecewise polynomial line that is nearest to a runner, of all.

On each piece the places where the distance is least or largest are roots of a polynomial of the ninth degree, ``g(x) =
-q . q'`` with q from the runner to the line. It is looked at in steps; between two of them where it goes from above to
below zero the distance is least, and the root there is found in a bracket. A piece that is too far away is left out.
"""

from typing import Annotated, Any, NamedTuple

from kanefe.kernels.force_elements.places import End, Ends
from kanefe.kernels.language import ZERO, Behind, Record, Rows, Vector, dot, kernel, numbers_from
from kanefe.kernels.links.polynomials import POWERS


class Limits(NamedTuple):
    """How the nearest place is looked for."""

    steps: int = 32
    """Number of steps in which a piece is looked at: its distance has five least places at most."""
    most_steps: int = 60
    """Number of steps to a root in its bracket, which halvings alone reach to the last digit in 53."""
    close: float = 1e-15
    """Length of a step to a root, relative to that of the piece, that is round-off."""


LIMITS = Limits()

DEGREE = 2 * POWERS - 3
"""Degree of g."""


class Line(Record):
    """A line: how many points and pieces it has.

    The table has the arc lengths of the points, those at which the pieces start and the last ends, and of each piece
    the coefficients of the powers 0 to 5, with a weight for each point.
    """

    points: float
    pieces: float
    table: Annotated[Any, Behind()]


class Power(Record):
    """What is multiplied by a power of the arc length."""

    of: Vector


class Powers(Rows[Power]):
    """A piece as seen from the runner; the coefficients of g follow."""


@kernel
def nearest_on_pieces(line: Line, ends: Any, room: Any) -> float:
    """Return the arc length of the nearest point of the line; the first end is the runner, the others its points.

    `room` is for the coefficients of a piece.
    """
    found, least, points, table, seen = 0.0, -1.0, int(line.points), line.table, Powers(room)
    slopes = numbers_from(seen[POWERS])
    for i in range(points):  # ends of pieces are among them
        d = place_from_runner(Ends(ends)[i + 1], Ends(ends)[0])
        if least < 0.0 or dot(d, d) < least:
            found, least = table[i], dot(d, d)
    for piece in range(int(line.pieces)):
        start = table[points + piece]
        width = table[points + piece + 1] - start
        put_piece(line, points + int(line.pieces) + 1 + piece * POWERS * points, ends, seen)
        if is_farther(seen, width, least):
            continue
        low, value_low = 0.0, slope_at(slopes, 0.0)[0]
        for step in range(1, LIMITS.steps + 1):
            high = width * step / LIMITS.steps
            value = slope_at(slopes, high)[0]
            if value_low > 0.0 and value <= 0.0:
                x = root_between(slopes, low, high)
                gap = gap_at(seen, x)
                if gap < least:
                    found, least = start + x, gap
            low, value_low = high, value
    return found


@kernel
def place_from_runner(end: End, runner: End) -> Vector:
    """Return where an end is seen from the runner, in real numbers."""
    d = end.p - runner.p
    return Vector(d.x.real, d.y.real, d.z.real)


@kernel
def put_piece(line: Line, weights: int, ends: Any, powers: Powers) -> None:
    """Write a piece as seen from the runner, of the place of its first weight in the table."""
    points, slopes = int(line.points), numbers_from(powers[POWERS])
    for power in range(POWERS):
        powers[power].of = ZERO
        for i in range(points):
            d = place_from_runner(Ends(ends)[i + 1], Ends(ends)[0])
            powers[power].of += line.table[weights + power * points + i] * d
    for k in range(DEGREE + 1):
        slopes[k] = 0.0
    for i in range(POWERS):
        for j in range(1, POWERS):
            slopes[i + j - 1] -= j * dot(powers[i].of, powers[j].of)


@kernel
def is_farther(powers: Powers, width: float, least: float) -> bool:
    """Return whether all of a piece is farther from the runner than the root of a square."""
    near, reach, scale = dot(powers[0].of, powers[0].of) ** 0.5, 0.0, 1.0
    for power in range(1, POWERS):
        scale *= width
        reach += scale * dot(powers[power].of, powers[power].of) ** 0.5
    return near > reach and (near - reach) ** 2 > least


@kernel
def slope_at(slopes: Any, x: float) -> tuple[float, float]:
    """Return g and its derivative."""
    value, rate = slopes[DEGREE], 0.0
    for k in range(DEGREE - 1, -1, -1):
        value, rate = value * x + slopes[k], rate * x + value
    return value, rate


@kernel
def gap_at(powers: Powers, x: float) -> float:
    """Return the square of the distance from the runner, m2."""
    q = powers[POWERS - 1].of
    for power in range(POWERS - 2, -1, -1):
        q = x * q + powers[power].of
    return dot(q, q)


@kernel
def root_between(slopes: Any, low: float, high: float) -> float:
    """Return where g goes from above to below zero, by Newton's steps; by halving where these leave the bracket."""
    width = high - low
    x = 0.5 * (low + high)
    for _ in range(LIMITS.most_steps):
        value, rate = slope_at(slopes, x)
        if value > 0.0:
            low = x
        else:
            high = x
        new = 0.5 * (low + high)
        if rate < 0.0 and low < x - value / rate < high:
            new = x - value / rate
        if abs(new - x) <= LIMITS.close * width:
            break
        x = new
    return x
