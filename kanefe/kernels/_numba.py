"""The door to numba: how kernels are compiled, and where the compiled code is kept.

numba's own cache looks at the file of a function alone and would not see a change in a kernel that it calls. The code
is therefore kept in a folder of the user's cache that is named by a hash of all files below this folder, so that a
change in any of them starts a new one. Constants are compiled in: those of kernels have to be in these files too.
``KANEFE_JIT=0`` runs the kernels as plain Python, without importing numba.
"""

from __future__ import annotations

import ctypes
import hashlib
import numbers
import os
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import cache, lru_cache
from pathlib import Path
from typing import Any, TypeVar

from kanefe.errors import ModelError
from kanefe.storage.files import cache_folder

Function = TypeVar("Function", bound=Callable[..., Any])

IS_COMPILED = os.environ.get("KANEFE_JIT", "1") != "0"

# What floating point may do: contract a * b + c, drop the sign of zero, multiply by a reciprocal. Not reorder sums, not
# assume that there are no infinities or NaN: a run that blows up must be seen.
RELAXED = {"contract", "nsz", "arcp"}

# A kernel is called by kernels only: without the wrappers for Python it compiles faster. None of them makes an array
# that outlives it, so that none counts references to arrays, which would cost more than half of a small evaluation.
INNER = {"error_model": "numpy", "no_cpython_wrapper": True, "no_cfunc_wrapper": True, "_nrt": False}

_OfLibrary: Any = ctypes._CFuncPtr  # type: ignore[attr-defined]  # the class of all functions that ctypes opens

_entries: dict[str, Any] = {}
_timers: list[Any] = []


def kernel(function: Function) -> Function:
    """Compile a function that other kernels call."""
    if not IS_COMPILED:
        return function
    import numba

    return numba.njit(fastmath=RELAXED, **INNER)(function)  # type: ignore[no-any-return]


def inlined(function: Function) -> Function:
    """Compile a small function into each place where it is called: its arguments stay in registers."""
    if not IS_COMPILED:
        return function
    import numba

    return numba.njit(fastmath=RELAXED, forceinline=True, **INNER)(function)  # type: ignore[no-any-return]


def expanded(function: Function) -> Function:
    """Have a function compiled as a part of each that calls it, and not by itself: that would take as long again.

    Of those that call most kernels; arguments that are None leave out code in it as in the one that calls it.
    """
    if not IS_COMPILED:
        return function
    import numba

    return numba.njit(inline="always")(function)  # type: ignore[no-any-return]


def vector_kernel(function: Function) -> Function:
    """Compile a function of long sums whose order may change, so that they use vector instructions."""
    if not IS_COMPILED:
        return function
    import numba

    return numba.njit(fastmath=RELAXED | {"reassoc"}, forceinline=True, **INNER)(function)  # type: ignore[no-any-return]


def entry(function: Function) -> Function:
    """Compile a function that Python calls, and keep the machine code on disk."""
    return _kept(function, {})


def entry_without_arrays(function: Function) -> Function:
    """Compile one that makes no array, and so counts no references to slices, half of a small evaluation."""
    return _kept(function, {"_nrt": False})


def _kept(function: Function, options: dict[str, Any]) -> Function:
    if not IS_COMPILED:
        return function
    import numba

    folder = _cache_folder()
    options |= {"error_model": "numpy", "fastmath": RELAXED, "nogil": True, "cache": folder is not None}
    with _kept_in(folder):
        compiled = numba.njit(**options)(function)
    if not _entries:
        _announce_compilation(folder)
    _entries[function.__qualname__] = compiled
    return compiled  # type: ignore[no-any-return]


def direct(function: Callable[..., Any], *arguments: Any) -> Callable[..., Any]:
    """Return an entry for arguments of these types only: to tell the type of a pointer takes 20 us in every call."""
    if not IS_COMPILED:
        return function
    import numba

    return function.compile(tuple(map(numba.typeof, arguments)))  # type: ignore[attr-defined,no-any-return]


