"""Symbols of numbers, on which the operators and functions of values are run for their code and their types.

A symbol of a number writes an instruction where it is added or multiplied. For types alone the same functions are run
on numbers of which only the kind is known.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from llvmlite import ir

from kanefe.kernels.compiler._numba_calls import quotient
from kanefe.kernels.compiler._numba_lanes import COMPLEX, DOUBLE, LANES, REAL, floor_of, in_all, widened
from kanefe.kernels.values.tensors import Value


class Symbol:
    """A number in code that is written.

    Parameters
    ----------
    builder : of llvmlite
    real : value of llvmlite
    imaginary : value of llvmlite, optional
        Of a complex number.
    """

    def __init__(self, builder: Any, real: Any, imaginary: Any = None) -> None:
        self.builder, self.real, self.imaginary = builder, real, imaginary

    @property
    def is_complex(self) -> bool:
        """Whether it is of the complex type."""
        return self.imaginary is not None

    @property
    def scalar(self) -> Any:
        """Its type."""
        return LANES if isinstance(self.real.type, ir.VectorType) else COMPLEX if self.is_complex else REAL

    def _symbol(self, number: Any) -> Symbol:
        return number if isinstance(number, Symbol) else Symbol(self.builder, DOUBLE(float(number)))

    def _made(self, real: Any, imaginary: Any = None) -> Symbol:
        return Symbol(self.builder, real, imaginary)

    def _done(self, do: Callable[..., Any], *numbers: Any) -> Any:
        """Return what an instruction makes of real parts, of lanes where one of them is."""
        return do(*widened(self.builder, [self._symbol(number).real for number in numbers]))

    def __add__(self, other: Any) -> Symbol:
        if isinstance(other, Value):
            return NotImplemented
        other, add = self._symbol(other), self.builder.fadd
        real = self._done(add, self, other)
        if self.is_complex and other.is_complex:
            return self._made(real, add(self.imaginary, other.imaginary))
        return self._made(real, self.imaginary if self.is_complex else other.imaginary)

    def __sub__(self, other: Any) -> Symbol:
        if isinstance(other, Value):
            return NotImplemented
        other, subtract = self._symbol(other), self.builder.fsub
        real = self._done(subtract, self, other)
        if self.is_complex and other.is_complex:
            return self._made(real, subtract(self.imaginary, other.imaginary))
        return self._made(real, self.builder.fneg(other.imaginary) if other.is_complex else self.imaginary)

    def __mul__(self, other: Any) -> Symbol:
        if isinstance(other, Value):
            return NotImplemented
        other, times = self._symbol(other), self.builder.fmul
        a, b, c, d = self.real, self.imaginary, other.real, other.imaginary
        if self.is_complex and other.is_complex:
            real = self.builder.fsub(times(a, c), times(b, d))
            return self._made(real, self.builder.fadd(times(a, d), times(b, c)))
        if self.is_complex:
            return self._made(times(a, c), times(b, c))
        return self._made(self._done(times, self, other), times(a, d) if other.is_complex else None)

    def __truediv__(self, other: Any) -> Symbol:
        if isinstance(other, Value):
            return NotImplemented
        other, divide = self._symbol(other), self.builder.fdiv
        if other.is_complex:
            imaginary = self.imaginary if self.is_complex else DOUBLE(0.0)
            return self._made(*quotient(self.builder, self.real, imaginary, other.real, other.imaginary))
        imaginary = divide(self.imaginary, other.real) if self.is_complex else None
        return self._made(self._done(divide, self, other), imaginary)

    def __neg__(self) -> Symbol:
        negative = self.builder.fneg
        return self._made(negative(self.real), negative(self.imaginary) if self.is_complex else None)

    def __radd__(self, other: Any) -> Symbol:
        return self._symbol(other) + self

    def __rsub__(self, other: Any) -> Symbol:
        return self._symbol(other) - self

    def __rmul__(self, other: Any) -> Symbol:
        return self._symbol(other) * self

    def __rtruediv__(self, other: Any) -> Symbol:
        return self._symbol(other) / self

    def parts(self) -> tuple[Symbol, Symbol | None]:
        """Return the real and the imaginary part."""
        return self._made(self.real), self._made(self.imaginary) if self.is_complex else None

    def joined(self, imaginary: Symbol) -> Symbol:
        """Return the complex number of two parts."""
        return self._made(self.real, imaginary.real)

    def floor(self) -> Symbol:
        """Return the whole number below."""
        return self._made(floor_of(self.builder, self.real))

    def is_above(self, a: Any, b: Any) -> Truth:
        """Return whether a is above b, in all lanes."""
        return Truth(in_all(self.builder, self._done(partial(self.builder.fcmp_ordered, ">"), a, b)))

    def is_there(self) -> Truth:
        """Return whether it is not zero, in one lane."""
        no = in_all(self.builder, self._done(partial(self.builder.fcmp_ordered, "=="), self, 0.0))
        return Truth(self.builder.not_(no))

    def chosen(self, a: Any, b: Any, if_above: Any, otherwise: Any) -> Symbol:
        """Return one of two numbers of one kind: the first where a is above b."""
        first, second = self._symbol(if_above), self._symbol(otherwise)
        condition = self._done(partial(self.builder.fcmp_ordered, ">"), a, b)
        real = self._done(partial(self.builder.select, condition), first, second)
        if not first.is_complex:
            return self._made(real)
        return self._made(real, self.builder.select(condition, first.imaginary, second.imaginary))


class Truth:
    """Whether something holds, in code that is written; without a value where only types are wanted."""

    def __init__(self, value: Any = None) -> None:
        self.value = value


class Unknown:
    """A number of which only the kind is known."""

    def __init__(self, scalar: Any) -> None:
        self.scalar = scalar

    def _with(self, *others: Any) -> Any:
        if any(isinstance(other, Value) for other in others):
            return NotImplemented
        return Unknown(scalar_of(self, *others))

    __add__ = __sub__ = __mul__ = __truediv__ = __neg__ = _with
    __radd__ = __rsub__ = __rmul__ = __rtruediv__ = _with
    floor = chosen = _with

    def parts(self) -> tuple[Unknown, Unknown | None]:
        """Return the real and the imaginary part."""
        return (Unknown(REAL), Unknown(REAL)) if self.scalar == COMPLEX else (self, None)

    def joined(self, imaginary: Unknown) -> Unknown:
        """Return the complex number of two parts."""
        return Unknown(COMPLEX)

    def is_above(self, *others: Any) -> Truth:
        """Return whether a number is above another."""
        return Truth()

    is_there = is_above


def scalar_of(*numbers: Any) -> Any:
    """Return the type of what is made of some numbers: lanes, complex or real ones.

    Raises
    ------
    TypeError
        If there are complex numbers beside lanes, which have none.
    """
    found = {one.scalar if isinstance(one, (Symbol, Unknown)) else _kind_of(one) for one in numbers}
    if {LANES, COMPLEX} <= found:
        raise TypeError("lanes are of real numbers")
    return next((kind for kind in (LANES, COMPLEX) if kind in found), REAL)


def _kind_of(number: Any) -> Any:
    return COMPLEX if isinstance(number, complex) else REAL
