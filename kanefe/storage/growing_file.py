"""Files of tables that grow row by row, and can be read at any time, also after the writer was killed.

While it grows, a file is one of sealed parts, which no library of others reads. When it is closed, it becomes an HDF5
file, whose digest is compared before HDF5 reads it.
"""

from __future__ import annotations

import contextlib
import json
import shutil
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import numpy as np

from kanefe.errors import FileError
from kanefe.storage.files import ready_path, regular_file, write_whole
from kanefe.storage.hdf5 import HEAD, array_at, as_text, h5py_for, opened_sealed, put_digest
from kanefe.storage.sealed_parts import USUAL, Part, PartWriter, parts_of

CHUNK_BYTES = 2**16
"""Size of a chunk of a table in the HDF5 file, bytes."""

BLOCK_BYTES = 2**20
"""Size of the rows of a table that are written to the HDF5 file together, bytes."""

LEAST_ROOM = 2**20
"""Space on the disk beside that of the HDF5 file below which it is not written, bytes: HDF5 can crash on a full disk.
"""

LAYOUTS = "layouts"
"""Name in the header of a file of parts."""

REMEDY = "Remedy: record the run again"


class Layout(NamedTuple):
    """Number of columns of a table, and whether it grows; else it has two rows, each number with its own time."""

    width: int
    grows: bool