@cache
def pointer(function: Function) -> Function:
    """Compile a function of a method of integration (see `kanefe.kernels.stepping`) to a pointer of one type for all.

    Kernels that call it need not be compiled for each. Made when it is first used. Functions of three arguments are
    those of `filler`.
    """
    if not IS_COMPILED:
        return function
    import numba
    from numba import types

    memory = types.int64[::1], types.float64[::1], types.float64[:, ::1], types.float64[:, ::1]
    signatures = {
        3: types.void(types.float64, types.float64[::1], types.float64[::1]),
        4: types.int64(*memory),
        6: types.void(*memory, types.float64, types.float64[::1]),
    }
    signature = signatures[function.__code__.co_argcount]
    folder = _cache_folder()
    with _kept_in(folder):
        return numba.cfunc(signature, error_model="numpy", fastmath=RELAXED, cache=folder is not None)(function)  # type: ignore[no-any-return]


def compiled(function: Callable[[float], float], label: str) -> Callable[[float], float]:
    """Compile a function of a number of the user; a ModelError names `label` if numba cannot."""
    if not IS_COMPILED or hasattr(function, "py_func"):
        return function
    import numba
    from numba import types

    try:
        return numba.njit(types.float64(types.float64))(function)  # type: ignore[no-any-return]
    except (numba.core.errors.NumbaError, TypeError) as error:
        reason = str(error).strip().splitlines()[-1]
        raise ModelError(
            f"the {label} cannot be compiled: {reason}. Remedy: use numbers, math and conditions alone, or leave it in "
            "Python, a Motion without compiled()"
        ) from error


def native(function: Function, kinds: tuple[str, ...]) -> Any:
    """Compile a function without a result to a C function, kept on disk; see `kanefe.kernels.addresses` for the kinds.

    Its address is ``.address``. Without compilation: the function itself.
    """
    if not IS_COMPILED:
        return function
    import numba
    from numba import types

    def of(kind: str) -> Any:
        value = getattr(types, kind.rstrip("*"))
        return types.CPointer(value) if kind.endswith("*") else value

    signature, folder = types.void(*map(of, kinds)), _cache_folder()
    with _kept_in(folder):
        return numba.cfunc(signature, error_model="numpy", fastmath=RELAXED, cache=folder is not None)(function)


def by_address(in_python: Callable[..., None]) -> Callable[..., None]:
    """Return what kernels call a C function by its address with: see `kanefe.kernels.calls`.

    `in_python` does the same where nothing is compiled.
    """
    if not IS_COMPILED:
        return in_python
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

    return call_address  # type: ignore[no-any-return]


def address_of(given: object, what: str) -> int:
    """Return the address of a C function of the user, for `kanefe.kernels.addresses`.

    Parameters
    ----------
    given : object
        A ``numba.cfunc``, a function of a library opened by ctypes or cffi, or the address itself. Whoever has the
        address keeps the function too.
    what : str
        For messages.

    Raises
    ------
    ModelError
        If it is none of these, or null.
    """
    found = _address(given)
    if not found:
        raise ModelError(
            f"{what} must be a compiled function, not {given!r}. Remedy: a numba.cfunc, a function of a library opened "
            "by ctypes or cffi, or its address"
        )
    return found


def check_functions(functions: Iterable[object], what: str) -> None:
    """Raise a ModelError if what should be functions of the house, addresses or None is none of them."""
    for function in functions:
        if function is not None and not callable(function) and not (isinstance(function, int) and function > 0):
            raise ModelError(
                f"a function of {what} must be the address of a C function, such as numba.cfunc(...).address, not "
                f"{function!r}"
            )


def _address(given: Any) -> int:
    if isinstance(given, bool):
        return 0
    if isinstance(given, numbers.Integral):
        return int(given)
    if isinstance(given, _OfLibrary):
        return ctypes.cast(given, ctypes.c_void_p).value or 0
    if type(given).__module__ == "_cffi_backend":
        cffi = sys.modules["_cffi_backend"].FFI()
        if cffi.typeof(given).kind in ("function", "pointer"):
            return int(cffi.cast("intptr_t", given))
    address = getattr(given, "address", None)  # a numba.cfunc
    return address if isinstance(address, int) else 0


