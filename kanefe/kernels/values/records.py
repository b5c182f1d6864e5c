"""Records: rows of arrays whose numbers have names.

    class Hinge(Record):
        parent: int                                # whole numbers, in a row of the array of integers
        axis: Vector                               # numbers and values, in a row of the array of numbers
        inertia: float

    Hinges = Rows[Hinge]

    hinges = Hinges(integers, numbers)             # the arrays stay what they are: a record is a view
    hinges[0].inertia += dot(hinges[0].axis, hinges[1].axis)

A field is an int, bool, IntEnum, float, value (`kanefe.kernels.values.tensors`) or another record, or ``Annotated`` by
a part: some `Columns` of the row, or what lies elsewhere, in a long array that is called a pool, an `Array`, `Many`
values or a `Table` of records. Where these begin says an integer, a `Start`; the parts that follow it lie there one
behind the other:

    k: int
    start: Annotated[int, Start("pool")]
    stiffness: Annotated[np.ndarray, Array("k", "k")]
    shapes: Annotated[Values, Many(Vector, "k")]

Numbers and pools may be real or complex.

A record of another kind on the same memory is made of a record: ``Wheel(hinge)``. A record that is no row is made of
arrays of its own, integers, numbers and pools: ``Wheel(integers, numbers, pool)``. Behind its fields these may have
parts too: of a ``Start("integers")`` or ``Start("numbers")``. `allocate` of `kanefe.kernels.values.filled` makes the
arrays of such a record.

One whose fields are all among the numbers is made of any list of these, and a place in it: ``Wheel(numbers, at)``;
``Wheels(numbers)[i]`` is one of those that lie one behind the other from its start on, and what is `Behind` a record
the rest of the list. Functions that are called by address have such lists, as the place of a first number.
"""

from __future__ import annotations

import enum
import inspect
from collections import Counter
from collections.abc import Iterator
from copy import copy
from functools import cache
from typing import TYPE_CHECKING, Any, ClassVar, Generic, TypeVar

import numpy as np

from kanefe.kernels.values.parts import (
    INTEGERS,
    NUMBERS,
    Array,
    Behind,
    Columns,
    Many,
    One,
    Start,
    Table,
    Values,
    vectors,
)
from kanefe.kernels.values.tensors import KINDS

__all__ = ["Array", "Behind", "Columns", "Many", "One", "Start", "Table", "Values", "vectors"]
__all__ += ["Field", "Record", "Rest", "Rows", "behind", "column", "lacks", "made_of", "numbers_from"]


