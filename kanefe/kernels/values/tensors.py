"""Vectors and 3 x 3 matrices of real or complex numbers, with operators.

What an operator does is written here, once: for compiled code the same functions are run on symbols, and what they
return is the code (see `kanefe.kernels.compiler._numba_tensors`). They may look at kinds of values, not at numbers.

    >>> cross(Vector(1.0, 0.0, 0.0), Vector(0.0, 1j, 0.0)) + 2.0 * Vector(0.0, 0.0, 1.0)
    Vector(0.0, 0.0, (2+1j))
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterator, Sequence
from typing import Any, ClassVar, Self

Number = Any
"""A real or complex number, or a symbol of one in code that is being compiled."""


class Value:
    """Some numbers that are added, and multiplied by a number, one by one.

    Parameters
    ----------
    *numbers : number
        As many as the kind has; a TypeError says so.
    """

    __slots__ = ("numbers",)
    __array_ufunc__ = None  # a number of numpy times a value is a value
    count: ClassVar[int]
    properties: ClassVar[tuple[str, ...]] = ()

    def __init__(self, *numbers: Number) -> None:
        if len(numbers) != self.count:
            raise TypeError(f"a {type(self).__name__} has {self.count} numbers, not {len(numbers)}")
        self.numbers = numbers

    def __iter__(self) -> Iterator[Number]:
        return iter(self.numbers)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(map(str, self.numbers))})"

    def __add__(self, other: Self) -> Self:
        return self._by_ones(operator.add, other)

    def __sub__(self, other: Self) -> Self:
        return self._by_ones(operator.sub, other)

    def __neg__(self) -> Self:
        return type(self)(*[-a for a in self.numbers])

    def __mul__(self, factor: Number) -> Self:
        if isinstance(factor, Value):
            return NotImplemented
        return type(self)(*[factor * a for a in self.numbers])

    __rmul__ = __mul__

    def _by_ones(self, do: Callable[[Number, Number], Number], other: Self) -> Self:
        if type(other) is not type(self):
            return NotImplemented
        return type(self)(*map(do, self.numbers, other.numbers))


class Vector(Value):
    """x, y, z."""

    __slots__ = ()
    count = 3
    properties = "x", "y", "z"

    @property
    def x(self) -> Number:
        """First component."""
        return self.numbers[0]

    @property
    def y(self) -> Number:
        """Second component."""
        return self.numbers[1]

    @property
    def z(self) -> Number:
        """Third component."""
        return self.numbers[2]


class _Square(Value):
    """A 3 x 3 matrix of some kind."""

    __slots__ = ()

    @property
    def full(self) -> Matrix:
        """All nine numbers."""
        raise NotImplementedError

    def __matmul__(self, other: Any) -> Any:
        if isinstance(other, Skew):
            return Matrix(*[n for row in _rows(self.full) for n in _crossed(row, other.numbers)])
        if isinstance(other, Vector):
            return Vector(*[_sum_of_products(row, other.numbers) for row in _rows(self.full)])
        if not isinstance(other, _Square):
            return NotImplemented
        columns = _rows(other.full.T)
        return Matrix(*[_sum_of_products(row, column) for row in _rows(self.full) for column in columns])


class Matrix(_Square):
    """A 3 x 3 matrix: nine numbers, row by row."""

    __slots__ = ()
    count = 9
    properties = "x", "y", "z", "T", "full"

    @property
    def x(self) -> Vector:
        """First column."""
        return Vector(*self.numbers[0::3])

    @property
    def y(self) -> Vector:
        """Second column."""
        return Vector(*self.numbers[1::3])

    @property
    def z(self) -> Vector:
        """Third column."""
        return Vector(*self.numbers[2::3])

    @property
    def T(self) -> Matrix:
        """The transposed matrix."""
        return Matrix(*[self.numbers[3 * j + i] for i in range(3) for j in range(3)])

    @property
    def full(self) -> Matrix:
        """The matrix itself."""
        return self


class Symmetric(_Square):
    """A symmetric 3 x 3 matrix: xx, xy, xz, yy, yz, zz."""

    __slots__ = ()
    count = 6
    properties = "full", "trace", "inverse"

    @property
    def full(self) -> Matrix:
        """All nine numbers."""
        xx, xy, xz, yy, yz, zz = self.numbers
        return Matrix(xx, xy, xz, xy, yy, yz, xz, yz, zz)

    @property
    def trace(self) -> Number:
        """Sum of the diagonal."""
        xx, _, _, yy, _, zz = self.numbers
        return xx + yy + zz

    @property
    def inverse(self) -> Symmetric:
        """The inverse, by cofactors; infinite where the matrix is singular."""
        xx, xy, xz, yy, yz, zz = self.numbers
        x, y, z = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
        over = 1.0 / (xx * x + xy * y + xz * z)
        return Symmetric(
            over * x, over * y, over * z,
            over * (xx * zz - xz * xz), over * (xy * xz - xx * yz), over * (xx * yy - xy * xy),
        )  # fmt: skip


class Skew(_Square):
    """The matrix of a cross product, ``skew(a) @ b = a x b``: the three numbers of a."""

    __slots__ = ()
    count = 3
    properties = ("full",)

    @property
    def full(self) -> Matrix:
        """All nine numbers."""
        x, y, z = self.numbers
        zero = 0.0 * x
        return Matrix(zero, -z, y, z, zero, -x, -y, x, zero)

    def __matmul__(self, other: Any) -> Any:
        if isinstance(other, Vector):
            return Vector(*_crossed(self.numbers, other.numbers))
        if not isinstance(other, _Square):
            return NotImplemented
        return Matrix(*[n for column in _rows(other.full.T) for n in _crossed(self.numbers, column)]).T


KINDS: tuple[type[Value], ...] = (Vector, Matrix, Symmetric, Skew)
"""All kinds of values."""


def _rows(A: Matrix) -> list[Sequence[Number]]:
    return [A.numbers[i : i + 3] for i in (0, 3, 6)]


def _sum_of_products(a: Sequence[Number], b: Sequence[Number]) -> Number:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _crossed(a: Sequence[Number], b: Sequence[Number]) -> tuple[Number, Number, Number]:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _wanted(kind: type[Value], *values: Any) -> None:
    for value in values:
        if not isinstance(value, kind):
            raise TypeError(f"a {kind.__name__} is wanted, not a {type(value).__name__}")


def dot(a: Vector, b: Vector) -> Number:
    """Return a . b, without conjugation of complex numbers."""
    _wanted(Vector, a, b)
    return _sum_of_products(a.numbers, b.numbers)


def cross(a: Vector, b: Vector) -> Vector:
    """Return a x b."""
    _wanted(Vector, a, b)
    return Vector(*_crossed(a.numbers, b.numbers))


def skew(a: Vector) -> Skew:
    """Return the matrix of ``a x``."""
    _wanted(Vector, a)
    return Skew(*a.numbers)


def contract(A: Symmetric, B: Symmetric) -> Number:
    """Return A : B, the sum of the products of all entries."""
    _wanted(Symmetric, A, B)
    a, b = A.numbers, B.numbers
    return a[0] * b[0] + a[3] * b[3] + a[5] * b[5] + 2.0 * (a[1] * b[1] + a[2] * b[2] + a[4] * b[4])


def outer(a: Vector, b: Vector) -> Matrix:
    """Return a b^T."""
    _wanted(Vector, a, b)
    return Matrix(*[x * y for x in a.numbers for y in b.numbers])


def square(a: Vector, b: Vector) -> Symmetric:
    """Return a b^T where b is a multiple of a."""
    return symmetric(outer(a, b))


def symmetric(A: Matrix) -> Symmetric:
    """Return a matrix of which it is known that it is symmetric, by what is on its diagonal and above."""
    _wanted(Matrix, A)
    xx, xy, xz, _, yy, yz, _, _, zz = A.numbers
    return Symmetric(xx, xy, xz, yy, yz, zz)


def congruent(R: Matrix, S: Symmetric) -> Symmetric:
    """Return R S R^T."""
    _wanted(Symmetric, S)
    return symmetric(R @ S @ R.T)


def diagonal(number: Number) -> Symmetric:
    """Return a number times the identity."""
    zero = 0.0 * number
    return Symmetric(number, zero, zero, number, zero, number)


def turned_about_z(R: Matrix, cosine: Number, sine: Number) -> Matrix:
    """Return R Rz, the axes turned about their z by an angle."""
    _wanted(Matrix, R)
    x, y, z = R.x, R.y, R.z
    return Matrix(*(cosine * x + sine * y).numbers, *(cosine * y - sine * x).numbers, *z.numbers).T


def rotation(e0: Number, e1: Number, e2: Number, e3: Number) -> Matrix:
    """Return the rotation matrix of Euler parameters, which are normalised first (Eq. 6)."""
    s = 2.0 / (e0 * e0 + e1 * e1 + e2 * e2 + e3 * e3)
    return Matrix(
        1.0 - s * (e2 * e2 + e3 * e3), s * (e1 * e2 - e0 * e3), s * (e1 * e3 + e0 * e2),
        s * (e1 * e2 + e0 * e3), 1.0 - s * (e1 * e1 + e3 * e3), s * (e2 * e3 - e0 * e1),
        s * (e1 * e3 - e0 * e2), s * (e2 * e3 + e0 * e1), 1.0 - s * (e1 * e1 + e2 * e2),
    )  # fmt: skip


FUNCTIONS: tuple[Callable[..., Any], ...] = (
    dot, cross, skew, contract, outer, square, symmetric, congruent, diagonal, turned_about_z, rotation,
)  # fmt: skip
"""All functions that compiled code may call."""

IDENTITY = Matrix(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
ZERO = Vector(0.0, 0.0, 0.0)
NO_MATRIX = Matrix(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
NO_INERTIA = Symmetric(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
