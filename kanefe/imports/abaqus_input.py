"""Keywords of input files of Abaqus and CalculiX, with their data and those of the files that they include."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np

from kanefe.errors import FileError
from kanefe.imports.included import DeckFile
from kanefe.imports.text import number, plain_numbers

_ENDS_WITH_COMMA = re.compile(r",[ \t]*(?=\n|$)")

_OPTION = re.compile(r"[A-Za-z][\w ]*(=.*)?|")
"""A parameter of a line that goes on. CalculiX 2.20 has no such lines: what is no parameter is a line of data."""

FLAGS = ("GENERATE", "UNSORTED", "INTERNAL", "SHIFT", "LOCAL", "PERTURBATION", "STIFFNESS", "MASS", "LINEAR", "UNSYMM")
"""Parameters without a value that a line which goes on may begin with."""

_WHOLE = ("SYSTEM", "NCOPY", "INSTANCE", "TRANSFORM")
"""Keywords whose lines belong together, so that they are in one file."""

_COMMA, _NEWLINE = 44, 10


class Table(NamedTuple):
    """Numbers of data lines, all of them at once.

    Attributes
    ----------
    values : ndarray, shape (n,)
    counts : ndarray of int
        How many each line has.
    """

    values: np.ndarray
    counts: np.ndarray


class Keyword:
    """One keyword line of an input file with the lines that follow it.

    Attributes
    ----------
    name : str
        Upper case, without the star and without blanks, which mean nothing.
    options : dict of str to str
        Upper-case names; an option without a value has "".
    file : str
        Name of the file.
    at : int
        Number of its line in it.
    pieces : list of (int, str)
        Its data: text between comments, with the number of its first line.
    comments : list of str
        Comment lines among them, without their stars.
    """

    def __init__(self, name: str, options: dict[str, str], file: str, at: int) -> None:
        self.name, self.options, self.file, self.at = name, options, file, at
        self.pieces: list[tuple[int, str]] = []
        self.comments: list[str] = []

    @cached_property
    def numbered(self) -> list[tuple[int, str]]:
        """Data lines that are not blank, each with its number."""
        return [
            (at, line.strip())
            for first, text in self.pieces
            for at, line in enumerate(text.split("\n"), first)
            if line.strip()
        ]

    @property
    def lines(self) -> list[str]:
        """Data lines that are not blank."""
        return [line for _, line in self.numbered]

    def option(self, name: str) -> str:
        """Return the value of an option that must be there."""
        value = self.options.get(name, "").strip()
        if not value:
            raise self.refused(f"has no {name}=. Remedy: check that its line is complete")
        return value

    def rows(self) -> Iterator[tuple[int, list[str]]]:
        """Yield number and fields of the data lines; a comma at their end is none of theirs."""
        for at, line in self.numbered:
            yield at, [part.strip() for part in line.rstrip(", \t").split(",")]

    def table(self) -> Table | None:
        """Return the numbers of all data lines at once, or None if a field is left out or not plainly a number."""
        text = "\n".join(piece.strip("\n") for _, piece in self.pieces)
        if ",\n" in text or ", \n" in text or text.rstrip().endswith(","):
            text = _ENDS_WITH_COMMA.sub("", text)
        values = plain_numbers(text.replace("\n", ","), " , ")
        if values is None:
            return None
        codes = np.frombuffer(text.encode("latin-1"), dtype=np.uint8)
        ends = np.append(np.flatnonzero(codes == _NEWLINE), len(codes))
        commas = np.searchsorted(np.flatnonzero(codes == _COMMA), ends)
        counts = np.diff(commas, prepend=0) + 1
        return Table(values, counts) if counts.sum() == len(values) else None

    def refused(self, reason: str, at: int | None = None) -> FileError:
        """Return the error of a keyword, or of one of its lines; the reason is the end of a sentence."""
        return FileError(f"{self.file}: *{self.name} (line {self.at if at is None else at}) {reason}")

    def label(self, text: str, at: int) -> int:
        """Return the label of a node or element; a FileError with the line if it is none."""
        try:
            value = number(text)
        except ValueError:
            value = 0.0
        if value < 1 or value != int(value):
            raise self.refused(f"has {text!r} where a label should be. Remedy: check that the file is complete", at)
        return int(value)

    def number(self, text: str, at: int) -> float:
        """Return the number of a field, 0 if it was left out; a FileError with the line if it is none."""
        try:
            return number(text) if text else 0.0
        except ValueError:
            raise self.refused(
                f"has {text!r}, which is not a number. Remedy: check that the file is complete", at
            ) from None


def deck_keywords(path: Path, *, trusted: bool, reader: str) -> list[Keyword]:
    """Return the keywords of an input file, those of the files that it includes in their places.

    Parameters
    ----------
    path : Path
    trusted : bool
        Whether it may include files outside its folder.
    reader : str
        The function that the user called.

    Raises
    ------
    FileError
        If the file or one that it includes is not there, or elsewhere without being trusted, or as `keywords`.
    """
    return _with_included(DeckFile(path, path, trusted, reader), [])


def _with_included(file: DeckFile, found: list[Keyword]) -> list[Keyword]:
    """Add the keywords of a file to those before it."""
    for block in _blocks(file.text("Abaqus input"), file.path.name):
        if block.name == "INCLUDE":
            _with_included(file.included(block.option("INPUT").strip("\"'"), block.at), found)
        elif block.name:
            found.append(block)
        if block.name in ("", "INCLUDE") and block.pieces:
            found.append(_gone_on(block, found))
    return found


def _gone_on(data: Keyword, found: list[Keyword]) -> Keyword:
    """Return the last keyword once more, with data that begin a file, or that follow one that is included."""
    at = data.pieces[0][0]
    if not found or found[-1].name in _WHOLE:
        before = f"are those of *{found[-1].name}, which is in one file" if found else "are before its first keyword"
        raise FileError(f"{data.file} has data that {before} (line {at}). Remedy: check that it is complete")
    block = Keyword(found[-1].name, found[-1].options, data.file, at)
    block.pieces = data.pieces
    return block


def keywords(text: str, file: str) -> list[Keyword]:
    """Return the keywords of a text in their order.

    A keyword line that ends with a comma goes on in the next one, as in Abaqus, if that has parameters.

    Raises
    ------
    FileError
        If data are before the first keyword, or one has no name.
    """
    blocks = _blocks(text, file)
    if blocks and not blocks[0].name:
        _gone_on(blocks[0], [])
    return blocks


def _blocks(text: str, file: str) -> list[Keyword]:
    """Return the keywords of a text; data before the first one are those of one without a name."""
    blocks: list[Keyword] = []
    after, line = 0, 1  # what is read ends before this character, which is of this line
    for first, last in _starred(text):
        if first < after:
            continue
        _add_data(blocks, text[after:first], line, file)
        line += text.count("\n", after, first)
        content, after = text[first:last].strip(), last + 1
        if content.startswith("**"):
            if blocks:
                blocks[-1].comments.append(content.lstrip("*").strip())
            line += 1
            continue
        at = line
        while content.endswith(",") and after < len(text):
            end = text.find("\n", after)
            more = text[after : end if end >= 0 else len(text)].strip()
            if not _goes_on(more):
                break
            content, line, after = content + more, line + 1, (end if end >= 0 else len(text)) + 1
        name, *fields = content.lstrip("*").split(",")
        if not name.strip():
            raise FileError(f"{file} has a keyword without a name (line {at}). Remedy: check that the file is complete")
        options = [field.partition("=") for field in fields if field.strip()]
        blocks.append(
            Keyword(
                "".join(name.split()).upper(),
                {" ".join(option.split()).upper(): value.strip() for option, _, value in options},
                file,
                at,
            )
        )
        line += 1
    _add_data(blocks, text[after:], line, file)
    return blocks


def _starred(text: str) -> Iterator[tuple[int, int]]:
    """Yield where lines whose first character is a star begin and end."""
    star = text.find("*")
    while star >= 0:
        first = text.rfind("\n", 0, star) + 1
        last = text.find("\n", star)
        last = len(text) if last < 0 else last
        if not text[first:star].strip():
            yield first, last
        star = text.find("*", last)


def _goes_on(line: str) -> bool:
    fields = [field.strip() for field in line.rstrip(",").split(",")]
    return line[:1] != "*" and all(
        _OPTION.fullmatch(field) and ("=" in field or field.upper() in FLAGS) for field in fields if field
    )


def _add_data(blocks: list[Keyword], text: str, line: int, file: str) -> None:
    if not text.strip():
        return
    if not blocks:
        blocks.append(Keyword("", {}, file, line))
        line += text[: len(text) - len(text.lstrip())].count("\n")
        text = text.lstrip()
    blocks[-1].pieces.append((line, text.rstrip()))
