"""Arrays as kernels see them while a library is built: where their numbers are, and how many lie along each axis.

numba keeps seven things of an array, in memory that it writes and reads at each index. Arrays of kernels are contiguous
and their memory is not their own: all but the place and the lengths follows. Here a contiguous array of plain numbers
is these two, and those of any array are known while code is written. Kernels are translated to half as many
instructions, and reshaping, which was a call, is none. What numba does with other arrays stays as it is.
"""

from collections.abc import Sequence
from functools import cache
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import base, cgutils
from numba.core.datamodel import models
from numba.core.imputils import lower_builtin
from numba.cpython import slicing
from numba.np import arrayobj

from kanefe.kernels.compiler._numba_change import Change
from kanefe.kernels.compiler._numba_lanes import LanesType
from kanefe.kernels.compiler._numba_values import known_number

INTEGER = ir.IntType(64)

FULL = INTEGER(0), INTEGER(2**63 - 1)
"""The ends of a span of indices where they are left out, as numba has them."""


def is_plain(kind: Any) -> bool:
    """Return whether a type is that of contiguous arrays of plain numbers."""
    numbers = types.Integer, types.Float, types.Complex, LanesType
    return isinstance(kind, types.Array) and kind.layout == "C" and isinstance(kind.dtype, numbers)


def array_changes() -> tuple[Change, ...]:
    """Return what takes the place of functions of numba."""
    return (
        Change(models.ArrayModel, "__init__", _short_model, "ndim MemInfoPointer dtype pyobject CPointer UniTuple"),
        Change(arrayobj, "make_array", lambda original: in_registers, "as_array create_struct_proxy"),
        Change(arrayobj, "populate_array", lambda original: populate, "_datamodel _fields"),
        Change(arrayobj, "basic_indexing", _by_numbers_and_spans, "fix_slice fix_integer_index get_item_pointer"),
        Change(arrayobj, "array_reshape", _reshape_without_call, "_attempt_nocopy_reshape"),
        Change(base.BaseContext, "cast", _with_plain_arrays, "_casts find"),
    )


def add_views_and_spans() -> None:
    """Have numba take views of plain arrays as other numbers, and spans of indices, as it is done here."""
    lower_builtin("array.view", types.Array, types.DTypeSpec)(_view)
    lower_builtin(slice, types.VarArg(types.Any))(_span)


def _short_model(original: Any) -> Any:
    def init(model: Any, manager: Any, kind: Any) -> None:
        if is_plain(kind):
            lengths = types.UniTuple(types.intp, kind.ndim)
            parts = [("data", types.CPointer(kind.dtype)), ("shape", lengths)]
            models.StructModel.__init__(model, manager, kind, parts)
        else:
            original(model, manager, kind)

    return init


class ArrayInRegisters:
    """What numba takes for the structure of an array: its parts are values, and none of them is in memory.

    Parameters
    ----------
    context, builder : of numba
    value : of llvmlite, optional
        An array to read; else one to be written part by part.
    """

    kind: Any

    def __init__(self, context: Any, builder: Any, value: Any = None) -> None:
        own = vars(self)
        own["_context"], own["_builder"], own["_written"] = context, builder, {}
        own["_datamodel"] = context.data_model_manager[self.kind]
        own["_type"] = context.get_value_type(self.kind)
        own["_value"] = ir.Constant(self._type, ir.Undefined) if value is None else value

    def __getattr__(self, name: str) -> Any:
        """Return a part, or what follows from the place and the lengths."""
        if name in self._written:
            return self._written[name]
        if name in self._datamodel._fields:
            return self._builder.extract_value(self._value, self._datamodel.get_field_position(name))
        if name == "meminfo":
            return ir.Constant(self._context.get_value_type(types.MemInfoPointer(self.kind.dtype)), None)
        if name == "parent":
            return ir.Constant(self._context.get_value_type(types.pyobject), None)
        size = INTEGER(self._context.get_abi_sizeof(self._context.get_data_type(self.kind.dtype)))
        if name == "itemsize":
            return size
        lengths = cgutils.unpack_tuple(self._builder, self.shape, self.kind.ndim)
        if name == "nitems":
            return _product(self._builder, lengths)
        if name == "strides":
            strides = [size]
            for length in reversed(lengths[1:]):
                strides.insert(0, self._builder.mul(strides[0], length))
            return cgutils.pack_array(self._builder, strides, ty=INTEGER)
        raise AttributeError(name)

    def __setattr__(self, name: str, value: Any) -> None:
        self._written[name] = value

    def _getvalue(self) -> Any:
        value = self._value
        for name in self._datamodel._fields:
            if name in self._written:
                at = self._datamodel.get_field_position(name)
                value = self._builder.insert_value(value, self._written[name], at)
        return value

    def _getpointer(self) -> Any:
        place = cgutils.alloca_once(self._builder, self._type)
        self._builder.store(self._getvalue(), place)
        return place


@cache
def in_registers(kind: Any) -> type[ArrayInRegisters]:
    """Return the structure of arrays of a type, in the place of numba's `make_array`."""
    return type("Array", (ArrayInRegisters,), {"kind": kind.as_array})


