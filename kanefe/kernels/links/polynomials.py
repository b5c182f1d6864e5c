"""Piecewise polynomials among the numbers of a link: which piece, and its values and derivatives."""

from typing import Any

from kanefe.kernels.language import Vector, inlined

POWERS = 6


@inlined
def piece_at(numbers: Any, starts: int, count: int, at: Any) -> int:
    """Return the piece in which a real number lies; the first or last one beyond them."""
    low, high = 0, count
    while high - low > 1:
        middle = (low + high) // 2
        if numbers[starts + middle] <= at:
            low = middle
        else:
            high = middle
    return low


@inlined
def polynomial(numbers: Any, at: int, x: Any) -> tuple[Any, Any, Any, Any]:
    """Return a polynomial and its first three derivatives; `at` is where its coefficients begin, of powers 0 to 5."""
    f = numbers[at + POWERS - 1] + 0.0 * x
    d = dd = ddd = 0.0 * x
    for k in range(POWERS - 2, -1, -1):
        ddd, dd, d, f = ddd * x + dd, dd * x + d, d * x + f, f * x + numbers[at + k]
    return f, d, 2.0 * dd, 6.0 * ddd


@inlined
def vector_polynomial(numbers: Any, at: int, x: Any) -> tuple[Vector, Vector, Vector, Vector]:
    """Return a vector of three polynomials, one behind the other, and its first three derivatives."""
    a, b, c = polynomial(numbers, at, x), polynomial(numbers, at + POWERS, x), polynomial(numbers, at + 2 * POWERS, x)
    return Vector(a[0], b[0], c[0]), Vector(a[1], b[1], c[1]), Vector(a[2], b[2], c[2]), Vector(a[3], b[3], c[3])
