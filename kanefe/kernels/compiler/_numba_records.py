"""Records in compiled code: the addresses of their arrays, and fields as numbers at known distances from these.

A record costs nothing: it is one address for each array that it has fields in, and where a field is follows while code
is written, as it does in Python, by the functions of `kanefe.kernels.values.records`.
"""

from __future__ import annotations

import operator
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.datamodel import models, register_default
from numba.core.errors import TypingError
from numba.core.imputils import lower_builtin, lower_getattr_generic, lower_setattr_generic
from numba.core.typing.templates import AbstractTemplate, AttributeTemplate, infer_getattr, infer_global, signature

from kanefe.kernels.compiler._numba_tensors import (
    COMPLEX,
    Symbol,
    ValueType,
    number_symbol,
    number_value,
    packed,
    symbol,
    value_type,
)
from kanefe.kernels.values.records import (
    INTEGERS,
    NUMBERS,
    Array,
    Behind,
    Columns,
    Field,
    Many,
    One,
    Record,
    Rows,
    Table,
    lacks,
    numbers_from,
    vectors,
)
from kanefe.kernels.values.tensors import KINDS, Value, Vector

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


def _load(builder: Any, scalar: Any, address: Any) -> Symbol:
    if scalar != COMPLEX:
        return number_symbol(builder, scalar, builder.load(address))
    parts = [builder.gep(address, [PART(0), PART(i)], inbounds=True) for i in range(2)]
    return Symbol(builder, *map(builder.load, parts))


def _store(builder: Any, scalar: Any, address: Any, number: Symbol) -> None:
    if scalar != COMPLEX:
        builder.store(number_value(builder, scalar, number), address)
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
            return _structure(context, builder, wanted, [start, *lengths])
        if isinstance(of, One):
            return _read(context, builder, wanted, of.kind, start)
        return array_at(context, builder, wanted, start, lengths)
    if wanted.__class__ is RecordType:
        first = {INTEGERS: field.integer_at, NUMBERS: field.number_at}
        return _structure(context, builder, wanted, [seen.address(one, first.get(one, 0)) for one in of.memories])
    if isinstance(of, Behind):
        return seen.address(NUMBERS, field.number_at)
    if isinstance(of, Columns):
        return array_at(context, builder, wanted, seen.address(NUMBERS, field.number_at), [INTEGER(of.count)])
    return _read(context, builder, wanted, of, seen.address(NUMBERS, field.number_at))


def _read(context: Any, builder: Any, wanted: Any, of: Any, start: Any) -> Any:
    """Return a number or a value that begins at an address."""
    if of is float:
        return packed(context, builder, wanted, _load(builder, wanted, start))
    numbers = [_load(builder, wanted.scalar, behind(builder, start, i)) for i in range(of.count)]
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
        _store(builder, scalar, behind(builder, start, i), number)


def _structure(context: Any, builder: Any, kind: Any, parts: list[Any]) -> Any:
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


@infer_global(operator.getitem)
class _Item(AbstractTemplate):  # type: ignore[misc]
    def generic(self, args: Any, kws: Any) -> Any:
        """Return the signature for types of arguments."""
        if len(args) == 2 and isinstance(args[1], types.Integer):
            if isinstance(args[0], RowsType):
                return signature(args[0].row, args[0], types.int64)
            if isinstance(args[0], ManyType):
                return signature(args[0].value, args[0], types.int64)
        return None


