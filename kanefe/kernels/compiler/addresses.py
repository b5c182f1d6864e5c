"""C functions that kernels call by their address: those of the house, and those of the user.

An address is an integer in the tables of a scene, never a constant of compiled code, so that one compiled kernel serves
all functions. Arguments are numbers, passed by value, and contiguous arrays, passed as the pointer to their first
number; a complex number is passed in an array, as a pair of real ones. There is no result: functions write to arrays.
Kernels call them with `kanefe.kernels.compiler.calls.call_address`; `kanefe.kernels.compiler.foreign.address_of` finds
those of the user.
"""

import ctypes
from collections.abc import Callable
from functools import cache
from typing import Any, TypeVar

import numpy as np

from kanefe.kernels.compiler._numba import IS_COMPILED
from kanefe.kernels.compiler._numba_objects import compiled_function
from kanefe.kernels.compiler.compiled_functions import CompiledFunction, machine_code

Function = TypeVar("Function", bound=Callable[..., Any])

# Kinds of arguments of a function of the house: see `house_address`
INTEGER, NUMBER = "int64", "float64"
INTEGERS, NUMBERS, COMPLEX_NUMBERS = "int64*", "float64*", "complex128*"
VALUES = "float64* or complex128*"
"""Type of a function that exists twice, see `addresses`: its numbers are complex where those of the scene are."""

_in_python: dict[int, Callable[..., None]] = {}
"""Functions of the library by their substitute for an address, a negative number, if nothing is compiled."""


def called_by_address(*kinds: str) -> Callable[[Function], Function]:
    """Mark a function of the house that loads or links name, with the kinds of its arguments; see `house_address`."""

    def mark(function: Function) -> Function:
        function.kinds = kinds  # type: ignore[attr-defined]
        return function

    return mark


def compiled_functions_of(function: Callable[..., None], kinds: tuple[str, ...]) -> list[CompiledFunction]:
    """Return what is built for a function of the house: for real and for complex numbers, where it takes VALUES."""
    forms = [tuple(form if kind == VALUES else kind for kind in kinds) for form in (NUMBERS, COMPLEX_NUMBERS)]
    return [_unit(function, form) for form in dict.fromkeys(forms)]


def _unit(function: Callable[..., None], kinds: tuple[str, ...]) -> CompiledFunction:
    name = f"{function.__name__}-{'complex' if COMPLEX_NUMBERS in kinds else 'real'}"
    return CompiledFunction(name, function.__module__, lambda: compiled_function(function, kinds))


@cache
def house_address(function: Callable[..., None], *kinds: str) -> int:
    """Return the address of a function of the library, compiled at the first request.

    Parameters
    ----------
    function : callable
        Of numbers and of pointers, which it may index alone; it returns nothing.
    kinds : str
        INTEGER, NUMBER, INTEGERS, NUMBERS or COMPLEX_NUMBERS, one for each argument.
    """
    return machine_code(_unit(function, kinds)).address if IS_COMPILED else stand_in(function)


def stand_in(function: Callable[..., None]) -> int:
    """Return what stands for the address of a function where nothing is compiled."""
    number = -1 - len(_in_python)
    _in_python[number] = function
    return number


def addresses(
    real: Callable[..., None] | int, complex_: Callable[..., None] | int | None, signature: tuple[str, ...]
) -> tuple[int, int]:
    """Return the addresses of a function for real and for complex numbers, 0 if there is none for them.

    Functions are those of the house, compiled when they are first used; whole numbers are addresses already. The kinds
    of arguments are those of `house_address`, and VALUES.
    """

    def address(function: Callable[..., None] | int, values: str) -> int:
        if isinstance(function, int):
            return function
        return house_address(function, *(values if kind == VALUES else kind for kind in signature))

    return address(real, NUMBERS), 0 if complex_ is None else address(complex_, COMPLEX_NUMBERS)


def call_in_python(address: int, arguments: tuple[Any, ...]) -> None:
    """Do in Python what `kanefe.kernels.compiler.calls.call_address` does in compiled code."""
    if address in _in_python:
        _in_python[address](*arguments)
        return
    kinds: list[Any] = []
    given: list[Any] = []
    for argument in arguments:
        if isinstance(argument, np.ndarray):
            kinds.append(ctypes.c_void_p)
            given.append(argument.ctypes.data)
        else:
            kinds.append(ctypes.c_int64 if isinstance(argument, (int, np.integer)) else ctypes.c_double)
            given.append(argument)
    ctypes.CFUNCTYPE(None, *kinds)(int(address))(*given)


LAW_NUMBERS = 5
"""Numbers that a law of the user writes: see `kanefe.kernels.contact.laws.compiled_law.CompiledLaw`."""


def law_in_python(address: int, depth: float, rate: float, numbers: Any, at: int) -> tuple[float, ...]:
    """Do in Python what `kanefe.kernels.compiler.calls.call_law` does in compiled code."""
    written = np.zeros(LAW_NUMBERS)
    own = np.ascontiguousarray(numbers[at:])
    _law_at(int(address))(depth, rate, own.ctypes.data, written.ctypes.data)
    return tuple(written.tolist())


@cache
def _law_at(address: int) -> Callable[..., None]:
    return ctypes.CFUNCTYPE(None, ctypes.c_double, ctypes.c_double, ctypes.c_void_p, ctypes.c_void_p)(address)
