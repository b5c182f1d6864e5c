"""Lanes in compiled code: several real numbers in one vector register, which instructions take as they take one."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils, typeconv
from numba.core.datamodel import models, register_default
from numba.core.imputils import lower_builtin, lower_cast, lower_getattr
from numba.core.typing.templates import AbstractTemplate, AttributeTemplate, infer_getattr, infer_global, signature

from kanefe.kernels.values.numbers import lane_count, lanes_of

REAL, COMPLEX = types.float64, types.complex128
DOUBLE, PLACE = ir.DoubleType(), ir.IntType(32)

IN_MEMORY = 8
"""Alignment of lanes in memory, bytes: that of a number, since arrays begin anywhere."""


@cache
def width() -> int:
    """Return how many lanes fill a register of the processor that is built for; four where it has none so long."""
    from numba.core.registry import cpu_target

    return 8 if "+avx512f" in cpu_target.target_context.codegen()._tm_features else 4


class LanesType(types.Type):  # type: ignore[misc]
    """The type of lanes."""

    def __init__(self) -> None:
        super().__init__("lanes")

    def can_convert_from(self, context: Any, other: Any) -> Any:
        """Return how well another type becomes lanes: real numbers do."""
        return typeconv.Conversion.promote if isinstance(other, (types.Float, types.Integer)) else None

    def unify(self, context: Any, other: Any) -> Any:
        """Return the type of what is lanes or of another type."""
        return self if isinstance(other, (types.Float, types.Integer)) else None


LANES = LanesType()


@register_default(LanesType)
class _LanesModel(models.PrimitiveModel):  # type: ignore[misc]
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, ir.VectorType(DOUBLE, width()))

    def load_from_data_pointer(self, builder: Any, place: Any, align: Any = None) -> Any:
        """Return the lanes at a place."""
        return builder.load(place, align=IN_MEMORY)


def widened(builder: Any, numbers: Sequence[Any], are_lanes: bool = False) -> list[Any]:
    """Return numbers as llvmlite has them: all as lanes where one is, or it is said."""
    if not (are_lanes or any(isinstance(one.type, ir.VectorType) for one in numbers)):
        return [*numbers]
    return [one if isinstance(one.type, ir.VectorType) else _in_each(builder, one) for one in numbers]


def _in_each(builder: Any, number: Any) -> Any:
    """Return lanes that are one number."""
    kind = ir.VectorType(number.type, width())
    if isinstance(number, ir.Constant):
        return ir.Constant(kind, [number] * width())
    none = ir.Constant(kind, ir.Undefined)
    first = builder.insert_element(none, number, PLACE(0))
    return builder.shuffle_vector(first, none, ir.Constant(ir.VectorType(PLACE, width()), [PLACE(0)] * width()))


def in_all(builder: Any, condition: Any) -> Any:
    """Return whether a condition holds, of lanes: in all of them."""
    if not isinstance(condition.type, ir.VectorType):
        return condition
    bits = ir.IntType(width())
    return builder.icmp_signed("==", builder.bitcast(condition, bits), bits(-1))


def floor_of(builder: Any, number: Any) -> Any:
    """Return the whole number below a number, or below each lane."""
    name = f"llvm.floor.v{width()}f64" if isinstance(number.type, ir.VectorType) else "llvm.floor.f64"
    floor = cgutils.get_or_insert_function(builder.module, ir.FunctionType(number.type, (number.type,)), name)
    return builder.call(floor, (number,))


@lower_cast(types.Float, LanesType)
@lower_cast(types.Integer, LanesType)
def _cast(context: Any, builder: Any, given: Any, wanted: Any, value: Any) -> Any:
    return _in_each(builder, value if isinstance(given, types.Float) else builder.sitofp(value, DOUBLE))


@infer_getattr
class _Real(AttributeTemplate):  # type: ignore[misc]
    key = LanesType

    def resolve_real(self, kind: Any) -> Any:
        """Return the type of the real part: lanes are real."""
        return kind


@lower_getattr(LanesType, "real")
def _real(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    return value


@infer_global(lanes_of)
class _LanesOf(AbstractTemplate):  # type: ignore[misc]
    def generic(self, args: Any, kws: Any) -> Any:
        """Return the signature for types of arguments."""
        (array,) = args
        return signature(types.Array(LANES, array.ndim - 1, "C"), array)


@lower_builtin(lanes_of, types.Array)
def _lanes_of(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
    given = context.make_array(sig.args[0])(context, builder, arguments[0])
    made = context.make_array(sig.return_type)(context, builder)
    size = ir.IntType(64)(8 * width())
    lengths = cgutils.unpack_tuple(builder, given.shape, sig.args[0].ndim)[:-1]
    strides = [size]
    for length in lengths[:0:-1]:
        strides.insert(0, builder.mul(strides[0], length))
    place = builder.bitcast(given.data, ir.VectorType(DOUBLE, width()).as_pointer())
    context.populate_array(made, data=place, shape=lengths, strides=strides, itemsize=size, meminfo=None)
    return made._getvalue()


@infer_global(lane_count)
class _LaneCount(AbstractTemplate):  # type: ignore[misc]
    def generic(self, args: Any, kws: Any) -> Any:
        """Return the signature for types of arguments."""
        return signature(types.int64)


@lower_builtin(lane_count)
def _lane_count(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
    return ir.IntType(64)(width())
