"""Channels of a saved run."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from kanefe.errors import ModelError
from kanefe.integrate.sampling import ControllerLog
from kanefe.integrate.status import RunStatus, summary
from kanefe.results.channel_tables import channels_of, check_channels, stored_parts
from kanefe.results.load_lines import LoadLine
from kanefe.results.quantities import FORCES
from kanefe.results.reader import Reader
from kanefe.results.recorded import Recorded
from kanefe.results.saved_shapes import shape_of, within
from kanefe.results.surface_outline import SurfaceOutline

PARTS = {
    "statistics": dict,
    "status": dict,
    "events": dict,
    "controllers": list,
    "bodies": list,
    "loops": list,
    "gears": dict,
    "loads": dict,
    "points": dict,
    "surfaces": list,
    "lines": list,
    "records": list,
    "channels": dict,
}
"""JSON attributes of a file, with the type of each."""


class FileChannels:
    """Channels of a saved run.

    Parameters
    ----------
    path : Path
        For messages.
    header : dict
        Attributes of the file.
    arrays : dict
        Its arrays by path.
    """

    def __init__(self, path: Path, header: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> None:
        self.path = path
        self.times = _checked_times(arrays["times"])
        parts = _parts(header)
        self.statistics: dict[str, Any] = parts["statistics"]
        self.status = RunStatus(**parts["status"])
        self.events: Mapping[str, np.ndarray] = {name: np.array(times) for name, times in parts["events"].items()}
        summary(self.status, self.statistics, self.events)  # raises where parts are missing
        self.bodies = tuple(shape_of(entry, i, arrays) for i, entry in enumerate(parts["bodies"]))
        self.loops = tuple(parts["loops"])
        self.gears: Mapping[str, tuple[str, ...]] = {name: tuple(columns) for name, columns in parts["gears"].items()}
        self.loads: Mapping[str, tuple[str, ...]] = {name: tuple(columns) for name, columns in parts["loads"].items()}
        self.points: Mapping[str, int] = {name: int(count) for name, count in parts["points"].items()}
        self.controllers: Mapping[str, ControllerLog] = {
            entry.pop("name"): ControllerLog(**_with_arrays(entry, f"controllers/{i}/", arrays))
            for i, entry in enumerate(parts["controllers"])
        }
        self.surfaces = tuple(
            SurfaceOutline(**_with_arrays(entry, f"surfaces/{i}/", arrays)) for i, entry in enumerate(parts["surfaces"])
        )
        self._lines = tuple(
            self._checked(LoadLine(**_with_arrays(entry, f"lines/{i}/", arrays)))
            for i, entry in enumerate(parts["lines"])
        )
        self.records: Mapping[str, Recorded] = {
            entry["name"]: Recorded.in_memory(**_with_arrays(entry, f"records/{i}/", arrays))
            for i, entry in enumerate(parts["records"])
        }
        self._channels = channels_of(parts["channels"], arrays, len(self.times))
        self.has_forces = any(quantity in FORCES for quantity in parts["channels"])
        check_channels(self._channels, Reader(self))

    def load_lines(self, rows: np.ndarray) -> tuple[LoadLine, ...]:
        """Return the lines of loads that act along one, at output times given by number."""
        return tuple(line.at(rows) for line in self._lines)

    def read(self, quantity: str, body: str = "", interface: str = "", of: str = "") -> np.ndarray:
        """Return a channel, or a part of a coupling force, time first.

        Raises
        ------
        ModelError
            If it was not saved.
        """
        whole = self._channel(quantity, body, interface)
        if not of:
            return whole
        neighbours = next(shape for shape in self.bodies if shape.name == body).neighbours[interface]
        parts = neighbours.parts(of, f"{interface!r} of {body!r}")
        if not stored_parts(neighbours):
            return whole if parts else np.zeros_like(whole)
        return sum((self._channel(quantity, body, interface, part) for part in parts), np.zeros_like(whole))

    def _channel(self, quantity: str, body: str, interface: str, part: str = "") -> np.ndarray:
        found = self._channels.get((quantity, body, interface, part))
        if found is None:
            of = f" of {body!r}" + (f" at {interface!r}" if interface else "") if body else ""
            raise ModelError(
                f"{quantity}{of} was not saved in {self.path}. Remedy: run the scene again and save with forces=True"
            )
        return found

    def _checked(self, line: LoadLine) -> LoadLine:
        """Return a line; a ValueError unless it has a row for each time."""
        count = len(self.times)
        if line.points.shape[:1] != (count,) or line.points.shape[2:] != (3,) or line.states.shape != (count,):
            raise ValueError(f"the line of {line.name!r} has not a row for each of {count} times")
        return line


def _parts(header: Mapping[str, Any]) -> dict[str, Any]:
    """Return the attributes that are JSON; a ValueError if one is of another type."""
    parts = {name: json.loads(text) for name, text in header.items() if name in PARTS}
    for name, kind in PARTS.items():
        if not isinstance(parts[name], kind):
            raise ValueError(f"{name} is no {kind.__name__}")
    return parts


def _checked_times(times: np.ndarray) -> np.ndarray:
    """Return the times; a ValueError unless they are finite and ascend."""
    if times.ndim != 1 or times.dtype != float or not np.all(np.isfinite(times)):
        raise ValueError(f"times are not finite numbers in a row, but {times.dtype} {times.shape}")
    if not len(times) or np.any(np.diff(times) < 0.0):
        raise ValueError("times do not rise")
    return times


def _with_arrays(entry: Mapping[str, Any], folder: str, arrays: Mapping[str, np.ndarray]) -> dict[str, Any]:
    """Return what the header tells of something, and its arrays, by name."""
    told = {name: tuple(value) if isinstance(value, list) else value for name, value in entry.items()}
    return told | within(folder, arrays)
