"""Functions that users have compiled by numba, adapted for runs: arguments checked, errors reported as values.

Machine code cannot raise to the run that calls it. What a function raises becomes NaN there, which the run takes for no
number: it calls the function once more from Python, where the error is raised, and named by the load.
"""

from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from kanefe.errors import ModelError
from kanefe.kernels.compiler._numba import INSIDE, IS_COMPILED, numba_for, timed
from kanefe.kernels.compiler.arrays import FILLER

Function = Callable[..., Any]


@lru_cache(maxsize=64)
def checked(function: Function) -> Function:
    """Return a compiled function of the user that raises an IndexError where it reads beyond the end of an array.

    numba leaves that out unless it is told, and reads what is in memory there.
    """
    options = {**function.targetoptions, "boundscheck": True}  # type: ignore[attr-defined]
    options.pop("nopython", None)  # njit says so itself
    return numba_for("a compiled function").njit(**options)(function.py_func)  # type: ignore[attr-defined, no-any-return]


def offered(function: Function, name: str, parameters: int) -> Function:
    """Return a function of the user compiled for the time, and for one or two arrays; a ModelError says why it is not.

    The first array is not to be written to.
    """
    if not IS_COMPILED:
        return function
    numba = numba_for("kanefe.compiled")
    from numba import types

    made = function if hasattr(function, "py_func") else numba.njit(function)
    arrays = types.Array(types.float64, 1, "C", readonly=True), types.float64[::1]
    try:
        checked(made).compile((types.float64, *arrays[: parameters - 1], *left_out(made)))  # type: ignore[attr-defined]
    except (numba.core.errors.NumbaError, TypeError, NotImplementedError) as error:
        raise ModelError(
            f"kanefe.compiled cannot compile {name!r}: {_reason(error)}. Remedy: what numba knows: numbers, arrays, "
            "math and numpy (reads.copy() to change it); or the function in Python, without kanefe.compiled"
        ) from error
    return made  # type: ignore[no-any-return]


def compiled_of_time(function: Callable[[float], float], label: str) -> Callable[[float], float]:
    """Compile a function of a number of the user; a ModelError names `label` if numba cannot."""
    if not IS_COMPILED or hasattr(function, "py_func"):
        return function
    numba = numba_for(f"the compiled {label}")
    from numba import types

    try:
        return numba.njit(types.float64(types.float64, *left_out(function)))(function)  # type: ignore[no-any-return]
    except (numba.core.errors.NumbaError, TypeError) as error:
        reason = str(error).strip().splitlines()[-1]
        raise ModelError(
            f"the {label} cannot be compiled: {reason}. Remedy: use numbers, math and conditions alone, or leave it in "
            "Python, a Motion without compiled()"
        ) from error


def left_out(function: Function) -> tuple[Any, ...]:
    """Return the types of the arguments that calls leave out: those with a default, as in ``lambda t, k=k: k * t``."""
    from numba.core.types import misc

    return tuple(map(misc.Omitted, getattr(function, "py_func", function).__defaults__ or ()))


def _reason(error: Exception) -> str:
    """Return the line of an error of numba that tells why."""
    told = [line.strip() for line in str(error).splitlines() if line.strip()] or [type(error).__name__]
    return next((line for line in told if not line.startswith("Failed in")), told[0])


@lru_cache(maxsize=64)
def controller_function(function: Function, counts: tuple[int, int, int], label: str) -> Any:
    """Return what a run calls for a sampled controller by its address: NaN where it raises, or gives another number.

    ``void f(double t, const double *reads, double *memory, double *drives)``, with the counts of the three. A
    ModelError names the label if the function can give no such drives.
    """
    reads, memory, drives = counts
    if not IS_COMPILED:
        from kanefe.kernels.compiler.addresses import stand_in

        def in_python(t: float, read: Any, kept: Any, out: Any) -> None:
            out[:drives] = function(t, read[:reads], kept[:memory])

        return stand_in(in_python)
    numba = numba_for(f"the function of {label}")
    from numba import types

    own, arrays = checked(function), (types.Array(types.float64, 1, "C", readonly=True), types.float64[::1])
    own.compile((types.float64, *arrays, *left_out(function)))  # type: ignore[attr-defined]
    given = own.nopython_signatures[0].return_type  # type: ignore[attr-defined]
    written = ", ".join(f"float(given[{i}])" for i in range(drives))
    source = "(float(given),)" if isinstance(given, (types.Number, types.Boolean)) else f"({written},)"
    count = 1 if isinstance(given, (types.Number, types.Boolean)) else getattr(given, "count", drives)
    if count != drives:
        raise ModelError(f"the compiled function of {label} gives {count} numbers for {drives} drives")
    as_numbers = numba.njit(eval(f"lambda given: {source}"))
    has_length = isinstance(given, types.Array)
    length = numba.njit((lambda given: len(given)) if has_length else (lambda given: drives))

    def call(t: float, read_at: Any, kept_at: Any, out_at: Any) -> None:
        out = numba.carray(out_at, (drives,))
        try:
            given = own(t, numba.carray(read_at, (reads,)), numba.carray(kept_at, (memory,)))
            found = as_numbers(given)
            for i in range(drives):
                out[i] = found[i] if length(given) == drives else np.nan
        except Exception:  # noqa: BLE001 - numba knows no other
            out[0] = np.nan

    place = types.CPointer(types.float64)
    try:
        return numba.cfunc(types.void(types.float64, place, place, place))(call)
    except numba.core.errors.NumbaError as error:
        raise ModelError(
            f"the compiled function of {label} does not give a number for each of {drives} drives: {_reason(error)}. "
            "Remedy: one number, a tuple or an array"
        ) from error


