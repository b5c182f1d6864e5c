"""The door to numba: what kernels are compiled with, and user's functions.

numba is imported when something is compiled, not before: kernels that were built ahead of time (see
`kanefe.kernels.compiler.compiled_functions`) do without. Until then a kernel is the plain function that is written;
compiled are copies of them, whose modules see each other's copies.
``KANEFE_JIT=0`` runs the kernels as plain Python.
"""

import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from types import FunctionType, ModuleType
from typing import Any, TypeVar

from kanefe.errors import MissingDependency
from kanefe.kernels.values.records import Record, Rows

Function = TypeVar("Function", bound=Callable[..., Any])

IS_COMPILED = os.environ.get("KANEFE_JIT", "1") != "0"

# What floating point may do: contract a * b + c, drop the sign of zero, multiply by a reciprocal. Not reorder sums, not
# assume that there are no infinities or NaN: a run that blows up must be seen.
RELAXED = {"contract", "nsz", "arcp"}

# What compiled code alone calls, as kernels, and functions around those of the user: what Python and C would call it by
# takes half of its compilation.
INSIDE = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}

# No kernel makes an array that outlives it, so that none counts references to arrays, which would cost more than half
# of a small evaluation. What is not said here numba takes from the kernel that happens to be the first to call it.
INNER = {"error_model": "numpy", "_nrt": False, "fastmath": False, "forceinline": False, **INSIDE}

_seconds_compiling = 0.0


@contextmanager
def timed() -> Iterator[None]:
    """Count what is inside as time of compiling."""
    global _seconds_compiling
    began = time.perf_counter()
    try:
        yield
    finally:
        _seconds_compiling += time.perf_counter() - began


def numba_for(what: str) -> Any:
    """Return numba.

    Raises
    ------
    MissingDependency
        If it is not installed; the message says what it is for.
    """
    try:
        import numba
    except ImportError as error:
        remedy = "pip install 'kanefe[compile]', or KANEFE_JIT=0 to do without, some hundred times slower"
        raise MissingDependency("numba", what, remedy) from error
    return numba


def kernel(function: Function) -> Function:
    """Mark a function that other kernels call."""
    return _marked(function, {**INNER, "fastmath": RELAXED})


def exact(function: Function) -> Function:
    """Mark a function that other kernels call, whose arithmetic is that of Python to the bit."""
    return _marked(function, {**INNER})


def inlined(function: Function) -> Function:
    """Mark a small function that is compiled into each place where it is called: its arguments stay in registers."""
    return _marked(function, {**INNER, "fastmath": RELAXED, "forceinline": True})


def expanded(function: Function) -> Function:
    """Have a function compiled as a part of each that calls it, and not by itself: that would take as long again.

    For functions that call most kernels.
    """
    return _marked(function, {"inline": "always"})


def vector_kernel(function: Function) -> Function:
    """Mark a function of long sums whose order may change, so that they use vector instructions."""
    return in_vectors(_marked(function, {**INNER, "fastmath": RELAXED | {"reassoc"}, "forceinline": True}))


def in_vectors(function: Function) -> Function:
    """Mark a function of loops whose passes do not depend on each other, so that they use vector instructions."""
    function.has_vectors = True  # type: ignore[attr-defined]
    return function


def _marked(function: Function, options: dict[str, Any]) -> Function:
    function.kernel_options = options  # type: ignore[attr-defined]
    return function


def by_address(in_python: Function) -> Function:
    """Mark the function that kernels call a C function by its address with: see `kanefe.kernels.compiler.calls`.

    `in_python` does the same where nothing is compiled.
    """
    in_python.calls_by_address = _call_by_address  # type: ignore[attr-defined]
    return in_python


def law_by_address(in_python: Function) -> Function:
    """Mark the function by which kernels call a law of the user at its address: see `kanefe.kernels.compiler.calls`."""
    in_python.calls_by_address = _law_by_address  # type: ignore[attr-defined]
    return in_python


_seen: dict[str, dict[str, Any]] = {}
_dispatchers: dict[Callable[..., Any], Any] = {}
_kinds: set[type[Any]] = set()