class _Rows(NamedTuple):
    """Rows of a table: times (T,), or (2, columns) of one that does not grow, and values (T, columns)."""

    number: int
    times: np.ndarray
    values: np.ndarray


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
        h5py_for("the recording of a run")
        self.path, self._tables = ready_path(path), tuple(tables)
        self._counts = [0] * len(tables)
        self._header = {name: as_text(value) for name, value in header.items()}
        try:
            self._parts = PartWriter(self.path)
            self._parts.add(0, json.dumps(self._header | {LAYOUTS: json.dumps(tables)}).encode())
        except OSError as error:
            raise FileError(f"cannot write {self.path}: {error}. Remedy: another folder or name") from error

    def write(self, number: int, times: np.ndarray, values: np.ndarray) -> None:
        """Add rows to a table, times (T,) and values (T, columns); of one that does not grow write the two rows."""
        grows = self._tables[number].grows
        most = max(1, USUAL // (8 * (1 + values.shape[1]))) if grows else 2
        try:
            for first in range(0, len(values), most):
                some = slice(first, first + most)
                content = np.concatenate((times[some].ravel(), values[some].ravel())).astype("<f8").tobytes()
                self._parts.add(number + 1, content)
                self._counts[number] = self._counts[number] + len(values[some]) if grows else 2
        except OSError as error:
            raise self._unwritten(error) from error

    def leave(self) -> None:
        """Close the file as it is."""
        with contextlib.suppress(OSError):
            self._parts.close()

    def close(self, header: Mapping[str, Any]) -> None:
        """Close the file with more of its header, and make it an HDF5 file.

        Raises
        ------
        FileError
            If the disk has no room; it is still the file of parts then, which can be read.
        """
        more = {name: as_text(value) for name, value in header.items()}
        self._header |= more
        try:
            self._parts.add(0, json.dumps(more).encode())
            self._parts.close()
            free, size = shutil.disk_usage(self.path.parent).free, self.path.stat().st_size
        except OSError as error:
            raise self._unwritten(error) from error
        if free < size + LEAST_ROOM:
            raise FileError(
                f"{self.path} does not become an HDF5 file: its disk has {free / 2**20:.3g} MB left, which are less "
                "than it takes. Remedy: none is needed to read it by kanefe.load_records; for other programs another "
                "disk"
            )
        write_whole(self.path, self._write_hdf5)

    def _write_hdf5(self, file: BinaryIO) -> None:
        h5py = h5py_for("the recording of a run")
        with h5py.File(file, "w", libver=("v110", "v110"), userblock_size=HEAD) as made:
            made.attrs.update(self._header)
            for i, (table, count) in enumerate(zip(self._tables, self._counts, strict=True)):
                whole, group = (count, table.width), made.create_group(f"records/{i}")
                rows = max(1, min(CHUNK_BYTES // (8 * table.width), count))
                for name, shape in (("times", whole[:1] if table.grows else whole), ("values", whole)):
                    chunks: dict[str, Any] = {"chunks": (rows, *shape[1:]), "fletcher32": True} if count else {}
                    group.create_dataset(name, shape=shape, dtype=float, fillvalue=np.nan, **chunks)
                group["times"].attrs["unit"] = "s"
            ends = [0] * len(self._tables)
            for number, times, values in _in_blocks(_rows_of(parts_of(self.path) or ())):
                group, first = made[f"records/{number}"], ends[number] if self._tables[number].grows else 0
                ends[number] = first + len(values)
                group["times"][first : ends[number]], group["values"][first : ends[number]] = times, values
            if ends != self._counts:
                raise OSError("another program changed it meanwhile")
        put_digest(file)

    def _unwritten(self, error: Exception) -> FileError:
        return FileError(f"{self.path} cannot grow: {error}. Remedy: another disk, or fewer channels")


def read_head(path: str | Path) -> dict[str, str]:
    """Return the header of a file.

    Raises
    ------
    FileError
        If it does not exist, is damaged, or is no file of tables.
    MissingDependency
        If h5py is not installed.
    """
    path = regular_file(path, whole=False)
    with _refusals(path):
        if (parts := parts_of(path)) is not None:
            return _head_of(parts)
        with opened_sealed(path) as file:
            return {name: value for name, value in file.attrs.items() if isinstance(value, str)}


def read_part(path: str | Path, number: int, column: int) -> tuple[np.ndarray, np.ndarray]:
    """Return times and values of a column of a table, as far as they are sealed.

    Raises
    ------
    FileError
        If it does not exist, is damaged, or is no file of tables.
    """
    path = regular_file(path, whole=False)
    with _refusals(path):
        if (parts := parts_of(path)) is not None:
            return _column_of(parts, number, column)
        with opened_sealed(path) as file:
            times = array_at(file, f"records/{number}/times")[...]
            values = array_at(file, f"records/{number}/values")[:, column]
        return (times[:, column] if times.ndim == 2 else times), values


@contextlib.contextmanager
def _refusals(path: Path) -> Iterator[None]:
    """Raise a FileError for what a file of another kind, or a damaged one, raises."""
    try:
        yield
    except (OSError, RuntimeError, KeyError, IndexError, ValueError, TypeError, MemoryError) as error:
        raise FileError(f"{path} is damaged, or no file of records of this kanefe: {error}. {REMEDY}") from error


def _head_of(parts: Iterable[Part]) -> dict[str, str]:
    """Return the header of a file of parts: what its first part has, and its last one if it was closed."""
    head: dict[str, str] = {}
    for number, content in parts:
        if number == 0:
            head |= json.loads(content)
    if not head:
        raise ValueError("its first part is not whole")
    return head


def _column_of(parts: Iterable[Part], number: int, column: int) -> tuple[np.ndarray, np.ndarray]:
    times, values = [np.zeros(0)], [np.zeros(0)]
    for table, some_times, some_values in _rows_of(parts):
        if table == number and some_times.ndim == 2:  # the extremes so far
            times, values = [some_times[:, column]], [some_values[:, column]]
        elif table == number:
            times.append(some_times)
            values.append(some_values[:, column].copy())
    return np.concatenate(times), np.concatenate(values)


def _rows_of(parts: Iterable[Part]) -> Iterator[_Rows]:
    """Yield the rows of all tables of a file of parts, in the order in which they were written."""
    layouts: list[Layout] = []
    for number, content in parts:
        if number == 0:
            layouts = layouts or [Layout(*layout) for layout in json.loads(json.loads(content)[LAYOUTS])]
            continue
        width, grows = layouts[number - 1]
        data = np.frombuffer(content, "<f8")
        if grows:
            count = len(data) // (1 + width)
            yield _Rows(number - 1, data[:count], data[count:].reshape(count, width))
        else:
            yield _Rows(number - 1, *data.reshape(2, 2, width))


def _in_blocks(rows: Iterable[_Rows]) -> Iterator[_Rows]:
    """Yield rows of all tables, those of a table that grows together: HDF5 takes a millisecond for each write."""
    waiting: dict[int, list[_Rows]] = {}
    sizes: Counter[int] = Counter()
    for some in rows:
        number = some.number
        if some.times.ndim == 2:
            waiting[number] = [some]
            continue
        waiting.setdefault(number, []).append(some)
        sizes[number] += some.values.nbytes
        if sizes[number] > BLOCK_BYTES:
            del sizes[number]
            yield _together(waiting.pop(number))
    yield from map(_together, waiting.values())


def _together(blocks: Sequence[_Rows]) -> _Rows:
    number, times, values = zip(*blocks, strict=True)
    return _Rows(number[0], np.concatenate(times), np.concatenate(values))
