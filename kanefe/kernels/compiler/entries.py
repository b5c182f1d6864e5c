"""Kernels that are called from outside: from Python, or by other kernels through prepared calls.

`entry` declares one, with the numbers that it is built for, real or complex ones. It is called in three ways, the
later the faster: once; `bound` to what stays the same; or `prepared`, with arrays that stay where they are.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator
from enum import Enum, auto
from functools import cached_property, partial
from typing import Any

import numpy as np

from kanefe.kernels.compiler._numba import IS_COMPILED
from kanefe.kernels.compiler._numba_objects import compiled_entry, compiled_pointer
from kanefe.kernels.compiler.arrays import Prepared
from kanefe.kernels.compiler.compiled_functions import CompiledFunction, MachineCode, machine_code
from kanefe.kernels.compiler.signatures import (
    BOOLEAN,
    COMPLEX,
    INTEGER,
    NUMBER,
    REAL,
    Group,
    Numbers,
    Part,
    Signature,
    signature_of,
    wrapper_source,
)


class _Argument(Enum):
    LATER = auto()


LATER: Any = _Argument.LATER
"""Mark of an argument that is given in each call."""


class Entry:
    """A kernel that is called from outside.

    Parameters
    ----------
    function : function
        With annotations of `kanefe.kernels.compiler.arrays`.
    numbers : tuple of Numbers
        What its values may be.

    Attributes
    ----------
    function : function
    numbers : tuple of Numbers
    """

    def __init__(self, function: Callable[..., Any], numbers: tuple[Numbers, ...]) -> None:
        self.function, self.numbers = function, numbers
        self.__name__, self.__qualname__ = function.__name__, function.__qualname__
        self.__module__, self.__doc__ = function.__module__, function.__doc__
        self._names = function.__code__.co_varnames[: function.__code__.co_argcount]

    def __reduce__(self) -> str:
        return self.__qualname__

    def __call__(self, *arguments: Any) -> Any:
        """Call it once: what is called often is bound first."""
        return self.bound(*arguments)()

    def unit(self, values: Numbers = REAL) -> CompiledFunction:
        """Return what is built for values of some kind."""
        is_complex = values is COMPLEX

        def compile_() -> Any:
            return compiled_entry(self.function, *wrapper_source(signature_of(self.function, values)))

        return CompiledFunction(self.__name__ + "-complex" * is_complex, self.__module__, compile_, is_complex)

    @property
    def units(self) -> list[CompiledFunction]:
        """All that is built for it."""
        return [self.unit(values) for values in self.numbers]

    def bound(self, *arguments: Any, is_complex: bool = False) -> Bound:
        """Return it with arguments that stay the same; in the place of others is LATER.

        `is_complex`: whether values are complex.
        """
        return Bound(self, COMPLEX if is_complex else REAL, arguments)


class Bound:
    """An entry with arguments that stay the same. Calls from several threads do not meet.

    Parameters
    ----------
    entry : Entry
    values : Numbers
    arguments : tuple
        LATER for those that come with each call.
    """

    def __init__(self, entry: Entry, values: Numbers, arguments: tuple[Any, ...]) -> None:
        self._entry, self._values, self._arguments = entry, values, arguments
        self._signature = signature = signature_of(entry.function, values)
        places = (ctypes.c_int64 * max(signature.place_count, 1))()
        numbers = (ctypes.c_double * max(signature.number_room, 1))()
        self._later: list[Part] = []
        for part, value in zip(signature.parts, arguments, strict=True):
            if value is LATER:
                self._later.append(part)
            else:
                _write(part, value, places, numbers)
        self._places, self._numbers = places, numbers

    @property
    def unit(self) -> CompiledFunction:
        """What is built for it."""
        return self._entry.unit(self._values)

    def __reduce__(self) -> tuple[Any, ...]:
        return Bound, (self._entry, self._values, self._arguments)

    def __call__(self, *later: Any) -> Any:
        """Call it with the arguments that were left out; return what the kernel returns."""
        return self.prepared(*later)()

    def prepared(self, *later: Any) -> Call:
        """Return the call with the arguments that were left out."""
        places = type(self._places).from_buffer_copy(self._places)
        numbers = type(self._numbers).from_buffer_copy(self._numbers)
        for part, value in zip(self._later, later, strict=True):
            _write(part, value, places, numbers)
        return Call(self, later, places, numbers)

    def write(self, later: tuple[Any, ...], places: Any, numbers: Any, before: tuple[Any, ...]) -> None:
        """Write the arguments that were left out to the places of a call, but for objects that it had before."""
        for part, value, old in zip(self._later, later, before, strict=True):
            if value is old:
                continue
            if isinstance(part, Group):
                for inner, item, one in zip(part.parts, value, old, strict=True):
                    if item is not one or isinstance(item, (int, float)):  # which may have been written in place
                        _write(inner, item, places, numbers)
            else:
                _write(part, value, places, numbers)

    @cached_property
    def code(self) -> MachineCode:
        """What is called."""
        return machine_code(self.unit)

    @property
    def signature(self) -> Signature:
        """Where everything is."""
        return self._signature

    def with_later(self, later: tuple[Any, ...]) -> tuple[Any, ...]:
        """Return all arguments, those that were left out filled in."""
        rest = iter(later)
        return tuple(next(rest) if value is LATER else value for value in self._arguments)

    def in_python(self, later: tuple[Any, ...], places: Any, numbers: Any) -> None:
        """Do in Python what a call does where nothing is compiled: scalars are read when it is called."""
        signature, given = self._signature, self.with_later(later)
        taken = [_read(part, value, places, numbers) for part, value in zip(signature.parts, given, strict=True)]
        found = self._entry.function(*taken)
        if signature.result:
            numbers[signature.number_count : signature.number_room] = found if len(signature.result) > 1 else [found]


class Call:
    """A call with all its arguments, whose arrays stay where they are: of one thread at a time.

    Attributes
    ----------
    places, numbers : ctypes arrays
        See `kanefe.kernels.compiler.signatures`: scalars among them may be written before each call.
    run : function
        Does it; what is returned is then among the numbers.
    """

    def __init__(self, bound: Bound, later: tuple[Any, ...], places: Any, numbers: Any) -> None:
        self._bound, self._later = bound, later  # which keep the memory of the arrays
        self.places, self.numbers = places, numbers
        self.run: Callable[[], Any] = self._in_python
        if IS_COMPILED:
            self.run = partial(bound.code.call, ctypes.byref(places), ctypes.byref(numbers))
        signature = bound.signature
        self._found = slice(signature.number_count, signature.number_room)
        self._others = [(i, kinds[kind]) for i, kind in enumerate(signature.result) if kind != NUMBER]

    def __call__(self) -> Any:
        """Call it; return what the kernel returns."""
        self.run()
        found = self.numbers[self._found]
        for i, kind in self._others:
            found[i] = kind(found[i])
        return tuple(found) if len(found) > 1 else found[0] if found else None

    def _in_python(self) -> None:
        self._bound.in_python(self._later, self.places, self.numbers)

    def give(self, *later: Any) -> None:
        """Let it have other arguments in place of those that were left out; the same object stays as it is."""
        self._bound.write(later, self.places, self.numbers, self._later)
        self._later = later

    @property
    def signature(self) -> Signature:
        """Where everything is."""
        return self._bound.signature

    @property
    def arguments(self) -> tuple[Any, ...]:
        """What the kernel is given, in the order of its parameters."""
        return self._bound.with_later(self._later)

    @property
    def address(self) -> int:
        """Where its machine code is."""
        return self._bound.code.address

    def for_kernels(self) -> Prepared:
        """Return the call as kernels take it: what is returned keeps it."""
        if IS_COMPILED:
            address = self._bound.code.address
        else:
            from kanefe.kernels.compiler.addresses import stand_in

            address = stand_in(lambda places, numbers: self._bound.in_python(self._later, places, numbers))
        places, numbers = (
            np.asarray(_Memory(self, array, kind)) for array, kind in ((self.places, "<i8"), (self.numbers, "<f8"))
        )
        return Prepared(address, places, numbers)


class _Memory:
    """Memory of a call as numpy takes it: an array made from it keeps the call, and knows it."""

    def __init__(self, call: Call, array: Any, kind: str) -> None:
        self.call = call
        where = ctypes.addressof(array), False
        self.__array_interface__ = {"version": 3, "data": where, "shape": (len(array),), "typestr": kind}


def calls_in(value: Any) -> Iterator[Call]:
    """Return the calls that a kernel makes by their addresses, of an argument of its own."""
    if isinstance(value, Prepared):
        memory: Any = value.places.base
        if isinstance(memory, _Memory):  # else it is the one that stands for none
            yield memory.call
    elif isinstance(value, tuple):
        for item in value:
            yield from calls_in(item)


CHARACTERS = {kind: np.dtype(kind).char for kind in ("int64", "float64", "complex128")}


def _write(part: Part, value: Any, places: Any, numbers: Any) -> None:
    """Write an argument to its places; where nothing is compiled scalars alone, which are read there."""
    if isinstance(part, Group):
        for inner, item in zip(part.parts, value, strict=True):
            _write(inner, item, places, numbers)
        return
    kind, axes, at = part
    if axes > 0:  # most are arrays
        if IS_COMPILED:
            places[at] = _address(value, axes, kind)
            for length in value.shape:
                at += 1
                places[at] = length
    elif axes == 0:
        (numbers if part.is_number else places)[at] = value
    elif IS_COMPILED:
        places[at] = value.address


def _read(part: Part, value: Any, places: Any, numbers: Any) -> Any:
    """Return an argument with its scalars as they are in its places by now."""
    if isinstance(part, Group):
        return part.of(*(_read(inner, item, places, numbers) for inner, item in zip(part.parts, value, strict=True)))
    if part.axes != 0:
        return value
    return numbers[part.at] if part.is_number else kinds[part.kind](places[part.at])


def _address(array: np.ndarray, axes: int, kind: str) -> int:
    """Return where the numbers of an array are; a TypeError says that it is not of the kind declared."""
    if array.dtype.char == CHARACTERS[kind] and array.ndim == axes:
        if array.size == 0:
            return 0
        try:
            return ctypes.addressof(ctypes.c_char.from_buffer(array))  # type: ignore[arg-type]  # half the time of numpy's
        except TypeError:  # read-only, or in pieces
            if array.flags.c_contiguous:
                return array.__array_interface__["data"][0]  # type: ignore[no-any-return]
    raise TypeError(f"a kernel wants a contiguous {kind} array of {axes} axes, not {array.dtype} {array.shape}")


kinds: dict[str, Callable[[Any], Any]] = {INTEGER: int, BOOLEAN: bool}


def entry(*numbers: Numbers) -> Callable[[Callable[..., Any]], Entry]:
    """Declare a kernel that is called from outside: of real numbers, if nothing else is said."""
    return lambda function: Entry(function, numbers or (REAL,))


class Pointer:
    """A kernel that others call by its address, one of a type that all methods, or all scenes, share.

    Parameters
    ----------
    function : function
    kind : str
        Name of the type, see `kanefe.kernels.compiler.arrays`.
    """

    def __init__(self, function: Callable[..., Any], kind: str) -> None:
        self.function, self.kind = function, kind
        self.__name__, self.__qualname__ = function.__name__, function.__qualname__
        self.__module__, self.__doc__ = function.__module__, function.__doc__

    def __reduce__(self) -> str:
        return self.__qualname__

    def __call__(self, *arguments: Any) -> Any:
        """Call the plain function."""
        return self.function(*arguments)

    @property
    def unit(self) -> CompiledFunction:
        """What is built for it."""
        function, kind = self.function, self.kind
        return CompiledFunction(self.__name__, self.__module__, lambda: compiled_pointer(function, kind))

    @property
    def units(self) -> list[CompiledFunction]:
        """All that is built for it."""
        return [self.unit]

    @property
    def address(self) -> int:
        """Where its machine code is."""
        return machine_code(self.unit).address


def pointer(kind: str) -> Callable[[Callable[..., Any]], Pointer]:
    """Declare a kernel that is called by its address."""
    return lambda function: Pointer(function, kind)
