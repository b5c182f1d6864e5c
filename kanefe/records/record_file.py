"""Files of records: what `kanefe.load_records` reads."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path

from kanefe.arguments import checked
from kanefe.errors import FileError
from kanefe.integrate.status import RunStatus
from kanefe.records.table import Columns, columns_in_file
from kanefe.results.recorded import Recorded
from kanefe.storage.growing_file import read_head

FORMAT = "kanefe records"
VERSION = 2
"""Version of the file."""


class RecordFile(Mapping[str, Recorded]):
    """The recorded columns of a file, by name; values are read when they are asked for.

    Attributes
    ----------
    path : Path
    status : RunStatus or None
        How the run ended; None: it goes on, or its process was killed.
    """

    def __init__(self, path: Path, columns: Mapping[str, Recorded], status: RunStatus | None) -> None:
        self.path, self.status, self._columns = path, status, columns

    def __getitem__(self, name: str) -> Recorded:
        return self._columns[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def __str__(self) -> str:
        ended = "the run goes on, or was killed" if self.status is None else str(self.status)
        return "\n".join([f"records in {self.path}: {ended}", *(f"  {column!r}" for column in self.values())])


@checked
def load_records(path: str | Path) -> RecordFile:
    """Read what ``simulate(..., record_file=path)`` has written, also while the run goes on or after it was killed.

    Parameters
    ----------
    path : path

    Raises
    ------
    FileError
        If it does not exist, was damaged, or is no such file.
    MissingDependency
        If h5py is not installed.

    Examples
    --------
    ``kf.load_records("run.h5")["position arm x"].values``
    """
    path = Path(path)
    header = read_head(path)
    if header.get("format") != FORMAT:
        raise FileError(f"{path} is no file of records. Remedy: one that simulate(..., record_file=...) wrote")
    if header.get("version") != str(VERSION):
        raise FileError(
            f"{path} has version {header.get('version')}, this kanefe reads {VERSION}. Remedy: record the run again"
        )
    try:
        tables = [
            Columns(tuple(t["names"]), tuple(t["units"]), bool(t["is_extremes"])) for t in json.loads(header["tables"])
        ]
        status = RunStatus(**json.loads(header["status"])) if "status" in header else None
    except (KeyError, ValueError, TypeError) as error:
        raise FileError(f"{path} is damaged ({error!r}). Remedy: record the run again") from error
    columns: dict[str, Recorded] = {}
    for i, table in enumerate(tables):
        columns |= columns_in_file(path, i, table)
    return RecordFile(path, columns, status)
