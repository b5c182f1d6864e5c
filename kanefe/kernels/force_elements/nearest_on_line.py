"""The point of a piecewise polynomial line that is nearest to a runner, of all.

On each piece the places where the distance is least or largest are roots of a polynomial of the ninth degree, ``g(x) =
-q . q'`` with q from the runner to the line. It is looked at in steps; between two of them where it goes from above to
below zero the distance is least, and the root there is found in a bracket. A piece that is too far away is left out.
"""

from __future__ import annotations

from typing import Any

from kanefe.kernels.compiler._numba import kernel
from kanefe.kernels.force_elements.places import END_NUMBERS, P
from kanefe.kernels.links.polynomials import POWERS

STEPS = 32
"""Number of steps in which a piece is looked at: its distance has five least places at most."""

MOST_STEPS = 60
"""Number of steps to a root in its bracket, which halvings alone reach to the last digit in 53."""

SLOPES = 3 * POWERS
"""Index of the coefficients of g, behind those of the line."""

DEGREE = 2 * POWERS - 3
"""Degree of g."""

CLOSE = 1e-15
"""Length of a step to a root, relative to that of the piece, that is round-off."""


@kernel
def nearest_on_pieces(numbers: Any, table: int, points: int, pieces: int, ends: Any, line: Any) -> float:
    """Return the arc length of the nearest point of the line; the first end is the runner, the others its points.

    Parameters
    ----------
    numbers, table : array, int
        Where its table begins: see `kanefe.kernels.force_elements.guide.GuideNumbers`.
    points, pieces : int
        How many there are.
    ends : array
    line : array
        Room for the coefficients of a piece.
    """
    found, least, starts = 0.0, -1.0, table + points
    for i in range(points):  # ends of pieces are among them
        gap = 0.0
        for c in range(3):
            gap += (ends[END_NUMBERS * (i + 1) + P + c].real - ends[P + c].real) ** 2
        if least < 0.0 or gap < least:
            found, least = numbers[table + i], gap
    for piece in range(pieces):
        start = numbers[starts + piece]
        width = numbers[starts + piece + 1] - start
        put_piece(numbers, starts + pieces + 1 + piece * POWERS * points, points, ends, line)
        if is_farther(line, width, least):
            continue
        low, value_low = 0.0, slope_at(line, 0.0)[0]
        for step in range(1, STEPS + 1):
            high = width * step / STEPS
            value = slope_at(line, high)[0]
            if value_low > 0.0 and value <= 0.0:
                x = root_between(line, low, high)
                gap = gap_at(line, x)
                if gap < least:
                    found, least = start + x, gap
            low, value_low = high, value
    return float(found)


@kernel
def put_piece(numbers: Any, weights: int, points: int, ends: Any, line: Any) -> None:
    """Write the coefficients of a piece as seen from the runner, those of x, y and z for each power, and those of g."""
    for power in range(POWERS):
        for c in range(3):
            line[3 * power + c] = 0.0
        for i in range(points):
            b, at = numbers[weights + power * points + i], END_NUMBERS * (i + 1) + P
            for c in range(3):
                line[3 * power + c] += b * (ends[at + c].real - ends[P + c].real)
    for k in range(DEGREE + 1):
        line[SLOPES + k] = 0.0
    for i in range(POWERS):
        for j in range(1, POWERS):
            both = 0.0
            for c in range(3):
                both += line[3 * i + c] * line[3 * j + c]
            line[SLOPES + i + j - 1] -= j * both


@kernel
def is_farther(line: Any, width: float, least: float) -> bool:
    """Return whether all of a piece is farther from the runner than the root of a square."""
    near, reach, scale = 0.0, 0.0, 1.0
    for power in range(POWERS):
        size = 0.0
        for c in range(3):
            size += line[3 * power + c] ** 2
        if power == 0:
            near = size**0.5
        else:
            scale *= width
            reach += scale * size**0.5
    return bool(near > reach and (near - reach) ** 2 > least)


@kernel
def slope_at(line: Any, x: float) -> tuple[float, float]:
    """Return g and its derivative."""
    value, rate = line[SLOPES + DEGREE], 0.0
    for k in range(DEGREE - 1, -1, -1):
        value, rate = value * x + line[SLOPES + k], rate * x + value
    return value, rate


@kernel
def gap_at(line: Any, x: float) -> float:
    """Return the square of the distance from the runner, m2."""
    square = 0.0
    for c in range(3):
        q = line[3 * (POWERS - 1) + c]
        for power in range(POWERS - 2, -1, -1):
            q = q * x + line[3 * power + c]
        square += q * q
    return float(square)


@kernel
def root_between(line: Any, low: float, high: float) -> float:
    """Return where g goes from above to below zero, by Newton's steps; by halving where these leave the bracket."""
    width = high - low
    x = 0.5 * (low + high)
    for _ in range(MOST_STEPS):
        value, rate = slope_at(line, x)
        if value > 0.0:
            low = x
        else:
            high = x
        new = 0.5 * (low + high)
        if rate < 0.0 and low < x - value / rate < high:
            new = x - value / rate
        if abs(new - x) <= CLOSE * width:
            break
        x = new
    return float(x)
