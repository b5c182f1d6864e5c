"""Rows of records and many values in compiled code, and how records and rows are made of arrays."""

import operator
from typing import Any

from numba import types
from numba.core import cgutils
from numba.core.errors import TypingError
from numba.core.imputils import lower_builtin, lower_getattr_generic
from numba.core.typing.templates import AbstractTemplate, AttributeTemplate, infer_getattr, infer_global, signature

from kanefe.kernels.compiler._numba_records import (
    INTEGER,
    ManyType,
    RecordType,
    RowsType,
    Seen,
    array_at,
    behind,
    load_number,
    store_number,
    structure,
)
from kanefe.kernels.compiler._numba_tensors import ValueType, packed, symbol
from kanefe.kernels.values.parts import INTEGERS, NUMBERS
from kanefe.kernels.values.records import Record, Rows, numbers_from, vectors
from kanefe.kernels.values.tensors import Vector


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
    return structure(context, builder, sig.return_type, parts)


def _components(builder: Any, kind: ManyType, many: Any, i: Any) -> list[Any]:
    """Return the addresses of the components of a value."""
    start, count = builder.extract_value(many, 0), builder.extract_value(many, 1)
    places = [builder.add(builder.mul(INTEGER(c), count), i) for c in range(kind.kind.count)]
    return [behind(builder, start, place) for place in places]


@lower_builtin(operator.getitem, ManyType, types.Integer)
def _one(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
    kind = sig.args[0]
    numbers = [load_number(builder, kind.scalar, place) for place in _components(builder, kind, *arguments)]
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
        store_number(builder, kind.scalar, place, number)


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
    return structure(context, builder, sig.return_type, [array.data, cgutils.unpack_tuple(builder, array.shape, 2)[1]])


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
        return structure(context, builder, sig.return_type, parts)

    @lower_builtin(kind, RecordType)
    def build(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
        seen = Seen(builder, sig.args[0], arguments[0])
        return structure(context, builder, sig.return_type, [seen.address(name) for name in kind.memories])


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
            return structure(context, builder, wanted, [start, INTEGER(0), INTEGER(record.number_count)])
        arrays = [
            context.make_array(one)(context, builder, array) for one, array in zip(sig.args, arguments, strict=True)
        ]
        shapes = [
            cgutils.unpack_tuple(builder, array.shape, 2)
            for name, array in zip(record.memories, arrays, strict=True)
            if name in wanted.in_rows
        ]
        parts = [*(array.data for array in arrays), shapes[0][0], *(width for _, width in shapes)]
        return structure(context, builder, wanted, parts)