class Field:
    """A named place in a record.

    Attributes
    ----------
    name : str
    kind : type or Part
        What it is declared as.
    integer_at, number_at : int
        Its first column among the integers and the numbers.
    integers, numbers : int
        How many columns it has there.
    is_open : bool
        Whether it has as many numbers as follow.
    """

    def __init__(self, name: str, kind: Any, owner: str) -> None:
        self.name, self.kind = name, kind
        self.integer_at = self.number_at = self.integers = self.numbers = 0
        self.is_open = isinstance(kind, Behind) or (
            _is(kind, Record) and any(one.is_open for one in kind.fields.values())
        )
        self.is_whole = kind is int or kind is bool or _is(kind, enum.IntEnum) or isinstance(kind, Start)
        if self.is_whole:
            self.integers = 1
        elif _is(kind, Record):
            self.integers, self.numbers = kind.integer_count, kind.number_count
        elif kind is float or kind in KINDS or isinstance(kind, Columns):
            self.numbers = 1 if kind is float else kind.count
        elif not isinstance(kind, (Array, Behind)):
            raise TypeError(f"{owner}.{name}: {getattr(kind, '__name__', kind)} can be no field of a record")

    def __get__(self, record: Record | None, owner: type | None = None) -> Any:
        if record is None:
            return self
        memory, kind = record._memory, self.kind
        if kind is float:
            return memory[NUMBERS][self.number_at]
        if self.is_whole:
            found = int(memory[INTEGERS][self.integer_at])
            return found if isinstance(kind, Start) else kind(found)
        if isinstance(kind, Array):
            whole = record.__getattribute__
            at = kind.place(whole)
            return kind.view(memory[kind.pool][at : at + kind.size(whole)], whole)
        if _is(kind, Record):
            return made_of(kind, self._inside(memory))
        if isinstance(kind, Behind):
            return behind(memory[NUMBERS], self.number_at)
        numbers = memory[NUMBERS][self.number_at : self.number_at + self.numbers]
        return numbers if isinstance(kind, Columns) else kind(*numbers)

    def _inside(self, memory: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        """Return the memory of the record that it is."""
        own = dict(memory)
        for name, at, count in ((INTEGERS, self.integer_at, self.integers), (NUMBERS, self.number_at, self.numbers)):
            if count:
                own[name] = behind(own[name], at)  # with what follows: its last field may be that
        return own

    def __set__(self, record: Record, value: Any) -> None:
        memory, kind, numbers, at = record._memory, self.kind, NUMBERS, self.number_at
        if self.is_whole:
            memory[INTEGERS][self.integer_at] = value
            return
        if isinstance(kind, One):
            numbers, at, kind = kind.pool, kind.place(record.__getattribute__), kind.kind
        if kind is float:
            memory[numbers][at] = value
        elif kind not in KINDS:
            raise AttributeError(f"{type(record).__name__}.{self.name} has parts: write these")
        elif type(value) is not kind:
            raise TypeError(f"{type(record).__name__}.{self.name} is a {kind.__name__}, not a {type(value).__name__}")
        else:
            memory[numbers][at : at + kind.count] = value.numbers


def _is(kind: Any, of: type) -> bool:
    return isinstance(kind, type) and issubclass(kind, of)


class Rest:
    """The numbers of a list from a place on: what lists have no views for.

    Parameters
    ----------
    numbers : sequence
    at : int
    """

    __slots__ = ("at", "numbers")

    def __init__(self, numbers: Any, at: int) -> None:
        self.numbers, self.at = numbers, at

    def __getitem__(self, i: Any) -> Any:
        return self.numbers[self._moved(i)]

    def __setitem__(self, i: Any, value: Any) -> None:
        self.numbers[self._moved(i)] = value

    def _moved(self, i: Any) -> Any:
        return slice(i.start + self.at, i.stop + self.at) if isinstance(i, slice) else i + self.at


def behind(numbers: Any, at: int = 0) -> Any:
    """Return the numbers of an array, or of a list, from a place on."""
    if isinstance(numbers, Rest):
        return Rest(numbers.numbers, numbers.at + at)
    return numbers[at:] if isinstance(numbers, np.ndarray) else Rest(numbers, at)


class Record:
    """A row of arrays. Subclasses declare fields, whose places follow; those of a record's subclass come after its own.

    With ``class Link(Record, is_frozen=True)`` nobody writes its whole numbers while a kernel runs: compiled code need
    not read them again after it has written something else.

    Parameters
    ----------
    *of : Record, or ndarrays, or list and int
        Whose memory it is; or arrays of its own: integers, numbers and pools, those of them that it has fields in; or a
        list of numbers and where it begins there.
    """

    __slots__ = ("_memory",)
    _memory: dict[str, np.ndarray]
    fields: ClassVar[dict[str, Field]] = {}
    integer_count: ClassVar[int] = 0
    number_count: ClassVar[int] = 0
    memories: ClassVar[tuple[str, ...]] = ()
    _open: ClassVar[tuple[str, str, Counter[tuple[str, ...]]]] = "", "", Counter()
    is_frozen: ClassVar[bool] = False

    def __init_subclass__(cls, is_frozen: bool | None = None) -> None:
        cls.is_frozen = cls.is_frozen if is_frozen is None else is_frozen
        cls.fields = dict(cls.fields)
        start, pool, before = cls._open  # what it adds to the parts of another record lies behind these
        for name, hint in inspect.get_annotations(cls, eval_str=True).items():
            kind = copy(hint.__metadata__[0]) if hasattr(hint, "__metadata__") else hint
            if hasattr(Record, name):
                raise TypeError(f"{cls.__name__}.{name}: records themselves have something of this name")
            cls.fields[name] = field = Field(name, kind, cls.__name__)
            field.integer_at, field.number_at = cls.integer_count, cls.number_count
            cls.integer_count += field.integers
            cls.number_count += field.numbers
            setattr(cls, name, field)
            if isinstance(kind, Start):
                start, pool, before = name, kind.pool, Counter()
            elif isinstance(kind, Array):
                if not start:
                    raise TypeError(f"{cls.__name__}.{name}: no Start before it says where it begins")
                kind.lie_behind(start, pool, before)
                before = before + kind.extent
        cls._open = start, pool, before
        cls.memories = _memories_of(cls)

    def __init__(self, *arrays: Any) -> None:
        of = arrays[0]
        if not isinstance(of, Record):
            if self.memories == (NUMBERS,) and getattr(of, "ndim", 1) == 1:
                self._memory = {NUMBERS: behind(*arrays)}
            else:
                self._memory = dict(zip(self.memories, (one.reshape(-1) for one in arrays), strict=True))
            return
        missing = [name for name in self.memories if name not in of._memory]
        if missing:
            raise TypeError(f"a {type(of).__name__} has no {missing[0]}, which a {type(self).__name__} wants")
        self._memory = of._memory

    def __setattr__(self, name: str, value: Any) -> None:
        field = self.fields.get(name)
        if field is not None:
            field.__set__(self, value)
        elif name == "_memory":
            object.__setattr__(self, name, value)
        else:
            raise AttributeError(lacks(type(self), name))

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(lacks(type(self), name))

    def __repr__(self) -> str:
        lines = [f"  {name} = {plain(getattr(self, name))!r}" for name in self.fields]
        return "\n".join([type(self).__name__, *lines])


def plain(value: Any) -> Any:
    """Return a number of numpy as one of Python, whose text is the number alone."""
    return value.item() if isinstance(value, np.generic) else value


R = TypeVar("R", bound=Record)


def _memories_of(record: type[Record]) -> tuple[str, ...]:
    """Return the names of the arrays that a record has fields in: integers, numbers, and pools as they come."""
    kinds = [field.kind for field in record.fields.values()]
    pools = [kind.pool for kind in kinds if isinstance(kind, Start)]
    pools += [name for kind in kinds if _is(kind, Record) for name in kind.memories]
    pools = [name for name in pools if name not in (INTEGERS, NUMBERS)]
    in_rows = ((INTEGERS, record.integer_count), (NUMBERS, record.number_count))
    return (*(name for name, count in in_rows if count), *dict.fromkeys(pools))


def made_of(record: type[R], memory: dict[str, np.ndarray]) -> R:
    """Return a record on a memory."""
    made = record.__new__(record)
    made._memory = memory
    return made


def lacks(record: type[Record], name: str) -> str:
    """Return what is said of a field that a record has not."""
    return f"a {record.__name__} has no {name!r}; it has {', '.join(record.fields)}"


def numbers_from(record: Record) -> Any:
    """Return the list of numbers that a record lies in, from its first on."""
    return record._memory[NUMBERS]


def column(record: type[Record], name: str) -> int:
    """Return the first column of a field, in the array that has it."""
    field = record.fields[name]
    return field.integer_at if field.is_whole else field.number_at


class Rows(Generic[R]):
    """All records of a kind in arrays: ``Links = Rows[Link]``, or a subclass of it.

    Parameters
    ----------
    *arrays : ndarray
        Those that the record has fields in: of integers and of numbers, a row for each record and at least as many
        columns as it needs, and its pools; or one list of numbers, in which they lie one behind the other.
    """

    record: type[R]

    if not TYPE_CHECKING:

        def __class_getitem__(cls, record: type[Record]) -> type[Rows]:
            return _rows_of(record)

    def __init__(self, *arrays: Any) -> None:
        names = self.record.memories
        self._list = arrays[0] if names == (NUMBERS,) and getattr(arrays[0], "ndim", 1) == 1 else None
        if len(arrays) != len(names):
            raise TypeError(f"{type(self).__name__} are made of {', '.join(names)}, not of {len(arrays)} arrays")
        self._arrays = dict(zip(names, arrays, strict=True))
        self._in_rows = [name for name in names if name in (INTEGERS, NUMBERS)]

    def __len__(self) -> int:
        return len(self._arrays[self._in_rows[0]])

    @property
    def numbers(self) -> np.ndarray:
        """The array of numbers."""
        return self._arrays[NUMBERS]

    def __getitem__(self, i: int) -> R:
        if self._list is not None:
            return self.record(self._list, i * self.record.number_count)
        memory = dict(self._arrays)
        for name in self._in_rows:
            memory[name] = memory[name][i]
        return made_of(self.record, memory)

    def __iter__(self) -> Iterator[R]:
        return (self[i] for i in range(len(self)))


@cache
def _rows_of(record: type[Record]) -> type[Rows[Any]]:
    name = f"Rows[{record.__module__}.{record.__qualname__}]"
    globals()[name] = made = type(name, (Rows,), {"record": record})  # numba asks for it by its name
    return made
