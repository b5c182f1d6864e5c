"""Functions of one type for all, called by their address: how a compiled kernel calls one, and is one.

In C an array is the place of its first number and its lengths, which follow; so it does not matter whether both sides
were compiled in one way. The types are those of `kanefe.kernels.compiler.arrays`.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

from kanefe.kernels.compiler.arrays import ADVANCE, FILLER, INTERPOLATE

_MEMORY = "int64", 1, "float64", 1, "float64", 2, "float64", 2
_TYPES: dict[str, tuple[tuple[Any, ...], str]] = {
    FILLER: (("float64", 0, "float64", 1, "float64", 1), "void"),
    ADVANCE: (_MEMORY, "int64"),
    INTERPOLATE: ((*_MEMORY, "float64", 0, "float64", 1), "void"),
}
"""Types by their names: kind and axes of each argument, in turn, and the result."""


def _arguments(kind: str) -> list[tuple[str, int]]:
    given = _TYPES[kind][0]
    return [*zip(given[::2], given[1::2], strict=True)]


def c_signature(kind: str) -> Any:
    """Return the type of the C function, of numba."""
    from numba import types

    taken: list[Any] = []
    for name, axes in _arguments(kind):
        number = getattr(types, name)
        taken += [types.CPointer(number), *[types.int64] * axes] if axes else [number]
    return getattr(types, _TYPES[kind][1])(*taken)


def c_function(function: Callable[..., Any], kind: str) -> Callable[..., Any]:
    """Return what calls a compiled function of arrays with what the C function is given, for numba."""
    from numba import carray

    taken, handed = [], []
    for i, (_, axes) in enumerate(_arguments(kind)):
        lengths = [f"n{i}_{axis}" for axis in range(axes)]
        taken += [f"a{i}", *lengths]
        handed.append(f"array_of(a{i}, ({', '.join(lengths)},))" if axes else f"a{i}")
    names: dict[str, Any] = {"function": function, "array_of": carray}
    exec(f"def wrapper({', '.join(taken)}):\n    return function({', '.join(handed)})\n", names)
    return names["wrapper"]  # type: ignore[no-any-return]


@cache
def function_at(kind: str) -> Any:
    """Return what makes of an address a function that compiled code can call, for numba."""
    from numba import types
    from numba.core.datamodel import models, register_default
    from numba.core.imputils import lower_builtin
    from numba.core.typing.templates import signature
    from numba.extending import intrinsic

    def number(name: str, axes: int) -> Any:
        value = getattr(types, name)
        return types.Array(value, axes, "C") if axes else value

    arguments = [number(name, axes) for name, axes in _arguments(kind)]
    result = getattr(types, _TYPES[kind][1])

    class Address(types.Callable):  # type: ignore[misc]
        """The type of an address of a function of this kind."""

        def get_call_type(self, context: Any, args: Any, kws: Any) -> Any:
            return signature(result, *arguments, recvr=self)

        def get_call_signatures(self) -> Any:
            return [signature(result, *arguments)], False

        def get_impl_key(self, sig: Any) -> Any:
            return self

    register_default(Address)(_model_of_an_integer(models))
    made = Address(f"address of {kind}")

    def call(context: Any, builder: Any, sig: Any, values: Any) -> Any:
        from llvmlite import ir
        from numba.core import cgutils

        given = []
        for wanted, value in zip(arguments, values[1:], strict=True):
            if isinstance(wanted, types.Array):
                array = context.make_array(wanted)(context, builder, value)
                given += [array.data, *cgutils.unpack_tuple(builder, array.shape, wanted.ndim)]
            else:
                given.append(value)
        returned = ir.VoidType() if result is types.void else context.get_value_type(result)
        function = ir.FunctionType(returned, [value.type for value in given]).as_pointer()
        found = builder.call(builder.inttoptr(values[0], function), given)
        return context.get_dummy_value() if result is types.void else found

    lower_builtin(made, types.VarArg(types.Any))(call)

    @intrinsic
    def at(typing: Any, address: Any) -> Any:
        return made(types.int64), lambda context, builder, sig, values: values[0]

    return at


def _model_of_an_integer(models: Any) -> Any:
    from numba import types

    class Model(models.PrimitiveModel):  # type: ignore[misc]
        def __init__(self, manager: Any, kind: Any) -> None:
            super().__init__(manager, kind, manager.lookup(types.int64).get_value_type())

    return Model
