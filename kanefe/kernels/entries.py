"""Kernels that are called from outside: from Python, or by other kernels through prepared calls.

`entry` declares one, with the variants that it is built in: optional parameters that are None leave out their code. A
scene takes the smallest variant that has what it needs, and empty tables for what it does not.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterable, Mapping
from enum import Enum, auto
from functools import cached_property
from typing import Any

import numpy as np

from kanefe.kernels._numba import IS_COMPILED
from kanefe.kernels._numba_objects import compiled_entry, compiled_pointer
from kanefe.kernels.arrays import Prepared
from kanefe.kernels.signatures import (
    BOOLEAN,
    INTEGER,
    NUMBER,
    Group,
    Leaf,
    Part,
    Signature,
    Variant,
    signature_of,
    wrapper_source,
)
from kanefe.kernels.units import MachineCode, Unit, machine_code


class _Argument(Enum):
    LATER = auto()


LATER: Any = _Argument.LATER
"""An argument that comes with each call."""


class Entry:
    """A kernel that is called from outside.

    Parameters
    ----------
    function : function
        With annotations of `kanefe.kernels.arrays`.
    variants : iterable of Variant
        From the smallest to the largest.
    empty : mapping of str to named tuple
        What stands for None in a variant that takes a table where the scene has none.

    Attributes
    ----------
    function : function
    variants : tuple of Variant
    """

    def __init__(
        self, function: Callable[..., Any], variants: Iterable[Variant], empty: Mapping[str, Callable[[], Any]]
    ) -> None:
        self.function, self.variants, self._empty = function, tuple(variants), empty
        self.__name__, self.__qualname__ = function.__name__, function.__qualname__
        self.__module__, self.__doc__ = function.__module__, function.__doc__
        self._names = function.__code__.co_varnames[: function.__code__.co_argcount]

    def __reduce__(self) -> str:
        return self.__qualname__

    def __call__(self, *arguments: Any) -> Any:
        """Call it once: what is called often is bound first."""
        return self.bound(*arguments)()

    def unit(self, variant: Variant) -> Unit:
        """Return what is built for a variant."""
        name = f"{self.__name__}-{variant.label}".rstrip("-")
        source = wrapper_source(signature_of(self.function, variant))
        return Unit(name, self.__module__, lambda: compiled_entry(self.function, *source))

    def bound(self, *arguments: Any, is_complex: bool = False) -> Bound:
        """Return it with arguments that stay the same; in the place of others is LATER.

        `is_complex`: whether values are complex.
        """
        given = {name for name, value in zip(self._names, arguments, strict=True) if value is not None}
        variant = next(v for v in self.variants if v.is_complex == is_complex and self._serves(v, given))
        taken = [
            self._empty[name]() if value is None and name in variant.given else value
            for name, value in zip(self._names, arguments, strict=True)
        ]
        return Bound(self, variant, taken)

    def _serves(self, variant: Variant, given: set[str]) -> bool:
        signature = signature_of(self.function, variant)
        return all(
            part is not None or name not in given for name, part in zip(signature.names, signature.parts, strict=True)
        )


class Bound:
    """An entry with arguments that stay the same. Calls from several threads do not meet.

    Parameters
    ----------
    entry : Entry
    variant : Variant
    arguments : list
        LATER for those that come with each call.
    """

    def __init__(self, entry: Entry, variant: Variant, arguments: list[Any]) -> None:
        self._entry, self._variant, self._arguments = entry, variant, arguments
        self._signature = signature = signature_of(entry.function, variant)
        if not IS_COMPILED:
            return
        places, numbers = _written(signature, arguments)
        self._places, self._numbers = places.tobytes(), numbers.tobytes()
        self._Places, self._Numbers = ctypes.c_int64 * len(places), ctypes.c_double * len(numbers)
        self._later = [part for part, given in zip(signature.parts, arguments, strict=True) if given is LATER]
        # of scalars and arrays; of all else as if they were functions
        self._plan = [(p.at, p.axes, p.kind) if isinstance(p, Leaf) else (0, -1, "") for p in self._later]

    @property
    def unit(self) -> Unit:
        """What is built for it."""
        return self._entry.unit(self._variant)

    def __reduce__(self) -> tuple[Any, ...]:
        return Bound, (self._entry, self._variant, self._arguments)

    def __call__(self, *later: Any) -> Any:
        """Call it with the arguments that were left out; return what the kernel returns."""
        if not IS_COMPILED:
            return self._entry.function(*self._all(later))
        places, numbers = self._Places.from_buffer_copy(self._places), self._Numbers.from_buffer_copy(self._numbers)
        for (at, axes, kind), part, value in zip(self._plan, self._later, later, strict=True):
            if axes > 0:
                places[at] = _address(value, axes, kind)
                places[at + 1 : at + 1 + axes] = value.shape
            elif axes == 0:
                if kind == NUMBER:
                    numbers[at] = value
                else:
                    places[at] = value
            else:
                _write(part, value, places, numbers)
        self._code.call(places, numbers)
        return _returned(self._signature, numbers)

    @cached_property
    def _code(self) -> MachineCode:
        return machine_code(self.unit)

    def prepared(self, *later: Any) -> tuple[Prepared, Any]:
        """Return the call for kernels, and what has to be kept as long as it is used."""
        arguments = self._all(later)
        places, numbers = _written(self._signature, arguments) if IS_COMPILED else _blank(self._signature)
        if IS_COMPILED:
            return Prepared(self._code.address, places, numbers), arguments
        from kanefe.kernels.addresses import stand_in

        return Prepared(
            stand_in(_in_python(self._entry.function, self._signature, arguments)), places, numbers
        ), arguments

    def _all(self, later: tuple[Any, ...]) -> list[Any]:
        rest = iter(later)
        return [next(rest) if value is LATER else value for value in self._arguments]


CHARACTERS = {kind: np.dtype(kind).char for kind in ("int64", "float64", "complex128")}


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


def _blank(signature: Signature) -> tuple[np.ndarray, np.ndarray]:
    return np.zeros(max(signature.place_count, 1), dtype=np.int64), np.zeros(signature.error_at + 1)


def _written(signature: Signature, arguments: list[Any]) -> tuple[np.ndarray, np.ndarray]:
    """Return places and numbers, with what is given written."""
    places, numbers = _blank(signature)

    for part, value in zip(signature.parts, arguments, strict=True):
        if value is not LATER:
            _write(part, value, places, numbers)
    return places, numbers


def _write(part: Part, value: Any, places: Any, numbers: Any) -> None:
    """Write an argument to its places."""
    if part is None:
        return
    if isinstance(part, Group):
        for inner, item in zip(part.parts, value, strict=True):
            _write(inner, item, places, numbers)
    elif part.axes > 0:
        places[part.at] = _address(value, part.axes, part.kind)
        for i, length in enumerate(value.shape):
            places[part.at + 1 + i] = length
    elif part.is_number:
        numbers[part.at] = value
    else:
        places[part.at] = value if part.axes == 0 else value.address


def _returned(signature: Signature, numbers: Any) -> Any:
    """Return what a call has left in its numbers."""
    if numbers[signature.error_at]:
        raise ZeroDivisionError("complex division by zero")
    found = numbers[signature.number_count : signature.error_at]
    for i, kind in enumerate(signature.result):
        if kind != NUMBER:
            found[i] = kinds[kind](found[i])
    return tuple(found) if len(found) > 1 else found[0] if found else None


kinds: dict[str, Callable[[Any], Any]] = {INTEGER: int, BOOLEAN: bool}


def _in_python(function: Callable[..., Any], signature: Signature, arguments: list[Any]) -> Callable[..., None]:
    """Return what a prepared call does where nothing is compiled: scalars are read when it is called."""

    def call(places: np.ndarray, numbers: np.ndarray) -> None:
        taken = []
        for part, value in zip(signature.parts, arguments, strict=True):
            if part is not None and not isinstance(part, Group) and part.axes == 0:
                value = numbers[part.at] if part.is_number else kinds[part.kind](places[part.at])
            taken.append(value)
        try:
            found = function(*taken)
        except ZeroDivisionError:
            numbers[signature.error_at] = 1.0
            return
        if signature.result:
            numbers[signature.number_count : signature.error_at] = found

    return call


def entry(
    *variants: Variant, empty: Mapping[str, Callable[[], Any]] | None = None
) -> Callable[[Callable[..., Any]], Entry]:
    """Declare a kernel that is called from outside."""
    return lambda function: Entry(function, variants or (Variant(),), empty or {})


class Pointer:
    """A kernel that others call by its address, one of a type that all methods, or all scenes, share.

    Parameters
    ----------
    function : function
    kind : str
        Name of the type, see `kanefe.kernels.arrays`.
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
    def unit(self) -> Unit:
        """What is built for it."""
        return Unit(self.__name__, self.__module__, lambda: compiled_pointer(self.function, self.kind))

    @property
    def address(self) -> int:
        """Where its machine code is."""
        return machine_code(self.unit).address


def pointer(kind: str) -> Callable[[Callable[..., Any]], Pointer]:
    """Declare a kernel that is called by its address."""
    return lambda function: Pointer(function, kind)
