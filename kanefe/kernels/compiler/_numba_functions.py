"""Functions that users have compiled by numba, adapted for runs: arguments checked, errors reported as values.

Machine code cannot raise to the run that calls it. What a function raises becomes NaN there, which the run takes for no
number: it calls the function once more from Python, where the error is raised, and named by the load.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np

from kanefe.errors import ModelError
from kanefe.kernels.compiler._numba import IS_COMPILED, numba_for

Function = Callable[..., Any]


@lru_cache(maxsize=64)
def checked(function: Function) -> Function:
    """Return a compiled function of the user that raises an IndexError where it reads beyond the end of an array.

    numba leaves that out unless it is told, and reads what is in memory there.
    """
    options = {**function.targetoptions, "boundscheck": True}  # type: ignore[attr-defined]
    options.pop("nopython", None)  # njit says so itself
    return numba_for("a compiled function").njit(**options)(function.py_func)  # type: ignore[attr-defined, no-any-return]


def guarded(function: Function, label: str, count: int, size: int | None) -> Function:
    """Return a compiled function as `kanefe.kernels.compiler.filling` takes it: NaN where it raises.

    Parameters
    ----------
    function : callable
        Of the user, f(t) or f(t, y).
    label : str
        Of the load, for messages.
    count : int
        How many numbers it gives; 0: one by itself.
    size : int or None
        Of the state (q, u, z) that it takes, the first numbers of y; None: it is one of the time.

    Raises
    ------
    ModelError
        Naming the load, if it cannot be compiled to give that.
    """
    if not IS_COMPILED:
        return function
    numba = numba_for(f"the function of {label}")
    from numba import types

    if size is not None:
        _check_reads(function, label)
    try:
        made = _guarded(function, count, size)
        made.compile((types.float64,) if size is None else (types.float64, types.float64[::1]))  # type: ignore[attr-defined]
    except numba.core.errors.NumbaError as error:
        told = [line.strip() for line in str(error).splitlines() if line.strip()]
        reason = next((line for line in told if not line.startswith("Failed in")), told[0])
        wanted = f"{count} numbers, as a tuple or an array" if count else "one number"
        given = "f(t)" if size is None else "f(t, y) with the array y = (q, u, z)"
        raise ModelError(
            f"the compiled function of {label} cannot be called as {given} that gives {wanted}: {reason}. Remedy: what "
            "numba can compile, or the function in Python, without njit"
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
    return numba.njit([(types.float64, state)], **options)(plain)  # type: ignore[no-any-return]


def _check_reads(function: Function, label: str) -> None:
    """Raise a ModelError if a function of time and state can be compiled only if it may write to the state."""
    numba = numba_for("a compiled function")
    try:
        _reading(function)
    except Exception as error:
        try:
            checked(function).compile((numba.float64, numba.float64[::1]))  # type: ignore[attr-defined]
        except numba.core.errors.NumbaError:
            return  # there is more amiss with it
        raise ModelError(
            f"the compiled function of {label} takes the state y only if it may write to it, which is that of the run. "
            "Remedy: let it work on a copy, y.copy()"
        ) from error


@lru_cache(maxsize=64)
def _guarded(function: Function, count: int, size: int | None) -> Function:
    """Return the function with what it raises as NaN; the same one for each scene, which is compiled once."""
    numba = numba_for("a compiled function")
    own = checked(function) if size is None else _reading(function)
    called = numba.njit((lambda t, y: own(t)) if size is None else (lambda t, y: own(t, y[:size])))

    def number(t: float, y: Any) -> Any:
        try:
            return float(called(t, y))
        except Exception:  # noqa: BLE001 - numba knows no other
            return np.nan

    def three(t: float, y: Any) -> Any:
        try:
            given = called(t, y)
            return float(given[0]), float(given[1]), float(given[2])
        except Exception:  # noqa: BLE001 - numba knows no other
            return np.nan, np.nan, np.nan

    value = numba.njit(three if count else number)
    none = np.zeros(0)
    return numba.njit(lambda t: value(t, none)) if size is None else value  # type: ignore[no-any-return]
