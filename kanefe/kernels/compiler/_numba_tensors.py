"""Vectors and matrices in compiled code: types of numba, and operators by running those of Python on symbols.

A symbol of a number writes an instruction where it is added or multiplied. An operator of
`kanefe.kernels.values.tensors`, which is plain Python, is run once on such symbols, and what it returns is the code:
there is no function to be called, and none to be inlined. What floating point may do is what the kernel says that the
code becomes a part of. For types alone the same functions are run on numbers of which only the kind is known.
"""

from __future__ import annotations

import inspect
import operator
from collections.abc import Callable, Sequence
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import typeconv
from numba.core.datamodel import models, register_default
from numba.core.errors import TypingError
from numba.core.imputils import lower_builtin, lower_cast, lower_constant, lower_getattr_generic
from numba.core.typing.templates import AbstractTemplate, AttributeTemplate, infer_getattr, infer_global, signature
from numba.extending import typeof_impl

from kanefe.kernels.compiler._numba_calls import quotient
from kanefe.kernels.values.tensors import FUNCTIONS, KINDS, Value

REAL, COMPLEX = types.float64, types.complex128
DOUBLE = ir.DoubleType()

OPERATORS = {
    operator.add: operator.add,
    operator.sub: operator.sub,
    operator.mul: operator.mul,
    operator.matmul: operator.matmul,
    operator.iadd: operator.add,
    operator.isub: operator.sub,
    operator.imul: operator.mul,
}
"""Operators of two operands, and those of Python that say what they do."""

SIGNS = {
    operator.add: "+",
    operator.sub: "-",
    operator.mul: "*",
    operator.matmul: "@",
    operator.iadd: "+=",
    operator.isub: "-=",
    operator.imul: "*=",
}


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

    def _symbol(self, number: Any) -> Symbol:
        return number if isinstance(number, Symbol) else Symbol(self.builder, DOUBLE(float(number)))

    def _made(self, real: Any, imaginary: Any = None) -> Symbol:
        return Symbol(self.builder, real, imaginary)

    def __add__(self, other: Any) -> Symbol:
        if isinstance(other, Value):
            return NotImplemented
        other, add = self._symbol(other), self.builder.fadd
        real = add(self.real, other.real)
        if self.is_complex and other.is_complex:
            return self._made(real, add(self.imaginary, other.imaginary))
        return self._made(real, self.imaginary if self.is_complex else other.imaginary)

    def __sub__(self, other: Any) -> Symbol:
        if isinstance(other, Value):
            return NotImplemented
        other, subtract = self._symbol(other), self.builder.fsub
        real = subtract(self.real, other.real)
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
        return self._made(times(a, c), times(a, d) if other.is_complex else None)

    def __truediv__(self, other: Any) -> Symbol:
        if isinstance(other, Value):
            return NotImplemented
        other, divide = self._symbol(other), self.builder.fdiv
        if other.is_complex:
            imaginary = self.imaginary if self.is_complex else DOUBLE(0.0)
            return self._made(*quotient(self.builder, self.real, imaginary, other.real, other.imaginary))
        imaginary = divide(self.imaginary, other.real) if self.is_complex else None
        return self._made(divide(self.real, other.real), imaginary)

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


class Unknown:
    """A number of which only the kind is known."""

    def __init__(self, is_complex: bool) -> None:
        self.is_complex = is_complex

    def _with(self, *others: Any) -> Any:
        if any(isinstance(other, Value) for other in others):
            return NotImplemented
        return Unknown(self.is_complex or any(map(_is_complex, others)))

    __add__ = __sub__ = __mul__ = __truediv__ = __neg__ = _with
    __radd__ = __rsub__ = __rmul__ = __rtruediv__ = _with


def _is_complex(number: Any) -> bool:
    return number.is_complex if isinstance(number, (Symbol, Unknown)) else isinstance(number, complex)


class ValueType(types.Type):  # type: ignore[misc]
    """The type of a kind of values, of real or complex numbers."""

    def __init__(self, kind: type[Value], scalar: Any) -> None:
        self.kind, self.scalar = kind, scalar
        super().__init__(kind.__name__ if scalar == REAL else f"complex {kind.__name__}")

    def can_convert_to(self, context: Any, other: Any) -> Any:
        """Return how well it becomes another type: complex numbers take real ones."""
        if isinstance(other, ValueType) and (other.kind, self.scalar, other.scalar) == (self.kind, REAL, COMPLEX):
            return typeconv.Conversion.promote
        return None

    def unify(self, context: Any, other: Any) -> Any:
        """Return the type of what is one or the other."""
        return value_type(self.kind, COMPLEX) if isinstance(other, ValueType) and other.kind is self.kind else None


_TYPES = {(kind, scalar): ValueType(kind, scalar) for kind in KINDS for scalar in (REAL, COMPLEX)}


def value_type(kind: Any, scalar: Any) -> ValueType:
    """Return the type of values."""
    return _TYPES[kind, scalar]


@register_default(ValueType)
class _ValueModel(models.StructModel):  # type: ignore[misc]
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, [(f"n{i}", kind.scalar) for i in range(kind.kind.count)])


def _unknown(kind: Any) -> Any:
    """Return what stands for an argument where only types are wanted."""
    if isinstance(kind, ValueType):
        return kind.kind(*[Unknown(kind.scalar == COMPLEX)] * kind.kind.count)
    return Unknown(isinstance(kind, types.Complex))


