"""Matrices in op4 files of Nastran (OUTPUT4): binary, of both byte orders and widths of words, and text.

A binary file has Fortran records: a length of four bytes, the data, and the length again. A matrix is a head (columns,
rows, form, type, name), a record for each column that is not zero (column, first row, words, values), and one of a
column beyond the last. First row 0 says that the column has strings: each is one word ``65536 (L + 1) + row``, or two,
``L + 1, row``, if the head has the rows with a minus, and L words of values. A text file has the same in lines.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from kanefe.errors import FileError, ModelError
from kanefe.storage.files import regular_file

REAL, DOUBLE, LAST_TYPE = 1, 2, 4
"""Types of numbers: single, double; those up to the last are complex."""

LARGE = 65536
"""Number of rows from which strings have two words in front."""

_HEAD_LINE = re.compile(
    r"[ \d]{7}\d[ \d-]{7}\d[ \d]{7}\d[ \d]{7}[1-4].{0,8} *(?:(?:1P,)?(\d+)[EDed](\d+)\.\d+)? *(?:\|I8)?"
)


class _Column(NamedTuple):
    number: int
    rows: np.ndarray
    values: np.ndarray
    is_whole: bool


def is_output4(head: bytes) -> bool:
    """Return whether a file that begins with some bytes (100 or more, if it has as many) is an op4 file."""
    for order in ("<", ">"):
        length = int(np.frombuffer(head[:4].ljust(4, b"\0"), f"{order}i4")[0])
        if length in (24, 48) and head[4 + length : 8 + length] == head[:4]:
            return True
    return _HEAD_LINE.fullmatch(head.partition(b"\n")[0].decode("latin-1").rstrip()) is not None


def output4_matrices(path: Path, wanted: Collection[str]) -> dict[str, sp.csr_matrix]:
    """Return the matrices of an op4 file by upper-case name, those that are wanted.

    Raises
    ------
    FileError
        If the file is damaged; the message has the byte or the line.
    ModelError
        If a matrix that is wanted is complex, or there twice in different ways.
    """
    content = regular_file(path, "for the matrices").read_bytes()
    length = content[:4]
    if length in (np.array(n, f"{order}i4").tobytes() for n in (24, 48) for order in "<>"):
        return _matrices(_Binary(path, content), wanted)
    return _matrices(_Text(path, content.decode("latin-1")), wanted)


class _Damage:
    """What is common to both layouts: errors with their place."""

    path: Path

    def refused(self, reason: str, place: str) -> FileError:
        return FileError(f"{self.path}: {reason} ({place}): it is damaged or no op4 file. Remedy: export it again")


class _Binary(_Damage):
    """Heads and columns of a binary file."""

    def __init__(self, path: Path, content: bytes) -> None:
        self.path, self.content, self.at = path, content, 0
        order = "<" if int.from_bytes(content[:4], "little") in (24, 48) else ">"
        self.length = np.dtype(f"{order}i4")
        self.word = 4 if int(np.frombuffer(content[:4], self.length)[0]) == 24 else 8
        self.whole, self.single, self.double = (
            np.dtype(f"{order}{k}") for k in (f"i{self.word}", f"f{self.word}", "f8")
        )

    @property
    def place(self) -> str:
        return f"byte {self.at}"

    @property
    def has_more(self) -> bool:
        return self.at < len(self.content)

    def _record(self) -> bytes:
        if self.at + 4 > len(self.content):
            raise self.refused("it ends within a matrix", self.place)
        length = int(np.frombuffer(self.content, self.length, 1, self.at)[0])
        end = self.at + 4 + length
        if length < 0 or self.content[end : end + 4] != self.content[self.at : self.at + 4]:
            raise self.refused("a record has not the length that it says", self.place)
        data = self.content[self.at + 4 : end]
        self.at = end + 4
        return data

    def head(self) -> tuple[list[int], str]:
        place, data = self.place, self._record()
        if len(data) != 6 * self.word:
            raise self.refused("there is no head of a matrix", place)
        numbers = np.frombuffer(data, self.whole, 4).tolist()
        return numbers, data[4 * self.word :].decode("latin-1")

    def column(self, columns: int) -> tuple[list[int], _BinaryWords] | None:
        place, data = self.place, self._record()
        if len(data) < 3 * self.word:
            raise self.refused("there is no column of a matrix", place)
        numbers = np.frombuffer(data, self.whole, 3).tolist()
        if numbers[0] == columns + 1:
            return None
        if numbers[2] < 0 or len(data) != (3 + numbers[2]) * self.word:
            raise self.refused("a column has not the words that it says", place)
        return numbers, _BinaryWords(self, data[3 * self.word :])


class _BinaryWords:
    """The words of a column behind its first three."""

    def __init__(self, file: _Binary, data: bytes) -> None:
        self.file, self.data, self.at = file, data, 0

    def wholes(self, count: int) -> list[int]:
        start = self.at
        self.at += count * self.file.word
        return np.frombuffer(self.data[start : self.at], self.file.whole).tolist()

    def values(self, count: int, kind: int) -> np.ndarray:
        start, form = self.at, self.file.single if kind % 2 else self.file.double
        self.at += count * form.itemsize
        return np.frombuffer(self.data[start : self.at], form).astype(float)


class _Text(_Damage):
    """Heads and columns of a text file."""

    def __init__(self, path: Path, text: str) -> None:
        self.path, self.lines, self.at = path, text.splitlines(), 0
        self.width, self.per_line = 16, 5

    @property
    def place(self) -> str:
        return f"line {self.at + 1}"

    @property
    def has_more(self) -> bool:
        return any(line.strip() for line in self.lines[self.at :])

    def line(self) -> str:
        if self.at >= len(self.lines):
            raise self.refused("it ends within a matrix", self.place)
        self.at += 1
        return self.lines[self.at - 1]

    def wholes(self, text: str, most: int) -> list[int]:
        parts = [text[i : i + 8] for i in range(0, 8 * most, 8)]
        try:
            return [int(part) for part in parts if part.strip()]
        except ValueError:
            raise self.refused(f"{text.strip()!r} are not whole numbers", f"line {self.at}") from None

    def head(self) -> tuple[list[int], str]:
        text = self.line().rstrip()
        found = _HEAD_LINE.fullmatch(text)
        if found is None:
            raise self.refused("there is no head of a matrix", f"line {self.at}")
        self.per_line, self.width = int(found[1] or 5), int(found[2] or 16)
        if not (0 < self.per_line and 0 < self.width):
            raise self.refused("a head has no format of numbers", f"line {self.at}")
        return self.wholes(text, 4), text[32:40]

    def column(self, columns: int) -> tuple[list[int], _TextWords] | None:
        numbers = self.wholes(self.line(), 3)
        if len(numbers) != 3 or numbers[2] < 0:
            raise self.refused("there is no column of a matrix", f"line {self.at}")
        if numbers[0] == columns + 1:
            self.line()
            return None
        return numbers, _TextWords(self)


class _TextWords:
    """The lines of a column behind its first."""

    def __init__(self, file: _Text) -> None:
        self.file = file

    def wholes(self, count: int) -> list[int]:
        text = self.file.line()
        found = self.file.wholes(text, count) if count > 1 else [int(text)] if text.strip().isdigit() else []
        if len(found) != count:
            raise self.file.refused("there is no string of a column", f"line {self.file.at}")
        return found

    def values(self, count: int, kind: int) -> np.ndarray:
        found: list[float] = []
        while len(found) < count:
            text = self.file.line().rstrip().upper().replace("D", "E")
            expected = min(self.file.per_line, count - len(found))
            parts = [text[i : i + self.file.width] for i in range(0, len(text), self.file.width)]
            try:
                if len(parts) != expected or len(text) > expected * self.file.width:
                    raise ValueError
                found += [float(part) for part in parts]
            except ValueError:
                raise self.file.refused(f"there are not {expected} numbers", f"line {self.file.at}") from None
        return np.array(found)


def _matrices(file: _Binary | _Text, wanted: Collection[str]) -> dict[str, sp.csr_matrix]:
    found: dict[str, sp.csr_matrix] = {}
    while file.has_more:
        place = file.place
        (columns, rows, _, kind), text = file.head()
        name = text.strip(" \0").upper()
        if not (0 < columns and rows and REAL <= kind <= LAST_TYPE):
            raise file.refused(f"{columns} columns, {rows} rows and type {kind} are no matrix", place)
        if name in wanted and kind > DOUBLE:
            raise ModelError(f"matrix {name} in {file.path} is complex ({place}). Remedy: export K without damping")
        read = list(_columns(file, columns, rows, kind))
        if name in wanted:
            made = _of_columns(file, read, columns, abs(rows), name, place)
            known = found.setdefault(name, made)
            if known is not made and (known.shape != made.shape or (known != made).nnz):
                raise ModelError(
                    f"{file.path} has two matrices {name}, which differ (the second: {place}). Remedy: names= of "
                    "others, or a file with one of them"
                )
    return found


def _columns(file: _Binary | _Text, columns: int, rows: int, kind: int) -> Iterator[_Column]:
    """Yield the columns of a matrix up to its end."""
    last = 0
    parts_each = 1 if kind <= DOUBLE else 2
    is_text = isinstance(file, _Text)
    has_wide_words = isinstance(file, _Binary) and file.word == 8
    while True:
        place = file.place
        found = file.column(columns)
        if found is None:
            return
        (number, row, words), data = found
        if not last < number <= columns:
            raise file.refused(f"column {number} of {columns} follows column {last}", place)
        last = number
        all_rows: list[np.ndarray] = []
        values: list[np.ndarray] = []
        # a text counts numbers in columns without strings, and words in strings
        words_each = parts_each * (1 if kind % 2 or has_wide_words or (is_text and row > 0) else 2)
        left, before = words, 1
        while left > 0:
            first, own, head = _string(data, row, words, rows)
            left -= head
            count = own // words_each
            if own <= 0 or own > left or own % words_each or first < before or first - 1 + count > abs(rows):
                raise file.refused(f"column {number} has {own} words from row {first} of {abs(rows)} on", place)
            values.append(data.values(count * parts_each, kind))
            all_rows.append(np.arange(first - 1, first - 1 + count))
            left, before = left - own, first + count
        if kind <= DOUBLE and values:
            yield _Column(number - 1, np.concatenate(all_rows), np.concatenate(values), row > 0)


def _string(data: _BinaryWords | _TextWords, row: int, words: int, rows: int) -> tuple[int, int, int]:
    """Return the first row of the next string of a column, its length and that of its head, in words."""
    if row > 0:
        return row, words, 0
    if rows < 0 or rows >= LARGE:
        own, first = data.wholes(2)
        return first, own - 1, 2
    own, first = divmod(data.wholes(1)[0], LARGE)
    return first, own - 1, 1


def _of_columns(
    file: _Binary | _Text, read: list[_Column], columns: int, rows: int, name: str, place: str
) -> sp.csr_matrix:
    """Return a matrix of its columns; a program that writes zeros at their ends writes every column."""
    writes_zeros = any(c.is_whole and len(c.values) == rows and 0.0 in c.values[[0, -1]] for c in read)
    if writes_zeros and len(read) < columns:
        lost = sorted(set(range(columns)) - {c.number for c in read})
        raise file.refused(f"matrix {name} has lost column {lost[0] + 1} of {columns}", place)
    if not read:
        return sp.csr_matrix((rows, columns))
    at = np.concatenate([np.full(len(c.rows), c.number) for c in read])
    entries = np.concatenate([c.values for c in read]), (np.concatenate([c.rows for c in read]), at)
    return sp.csr_matrix(entries, shape=(rows, columns))
