"""Vectors and matrices in compiled code: types of numba, and operators by running those of Python on symbols.

An operator of `kanefe.kernels.values.tensors`, which is plain Python, is run once on symbols of numbers
(`kanefe.kernels.compiler._numba_symbols`), and what it returns is the code: there is no function to be called, and none
to be inlined. What floating point may do is what the kernel says that the code becomes a part of.
"""

from __future__ import annotations

import inspect
import itertools
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

from kanefe.kernels.compiler._numba_lanes import COMPLEX, DOUBLE, LANES, REAL, LanesType, widened
from kanefe.kernels.compiler._numba_symbols import Symbol, Truth, Unknown, scalar_of
from kanefe.kernels.values import numbers, tensors
from kanefe.kernels.values.tensors import KINDS, Value

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


class ValueType(types.Type):  # type: ignore[misc]
    """The type of a kind of values, of real or complex numbers."""

    def __init__(self, kind: type[Value], scalar: Any) -> None:
        self.kind, self.scalar = kind, scalar
        words = {REAL: "", COMPLEX: "complex ", LANES: "lanes of "}
        super().__init__(f"{words[scalar]}{kind.__name__}")

    def can_convert_to(self, context: Any, other: Any) -> Any:
        """Return how well it becomes another type: complex numbers and lanes take real ones."""
        if isinstance(other, ValueType) and other.kind is self.kind and self.scalar == REAL != other.scalar:
            return typeconv.Conversion.promote
        return None

    def unify(self, context: Any, other: Any) -> Any:
        """Return the type of what is one or the other."""
        if not isinstance(other, ValueType) or other.kind is not self.kind:
            return None
        return value_type(self.kind, scalar_of(Unknown(self.scalar), Unknown(other.scalar)))


_TYPES = {(kind, scalar): ValueType(kind, scalar) for kind in KINDS for scalar in (REAL, COMPLEX, LANES)}


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
        return kind.kind(*[Unknown(kind.scalar)] * kind.kind.count)
    return Unknown(kind if kind in (COMPLEX, LANES) else REAL)


def _type_of(found: Any) -> Any:
    if isinstance(found, (Truth, bool)):
        return types.boolean
    if isinstance(found, Value):
        return value_type(type(found), scalar_of(*found))
    return scalar_of(found)


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
    if scalar != COMPLEX:
        return widened(builder, [number.real], scalar == LANES)[0]
    imaginary = number.imaginary if number.is_complex else DOUBLE(0.0)
    made = ir.Constant(ir.LiteralStructType([DOUBLE, DOUBLE]), ir.Undefined)
    return builder.insert_value(builder.insert_value(made, number.real, 0), imaginary, 1)


def _constant_symbol(number: Any) -> Symbol:
    is_complex = isinstance(number, complex)
    return Symbol(None, DOUBLE(float(number.real)), DOUBLE(number.imag) if is_complex else None)


def packed(context: Any, builder: Any, kind: Any, found: Any) -> Any:
    """Return a number, a value, or whether something holds, as llvmlite has it."""
    if isinstance(found, (Truth, bool)):
        return found.value if isinstance(found, Truth) else ir.IntType(1)(found)
    if not isinstance(kind, ValueType):
        return number_value(builder, kind, found)
    made = ir.Constant(context.get_value_type(kind), ir.Undefined)
    for i, number in enumerate(found):
        made = builder.insert_value(made, number_value(builder, kind.scalar, number), i)
    return made


@lower_cast(ValueType, ValueType)
def _cast(context: Any, builder: Any, given: Any, wanted: Any, value: Any) -> Any:
    if given.kind is not wanted.kind or given.scalar not in (REAL, wanted.scalar):
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
            is_value = [isinstance(arg, (ValueType, LanesType)) for arg in args]
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


_OURS = ValueType, LanesType
_PAIRS = (
    *itertools.product(_OURS, _OURS),
    *((one, types.Number) for one in _OURS),
    *((types.Number, one) for one in _OURS),
)
for _key, _does in OPERATORS.items():
    _add_function(_does, _key, False, *_PAIRS)
for _key in (operator.truediv, operator.itruediv):
    _add_function(operator.truediv, _key, False, *_PAIRS)
_add_function(operator.neg, operator.neg, False, *((one,) for one in _OURS))
for _function in (*tensors.FUNCTIONS, *numbers.FUNCTIONS):
    _add_function(_function, _function, True, (types.Any,) * len(inspect.signature(_function).parameters))
for _kind in KINDS:
    _add_function(_kind, _kind, True, (types.Any,) * _kind.count)
