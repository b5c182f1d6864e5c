"""How results of verification are shown: a table as they come, and a JSON file."""

from __future__ import annotations

import json
import math
import os
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TextIO

from kanefe.errors import FileError

QUANTITY_WIDTH = 92
WIDTHS = (16, 16, 8, 9, 7)
"""Of the columns of numbers."""


@dataclass(frozen=True)
class Row:
    """One line of the table and one object of the JSON list: see `kanefe.checks.verification.case.Check`.

    Attributes
    ----------
    seconds : float
        Time to compute this row once the one before was done.
    """

    case: str
    quantity: str
    value: float
    reference: float
    error: float
    tolerance: float
    seconds: float
    passed: bool


class Table:
    """A table that grows row by row."""

    def __init__(self, stream: TextIO) -> None:
        self.stream = stream
        self._print("case", "quantity", "value", "reference", "error", "tolerance", "seconds")

    def add(self, row: Row) -> None:
        """Print a row."""
        self._print(
            row.case,
            row.quantity,
            f"{row.value:.10g}",
            f"{row.reference:.10g}",
            f"{row.error:.1e}",
            f"{row.tolerance:.1e}",
            f"{row.seconds:.2f}",
            "" if row.passed else "  MISSED",
        )

    def note(self, case: str, text: str) -> None:
        """Print a line about a case that has no numbers."""
        print(f"{case:5} {text}", file=self.stream, flush=True)

    def _print(self, case: str, quantity: str, *rest: str) -> None:
        columns = [f"{text:>{width}}" for text, width in zip(rest, WIDTHS, strict=False)]
        mark = "".join(rest[len(WIDTHS) :])
        print(f"{case:5} {quantity:{QUANTITY_WIDTH}} {' '.join(columns)}{mark}", file=self.stream, flush=True)


def check_json_path(path: str) -> None:
    """Raise a FileError if a file could not be written at `path` ("-" is the standard output)."""
    if path == "-":
        return
    target = Path(path)
    folder = target.parent
    if not folder.is_dir():
        raise FileError(f"cannot write {path}: there is no folder {folder}. Remedy: make it, or choose another")
    if target.is_dir():
        raise FileError(f"cannot write {path}: it is a folder. Remedy: give the name of a file")
    if not os.access(folder, os.W_OK):
        raise FileError(f"cannot write {path}: no permission to write in {folder}. Remedy: choose another folder")


def write_json(rows: Sequence[Row], path: str) -> None:
    """Write the rows as a JSON list to a file, or to the standard output if `path` is "-".

    The file is replaced at once when it is complete. Numbers that are not finite become null, which JSON knows.

    Raises
    ------
    FileError
        If the file cannot be written; an old one stays as it was.
    """
    objects = [
        {key: None if isinstance(x, float) and not math.isfinite(x) else x for key, x in asdict(row).items()}
        for row in rows
    ]
    text = json.dumps(objects, indent=1, allow_nan=False) + "\n"
    if path == "-":
        sys.stdout.write(text)
        sys.stdout.flush()
        return
    target = Path(path)
    temporary = None
    try:
        with tempfile.NamedTemporaryFile("w", dir=target.parent, delete=False, encoding="utf-8") as file:
            temporary = Path(file.name)
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        temporary.chmod(0o644)
        temporary.replace(target)
    except OSError as problem:
        if temporary is not None:
            temporary.unlink(missing_ok=True)
        raise FileError(
            f"cannot write {path}: {problem}. Remedy: free some space, or choose another folder"
        ) from problem
