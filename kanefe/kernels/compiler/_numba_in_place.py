"""Named tuples that kernels read where they are in the places of a call: in compiled code each is one address.

What is in them is the same while a kernel runs, so that it is read once, however much is written elsewhere.
"""

from functools import cache
from typing import Any

from llvmlite import ir
from numba import types
from numba.core.datamodel import models, register_default
from numba.core.errors import TypingError
from numba.core.imputils import lower_getattr_generic
from numba.core.typing.templates import AttributeTemplate, infer_getattr
from numba.extending import intrinsic

from kanefe.kernels.compiler._numba_records import array_at, load
from kanefe.kernels.compiler.signatures import BOOLEAN, INTEGER, Group, Part, parts_in_place

WHOLE = ir.IntType(64)


class InPlaceType(types.Type):  # type: ignore[misc]
    """The type of a named tuple in place."""

    def __init__(self, of: type) -> None:
        self.of, self.parts = of, parts_in_place(of)
        super().__init__(f"{of.__qualname__} in place")

    @property
    def key(self) -> Any:
        """What it differs from others by."""
        return self.of


@register_default(InPlaceType)
class _InPlaceModel(models.StructModel):  # type: ignore[misc]
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, [("places", types.CPointer(types.int64))])


def _type_of(part: Part) -> Any:
    if isinstance(part, Group):
        return in_place_type(part.of)
    if part.axes > 0:
        return types.Array(getattr(types, part.kind), part.axes, "C")
    return {INTEGER: types.int64, BOOLEAN: types.boolean}[part.kind]


in_place_type = cache(InPlaceType)


@infer_getattr
class _Parts(AttributeTemplate):  # type: ignore[misc]
    key = InPlaceType

    def generic_resolve(self, kind: Any, name: str) -> Any:
        """Return the type of a part."""
        if name not in kind.parts:
            raise TypingError(f"a {kind.of.__name__} has no {name!r}; it has {', '.join(kind.parts)}")
        return _type_of(kind.parts[name])


@lower_getattr_generic(InPlaceType)
def _get(context: Any, builder: Any, kind: Any, value: Any, name: str) -> Any:
    part, first = kind.parts[name], builder.extract_value(value, 0)
    wanted = _type_of(part)

    def at(place: int) -> Any:
        return builder.gep(first, [WHOLE(place)], inbounds=True)

    if isinstance(part, Group):
        return builder.insert_value(ir.Constant(context.get_value_type(wanted), ir.Undefined), at(part.at), 0)
    found = load(builder, at(part.at), is_frozen=True)
    if part.axes == 0:
        return builder.icmp_signed("!=", found, WHOLE(0)) if part.kind == BOOLEAN else found
    start = builder.inttoptr(found, context.get_value_type(types.CPointer(wanted.dtype)))
    lengths = [load(builder, at(part.at + 1 + i), is_frozen=True) for i in range(part.axes)]
    return array_at(context, builder, wanted, start, lengths)


@cache
def reader(of: type) -> Any:
    """Return what gives compiled code a tuple in the places of a call, from one of them on."""

    @intrinsic
    def in_place(typing: Any, places: Any, at: Any) -> Any:
        def build(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            address = builder.gep(values[0], [values[1]], inbounds=True)
            return builder.insert_value(ir.Constant(context.get_value_type(made), ir.Undefined), address, 0)

        made = in_place_type(of)
        return made(places, types.int64), build

    return in_place