def _type_of(found: Any) -> Any:
    if isinstance(found, Value):
        return value_type(type(found), COMPLEX if any(map(_is_complex, found)) else REAL)
    return COMPLEX if _is_complex(found) else REAL


def number_symbol(builder: Any, kind: Any, value: Any) -> Symbol:
    """Return the symbol of a number."""
    if isinstance(kind, types.Complex):
        return Symbol(builder, builder.extract_value(value, 0), builder.extract_value(value, 1))
    return Symbol(builder, builder.sitofp(value, DOUBLE) if isinstance(kind, types.Integer) else value)


def symbol(builder: Any, kind: Any, value: Any) -> Any:
    """Return the symbol of a number, or a value of symbols."""
    if not isinstance(kind, ValueType):
        return number_symbol(builder, kind, value)
    numbers = [builder.extract_value(value, i) for i in range(kind.kind.count)]
    return kind.kind(*[number_symbol(builder, kind.scalar, number) for number in numbers])


def number_value(builder: Any, scalar: Any, number: Any) -> Any:
    """Return a number as llvmlite has it."""
    number = number if isinstance(number, Symbol) else _constant_symbol(number)
    if scalar == REAL:
        return number.real
    imaginary = number.imaginary if number.is_complex else DOUBLE(0.0)
    made = ir.Constant(ir.LiteralStructType([DOUBLE, DOUBLE]), ir.Undefined)
    return builder.insert_value(builder.insert_value(made, number.real, 0), imaginary, 1)


def _constant_symbol(number: Any) -> Symbol:
    is_complex = isinstance(number, complex)
    return Symbol(None, DOUBLE(float(number.real)), DOUBLE(number.imag) if is_complex else None)


def packed(context: Any, builder: Any, kind: Any, found: Any) -> Any:
    """Return a number, or a value, as llvmlite has it."""
    if not isinstance(kind, ValueType):
        return number_value(builder, kind, found)
    made = ir.Constant(context.get_value_type(kind), ir.Undefined)
    for i, number in enumerate(found):
        made = builder.insert_value(made, number_value(builder, kind.scalar, number), i)
    return made


@lower_cast(ValueType, ValueType)
def _cast(context: Any, builder: Any, given: Any, wanted: Any, value: Any) -> Any:
    if given.kind is not wanted.kind or (given.scalar, wanted.scalar) == (COMPLEX, REAL):
        raise TypingError(f"a {wanted} is wanted, not a {given}")
    return packed(context, builder, wanted, symbol(builder, given, value))


@typeof_impl.register(Value)
def _typeof(value: Value, context: Any) -> ValueType:
    return _type_of(value)  # type: ignore[no-any-return]


@lower_constant(ValueType)
def _constant(context: Any, builder: Any, kind: Any, value: Value) -> Any:
    return packed(context, builder, kind, value)


def _add_function(function: Callable[..., Any], key: Any, takes_numbers: bool, *shapes: Sequence[Any]) -> None:
    """Have numba take a function of values: its types and its code by running it.

    Parameters
    ----------
    function : function
    key : object
        What a kernel calls.
    takes_numbers : bool
        Whether it is this function also where no argument is a value.
    *shapes : sequence
        Types of the arguments, as numba's choice of code wants them.
    """

    class Template(AbstractTemplate):  # type: ignore[misc]
        def generic(self, args: Any, kws: Any) -> Any:
            """Return the signature for types of arguments."""
            is_value = [isinstance(arg, ValueType) for arg in args]
            others = all(value or isinstance(arg, types.Number) for value, arg in zip(is_value, args, strict=True))
            if kws or not others or not (takes_numbers or any(is_value)):
                return None
            try:
                return signature(_type_of(function(*map(_unknown, args))), *args)
            except TypeError as error:
                sign = SIGNS.get(key)
                told = f" {sign} ".join(map(str, args)) if sign else f"{key.__name__}({', '.join(map(str, args))})"
                raise TypingError(f"there is no {told}: {error}") from None

    def build(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        given = [symbol(builder, kind, value) for kind, value in zip(signature.args, arguments, strict=True)]
        return packed(context, builder, signature.return_type, function(*given))

    Template.key = key
    infer_global(key)(Template)
    for shape in shapes:
        lower_builtin(key, *shape)(build)


@infer_getattr
class _Properties(AttributeTemplate):  # type: ignore[misc]
    key = ValueType

    def generic_resolve(self, kind: Any, name: str) -> Any:
        """Return the type of a property."""
        if name not in kind.kind.properties:
            told = ", ".join(kind.kind.properties)
            raise TypingError(f"a {kind.kind.__name__} has no {name!r}; it has {told}")
        return _type_of(getattr(_unknown(kind), name))


@lower_getattr_generic(ValueType)
def _property(context: Any, builder: Any, kind: Any, value: Any, name: str) -> Any:
    found = getattr(symbol(builder, kind, value), name)
    return packed(context, builder, _type_of(found), found)


for _key, _does in OPERATORS.items():
    _pairs = (ValueType, ValueType), (ValueType, types.Number), (types.Number, ValueType)
    _add_function(_does, _key, False, *_pairs)
_add_function(operator.neg, operator.neg, False, (ValueType,))
for _function in FUNCTIONS:
    _add_function(_function, _function, True, (types.Any,) * len(inspect.signature(_function).parameters))
for _kind in KINDS:
    _add_function(_kind, _kind, True, (types.Any,) * _kind.count)