class Given(NamedTuple):
    """What a compiled function of a load gives, and what it is given.

    Attributes
    ----------
    values : int
        How many numbers it gives; 0: one by itself.
    size : int or None
        Of the state (q, u, z) that it takes, the first numbers of y; None: it is one of the time.
    terms : tuple or None
        What it reads in place of y: of each number places in y and their factors.
    axes : tuple or None
        Matrix (3, 3), row by row, by which three components are multiplied.
    """

    values: int
    size: int | None
    terms: tuple[tuple[tuple[int, float], ...], ...] | None = None
    axes: tuple[float, ...] | None = None


def guarded(function: Function, label: str, given: Given) -> Function:
    """Return a compiled function as `kanefe.kernels.compiler.filling` takes it: NaN where it raises.

    Parameters
    ----------
    function : callable
        Of the user, f(t), f(t, y) or f(t, reads).
    label : str
        Of the load, for messages.
    given : Given

    Raises
    ------
    ModelError
        Naming the load, if it cannot be compiled to give that.
    """
    if not IS_COMPILED:
        return _in_python(function, given)
    numba = numba_for(f"the function of {label}")
    from numba import types

    size = given.size
    if size is not None:
        _check_reads(function, label)
    try:
        made = _guarded(function, given)
        made.compile((types.float64,) if size is None else (types.float64, types.float64[::1]))  # type: ignore[attr-defined]
    except numba.core.errors.NumbaError as error:
        wanted = f"{given.values} numbers, as a tuple or an array" if given.values else "one number"
        form = "f(t)" if size is None else "f(t, y) with the array y = (q, u, z)"
        form = form if given.terms is None else "f(t, reads)"
        raise ModelError(
            f"the compiled function of {label} cannot be called as {form} that gives {wanted}: {_reason(error)}. "
            "Remedy: what numba can compile, or the function in Python, without njit"
        ) from error
    return made


@lru_cache(maxsize=64)
def _reading(function: Function) -> Function:
    """Return a checked function of time and state, compiled for a state that it cannot write to, and for nothing else.

    In compiled code it is given the state of the run itself.
    """
    numba = numba_for("a compiled function")
    from numba import types

    state = types.Array(types.float64, 1, "C", readonly=True)
    plain, options = function.py_func, checked(function).targetoptions  # type: ignore[attr-defined]
    options = {name: value for name, value in options.items() if name != "nopython"}
    return numba.njit([(types.float64, state, *left_out(function))], **options, **INSIDE)(plain)  # type: ignore[no-any-return]


def _check_reads(function: Function, label: str) -> None:
    """Raise a ModelError if a function of time and state can be compiled only if it may write to the state."""
    numba = numba_for("a compiled function")
    try:
        _reading(function)
    except Exception as error:
        try:
            checked(function).compile((numba.float64, numba.float64[::1], *left_out(function)))  # type: ignore[attr-defined]
        except numba.core.errors.NumbaError:
            return  # there is more amiss with it
        raise ModelError(
            f"the compiled function of {label} takes the state y only if it may write to it, which is that of the run. "
            "Remedy: let it work on a copy, y.copy()"
        ) from error


def _in_python(function: Function, given: Given) -> Function:
    """Return the same where nothing is compiled."""
    if given.terms is None and given.axes is None:
        return function
    axes = np.eye(3) if given.axes is None else np.array(given.axes).reshape(3, 3)

    def value(t: float, *states: Any) -> Any:
        read = [np.array([sum(c * y[i] for i, c in own) for own in given.terms]) for y in states if given.terms]
        found = function(t, *(read or states))
        return axes @ found if given.values else found

    return value


