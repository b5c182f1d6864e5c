"""Parts of records: what they have besides single numbers and values, and where it lies in an array."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from kanefe.kernels.values.tensors import Value, Vector

INTEGERS, NUMBERS = "integers", "numbers"
"""Names of the arrays that have a row for each record."""


class Part:
    """What a record has of an array besides single numbers and values."""


class Columns(Part):
    """Some numbers of the record's own row, as an array.

    Parameters
    ----------
    count : int
    """

    def __init__(self, count: int) -> None:
        self.count = count


class Behind(Part):
    """The numbers that follow a record, the last of its fields, as what other records and functions are made of."""


class Start(Part):
    """Where parts that follow it begin in a pool.

    Parameters
    ----------
    pool : str
        Name of the pool.
    """

    def __init__(self, pool: str = "pool") -> None:
        self.pool = pool


Whole = Callable[[str], Any]
"""Gives an int of a record by its name."""


class Length(NamedTuple):
    """A length of a part: a factor times an int of the record, or times 1."""

    factor: int
    field: str | None

    def of(self, whole: Whole) -> Any:
        """Return it for a record, whose ints are given by name."""
        return self.factor * whole(self.field) if self.field else self.factor


class Array(Part):
    """Numbers of a pool.

    Parameters
    ----------
    *shape : int or str
        Lengths of the axes: numbers, names of ints of the record, or multiples of these, as "6k".
    """

    numbers = 1

    def __init__(self, *shape: int | str) -> None:
        self.shape = [_length(one) for one in shape]
        self.start, self.pool, self.before = "", "", Counter[tuple[str, ...]]()

    def lie_behind(self, start: str, pool: str, before: Counter[tuple[str, ...]]) -> None:
        """Place it in a pool, behind so many numbers times products of ints, from where an int of the record says."""
        self.start, self.pool, self.before = start, pool, before

    @property
    def extent(self) -> Counter[tuple[str, ...]]:
        """How many numbers it has: a factor, by the ints whose product it multiplies."""
        names = tuple(sorted(one.field for one in self.shape if one.field is not None))
        return Counter({names: self.numbers * math.prod(one.factor for one in self.shape)})

    def place(self, whole: Whole) -> Any:
        """Return where it begins in the pool."""
        sizes = (math.prod(map(whole, names)) * factor for names, factor in self.before.items())
        return sum(sizes, whole(self.start))

    def lengths(self, whole: Whole) -> list[Any]:
        """Return the lengths of the axes."""
        return [one.of(whole) for one in self.shape]

    def size(self, whole: Whole) -> Any:
        """Return how many numbers it has."""
        return self.numbers * math.prod(self.lengths(whole))

    def view(self, numbers: np.ndarray, whole: Whole) -> Any:
        """Return it, of its numbers."""
        return numbers.reshape(self.lengths(whole))


class Many(Array):
    """Values of a kind, component by component: first all x, then all y.

    Parameters
    ----------
    kind : type
    count : int or str
        How many.
    """

    def __init__(self, kind: type[Value], count: int | str) -> None:
        super().__init__(count)
        self.kind, self.numbers = kind, kind.count

    def view(self, numbers: np.ndarray, whole: Whole) -> Values:
        """Return it, of its numbers."""
        return Values(numbers, self.kind)


class Table(Array):
    """Records of a kind, each a row of numbers.

    Parameters
    ----------
    rows : type
        A class of `kanefe.kernels.values.records.Rows`, of records of numbers alone.
    count : int or str
        How many.
    width : int
        Numbers of a row.
    """

    def __init__(self, rows: type[Any], count: int | str, width: int) -> None:
        super().__init__(count, width)
        self.rows = rows

    def view(self, numbers: np.ndarray, whole: Whole) -> Any:
        """Return it, of its numbers."""
        return self.rows(super().view(numbers, whole))


class One(Array):
    """A number, or a value, of a pool.

    Parameters
    ----------
    kind : type
    """

    def __init__(self, kind: type[float] | type[Value]) -> None:
        super().__init__(1 if kind is float else kind.count)  # type: ignore[union-attr]
        self.kind = kind

    def view(self, numbers: np.ndarray, whole: Whole) -> Any:
        """Return it, of its numbers."""
        return numbers[0] if self.kind is float else self.kind(*numbers)


def _length(text: int | str) -> Length:
    if isinstance(text, int):
        return Length(text, None)
    found = re.fullmatch(r"(\d*)([A-Za-z_]\w*)", text)
    if found is None:
        raise TypeError(f"{text!r} is no length: wanted is a number, the name of an int, or a multiple as '6k'")
    return Length(int(found[1] or 1), found[2])


class Values:
    """Values of a kind in an array.

    Parameters
    ----------
    numbers : ndarray, shape (c n,)
        Component by component.
    kind : type

    Attributes
    ----------
    numbers : ndarray
    """

    def __init__(self, numbers: np.ndarray, kind: type[Value]) -> None:
        self.numbers, self._kind, self._components = numbers, kind, numbers.reshape(kind.count, -1)

    def __len__(self) -> int:
        return self._components.shape[1]

    def __getitem__(self, i: int) -> Any:
        return self._kind(*self._components[:, i])

    def __setitem__(self, i: int, value: Value) -> None:
        if type(value) is not self._kind:
            raise TypeError(f"a {self._kind.__name__} is wanted, not a {type(value).__name__}")
        self._components[:, i] = value.numbers


def vectors(rows: np.ndarray) -> Values:
    """Return the columns of an array of three rows, (3, n), as vectors."""
    return Values(rows.reshape(-1), Vector)
