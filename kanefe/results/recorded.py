"""What was recorded of one column of a channel."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np


class Extreme(NamedTuple):
    """A least or largest value and its time, s."""

    value: float
    time: float


class Recorded:
    """One recorded column of a channel.

    Parameters
    ----------
    name : str
    unit : str
    is_extremes : bool
        Whether the values are only the least and the largest one.
    read : callable
        Returns times and values; called each time, so that those of a file stay in the file.
    path : Path, optional
        The file that has them; default: they are in memory.

    Attributes
    ----------
    name, unit : str
    is_extremes : bool
    path : Path or None
    """

    def __init__(
        self,
        name: str,
        unit: str,
        is_extremes: bool,
        read: Callable[[], tuple[np.ndarray, np.ndarray]],
        path: Path | None = None,
    ) -> None:
        self.name, self.unit, self.is_extremes, self._read, self.path = name, unit, is_extremes, read, path

    @classmethod
    def in_memory(cls, name: str, unit: str, is_extremes: bool, times: np.ndarray, values: np.ndarray) -> Recorded:
        """Return a column with values (T,) at times (T,), which become read-only."""
        times, values = np.ascontiguousarray(times), np.ascontiguousarray(values)
        times.flags.writeable = values.flags.writeable = False
        return cls(name, unit, is_extremes, partial(_both, times, values))

    def __repr__(self) -> str:
        return f"{self.name} [{self.unit}]: {len(self.times)} recorded {'extremes' if self.is_extremes else 'values'}"

    @property
    def times(self) -> np.ndarray:
        """Times of the values, (T,), s."""
        return self._read()[0]

    @property
    def values(self) -> np.ndarray:
        """The values, (T,); of a record of extremes the least and the largest one."""
        return self._read()[1]

    @property
    def least(self) -> Extreme:
        """The least recorded value."""
        return self._extreme(np.argmin)

    @property
    def largest(self) -> Extreme:
        """The largest recorded value."""
        return self._extreme(np.argmax)

    def _extreme(self, find: Callable[[np.ndarray], np.intp]) -> Extreme:
        times, values = self._read()
        at = int(find(values))
        return Extreme(float(values[at]), float(times[at]))


def _both(times: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return times, values