def _reader(terms: tuple[tuple[tuple[int, float], ...], ...]) -> Function:
    """Return what gives sums of numbers of a state as an array."""
    import numba

    ends = np.cumsum([0, *map(len, terms)])
    places = np.array([place for own in terms for place, _ in own], dtype=np.int64)
    factors = np.array([factor for own in terms for _, factor in own], dtype=float)

    @numba.njit(**INSIDE)
    def read(y: Any) -> Any:
        found = np.zeros(len(ends) - 1)
        for i in range(len(found)):
            for k in range(ends[i], ends[i + 1]):
                found[i] += factors[k] * y[places[k]]
        return found

    return read  # type: ignore[no-any-return]


@lru_cache(maxsize=64)
def _guarded(function: Function, given: Given) -> Function:
    """Return the function with what it raises as NaN; the same one for each scene, which is compiled once."""
    size, axes = given.size, given.axes
    numba = numba_for("a compiled function")
    own = checked(function) if size is None else _reading(function)
    called = numba.njit(**INSIDE)((lambda t, y: own(t)) if size is None else (lambda t, y: own(t, y[:size])))
    if given.terms is not None:
        read = _reader(given.terms)
        called = numba.njit(**INSIDE)(lambda t, y: own(t, read(y)))

    @numba.njit(**INSIDE)
    def turned(x: float, y: float, z: float) -> Any:
        if axes is None:
            return x, y, z
        a = axes
        return a[0] * x + a[1] * y + a[2] * z, a[3] * x + a[4] * y + a[5] * z, a[6] * x + a[7] * y + a[8] * z

    def number(t: float, y: Any) -> Any:
        try:
            return float(called(t, y))
        except Exception:  # noqa: BLE001 - numba knows no other
            return np.nan

    def three(t: float, y: Any) -> Any:
        try:
            found = called(t, y)
            return turned(float(found[0]), float(found[1]), float(found[2]))
        except Exception:  # noqa: BLE001 - numba knows no other
            return np.nan, np.nan, np.nan

    value = numba.njit(**INSIDE)(three if given.values else number)
    none = np.zeros(0)
    return numba.njit(**INSIDE)(lambda t: value(t, none)) if size is None else value  # type: ignore[no-any-return]


Part = tuple[Callable[..., Any], int, int, bool]
"""A compiled function of the user, the position and number of its values (0: a scalar), and whether it takes y."""


@lru_cache(maxsize=64)
def compiled_filler(parts: tuple[Part, ...]) -> Callable[..., None]:
    """Return a function (t, y, inputs) that writes what compiled functions of the user give, of which there are some.

    It is a pointer to machine code with one type for all scenes, so that kernels which call it need not be compiled
    for each. Kept, since a scene is frozen anew for every run, which would wait for it.
    """
    if not IS_COMPILED:

        def fill(t: float, y: Any, inputs: Any) -> None:
            for function, at, count, takes_state in parts:
                inputs[at : at + max(count, 1)] = function(t, y) if takes_state else function(t)

        return fill
    numba = numba_for("a compiled function")
    from kanefe.kernels.compiler._numba_pointers import c_function, c_signature

    chain = numba.njit(**INSIDE)(lambda t, y, inputs: None)
    for part in parts:
        chain = _filler_of(part, chain)
    with timed():
        return _CompiledFiller(numba.cfunc(c_signature(FILLER))(c_function(chain, FILLER)))


class _CompiledFiller:
    """A compiled function (t, y, inputs), for Python and, by its address, for kernels."""

    def __init__(self, in_c: Any) -> None:
        self._in_c = in_c  # which keeps the machine code
        self.address: int = in_c.address

    def __call__(self, t: float, y: Any, inputs: Any) -> None:
        from kanefe.kernels.compiler.addresses import call_in_python

        state = np.ascontiguousarray(y, dtype=float)
        call_in_python(self.address, (float(t), state, len(state), inputs, len(inputs)))


def _filler_of(part: Part, rest: Callable[..., None]) -> Callable[..., None]:
    """Return a function that writes the values of one part, and then the rest."""
    import numba

    function, at, count, takes_state = part
    if takes_state:
        value = function
    else:

        @numba.njit(**INSIDE)
        def value(t: float, y: Any) -> Any:
            return function(t)

    if count == 0:

        @numba.njit(**INSIDE)
        def fill(t: float, y: Any, inputs: Any) -> None:
            inputs[at] = value(t, y)
            rest(t, y, inputs)

    else:

        @numba.njit(**INSIDE)
        def fill(t: float, y: Any, inputs: Any) -> None:
            values = value(t, y)
            for i in range(count):
                inputs[at + i] = values[i]
            rest(t, y, inputs)

    return fill  # type: ignore[no-any-return]