def populate(
    array: ArrayInRegisters,
    data: Any,
    shape: Any,
    strides: Any = None,
    itemsize: Any = None,
    meminfo: Any = None,
    parent: Any = None,
) -> ArrayInRegisters:
    """Write all parts of an array, in the place of numba's `populate_array`."""
    builder, parts, count = array._builder, array._datamodel, array.kind.ndim

    def type_of(name: str) -> Any:
        return array._type.elements[parts.get_field_position(name)]

    def packed(values: Any) -> Any:
        return cgutils.pack_array(builder, values, ty=INTEGER) if isinstance(values, (tuple, list)) else values

    array.data = data if data.type == type_of("data") else builder.bitcast(data, type_of("data"))
    array.shape = packed(shape)
    if not is_plain(array.kind):
        array.strides = packed(strides)
        array.itemsize = INTEGER(itemsize) if isinstance(itemsize, int) else itemsize
        array.nitems = _product(builder, cgutils.unpack_tuple(builder, array.shape, count))
        for name, value in (("meminfo", meminfo), ("parent", parent)):
            setattr(array, name, ir.Constant(type_of(name), None) if value is None else value)
    return array


def _product(builder: Any, factors: Sequence[Any]) -> Any:
    found: Any = INTEGER(1)
    for factor in factors:
        found = builder.mul(found, factor)
    return found


def _span(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    """Return a span of indices, whose ends are known where they are left out."""
    kind = signature.return_type
    if kind.has_step:
        return slicing.slice_constructor_impl(context, builder, signature, arguments)
    given = [*zip(signature.args, arguments, strict=True)]
    ends = given if len(given) > 1 else [(types.none, None), *given]
    values = [end if at is types.none else value for (at, value), end in zip(ends, FULL, strict=False)]
    return cgutils.make_anonymous_struct(builder, (*values[:2], INTEGER(1)), context.get_value_type(kind))


def _by_numbers_and_spans(original: Any) -> Any:
    """Return numba's place and lengths of a part of an array, for spans without steps in fewer instructions."""

    def index(
        context: Any, builder: Any, kind: Any, array: Any, kinds: Any, indices: Any, boundscheck: Any = None
    ) -> tuple[Any, list[Any], list[Any]]:
        is_span = [isinstance(one, types.SliceType) and not one.has_step for one in kinds]
        if not all(span or isinstance(one, types.Integer) for span, one in zip(is_span, kinds, strict=True)):
            return original(context, builder, kind, array, kinds, indices, boundscheck)  # type: ignore[no-any-return]
        lengths = cgutils.unpack_tuple(builder, array.shape, kind.ndim)
        strides = cgutils.unpack_tuple(builder, array.strides, kind.ndim)
        firsts, left, left_strides = [], [], []
        for span, one, value, length, stride in zip(is_span, kinds, indices, lengths, strides, strict=False):
            if span:
                first, last = (_within(builder, builder.extract_value(value, i), length) for i in (0, 1))
                firsts.append(first)
                left.append(_least(builder, builder.sub(last, first), INTEGER(0)))
                left_strides.append(stride)
            else:
                firsts.append(arrayobj.fix_integer_index(context, builder, one, value, length))
        left += lengths[len(indices) :]
        left_strides += strides[len(indices) :]
        place = cgutils.get_item_pointer(context, builder, kind, array, firsts, wraparound=False, boundscheck=False)
        return place, left, left_strides

    return index


def _within(builder: Any, end: Any, length: Any) -> Any:
    """Return an end of a span of indices as Python takes it: from 0 to the length, negative ones from the end."""
    if known_number(end) in (0, FULL[1].constant):
        return length if known_number(end) else end
    end = builder.select(builder.icmp_signed("<", end, INTEGER(0)), builder.add(end, length), end)
    end = _least(builder, end, INTEGER(0))
    return builder.select(builder.icmp_signed(">", end, length), length, end)


def _least(builder: Any, value: Any, least: Any) -> Any:
    return builder.select(builder.icmp_signed("<", value, least), least, value)


def _reshape_without_call(original: Any) -> Any:
    """Return numba's reshape with contiguous arrays apart; that sizes agree is not checked, as no index is."""

    def reshape(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        kind, lengths_kind = signature.args
        if not is_plain(kind):
            return original(context, builder, signature, arguments)
        array, lengths = in_registers(kind)(context, builder, arguments[0]), []
        given = cgutils.unpack_tuple(builder, arguments[1], lengths_kind.count)
        for axis, length in enumerate(given):
            if isinstance(length, ir.Constant) and length.constant == -1:
                rest = _product(builder, given[:axis] + given[axis + 1 :])
                none = builder.icmp_signed("==", rest, INTEGER(0))
                of_whole = builder.sdiv(array.nitems, builder.select(none, INTEGER(1), rest))
                length = builder.select(none, INTEGER(0), of_whole)
            lengths.append(length)
        made = in_registers(signature.return_type)(context, builder)
        return populate(made, array.data, lengths)._getvalue()

    return reshape


def _with_plain_arrays(original: Any) -> Any:
    """Return numba's conversion of types with that of a plain array to one that need not be contiguous."""

    def cast(context: Any, builder: Any, value: Any, given: Any, wanted: Any) -> Any:
        if isinstance(wanted, types.Array) and is_plain(given) and not is_plain(wanted):
            array = in_registers(given)(context, builder, value)
            made = in_registers(wanted)(context, builder)
            return populate(made, array.data, array.shape, array.strides, array.itemsize)._getvalue()
        return original(context, builder, value, given, wanted)

    return cast


def _view(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    """Return an array as one of other numbers: real ones as complex ones, or back."""
    given, wanted = signature.args[0], signature.return_type
    array = in_registers(given)(context, builder, arguments[0])
    lengths = cgutils.unpack_tuple(builder, array.shape, given.ndim)
    sizes = [INTEGER(context.get_abi_sizeof(context.get_data_type(kind.dtype))) for kind in (given, wanted)]
    lengths[-1] = builder.sdiv(builder.mul(lengths[-1], sizes[0]), sizes[1])
    return populate(in_registers(wanted)(context, builder), array.data, lengths)._getvalue()
