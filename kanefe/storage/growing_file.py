"""HDF5 files of tables that grow row by row, and can be read at any time, also after the writer was killed.

HDF5's single-writer mode writes each piece before what refers to it, so that a file is sound after each block. The file
of a writer that was killed opens in the mode for readers of such files only; `read_head` and `read_part` do that.
"""

from __future__ import annotations

import contextlib
import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from kanefe.errors import FileError
from kanefe.storage.files import ready_path, regular_file
from kanefe.storage.hdf5 import h5py_for, put_header

CHUNK_BYTES = 2**16
"""Size of a chunk of a table, bytes."""

LEAST_ROOM = 2**20
"""Space on the disk beside that of a block below which nothing more is written, bytes: HDF5 can crash on a full disk.
"""

WRITER = "the recording of a run"


class Layout(NamedTuple):
    """Number of columns of a table, and whether it grows; else it has two rows, each number with its own time."""

    width: int
    grows: bool


class GrowingFile:
    """A file of tables, open for writing.

    Parameters
    ----------
    path : path
        An existing file is replaced.
    header : mapping
        Texts as they are, anything else as JSON.
    tables : sequence of Layout

    Raises
    ------
    FileError
        If it cannot be written.
    MissingDependency
        If h5py is not installed.
    """

    def __init__(self, path: str | Path, header: Mapping[str, Any], tables: Sequence[Layout]) -> None:
        h5py = h5py_for(WRITER)
        self.path = ready_path(path)
        self._check_room(0)
        try:
            self._file = h5py.File(self.path, "w", libver=("v110", "v110"))
            put_header(self._file, header)
            self._times, self._values = [], []
            for i, (width, grows) in enumerate(tables):
                rows = max(1, CHUNK_BYTES // (8 * width))
                of_times: dict[str, Any] = {"shape": (2, width)}
                of_values: dict[str, Any] = {"shape": (2, width)}
                if grows:
                    of_times = {"shape": (0,), "maxshape": (None,), "chunks": (CHUNK_BYTES // 8,)}
                    of_values = {"shape": (0, width), "maxshape": (None, width), "chunks": (rows, width)}
                group = self._file.create_group(f"records/{i}")
                self._times.append(group.create_dataset("times", dtype=float, fillvalue=np.nan, **of_times))
                self._values.append(group.create_dataset("values", dtype=float, fillvalue=np.nan, **of_values))
                self._times[i].attrs["unit"] = "s"
            self._file.swmr_mode = True
        except OSError as error:
            raise FileError(f"cannot write {self.path}: {error}. Remedy: another folder or name") from error

    def write(self, number: int, times: np.ndarray, values: np.ndarray) -> None:
        """Add rows to a table, times (T,) and values (T, columns); of one that does not grow write the two rows."""
        self._check_room(times.nbytes + values.nbytes)
        try:
            for part, rows in ((self._values[number], values), (self._times[number], times)):
                first = 0
                if part.maxshape[0] is None:
                    first = len(part)
                    part.resize(first + len(rows), axis=0)
                part[first:] = rows
                part.flush()
        except (OSError, RuntimeError) as error:
            raise self._unwritten(error) from error

    def leave(self) -> None:
        """Close the file as it is."""
        with contextlib.suppress(OSError, RuntimeError):
            self._file.close()

    def close(self, header: Mapping[str, Any]) -> None:
        """Close the file, and write more of its header."""
        h5py = h5py_for(WRITER)
        try:
            self._file.close()
            self._check_room(0)
            self._file = h5py.File(self.path, "r+")
            put_header(self._file, header)
            self._file.close()
        except (OSError, RuntimeError) as error:
            raise self._unwritten(error) from error

    def _check_room(self, size: int) -> None:
        free = shutil.disk_usage(self.path.parent).free
        if free < size + LEAST_ROOM:
            raise FileError(
                f"{self.path} cannot grow: its disk has {free / 2**20:.3g} MB left. Remedy: another disk, fewer "
                "channels, or a longer step of the record"
            )

    def _unwritten(self, error: Exception) -> FileError:
        return FileError(f"{self.path} cannot grow: {error}. Remedy: another disk, or fewer channels")


def read_head(path: str | Path) -> dict[str, str]:
    """Return the header of a file.

    Raises
    ------
    FileError
        If it does not exist, or is no file of tables.
    MissingDependency
        If h5py is not installed.
    """
    with _opened(path) as file:
        return {name: value for name, value in file.attrs.items() if isinstance(value, str)}


def read_part(path: str | Path, number: int, column: int) -> tuple[np.ndarray, np.ndarray]:
    """Return times and values of a column of a table, as far as both are there.

    Raises
    ------
    FileError
        If it does not exist, or is no file of tables.
    """
    with _opened(path) as file:
        try:
            group = file[f"records/{number}"]
            times, values = group["times"][...], group["values"][:, column]
        except (OSError, KeyError, ValueError) as error:
            raise FileError(f"{path} is damaged: {error}. Remedy: record the run again") from error
    times = times[:, column] if times.ndim == 2 else times
    count = min(len(times), len(values))
    return times[:count], values[:count]


def _opened(path: str | Path) -> Any:
    h5py = h5py_for("reading records")
    path = regular_file(path, whole=False)
    try:
        try:
            return h5py.File(path, "r")
        except OSError:  # its writer is at work, or was killed
            return h5py.File(path, "r", libver="latest", swmr=True)
    except (OSError, RuntimeError, ValueError) as error:
        raise FileError(f"{path} is damaged or no HDF5 file: {error}. Remedy: record the run again") from error
