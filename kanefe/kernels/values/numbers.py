"""Functions of single numbers that do not branch: of real or complex ones, of symbols of these, and of lanes.

A lane is one of several numbers that compiled code calculates with at once, as if they were one: see `lanes_of`. All
that is here gives each lane to the last bit what a real number by itself gets.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

Number = Any
"""A real or complex number, lanes, or a symbol of one in code that is being compiled."""

# pi / 2 in three parts, so that the multiple of it that is taken off loses nothing
QUARTER, QUARTER_REST, QUARTER_LAST = 1.5707963267341256, 6.077100506303966e-11, 2.0222662487959506e-21

BEYOND = 0.79
"""Angle that is never left beyond a whole number of quarters, rad: just above pi / 4."""


def cosine(angle: Number) -> Number:
    """Return the cosine: right to 4e-16 up to 1e6 rad, to the last bit of the angle beyond.

    Of a complex angle the imaginary part is taken for a small change, as a complex step has it.
    """
    x, change = _parts(angle)
    of_cosine, of_sine = _turned(x)
    return of_cosine if change is None else _joined(of_cosine, -(of_sine * change))


def sine(angle: Number) -> Number:
    """Return the sine: see `cosine`."""
    x, change = _parts(angle)
    of_cosine, of_sine = _turned(x)
    return of_sine if change is None else _joined(of_sine, of_cosine * change)


def _turned(angle: Number) -> tuple[Number, Number]:
    """Return cosine and sine of a real angle.

    What remains of it within 45 degrees goes into the polynomials of best approximation that the C libraries of old
    Unix systems use (fdlibm); which of the two is cosine and which sine, and their signs, follows from the quarter.
    """
    quarters = _floor(angle * (2.0 / math.pi) + 0.5)
    x = ((angle - quarters * QUARTER) - quarters * QUARTER_REST) - quarters * QUARTER_LAST
    x = _chosen(x, BEYOND, BEYOND, _chosen(-BEYOND, x, -BEYOND, x))  # of huge angles no digit is behind the point
    x = _chosen(angle * angle, 1e60, math.nan, x)  # such a motion has grown without bound
    z = x * x
    sine = 2.75573137070700676789e-06 + z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)
    sine = 8.33333333332248946124e-03 + z * (-1.98412698298579493134e-04 + z * sine)
    sine = x + x * z * (-1.66666666666666324348e-01 + z * sine)
    cosine = -2.75573143513906633035e-07 + z * (2.08757232129817482790e-09 - z * 1.13596475577881948265e-11)
    cosine = -1.38888888888741095749e-03 + z * (2.48015872894767294178e-05 + z * cosine)
    cosine = 1.0 - 0.5 * z + z * z * (4.16666666666666019037e-02 + z * cosine)
    halves = _floor(0.5 * quarters)
    is_odd, sign = quarters - 2.0 * halves, 1.0 - 2.0 * (halves - 2.0 * _floor(0.5 * halves))
    turned, across = sign - sign * is_odd, sign * is_odd  # cosine and sine of the quarters: 1, 0 or -1
    return turned * cosine - across * sine, turned * sine + across * cosine


def is_above(a: Number, b: Number) -> Any:
    """Return whether the real part of a is above that of b, of lanes: in all of them; not if one is no number."""
    (x, _), (y, _) = _parts(a), _parts(b)
    symbol = _symbol_of(x, y)
    return bool(x > y) if symbol is None else symbol.is_above(x, y)


def is_there(a: Number) -> Any:
    """Return whether the real part of a number is not zero, of lanes: in one of them."""
    x, _ = _parts(a)
    return x.is_there() if hasattr(x, "is_there") else bool(x != 0.0)


def is_complex(a: Number) -> bool:
    """Return whether a number is of the complex kind."""
    return _parts(a)[1] is not None


def excess(x: Number, lower: Number, upper: Number) -> Number:
    """Return how far a number is beyond the limits of an interval: below zero at the lower one, zero within."""
    return _chosen(x, upper, x - upper, _chosen(lower, x, x - lower, 0.0 * x))


def held_brake(stop: Number, brake: Number, beyond: Number) -> Number:
    """Return what a brake gives beside a stop, which together never pull; nothing where the stop is not met."""
    held = _chosen((stop + brake) * beyond, 0.0, -stop, brake)
    return _chosen(beyond, 0.0, held, _chosen(0.0, beyond, held, 0.0 * brake))


FUNCTIONS: tuple[Callable[..., Any], ...] = (
    cosine, sine, is_above, is_there, is_complex, excess, held_brake,
)  # fmt: skip
"""All functions that compiled code may call."""


def lanes_of(numbers: np.ndarray) -> np.ndarray:
    """Return an array of real numbers, with an axis more for the lanes, as an array of lanes.

    In compiled code there are `lane_count` of them along that axis; in Python it is the first alone.
    """
    return numbers[..., 0]


def lane_count() -> int:
    """Return how many lanes compiled code has: as many as fill a vector register; in Python there is one."""
    return 1


def _floor(x: Number) -> Number:
    return x.floor() if hasattr(x, "floor") else np.floor(x)


def _chosen(a: Number, b: Number, if_above: Number, otherwise: Number) -> Number:
    """Return one of two numbers: the first where the real part of a is above that of b."""
    (x, _), (y, _) = _parts(a), _parts(b)
    symbol = _symbol_of(x, y)
    if symbol is None:
        return if_above if x > y else otherwise
    return symbol.chosen(x, y, if_above, otherwise)


def _symbol_of(*numbers: Number) -> Any:
    """Return one of some numbers that is a symbol, or None."""
    return next((one for one in numbers if hasattr(one, "chosen")), None)


def _parts(number: Number) -> tuple[Number, Number | None]:
    """Return the real part, and the imaginary one of a complex number."""
    if hasattr(number, "parts"):
        return number.parts()  # type: ignore[no-any-return]
    return (number.real, number.imag) if isinstance(number, complex) else (number, None)


def _joined(real: Number, imaginary: Number) -> Number:
    return real.joined(imaginary) if hasattr(real, "joined") else complex(real, imaginary)
