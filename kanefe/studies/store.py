"""The folder of a study: a header that describes it, and rows that are only ever appended.

::

    study.json      format, versions, parameters, options and source of the functions
    rows/00001.jsonl, rows/00002.jsonl, ...    one line per case; one file for each call of Study.run
    spare           space that is released for the last rows when the disk is full

A line is written when its case is done, so that a killed process loses no finished case; an incomplete last line is
ignored. Each line, and the header, end with their checksum: a damaged line is ignored with a warning, and its case
counts as not run. Of lines with the same key the last one counts.
"""

from __future__ import annotations

import json
import os
import time
import warnings
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, BinaryIO

from kanefe.errors import FileError, SimulationWarning
from kanefe.storage.files import possible_path, regular_file, write_whole
from kanefe.storage.sealed import sealed, unsealed

FORMAT, VERSION = "kanefe study", 2
"""Format and version of the file. Version 1 had no checksums."""

HEADER, ROWS, SPARE = "study.json", "rows", "spare"

SPARE_BYTES = 1 << 20
"""Size of the spare file, bytes, larger than the rows of the running cases."""

SECONDS_TO_DISK = 1.0
"""Longest time for which a row stays in the memory of the operating system, s. It survives a killed process there, but
not a power failure."""

NEEDED = ("key", "parameters", "outputs", "status", "reason", "simulated", "warnings", "wall", "cpu", "worker")
"""Required entries of a row."""

SAME = ("identity", "kanefe", "build", "outputs", "options")
"""Entries of a header that must be the same in a store and in a study that continues it. Parameters may differ: cases
are then added."""


class Store:
    """The folder of a study.

    Parameters
    ----------
    folder : path
    """

    def __init__(self, folder: str | Path) -> None:
        self.folder = possible_path(folder)

    def begin(self, header: Mapping[str, Any]) -> None:
        """Create the folder, or continue one of the same study, or one without rows.

        Raises
        ------
        FileError
            If the folder contains another study or other files, or cannot be written.
        """
        path = self.folder / HEADER
        if os.path.exists(path):
            if next(self.rows(), None) is not None:
                self.check_same(header)
        elif os.path.isdir(self.folder) and self._has_others():
            raise FileError(f"{self.folder} contains other files than a study. Remedy: a folder of its own")
        text = sealed({"format": FORMAT, "version": VERSION, **header})
        write_whole(path, lambda file: file.write(text.encode()))
        try:
            (self.folder / ROWS).mkdir(exist_ok=True)
        except OSError as error:
            raise FileError(
                f"cannot create the folder {self.folder / ROWS}: {error.strerror}. Remedy: another folder for the study"
            ) from error
        if not (self.folder / SPARE).exists():
            write_whole(self.folder / SPARE, lambda file: file.write(bytes(SPARE_BYTES)))

    def _has_others(self) -> bool:
        """Return whether there is anything in the folder."""
        try:
            return any(self.folder.iterdir())
        except OSError as error:
            raise FileError(f"cannot read {self.folder}: {error.strerror}. Remedy: another folder") from error

    def header(self) -> dict[str, Any]:
        """Return the header of the study.

        Raises
        ------
        FileError
            If there is none, or it is damaged or of another format.
        """
        path = self.folder / HEADER
        if not os.path.lexists(path):
            raise FileError(f"{self.folder} holds no study. Remedy: check the path")
        try:
            header = unsealed(regular_file(path).read_bytes())
        except (OSError, ValueError, RecursionError) as error:
            if isinstance(error, FileError):
                raise
            raise FileError(
                f"{path} cannot be read: {error}. It is damaged, or of another version of kanefe. Remedy: the version "
                "that wrote it, or run the study into another folder"
            ) from error
        if (header.get("format"), header.get("version")) != (FORMAT, VERSION):
            raise FileError(f"{path} is not of a study that this kanefe reads. Remedy: the version that wrote it")
        return header

    def rows(self) -> Iterator[dict[str, Any]]:
        """Yield all rows in the order in which they were written.

        Raises
        ------
        FileError
            If a file of rows cannot be read.

        Warns
        -----
        SimulationWarning
            For damaged lines.
        """
        for path in sorted((self.folder / ROWS).glob("*.jsonl")):
            with regular_file(path, whole=False).open("rb") as file:
                for number, line in enumerate(file, 1):
                    if line.endswith(b"\n"):  # else the process was killed or the disk full
                        try:
                            yield _row(line)
                        except (ValueError, RecursionError) as error:
                            warnings.warn(
                                f"line {number} of {path} is left out: {error}. Its case counts as not run. Remedy: "
                                "run the study again into this store, which runs that case again",
                                SimulationWarning,
                                stacklevel=2,
                            )

    def writer(self) -> RowWriter:
        """Return a writer of rows to a new file."""
        return RowWriter(self.folder)

    def check_same(self, wanted: Mapping[str, Any]) -> None:
        """Raise a FileError if the study of the folder differs from another one, naming the differences."""
        there = self.header()
        differing = [name for name in SAME if there.get(name) != json.loads(json.dumps(wanted[name]))]
        if not differing:
            return
        if differing == ["identity"]:
            what = "the functions, constants or data that build or outputs use"
        else:
            what = ", ".join(_difference(name, there, wanted) for name in differing if name != "identity")
        raise FileError(
            f"{self.folder} contains another study: it differs in {what}. Remedy: another folder, or the original study"
        )