@lower_builtin(operator.getitem, RowsType, types.Integer)
def _row(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
    kind, (rows, i) = sig.args[0], arguments
    names, parts = kind.record.memories, []
    count = builder.extract_value(rows, len(names))
    i = builder.select(builder.icmp_signed("<", i, INTEGER(0)), builder.add(i, count), i)
    for at, name in enumerate(names):
        part = builder.extract_value(rows, at)
        if name in kind.in_rows:
            width = builder.extract_value(rows, len(names) + 1 + kind.in_rows.index(name))
            part = behind(builder, part, builder.mul(i, width))
        parts.append(part)
    return _structure(context, builder, sig.return_type, parts)


def _components(builder: Any, kind: ManyType, many: Any, i: Any) -> list[Any]:
    """Return the addresses of the components of a value."""
    start, count = builder.extract_value(many, 0), builder.extract_value(many, 1)
    places = [builder.add(builder.mul(INTEGER(c), count), i) for c in range(kind.kind.count)]
    return [behind(builder, start, place) for place in places]


@lower_builtin(operator.getitem, ManyType, types.Integer)
def _one(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
    kind = sig.args[0]
    numbers = [_load(builder, kind.scalar, place) for place in _components(builder, kind, *arguments)]
    return packed(context, builder, kind.value, kind.kind(*numbers))


@infer_global(operator.setitem)
class _SetItem(AbstractTemplate):  # type: ignore[misc]
    def generic(self, args: Any, kws: Any) -> Any:
        """Return the signature for types of arguments."""
        if not isinstance(args[0], ManyType) or not isinstance(args[1], types.Integer):
            return None
        if self.context.can_convert(args[2], args[0].value) is None:
            raise TypingError(f"a {args[0].value} is wanted, not a {args[2]}")
        return signature(types.void, args[0], types.int64, args[0].value)


@lower_builtin(operator.setitem, ManyType, types.Integer, ValueType)
def _set_one(context: Any, builder: Any, sig: Any, arguments: Any) -> None:
    kind, (many, i, value) = sig.args[0], arguments
    numbers = symbol(builder, sig.args[2], value)
    for place, number in zip(_components(builder, kind, many, i), numbers, strict=True):
        _store(builder, kind.scalar, place, number)


@infer_getattr
class _Numbers(AttributeTemplate):  # type: ignore[misc]
    key = ManyType

    def generic_resolve(self, kind: Any, name: str) -> Any:
        """Return the type of all numbers of the values."""
        return types.Array(kind.scalar, 1, "C") if name == "numbers" else None


@lower_getattr_generic(ManyType)
def _all_numbers(context: Any, builder: Any, kind: Any, value: Any, name: str) -> Any:
    count = builder.mul(builder.extract_value(value, 1), INTEGER(kind.kind.count))
    return array_at(context, builder, types.Array(kind.scalar, 1, "C"), builder.extract_value(value, 0), [count])


@infer_global(vectors)
class _Vectors(AbstractTemplate):  # type: ignore[misc]
    def generic(self, args: Any, kws: Any) -> Any:
        """Return the signature for types of arguments."""
        if len(args) == 1 and getattr(args[0], "ndim", 0) == 2 and args[0].layout == "C":
            return signature(ManyType(Vector, args[0].dtype), *args)
        raise TypingError(f"vectors are made of contiguous arrays of two axes, not of {args}")


@lower_builtin(vectors, types.Array)
def _columns(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
    array = context.make_array(sig.args[0])(context, builder, arguments[0])
    return _structure(context, builder, sig.return_type, [array.data, cgutils.unpack_tuple(builder, array.shape, 2)[1]])


@infer_global(len)
class _Length(AbstractTemplate):  # type: ignore[misc]
    def generic(self, args: Any, kws: Any) -> Any:
        """Return the signature for types of arguments."""
        return signature(types.int64, *args) if isinstance(args[0], (RowsType, ManyType)) else None


@lower_builtin(len, RowsType)
@lower_builtin(len, ManyType)
def _count(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
    kind = sig.args[0]
    return builder.extract_value(arguments[0], len(kind.record.memories) if isinstance(kind, RowsType) else 1)


@infer_global(numbers_from)
class _NumbersFrom(AbstractTemplate):  # type: ignore[misc]
    def generic(self, args: Any, kws: Any) -> Any:
        """Return the signature for types of arguments."""
        is_record = len(args) == 1 and args[0].__class__ is RecordType and NUMBERS in args[0].record.memories
        return signature(types.CPointer(args[0].scalar(NUMBERS)), *args) if is_record else None


@lower_builtin(numbers_from, RecordType)
def _numbers_from(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
    return Seen(builder, sig.args[0], arguments[0]).address(NUMBERS)


def _is_list(kind: Any) -> bool:
    """Return whether a type is that of the place of a number, or of an array of one axis."""
    return isinstance(kind, types.CPointer) or (isinstance(kind, types.Array) and (kind.ndim, kind.layout) == (1, "C"))


def _first(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    """Return the address of the first number of such a list."""
    return value if isinstance(kind, types.CPointer) else context.make_array(kind)(context, builder, value).data


def add_record(kind: type[Record]) -> None:
    """Have compiled code make records of those of another kind, ``kind(record)``, and of arrays of their own."""

    class Template(AbstractTemplate):  # type: ignore[misc]
        key = kind

        def generic(self, args: Any, kws: Any) -> Any:
            """Return the signature for types of arguments."""
            if args and _is_list(args[0]) and kind.memories == (NUMBERS,):
                return signature(RecordType(kind, (args[0].dtype,)), args[0], *[types.int64] * (len(args) - 1))
            if len(args) == len(kind.memories) and all(getattr(one, "layout", "") == "C" for one in args):
                return signature(RecordType(kind, tuple(one.dtype for one in args)), *args)
            if len(args) != 1 or args[0].__class__ is not RecordType:
                raise TypingError(f"a {kind.__name__} is made of a record, not of {', '.join(map(str, args))}")
            own = args[0].record.memories
            missing = [name for name in kind.memories if name not in own]
            if missing:
                raise TypingError(f"a {args[0].record.__name__} has no {missing[0]}, which a {kind.__name__} wants")
            return signature(RecordType(kind, tuple(args[0].scalar(name) for name in kind.memories)), *args)

    infer_global(kind)(Template)

    @lower_builtin(kind, types.VarArg(types.Any))
    def build_of_arrays(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
        count = len(sig.return_type.scalars)
        parts = [_first(context, builder, *one) for one in zip(sig.args[:count], arguments[:count], strict=True)]
        if len(arguments) > count:
            parts = [behind(builder, parts[0], arguments[count])]
        return _structure(context, builder, sig.return_type, parts)

    @lower_builtin(kind, RecordType)
    def build(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
        seen = Seen(builder, sig.args[0], arguments[0])
        return _structure(context, builder, sig.return_type, [seen.address(name) for name in kind.memories])


def add_rows(kind: type[Rows[Any]]) -> None:
    """Have compiled code make rows of arrays, ``kind(*arrays)``."""
    record = kind.record

    class Template(AbstractTemplate):  # type: ignore[misc]
        key = kind

        def generic(self, args: Any, kws: Any) -> Any:
            """Return the signature for types of arguments."""
            if len(args) == 1 and _is_list(args[0]) and record.memories == (NUMBERS,):
                return signature(RowsType(record, (args[0].dtype,)), *args)
            axes = [2 if name in (INTEGERS, NUMBERS) else 1 for name in record.memories]
            if [getattr(one, "ndim", 0) for one in args] != axes or any(one.layout != "C" for one in args):
                wanted = ", ".join(record.memories)
                raise TypingError(f"{kind.__name__} are made of arrays of {wanted}, not of {', '.join(map(str, args))}")
            return signature(RowsType(record, tuple(one.dtype for one in args)), *args)

    infer_global(kind)(Template)

    @lower_builtin(kind, types.VarArg(types.Any))
    def build(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
        wanted = sig.return_type
        if _is_list(sig.args[0]):
            start = _first(context, builder, sig.args[0], arguments[0])
            return _structure(context, builder, wanted, [start, INTEGER(0), INTEGER(record.number_count)])
        arrays = [
            context.make_array(one)(context, builder, array) for one, array in zip(sig.args, arguments, strict=True)
        ]
        shapes = [
            cgutils.unpack_tuple(builder, array.shape, 2)
            for name, array in zip(record.memories, arrays, strict=True)
            if name in wanted.in_rows
        ]
        parts = [*(array.data for array in arrays), shapes[0][0], *(width for _, width in shapes)]
        return _structure(context, builder, wanted, parts)
