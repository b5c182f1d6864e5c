"""Arrays of records, made and filled by the names of fields: what is done once, where a scene is frozen."""

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any, TypeVar

import numpy as np

from kanefe.kernels.language import Array, Record, Start, column
from kanefe.kernels.values.parts import INTEGERS, NUMBERS

R = TypeVar("R", bound=Record)


def filled(record: type[Record], **values: Any) -> np.ndarray:
    """Return the numbers of a record, of numbers and arrays by name; those behind it may be as many as they like."""
    if unlike := set(values) ^ set(record.fields):
        raise TypeError(f"a {record.__name__} is filled by {', '.join(record.fields)}: {', '.join(sorted(unlike))}?")
    parts = [np.ravel(np.asarray(values[name], dtype=float)) for name in record.fields]
    for field, part in zip(record.fields.values(), parts, strict=True):
        if len(part) != field.numbers and not field.is_open:
            raise TypeError(f"{record.__name__}.{field.name} has {field.numbers} numbers, not {len(part)}")
    return np.concatenate(parts)


def filled_from(source: Any, record: type[Record], **more: Any) -> np.ndarray:
    """Return the numbers of a record, by name more ones and attributes of an object; None counts as zero."""
    own = {name: getattr(source, name) for name in record.fields if name not in more}
    return filled(record, **more, **{name: 0.0 if value is None else value for name, value in own.items()})


def filled_rows(record: type[Record], rows: Sequence[Mapping[str, Any]]) -> tuple[np.ndarray, ...]:
    """Return the arrays of integers and of numbers of records that are rows, of their fields by name."""
    own = {name: field for name, field in record.fields.items() if field.integers or field.numbers}
    integers, numbers = (np.zeros((len(rows), count)) for count in (record.integer_count, record.number_count))
    integers = integers.astype(np.int64)
    for whole, part, values in zip(integers, numbers, rows, strict=True):
        if unlike := set(values) ^ set(own):
            raise TypeError(f"a {record.__name__} is filled by {', '.join(own)}: {', '.join(sorted(unlike))}?")
        for name, field in own.items():
            if field.is_whole:
                whole[field.integer_at] = values[name]
            else:
                part[field.number_at : field.number_at + field.numbers] = np.ravel(values[name])
    return tuple(array for array in (integers, numbers) if array.shape[1])


def place(record: Record, name: str) -> int:
    """Return where a part of a record begins in its pool."""
    return int(record.fields[name].kind.place(record.__getattribute__))


def room(record: type[Record], start: str, **whole: int) -> int:
    """Return how many numbers the parts behind a Start have, of ints by name."""
    parts = [field.kind for field in record.fields.values() if isinstance(field.kind, Array)]
    return sum(part.size(whole.__getitem__) for part in parts if part.start == start)


def allocate(record: type[R], **whole: int) -> tuple[np.ndarray, ...]:
    """Return arrays of zeros for a record that is no row, with ints by name and all starts written.

    Parts among its integers and numbers begin behind its fields; in a pool they begin one behind the other.
    """
    counts, known = _layout(record, tuple(whole.items()))  # type: ignore[arg-type]  # mypy: a class has no hash
    integers = np.zeros(counts[INTEGERS], int)
    integers[: len(known)] = known
    return tuple(integers if name == INTEGERS else np.zeros(counts[name]) for name in record.memories)


@lru_cache(maxsize=256)
def _layout(record: type[Record], given: tuple[tuple[str, int], ...]) -> tuple[dict[str, int], list[int]]:
    """Return how many numbers each array has, and the whole numbers of the fields."""
    whole = {name: 0 for name, field in record.fields.items() if field.is_whole} | dict(given)
    counts = dict.fromkeys(record.memories, 0) | {INTEGERS: record.integer_count, NUMBERS: record.number_count}
    for name, field in record.fields.items():
        if isinstance(field.kind, Start):
            whole[name] = counts[field.kind.pool]
            counts[field.kind.pool] += room(record, name, **whole)
    known = [0] * record.integer_count
    for name, value in whole.items():
        known[column(record, name)] = value
    return counts, known


def laid_out(record: type[Record], **whole: int) -> np.ndarray:
    """Return the whole numbers of a record whose parts lie in one memory, of which its int `size` says how long it is.

    What is in a workspace is so declared once: kernels make it of these and a memory, ``Work(integers, memory)``.
    """
    integers, *memories = allocate(record, **whole)
    integers[column(record, "size")] = len(memories[-1])
    return integers
