"""Records in compiled code: the addresses of their arrays, and fields as numbers at known distances from these.

A record costs nothing: it is one address for each array that it has fields in, and where a field is follows while code
is written, as it does in Python, by the functions of `kanefe.kernels.values.records`.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.datamodel import models, register_default
from numba.core.errors import TypingError
from numba.core.imputils import lower_getattr_generic, lower_setattr_generic
from numba.core.typing.templates import AttributeTemplate, infer_getattr

from kanefe.kernels.compiler._numba_lanes import COMPLEX, IN_MEMORY
from kanefe.kernels.compiler._numba_symbols import Symbol
from kanefe.kernels.compiler._numba_tensors import (
    number_symbol,
    number_value,
    packed,
    symbol,
    value_type,
)
from kanefe.kernels.values.parts import INTEGERS, NUMBERS
from kanefe.kernels.values.records import Array, Behind, Columns, Field, Many, One, Record, Table, lacks
from kanefe.kernels.values.tensors import KINDS, Value

INTEGER, PART = ir.IntType(64), ir.IntType(32)

Scalars = tuple[Any, ...]
"""Types of the numbers of each array that a record has fields in."""


class RecordType(types.Type):  # type: ignore[misc]
    """The type of a record on arrays of some numbers."""

    words = ""

    def __init__(self, record: type[Record], scalars: Scalars) -> None:
        self.record, self.scalars = record, scalars
        super().__init__(f"{self.words}{record.__qualname__} of {', '.join(map(str, scalars))}")

    @property
    def key(self) -> Any:
        """What it differs from others by."""
        return self.record, self.scalars

    def scalar(self, memory: str) -> Any:
        """Return the type of the numbers of one of the arrays."""
        return self.scalars[self.record.memories.index(memory)]


class RowsType(RecordType):
    """The type of all records of a kind in arrays of some numbers."""

    words = "rows of "

    def __init__(self, record: type[Record], scalars: Scalars) -> None:
        super().__init__(record, scalars)
        self.row = RecordType(record, scalars)

    @property
    def in_rows(self) -> tuple[str, ...]:
        """Names of the arrays that have a row for each record."""
        return tuple(name for name in self.record.memories if name in (INTEGERS, NUMBERS))


class ManyType(types.Type):  # type: ignore[misc]
    """The type of values of a kind in an array."""

    def __init__(self, kind: type[Value], scalar: Any) -> None:
        self.kind, self.scalar, self.value = kind, scalar, value_type(kind, scalar)
        super().__init__(f"many {self.value}")


def _addresses(kind: RecordType) -> list[tuple[str, Any]]:
    return [(name, types.CPointer(scalar)) for name, scalar in zip(kind.record.memories, kind.scalars, strict=True)]


@register_default(RecordType)
class _RecordModel(models.StructModel):  # type: ignore[misc]
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _addresses(kind))


@register_default(RowsType)
class _RowsModel(models.StructModel):  # type: ignore[misc]
    def __init__(self, manager: Any, kind: Any) -> None:
        widths = [(f"width of {name}", types.int64) for name in kind.in_rows]
        super().__init__(manager, kind, [*_addresses(kind), ("count", types.int64), *widths])


@register_default(ManyType)
class _ManyModel(models.StructModel):  # type: ignore[misc]
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, [("data", types.CPointer(kind.scalar)), ("count", types.int64)])


class Whole:
    """A whole number in code that is written."""

    def __init__(self, builder: Any, value: Any) -> None:
        self.builder, self.value = builder, value

    def _value(self, other: Any) -> Any:
        return other.value if isinstance(other, Whole) else INTEGER(other)

    def __add__(self, other: Any) -> Whole:
        return Whole(self.builder, self.builder.add(self.value, self._value(other)))

    def __mul__(self, other: Any) -> Whole:
        return Whole(self.builder, self.builder.mul(self.value, self._value(other)))

    __radd__, __rmul__ = __add__, __mul__


class Seen:
    """A record in code that is written: where its arrays are, and its whole numbers."""

    def __init__(self, builder: Any, kind: RecordType, value: Any) -> None:
        self.builder, self.kind, self.value = builder, kind, value

    def address(self, memory: str, at: Any = 0) -> Any:
        """Return the address of a number of one of its arrays."""
        start = self.builder.extract_value(self.value, self.kind.record.memories.index(memory))
        return behind(self.builder, start, at)

    def whole(self, name: str) -> Whole:
        """Return one of its whole numbers."""
        address, record = self.address(INTEGERS, self.kind.record.fields[name].integer_at), self.kind.record
        return Whole(self.builder, load(self.builder, address, record.is_frozen))


def load(builder: Any, address: Any, is_frozen: bool) -> Any:
    """Return what is at an address; frozen: nobody writes there while a kernel runs, so that once is enough."""
    found = builder.load(address)
    if is_frozen:
        found.set_metadata("invariant.load", builder.module.add_metadata([]))
    return found


def behind(builder: Any, address: Any, at: Any) -> Any:
    """Return the address of a number some numbers behind another."""
    return builder.gep(address, [INTEGER(at) if isinstance(at, int) else at], inbounds=True)


def load_number(builder: Any, scalar: Any, address: Any) -> Symbol:
    """Return the number at an address."""
    if scalar != COMPLEX:
        return number_symbol(builder, scalar, builder.load(address, align=IN_MEMORY))
    parts = [builder.gep(address, [PART(0), PART(i)], inbounds=True) for i in range(2)]
    return Symbol(builder, *map(builder.load, parts))


def store_number(builder: Any, scalar: Any, address: Any, number: Symbol) -> None:
    """Write a number to an address."""
    if scalar != COMPLEX:
        builder.store(number_value(builder, scalar, number), address, align=IN_MEMORY)
        return
    imaginary = number.imaginary if number.is_complex else ir.DoubleType()(0.0)
    for i, part in enumerate((number.real, imaginary)):
        builder.store(part, builder.gep(address, [PART(0), PART(i)], inbounds=True))


def _type_of(kind: RecordType, field: Field) -> Any:
    of = field.kind
    if field.is_whole:
        return types.boolean if of is bool else types.int64
    if isinstance(of, Many):
        return ManyType(of.kind, kind.scalar(of.pool))
    if isinstance(of, Table):
        return RowsType(of.rows.record, (kind.scalar(of.pool),))
    if isinstance(of, One):
        scalar = kind.scalar(of.pool)
        return scalar if of.kind is float else value_type(of.kind, scalar)
    if isinstance(of, Array):
        return types.Array(kind.scalar(of.pool), len(of.shape), "C")
    if isinstance(of, Columns):
        return types.Array(kind.scalar(NUMBERS), 1, "C")
    if isinstance(of, Behind):
        return types.CPointer(kind.scalar(NUMBERS))
    if of is float:
        return kind.scalar(NUMBERS)
    if of in KINDS:
        return value_type(of, kind.scalar(NUMBERS))
    return RecordType(of, tuple(kind.scalar(name) for name in of.memories))


@infer_getattr
class _Fields(AttributeTemplate):  # type: ignore[misc]
    key = RecordType

    def generic_resolve(self, kind: Any, name: str) -> Any:
        """Return the type of a field."""
        if isinstance(kind, RowsType):
            if name == NUMBERS in kind.in_rows:
                return types.Array(kind.scalar(NUMBERS), 2, "C")
            raise TypingError(f"one of the {kind.record.__name__} records has fields, not all: [i]")
        if name not in kind.record.fields:
            raise TypingError(lacks(kind.record, name))
        return _type_of(kind, kind.record.fields[name])


@lower_getattr_generic(RecordType)
def _get(context: Any, builder: Any, kind: Any, value: Any, name: str) -> Any:
    if isinstance(kind, RowsType):
        memories = kind.record.memories
        places = memories.index(NUMBERS), len(memories), len(memories) + 1 + kind.in_rows.index(NUMBERS)
        start, *lengths = (builder.extract_value(value, place) for place in places)
        return array_at(context, builder, types.Array(kind.scalar(NUMBERS), 2, "C"), start, lengths)
    field, seen = kind.record.fields[name], Seen(builder, kind, value)
    wanted, of = _type_of(kind, field), field.kind
    if field.is_whole:
        found = seen.whole(name).value
        return builder.icmp_signed("!=", found, INTEGER(0)) if of is bool else found
    if isinstance(of, Array):
        start = seen.address(of.pool, of.place(seen.whole).value)
        lengths = [one.value if isinstance(one, Whole) else INTEGER(one) for one in of.lengths(seen.whole)]
        if isinstance(of, (Many, Table)):
            return structure(context, builder, wanted, [start, *lengths])
        if isinstance(of, One):
            return _read(context, builder, wanted, of.kind, start)
        return array_at(context, builder, wanted, start, lengths)
    if wanted.__class__ is RecordType:
        first = {INTEGERS: field.integer_at, NUMBERS: field.number_at}
        return structure(context, builder, wanted, [seen.address(one, first.get(one, 0)) for one in of.memories])
    if isinstance(of, Behind):
        return seen.address(NUMBERS, field.number_at)
    if isinstance(of, Columns):
        return array_at(context, builder, wanted, seen.address(NUMBERS, field.number_at), [INTEGER(of.count)])
    return _read(context, builder, wanted, of, seen.address(NUMBERS, field.number_at))


def _read(context: Any, builder: Any, wanted: Any, of: Any, start: Any) -> Any:
    """Return a number or a value that begins at an address."""
    if of is float:
        return packed(context, builder, wanted, load_number(builder, wanted, start))
    numbers = [load_number(builder, wanted.scalar, behind(builder, start, i)) for i in range(of.count)]
    return packed(context, builder, wanted, of(*numbers))


@lower_setattr_generic(RecordType)
def _set(context: Any, builder: Any, sig: Any, arguments: Any, name: str) -> None:
    kind, given = sig.args
    field, seen = kind.record.fields[name], Seen(builder, kind, arguments[0])
    if field.is_whole:
        if kind.record.is_frozen:
            raise TypingError(f"whole numbers of a {kind.record.__name__}, {name!r} as others, are not written")
        whole = arguments[1] if field.kind is not bool else builder.zext(arguments[1], INTEGER)
        builder.store(whole, seen.address(INTEGERS, field.integer_at))
        return
    memory, at = NUMBERS, field.number_at
    if isinstance(field.kind, One):
        memory, at = field.kind.pool, field.kind.place(seen.whole).value
    elif field.kind is not float and field.kind not in KINDS:
        raise TypingError(f"{kind.record.__name__}.{name} has parts: write these")
    found, scalar, start = symbol(builder, given, arguments[1]), kind.scalar(memory), seen.address(memory, at)
    for i, number in enumerate(found if isinstance(found, Value) else [found]):
        store_number(builder, scalar, behind(builder, start, i), number)


def structure(context: Any, builder: Any, kind: Any, parts: list[Any]) -> Any:
    """Return what a type is, of its parts."""
    made = ir.Constant(context.get_value_type(kind), ir.Undefined)
    for i, part in enumerate(parts):
        made = builder.insert_value(made, part, i)
    return made


def array_at(context: Any, builder: Any, kind: Any, start: Any, lengths: list[Any]) -> Any:
    """Return numbers from an address on as an array, which owns nothing."""
    made = context.make_array(kind)(context, builder)
    size = context.get_abi_sizeof(context.get_data_type(kind.dtype))
    strides = [INTEGER(size)]
    for length in lengths[:0:-1]:
        strides.insert(0, builder.mul(strides[0], length))
    shape, steps = (cgutils.pack_array(builder, numbers, ty=INTEGER) for numbers in (lengths, strides))
    context.populate_array(made, data=start, shape=shape, strides=steps, itemsize=INTEGER(size), meminfo=None)
    return made._getvalue()
