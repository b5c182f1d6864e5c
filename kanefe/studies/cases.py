"""The cases of a study: the values of its parameters, their order, and the key of each case."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kanefe.errors import ModelError

COLUMNS = ("case", "key", "status", "reason", "simulated", "warnings", "wall", "cpu", "worker")
"""Columns of a table in addition to parameters and outputs."""

KEY_DIGITS = 16

MOST_NESTED = 32
"""Largest depth of nested sequences in one value: the largest number of axes of an array."""

MOST_VALUES = 1_000_000
"""Largest number of values of a parameter, and of rows of a table: more are an infinite generator or a mistake.
"""


@dataclass(frozen=True)
class Cases:
    """Rows of a table, each with all combinations of the values of a grid; the last name of the grid runs fastest.

    They are generated on request: ten thousand cases take no more memory than their values.

    Attributes
    ----------
    table : tuple of dict
        Parameters that change together; one empty row if there is only a grid.
    grid : dict of str to tuple
        Values by name.
    """

    table: tuple[dict[str, Any], ...]
    grid: dict[str, tuple[Any, ...]]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters."""
        return (*self.table[0], *self.grid)

    def __len__(self) -> int:
        return len(self.table) * math.prod(len(values) for values in self.grid.values())

    def __getitem__(self, number: int) -> dict[str, Any]:
        if not 0 <= number < len(self):
            raise IndexError(number)
        chosen = {}
        for name, values in reversed(self.grid.items()):
            number, place = divmod(number, len(values))
            chosen[name] = values[place]
        return self.table[number] | dict(reversed(chosen.items()))

    def __iter__(self) -> Iterator[dict[str, Any]]:
        return (self[number] for number in range(len(self)))

    def record(self) -> dict[str, Any]:
        """Return the cases in types of JSON, for `from_record`."""
        return {"table": list(self.table), "grid": self.grid}

    @classmethod
    def from_record(cls, record: Mapping[str, Any]) -> Cases:
        """Return the cases of a record."""
        grid = {name: tuple(_tuples(value) for value in values) for name, values in record["grid"].items()}
        table = tuple({name: _tuples(value) for name, value in row.items()} for row in record["table"])
        return cls(table, grid)


def key_of(identity: str, parameters: Mapping[str, Any]) -> str:
    """Return the key of a case, from the identity of its study and its parameters in any order."""
    text = json.dumps(parameters, sort_keys=True)
    return hashlib.sha256(f"{identity} {text}".encode()).hexdigest()[:KEY_DIGITS]


def cases_of(table: Any, grid: Mapping[str, Any]) -> Cases:
    """Return the cases of the arguments of a study, checked.

    Parameters
    ----------
    table : sequence of mapping, or DataFrame, or None
        Parameters that change together, one row per case.
    grid : mapping
        One value or several values, by name.

    Raises
    ------
    ModelError
        If a parameter has no value, a value twice, or one that cannot be written to a table.
    """
    rows = _rows(table)
    axes = {name: _axis(name, values) for name, values in grid.items()}
    cases = Cases(rows, axes)
    twice = set(rows[0]) & set(axes)
    if twice:
        raise ModelError(f"{_listed(twice)} is in the table and given by name. Remedy: in one of them")
    if not cases.names:
        raise ModelError("a study needs a parameter. Remedy: Study(build, outputs, name=values)")
    reserved = [name for name in cases.names if name in COLUMNS]
    if reserved:
        raise ModelError(f"{_listed(reserved)} is a column of every table of a study. Remedy: another name")
    return cases


def plain(value: Any, what: str, depth: int = 0) -> Any:
    """Convert a value to Python's own types, which JSON writes and reads without loss.

    Raises
    ------
    ModelError
        If it is no number, text, boolean, None, or sequence of them.
    """
    if isinstance(value, np.generic):
        value = value.item()
    elif isinstance(value, np.ndarray):
        value = value.tolist()
    if value is None or isinstance(value, (bool, int, str)):
        return value
    if isinstance(value, float):
        if not math.isfinite(value):
            raise ModelError(f"{what} is {value}. Remedy: a finite number")
        return value
    if isinstance(value, (list, tuple)) and depth < MOST_NESTED:
        return tuple(plain(item, what, depth + 1) for item in value)
    raise ModelError(
        f"{what} is {_article(type(value).__name__)}, which cannot be written to a table. Remedy: a number, text, "
        "boolean or a sequence of them, from which build makes what it needs"
    )


def _axis(name: str, values: Any) -> tuple[Any, ...]:
    if isinstance(values, Mapping):
        raise ModelError(f"the values of {name} are a mapping. Remedy: a sequence of them")
    single = isinstance(values, (str, bytes)) or not isinstance(values, (Collection, Iterator))
    found = tuple(plain(value, name) for value in ([values] if single else bounded(values, f"the values of {name}")))
    if not found:
        raise ModelError(f"{name} has no values. Remedy: at least one")
    _check_twice([json.dumps(value) for value in found], f"{name} has the value {{}} twice")
    return found


def bounded(values: Iterable[Any], what: str) -> Iterator[Any]:
    """Yield values; raise a ModelError if there are too many, as from an infinite generator."""
    for number, value in enumerate(values):
        if number == MOST_VALUES:
            raise ModelError(
                f"{what} are more than {MOST_VALUES}: {type(values).__name__} may be infinite. Remedy: a finite number "
                "of them, such as list(itertools.islice(values, 100))"
            )
        yield value


def _rows(table: Any) -> tuple[dict[str, Any], ...]:
    if table is None:
        return ({},)
    if hasattr(table, "to_dict") and hasattr(table, "columns"):  # a DataFrame
        table = table.to_dict("records")
    if isinstance(table, (str, bytes, Mapping)) or not isinstance(table, Iterable):
        raise ModelError("table must be a sequence of mappings, one row per case, or a DataFrame")
    rows: list[dict[str, Any]] = []
    for number, row in enumerate(bounded(table, "the rows of the table")):
        if not isinstance(row, Mapping) or not all(isinstance(name, str) for name in row):
            raise ModelError(f"row {number} of the table is not a mapping of names to values")
        rows.append({name: plain(value, f"{name} in row {number} of the table") for name, value in row.items()})
        if set(row) != set(rows[0]):
            raise ModelError(f"row {number} of the table has {_listed(row)}, row 0 has {_listed(rows[0])}")
    if not rows:
        raise ModelError("the table has no rows. Remedy: at least one")
    _check_twice([json.dumps(row, sort_keys=True) for row in rows], "the table has the row {} twice")
    return tuple(rows)


def _check_twice(texts: Sequence[str], message: str) -> None:
    seen: set[str] = set()
    for text in texts:
        if text in seen:
            raise ModelError(f"{message.format(text)}: that is one run. Remedy: once, or a seed as another parameter")
        seen.add(text)


def _tuples(value: Any) -> Any:
    return tuple(_tuples(item) for item in value) if isinstance(value, list) else value


def _listed(names: Iterable[str]) -> str:
    return ", ".join(sorted(names)) or "no names"


def _article(name: str) -> str:
    return f"{'an' if name[:1].lower() in 'aeiou' else 'a'} {name}"
