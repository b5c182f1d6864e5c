"""An image of the memory that calls of kernels work on, which another process can load.

A prepared call consists of two arrays, of places and of numbers (see `kanefe.kernels.compiler.signatures`); places hold
the addresses of further arrays, and tables those of functions. The image contains all arrays one after the other, and
lists which of its numbers are addresses, and of what.
"""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from kanefe.errors import ModelError
from kanefe.kernels.compiler.compiled_functions import loaded_files
from kanefe.kernels.compiler.entries import Call, calls_in
from kanefe.kernels.compiler.signatures import Group, Part

ALIGNMENT = 64
"""Alignment of each array, bytes."""

LEAST_ADDRESS = 2**32
"""Lowest address of a library in a 64-bit process."""


class NeedsPython(ModelError):
    """A scene needs Python to continue; the message gives the reason."""


Block = tuple[int, int]
"""First address, and the address after the last."""


class CallPlaces(NamedTuple):
    """Places of a call in the image: its function, places, numbers and first result."""

    function: int
    places: int
    numbers: int
    result: int


class Image:
    """The memory of prepared calls.

    Parameters
    ----------
    calls : list of Call
        Those that they make by address are found.

    Attributes
    ----------
    functions : list of (Path, str)
        Library and symbol of each function, in the order of their numbers.
    pointers : list of (int, int)
        Place in the image of each address within it, and the place that it refers to.
    called : list of (int, int)
        Place in the image of each address of a function, and the number of the function.

    Raises
    ------
    NeedsPython
        If a function is in no file of kernels, such as one of the user.
    """

    def __init__(self, calls: list[Call]) -> None:
        calls = with_nested(calls)
        self._arrays: list[np.ndarray] = [array for call in calls for array in _arrays_of_call(call)]
        self._blocks = _merged([_block(array) for array in self._arrays if array.size])
        self._first = np.array([a for a, _ in self._blocks], dtype=np.int64)
        self._starts, self.size = [-1] * len(self._blocks), 0
        for array in self._arrays:  # in this order, and not in that of addresses, which differs from process to process
            i = self._block_of(_block(array)[0]) if array.size else -1
            if i >= 0 and self._starts[i] < 0:
                a, b = self._blocks[i]
                self._starts[i], self.size = self.size, self.size + (b - a + ALIGNMENT - 1) // ALIGNMENT * ALIGNMENT
        self._known = loaded_files()
        self.functions: list[tuple[Path, str]] = []
        self._numbers: dict[int, int] = {}
        self.pointers: list[tuple[int, int]] = []
        self.called: list[tuple[int, int]] = []
        for call in calls:
            self._function(call.address)
            self._note_pointers(call)
        self._note_functions()

    def place(self, array: np.ndarray) -> int:
        """Return the place of an array in the image, zero if it is empty."""
        return self._place_of(_block(array)[0]) if array.size else 0

    def call(self, call: Call) -> CallPlaces:
        """Return the places of a call."""
        signature, (places, numbers) = call.signature, _own_arrays(call)
        function = self._function(call.address)
        return CallPlaces(function, self.place(places), self.place(numbers), signature.number_count)

    def content(self) -> bytes:
        """Return the bytes of the image, with zeros for addresses."""
        made = bytearray(self.size)
        for start, (a, b) in zip(self._starts, self._blocks, strict=True):
            made[start : start + b - a] = ctypes.string_at(a, b - a)
        for at, _ in (*self.pointers, *self.called):
            made[at : at + 8] = bytes(8)
        return bytes(made)

    def _place_of(self, address: int) -> int:
        i = self._block_of(address)
        a, b = self._blocks[i] if i >= 0 else (0, 0)
        if not a <= address < b:
            raise ValueError("an address is in no array of the calls")
        return self._starts[i] + address - a

    def _block_of(self, address: int) -> int:
        """Return the number of the last block that does not begin after an address, -1 if there is none."""
        return int(np.searchsorted(self._first, address, side="right")) - 1

    def _function(self, address: int) -> int:
        if address not in self._known:
            raise NeedsPython(
                "the scene has a function that is compiled for this process alone, such as one of numba. Remedy: "
                "loads and joints of kanefe, or the value of the function as an input"
            )
        if address not in self._numbers:
            self._numbers[address] = len(self.functions)
            self.functions.append(self._known[address])
        return self._numbers[address]

    def _note_pointers(self, call: Call) -> None:
        places = _own_arrays(call)[0]
        first = self.place(places)
        for at in _array_places(call.signature.parts):
            if places[at]:
                self.pointers.append((first + 8 * at, self._place_of(int(places[at]))))

    def _note_functions(self) -> None:
        """Record all whole numbers that are addresses of functions: no other number is as large."""
        done = {at for at, _ in self.pointers}
        for array in {id(a): a for a in self._arrays if a.dtype == np.int64 and a.size}.values():
            first, flat = self.place(array), array.reshape(-1)
            for i in np.flatnonzero(flat >= LEAST_ADDRESS).tolist():
                if first + 8 * i not in done:
                    self.called.append((first + 8 * i, self._function(int(flat[i]))))
                    done.add(first + 8 * i)


def with_nested(calls: list[Call]) -> list[Call]:
    """Return calls with those that they make by address, each once."""
    found, waiting = dict[int, Call](), calls[::-1]
    while waiting:
        call = waiting.pop()
        if id(call) not in found:
            found[id(call)] = call
            waiting += calls_in(call.arguments)
    return list(found.values())


def _own_arrays(call: Call) -> tuple[np.ndarray, np.ndarray]:
    return np.frombuffer(call.places, np.int64), np.frombuffer(call.numbers, np.float64)


def _arrays_of_call(call: Call) -> Iterator[np.ndarray]:
    yield from _own_arrays(call)
    for value in call.arguments:
        yield from _arrays(value)


def _arrays(value: Any) -> Iterator[np.ndarray]:
    if isinstance(value, np.ndarray):
        yield value
    elif isinstance(value, tuple):
        for item in value:
            yield from _arrays(item)


def _array_places(parts: tuple[Part, ...]) -> Iterator[int]:
    for part in parts:
        if isinstance(part, Group):
            yield from _array_places(part.parts)
        elif part is not None and part.axes > 0:
            yield part.at


def _block(array: np.ndarray) -> Block:
    first = int(array.__array_interface__["data"][0])
    return first, first + array.nbytes


def _merged(blocks: list[Block]) -> list[Block]:
    """Return disjoint blocks: arrays may be parts of others."""
    found: list[Block] = []
    for a, b in sorted(set(blocks)):
        if found and a < found[-1][1]:
            found[-1] = found[-1][0], max(b, found[-1][1])
        else:
            found.append((a, b))
    return found
