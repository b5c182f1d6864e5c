"""The C signature of kernels that are called from outside: where each part of their arguments is.

A built kernel is ``void f(int64_t *places, double *numbers)``. `places` has whole numbers, addresses of functions, and
of each array its address and its lengths; `numbers` has floating-point numbers and, behind them, what is returned. One
such function serves any number of calls, from Python by ctypes and from other kernels by address.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from enum import Enum
from functools import cache
from types import NoneType
from typing import Annotated, Any, NamedTuple, TypeVar, get_args, get_origin, get_type_hints

from kanefe.kernels.compiler.arrays import VALUE

INTEGER, NUMBER, BOOLEAN = "int64", "float64", "boolean"


class Numbers(Enum):
    """What the values of a scene are, of arrays that exist twice: see `kanefe.kernels.compiler.arrays.VALUE`."""

    REAL = "float64"
    COMPLEX = "complex128"


REAL, COMPLEX = Numbers.REAL, Numbers.COMPLEX


class Leaf(NamedTuple):
    """A scalar, an array or a function among the arguments.

    Attributes
    ----------
    kind : str
        Of a scalar or of the elements of an array; of a function: its name in `kanefe.kernels.compiler.arrays`.
    axes : int
        Of an array; 0 of a scalar, -1 of a function.
    at : int
        Its first place, in the numbers if it is one.
    """

    kind: str
    axes: int
    at: int

    @property
    def is_number(self) -> bool:
        """Whether it is passed among the numbers."""
        return self.axes == 0 and self.kind == NUMBER


class Group(NamedTuple):
    """A named tuple among the arguments.

    Attributes
    ----------
    of : type
    parts : tuple
    at : int
        Its first place.
    """

    of: type
    parts: tuple[Leaf | Group, ...]
    at: int

    @property
    def is_in_place(self) -> bool:
        """Whether kernels read it where it is in the places of the call: see `in_place`."""
        return hasattr(self.of, "is_in_place")


Part = Leaf | Group

Tuple = TypeVar("Tuple", bound=type)


def in_place(of: Tuple) -> Tuple:
    """Mark a class of named tuples that kernels read where they are in the places of a call.

    In compiled code such a tuple is one address, however much is in it; tuples in it are read in place too. It has
    arrays and whole numbers, which nobody changes while a kernel runs, and is made by no kernel.
    """
    of.is_in_place = True  # type: ignore[attr-defined]
    return of


def parts_in_place(of: type) -> dict[str, Part]:
    """Return the parts of a tuple that is read in place, from its own first place on."""
    group = _Counter(REAL).part(of)
    return dict(zip(of._fields, group.parts, strict=True))  # type: ignore[attr-defined, union-attr]


class Signature(NamedTuple):
    """Where everything is.

    Attributes
    ----------
    names : tuple of str
        Of the parameters.
    parts : tuple
        Of each parameter.
    place_count, number_count : int
        Of `numbers`, arguments alone.
    result : tuple of str
        Kinds of what is returned.
    """

    names: tuple[str, ...]
    parts: tuple[Part, ...]
    place_count: int
    number_count: int
    result: tuple[str, ...]

    @property
    def number_room(self) -> int:
        """Length of `numbers`."""
        return self.number_count + len(self.result)

    def place_of(self, name: str, field: str) -> int:
        """Return where a scalar of a named tuple among the parameters is."""
        group = self.parts[self.names.index(name)]
        names = group.of._fields  # type: ignore[union-attr]
        return group.parts[names.index(field)].at  # type: ignore[union-attr, no-any-return]


class _Counter:
    def __init__(self, values: Numbers) -> None:
        self.places = self.numbers = 0
        self._values = values.value

    def leaf(self, kind: str, axes: int) -> Leaf:
        if axes == 0 and kind == NUMBER:
            self.numbers += 1
            return Leaf(kind, axes, self.numbers - 1)
        at = self.places
        self.places += 1 + max(axes, 0)
        return Leaf(self._values if kind == VALUE else kind, axes, at)

    def part(self, hint: Any) -> Leaf | Group:
        if hint in SCALARS:
            return self.leaf(SCALARS[hint], 0)
        if get_origin(hint) is Annotated:
            kind, *axes = hint.__metadata__
            return self.leaf(kind, axes[0] if axes else -1)
        fields, at, numbers = get_type_hints(hint, include_extras=True), self.places, self.numbers
        group = Group(hint, tuple(self.part(fields[name]) for name in hint._fields), at)
        if group.is_in_place and self.numbers > numbers:
            raise TypeError(f"{hint.__name__} is read in place: a float in it is not among the places")
        return group


SCALARS = {int: INTEGER, float: NUMBER, bool: BOOLEAN}


@cache
def signature_of(function: Callable[..., Any], values: Numbers) -> Signature:
    """Return the signature of a kernel that is called from outside, from the annotations of its parameters."""
    hints = get_type_hints(function, include_extras=True)
    names = tuple(inspect.signature(function).parameters)
    counter = _Counter(values)
    parts = tuple(counter.part(hints[name]) for name in names)
    returned = hints["return"]
    kinds = get_args(returned) or (() if returned is NoneType else (returned,))
    return Signature(names, parts, counter.places, counter.numbers, tuple(SCALARS[kind] for kind in kinds))


def wrapper_source(signature: Signature) -> tuple[str, dict[str, Any]]:
    """Return the source of the C function around a kernel for numba, and the tuples it names.

    See `kanefe.kernels.compiler._numba_objects.compiled_entry` for the rest of the names in it.
    """
    types: dict[str, Any] = {}

    def text(part: Part) -> str:
        if isinstance(part, Group):
            if part.is_in_place:
                types[f"{part.of.__name__}_in"] = part.of
                return f"{part.of.__name__}_in(places, {part.at})"
            types[part.of.__name__] = part.of
            return f"{part.of.__name__}({', '.join(map(text, part.parts))},)"
        if part.axes > 0:
            lengths = "".join(f"places[{part.at + 1 + axis}], " for axis in range(part.axes))
            return f"array_of(pointer_to(places[{part.at}]), ({lengths}), {part.kind})"
        if part.axes < 0:
            return f"{part.kind}_at(places[{part.at}])"
        if part.is_number:
            return f"numbers[{part.at}]"
        return f"places[{part.at}] != 0" if part.kind == BOOLEAN else f"places[{part.at}]"

    first = signature.number_count
    lines = [f"found = function({', '.join(map(text, signature.parts))})"]
    for i, _ in enumerate(signature.result):
        lines.append(f"numbers[{first + i}] = found{f'[{i}]' if len(signature.result) > 1 else ''}")
    source = "def wrapper(places, numbers):\n" + "".join(f"    {line}\n" for line in lines)
    return source, types