def _row(line: bytes) -> dict[str, Any]:
    """Return the row of a line; raise a ValueError if it is not a row."""
    row = unsealed(line)
    missing = [name for name in NEEDED if name not in row]
    if missing:
        raise ValueError(f"it is not a row of a study, without {', '.join(missing)}")
    return row


def _difference(name: str, there: Mapping[str, Any], wanted: Mapping[str, Any]) -> str:
    if name in ("build", "outputs"):
        old, new = there[name]["name"], wanted[name]["name"]
        return f"{name} ({old} there, {new} here)" if old != new else f"the source of {name} ({new})"
    return f"{name} ({there[name]} there, {wanted[name]} here)"


class RowWriter:
    """Adds rows to a store; a context.

    Raises
    ------
    FileError
        If a row cannot be written; earlier ones are kept.
    """

    def __init__(self, folder: Path) -> None:
        self._spare = folder / SPARE
        self._file = _new_file(folder / ROWS)
        self._size = 0
        self._synced = time.monotonic()

    def __enter__(self) -> RowWriter:
        return self

    def __exit__(self, *error: object) -> None:
        self._sync()
        self._file.close()

    def add(self, lines: str) -> None:
        """Write lines; if the disk is full, use the spare space and then raise a FileError nevertheless."""
        data = lines.encode()
        try:
            self._write(data)
        except OSError as error:
            kept = self._try_spare(data)
            raise FileError(
                f"cannot write {self._file.name}: {error.strerror or error}. "
                + ("All finished cases are in the store. " if kept else "All cases before are in the store. ")
                + "Remedy: free some space and run the study again: it continues"
            ) from error
        if time.monotonic() - self._synced > SECONDS_TO_DISK:
            self._sync()

    def _write(self, data: bytes) -> None:
        """Write all of it, or nothing."""
        try:
            rest = memoryview(data)
            while rest:
                rest = rest[self._file.write(rest) :]
        except OSError:
            self._file.truncate(self._size)
            self._file.seek(self._size)
            raise
        self._size += len(data)

    def _try_spare(self, data: bytes) -> bool:
        try:
            self._spare.unlink(missing_ok=True)
            self._write(data)
        except OSError:
            return False
        return True

    def _sync(self) -> None:
        os.fsync(self._file.fileno())
        self._synced = time.monotonic()


def _new_file(folder: Path) -> BinaryIO:
    """Create the next file of rows, which no other process uses."""
    number = max((int(path.stem) for path in folder.glob("*.jsonl") if path.stem.isdecimal()), default=0)
    while True:
        number += 1
        try:
            return (folder / f"{number:05d}.jsonl").open("xb", buffering=0)
        except FileExistsError:
            continue
        except OSError as error:
            raise FileError(f"cannot write into {folder}: {error.strerror}. Remedy: another folder") from error
