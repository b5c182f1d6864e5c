"""The table of a record: columns that grow with a run, in memory or in a file."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from kanefe.results.recorded import Recorded
from kanefe.storage.growing_file import GrowingFile, read_part


class Columns(NamedTuple):
    """Names and units of the columns of a table, and whether only their extremes are kept."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    is_extremes: bool


@dataclass
class Table:
    """The values of a record.

    Parameters
    ----------
    columns : Columns
    file : GrowingFile or None
        Where they are written; None: they stay in memory.
    number : int
        Of the table in the file.
    """

    columns: Columns
    file: GrowingFile | None
    number: int
    _times: list[np.ndarray] = field(default_factory=list)
    _values: list[np.ndarray] = field(default_factory=list)

    def add(self, times: np.ndarray, values: np.ndarray) -> None:
        """Add values (T, columns) at times (T,).

        Raises
        ------
        FileError
            If the file cannot grow.
        """
        if not len(times):
            return
        if self.columns.is_extremes:
            self._add_extremes(times, values)
        elif self.file is None:
            self._times.append(times.copy())
            self._values.append(values.copy())
        else:
            self.file.write(self.number, times, values)

    def _add_extremes(self, times: np.ndarray, values: np.ndarray) -> None:
        width = values.shape[1]
        if self._values:
            times = np.vstack((self._times[0], np.repeat(times[:, None], width, axis=1)))
            values = np.vstack((self._values[0], values))
        else:
            times = np.repeat(times[:, None], width, axis=1)
        at = np.array((values.argmin(axis=0), values.argmax(axis=0)))
        self._times = [np.take_along_axis(times, at, axis=0)]
        self._values = [np.take_along_axis(values, at, axis=0)]
        if self.file is not None:
            self.file.write(self.number, self._times[0], self._values[0])

    def recorded(self) -> dict[str, Recorded]:
        """Return the columns."""
        if self.file is not None:
            return columns_in_file(self.file.path, self.number, self.columns)
        is_extremes = self.columns.is_extremes
        none = np.zeros((0, len(self.columns.names)))
        times = np.concatenate([none if is_extremes else np.zeros(0), *self._times])
        return {
            name: Recorded.in_memory(
                name,
                unit,
                is_extremes,
                times[:, i] if is_extremes else times,
                np.concatenate([none[:, i], *(block[:, i] for block in self._values)]),
            )
            for i, (name, unit) in enumerate(zip(self.columns.names, self.columns.units, strict=True))
        }


def columns_in_file(path: Path, number: int, columns: Columns) -> dict[str, Recorded]:
    """Return the columns of a table of a file, read when they are asked for."""
    return {
        name: Recorded(name, unit, columns.is_extremes, partial(read_part, path, number, i), path)
        for i, (name, unit) in enumerate(zip(columns.names, columns.units, strict=True))
    }
