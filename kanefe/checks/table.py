"""Output of findings: a table that grows as they are known, and a JSON file."""

from __future__ import annotations

import json
import math
import os
import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, Generic, Protocol, TextIO, TypeVar

from kanefe.checks.runner import NotRun
from kanefe.errors import FileError
from kanefe.storage.files import write_whole


class _Row(Protocol):
    """One line of a table: its cells, the text after them, and whether its value is within the limit."""

    @property
    def texts(self) -> Sequence[str]: ...
    @property
    def mark(self) -> str: ...
    @property
    def passed(self) -> bool: ...


SomeRow = TypeVar("SomeRow", bound=_Row)


class GrowingTable(Generic[SomeRow]):
    """A table that is printed row by row and keeps its rows.

    Attributes
    ----------
    stream : TextIO
    rows : list
    not_run : list of NotRun
    """

    header: tuple[str, ...]
    formats: tuple[str, ...]
    gap = " "
    """Names and formats of the columns, the first of which is the name of the case, and the text between them."""

    def __init__(self, stream: TextIO) -> None:
        self.stream = stream
        self.rows: list[SomeRow] = []
        self.not_run: list[NotRun] = []
        self._print(self.header, "")

    def add(self, outcome: SomeRow | NotRun) -> None:
        """Print the outcome of a part of a case."""
        if isinstance(outcome, NotRun):
            self.not_run.append(outcome)
            self.note(outcome.case, f"not run: needs {outcome.package}")
        else:
            self.rows.append(outcome)
            self._print(outcome.texts, outcome.mark)

    def note(self, case: str, text: str) -> None:
        """Print a line about a case without a value."""
        print(f"{case:{self.formats[0]}} {text}", file=self.stream, flush=True)

    def exit_code(self, was_asked: bool) -> int:
        """Return 0 if all passed, 1 if one did not, or if a requested case could not run."""
        return int(not all(row.passed for row in self.rows) or (was_asked and bool(self.not_run)))

    def _print(self, texts: Sequence[str], mark: str) -> None:
        cells = (f"{text:{form}}" for text, form in zip(texts, self.formats, strict=True))
        print(self.gap.join(cells).rstrip() + mark, file=self.stream, flush=True)


def check_target(path: str | None) -> None:
    """Raise a FileError if a file could not be written at `path` ("-" is the standard output, None is no file)."""
    if path is None or path == "-":
        return
    folder = Path(path).parent
    if not folder.is_dir():
        raise FileError(f"cannot write {path}: there is no folder {folder}. Remedy: make it, or choose another")
    if Path(path).is_dir():
        raise FileError(f"cannot write {path}: it is a folder. Remedy: give the name of a file")
    if not os.access(folder, os.W_OK):
        raise FileError(f"cannot write {path}: no permission to write in {folder}. Remedy: choose another folder")


def write_json(rows: Sequence[Any], path: str) -> None:
    """Write rows, which are dataclasses, as a JSON list to a file, or to the standard output if `path` is "-".

    Numbers that are not finite become null.

    Raises
    ------
    FileError
        If the file cannot be written; an existing one is not changed.
    """
    objects = [
        {key: None if isinstance(x, float) and not math.isfinite(x) else x for key, x in asdict(row).items()}
        for row in rows
    ]
    write_as_json(objects, path)


def write_as_json(value: object, path: str) -> None:
    """Write a value as JSON to a file, or to the standard output if `path` is "-".

    Raises
    ------
    FileError
        If the file cannot be written; an existing one is not changed.
    """
    text = json.dumps(value, indent=1, allow_nan=False) + "\n"
    if path == "-":
        sys.stdout.write(text)
        sys.stdout.flush()
    else:
        write_whole(path, lambda file: file.write(text.encode("utf-8")))