def _seen_by(module: str) -> dict[str, Any]:
    """Return what the functions of a module see when they are compiled: compiled kernels in the place of plain ones."""
    if module not in _seen:
        _seen[module] = seen = dict(vars(sys.modules[module]))
        for name, value in list(seen.items()):
            if hasattr(value, "kernel_options"):
                seen[name] = dispatcher(value)
            elif hasattr(value, "calls_by_address"):
                seen[name] = value.calls_by_address()
            elif isinstance(value, type) and issubclass(value, (Record, Rows)):
                add_kind(value)
            elif isinstance(value, ModuleType) and value.__name__.startswith("kanefe.kernels."):
                seen[name] = ModuleType(value.__name__)
                vars(seen[name]).update(_seen_by(value.__name__))
    return _seen[module]


def add_kind(kind: type[Any]) -> None:
    """Have compiled code know a kind of records, or of rows of them."""
    from kanefe.kernels.compiler._numba_rows import add_record, add_rows

    if kind in _kinds:
        return
    _kinds.add(kind)
    if issubclass(kind, Record):
        add_record(kind)
    elif hasattr(kind, "record"):
        add_rows(kind)


def seeing_compiled(function: Callable[..., Any]) -> FunctionType:
    seen = _seen_by(function.__module__)
    return FunctionType(function.__code__, seen, function.__name__, function.__defaults__)  # type: ignore[attr-defined]


def dispatcher(function: Callable[..., Any]) -> Any:
    """Return the compiled form of a kernel; it is compiled for the types that it is called with."""
    import numba

    from kanefe.kernels.compiler import _numba_tensors  # noqa: F401 - numba knows values by it

    copy = seeing_compiled(function)  # other kernels first, of which one may be this
    if function not in _dispatchers:
        options = getattr(function, "kernel_options", {**INNER, "fastmath": RELAXED})
        _dispatchers[function] = numba.njit(**options)(copy)
    return _dispatchers[function]


def vector_dispatchers() -> Iterator[Any]:
    """Yield the compiled forms of kernels that use vector instructions, so far."""
    for function, made in _dispatchers.items():
        if hasattr(function, "has_vectors"):
            yield made


@cache
def _call_by_address() -> Any:
    """Return what calls a function by its address, with integers, numbers and the first places of arrays."""
    from llvmlite import ir
    from numba import types
    from numba.core import cgutils
    from numba.core.errors import TypingError
    from numba.extending import intrinsic

    def is_taken(kind: Any) -> bool:
        return kind in (types.int64, types.float64) or (isinstance(kind, types.Array) and kind.layout == "C")

    @intrinsic
    def call_address(typing: Any, address: Any, arguments: Any) -> Any:
        if address != types.int64 or not all(map(is_taken, arguments)):
            raise TypingError(f"call_address takes an int64 and int64, float64 or C-contiguous arrays, not {arguments}")

        def build(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            given = []
            for kind, value in zip(arguments, cgutils.unpack_tuple(builder, values[1]), strict=True):
                is_array = isinstance(kind, types.Array)
                given.append(context.make_array(kind)(context, builder, value).data if is_array else value)
            function = ir.FunctionType(ir.VoidType(), [value.type for value in given]).as_pointer()
            builder.call(builder.inttoptr(values[0], function), given)
            return context.get_dummy_value()

        return types.void(address, arguments), build

    return call_address


@cache
def _law_by_address() -> Any:
    """Return what calls a law by its address, which writes five numbers, and returns these."""
    from llvmlite import ir
    from numba import types
    from numba.core import cgutils
    from numba.core.errors import TypingError
    from numba.extending import intrinsic

    given = (types.int64, types.float64, types.float64, types.CPointer(types.float64), types.int64)
    written = types.UniTuple(types.float64, 5)

    @intrinsic
    def call_law(typing: Any, address: Any, depth: Any, rate: Any, numbers: Any, at: Any) -> Any:
        if (address, depth, rate, numbers, at) != given:
            raise TypingError(f"call_law takes {given}, not {(address, depth, rate, numbers, at)}")

        def build(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            real = ir.DoubleType()
            room = cgutils.alloca_once(builder, real, size=5)
            places = [builder.gep(room, [ir.IntType(32)(i)]) for i in range(5)]
            for place in places:
                builder.store(real(0.0), place)
            own = [values[1], values[2], builder.gep(values[3], [values[4]]), room]
            function = ir.FunctionType(ir.VoidType(), [value.type for value in own]).as_pointer()
            builder.call(builder.inttoptr(values[0], function), own)
            return context.make_tuple(builder, written, [builder.load(place) for place in places])

        return written(*given), build

    return call_law


def seconds_compiling() -> float:
    """Return how long, since the process began, kernels have been compiled."""
    return _seconds_compiling