Part = tuple[Callable[..., Any], int, int, bool]
"""A compiled function of the user, where its values go, how many they are (0: a number by itself), and takes it y."""


def _fill_nothing(t: float, y: Any, inputs: Any) -> None:
    return


@lru_cache(maxsize=64)
def filler(parts: tuple[Part, ...]) -> Callable[..., None]:
    """Return a function (t, y, inputs) that writes what compiled functions of the user give.

    It is a pointer to machine code with one type for all scenes, so that kernels which call it need not be compiled
    for each. Kept, since a scene is frozen anew for every run, which would wait for it.
    """
    if not parts:
        return pointer(_fill_nothing)
    if not IS_COMPILED:

        def fill(t: float, y: Any, inputs: Any) -> None:
            for function, at, count, takes_state in parts:
                inputs[at : at + max(count, 1)] = function(t, y) if takes_state else function(t)

        return fill
    import numba
    from numba import types

    chain = numba.njit(_fill_nothing)
    for part in parts:
        chain = _filler_of(part, chain)
    whole = chain
    signature = types.void(types.float64, types.float64[::1], types.float64[::1])
    return numba.cfunc(signature)(lambda t, y, inputs: whole(t, y, inputs))  # type: ignore[no-any-return]


def _filler_of(part: Part, rest: Callable[..., None]) -> Callable[..., None]:
    """Return a function that writes the values of one part, and then the rest."""
    import numba

    function, at, count, takes_state = part
    if takes_state:
        value = function
    else:

        @numba.njit
        def value(t: float, y: Any) -> Any:
            return function(t)

    if count == 0:

        @numba.njit
        def fill(t: float, y: Any, inputs: Any) -> None:
            inputs[at] = value(t, y)
            rest(t, y, inputs)

    else:

        @numba.njit
        def fill(t: float, y: Any, inputs: Any) -> None:
            values = value(t, y)
            for i in range(count):
                inputs[at + i] = values[i]
            rest(t, y, inputs)

    return fill  # type: ignore[no-any-return]


@contextmanager
def _kept_in(folder: Path | None) -> Iterator[None]:
    """Let numba keep what is compiled within in a folder."""
    import numba

    kept = numba.config.CACHE_DIR
    if folder is not None:
        numba.config.CACHE_DIR = str(folder)
    try:
        yield
    finally:
        numba.config.CACHE_DIR = kept


def _cache_folder() -> Path | None:
    """Return the folder of the compiled kernels, or None where none can be written."""
    folder = cache_folder() / "kernels" / _stamp(Path(__file__).parent)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return None
    return folder if os.access(folder, os.W_OK) else None


def _stamp(kernels: Path) -> str:
    """Return what names the code of all files in a folder and below: their paths and what is in them."""
    stamp = hashlib.sha256()
    for path in sorted(kernels.rglob("*.py")):
        if "__pycache__" not in path.relative_to(kernels).parts:
            content = path.read_bytes()
            stamp.update(f"{path.relative_to(kernels).as_posix()} {len(content)}\0".encode() + content)
    return stamp.hexdigest()[:16]


def _announce_compilation(folder: Path | None) -> None:
    """Print a line when a kernel is compiled, which takes seconds, and not when it is read from the cache."""
    from numba.core import event

    class Announcement(event.Listener):
        def on_start(self, happening: Any) -> None:
            dispatcher = happening.data["dispatcher"]
            name = dispatcher.py_func.__qualname__
            if _entries.get(name) is dispatcher:
                kept = f"kept in {folder}" if folder else "its cache cannot be written, so this happens in every run"
                print(
                    f"kanefe: compiling {name.replace('_', ' ')} for this kind of scene, 10 to 30 s, once ({kept})",
                    file=sys.stderr,
                    flush=True,
                )

        def on_end(self, happening: Any) -> None:
            """Nothing to say."""

    event.register("numba:compile", Announcement())
    _timers.append(event.TimingListener())
    event.register("numba:compiler_lock", _timers[0])


def seconds_compiling() -> float:
    """Return how long, since the process began, functions have been compiled or read from the cache."""
    return float(_timers[0].duration) if _timers and _timers[0].done else 0.0
