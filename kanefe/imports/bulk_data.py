"""Cards of Nastran's bulk data: fields of all widths, continuations, replication and included files."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from kanefe.errors import FileError
from kanefe.imports.included import DeckFile
from kanefe.imports.text import number as as_number

_BLANK = ("",) * 8

_BEGINS_INCLUDE = ("I", "i", " ", "\t")

_BEGIN = re.compile(r"\s*BEGIN +(BULK|SUPER)\b", re.IGNORECASE)

_REPEATED = re.compile(r"=\(?(\d+)\)?")  # the card before once more, or so many times

_RAISED = re.compile(r"\*\(?([^()]+)\)?")  # the field of the card before, raised by this


class Card(NamedTuple):
    """A card of bulk data.

    Attributes
    ----------
    name : str
        Upper case, without its star.
    fields : tuple of str
        Those after the name, each in its place; "" where one is left out.
    file : str
        Name of the file.
    at : int
        Number of its line in it.
    """

    name: str
    fields: tuple[str, ...]
    file: str
    at: int

    def field(self, number: int) -> str:
        """Return a field, counted from 2 as in manuals; "" if it was left out."""
        return self.fields[number - 2] if number - 2 < len(self.fields) else ""

    def whole(self, number: int) -> int:
        """Return the whole number of a field; a FileError names field and line if it is none."""
        try:
            return int(self.field(number))
        except ValueError:
            raise self._no_number(number, "a whole number") from None

    def number(self, number: int) -> float:
        """Return the number of a field, 0 if it was left out; a FileError names field and line if it is none."""
        try:
            return as_number(self.field(number) or "0")
        except ValueError:
            raise self._no_number(number, "a number") from None

    def numbers(self, first: int, count: int) -> list[float]:
        """Return the numbers of some fields; those that are left out are 0."""
        found = self.fields[first - 2 : first - 2 + count]
        try:
            return [as_number(text or "0") for text in found] + [0.0] * (count - len(found))
        except ValueError:
            return [self.number(first + i) for i in range(count)]

    def wholes(self, first: int, count: int) -> list[int]:
        """Return the whole numbers of some fields."""
        try:
            return [int(text) for text in self.fields[first - 2 : first - 2 + count]]
        except ValueError:
            return [self.whole(first + i) for i in range(count)]

    def refused(self, reason: str) -> FileError:
        """Return the error of a card that is not as it should be; the reason is the end of a sentence."""
        return FileError(f"{self.file}: {self.name} {self.field(2)} (line {self.at}) {reason}")

    def _no_number(self, number: int, what: str) -> FileError:
        return FileError(
            f"{self.file}: field {number} of {self.name} (line {self.at}) is {self.field(number)!r}, and should be "
            f"{what}. Remedy: check that the file is complete, and the columns of its fields"
        )


class _Line(NamedTuple):
    text: str
    file: str
    at: int


def bulk_cards(path: Path, *, trusted: bool = False, reader: str = "read_nastran") -> list[Card]:
    """Return the cards of the bulk data of a deck, with those of the files that it includes.

    A deck without BEGIN BULK is bulk data alone (a punch file).

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
        If the deck or a file that it includes is not there, or has no end; if a continuation follows no card, or
        another than it names; if a line has too many fields, or repeats what is not there. The message has the line.
    """
    found: list[Card] = []
    mark = ""
    for line in _bulk(_lines(DeckFile(path, path, trusted, reader)), path):
        name, fields, next_mark = _fields(line)
        if name.startswith("="):
            _repeat(found, name, fields, line)
        elif name == "" or name[0] in "+*":
            own, named = name.lstrip("+*"), mark.lstrip("+*")
            if not found or (own and named and own != named):
                raise FileError(
                    f"{line.file} goes on with {name or 'a blank field'!r} (line {line.at}), which the line before "
                    "does not name. Remedy: continuations behind their cards"
                )
            found[-1] = found[-1]._replace(fields=found[-1].fields + fields)
        else:
            found.append(Card(name.rstrip("*"), fields, line.file, line.at))
        mark = next_mark
    return found


def _lines(file: DeckFile) -> list[_Line]:
    """Return the lines of a file without comments, with those of the files that it includes in their places."""
    found: list[_Line] = []
    path = file.path
    text = iter(enumerate(file.text("Nastran deck").splitlines(), 1))
    for at, whole in text:
        bare = (whole.partition("$")[0] if "$" in whole else whole).rstrip()
        if bare[:1] not in _BEGINS_INCLUDE or bare.lstrip()[:7].upper() != "INCLUDE":
            if bare:
                found.append(_Line(bare, path.name, at))
            continue
        named = bare.lstrip()[7:].strip()
        while named[:1] in ("'", '"') and named.count(named[0]) < 2:  # a long name goes on in the next lines
            more = next(text, None)
            if more is None:
                raise FileError(f"{path.name}: INCLUDE (line {at}) has no end. Remedy: its second quotation mark")
            named += more[1].strip()
        found += _lines(file.included(named.strip("'\" "), at))
    return found


def _bulk(lines: list[_Line], path: Path) -> Iterator[_Line]:
    """Yield the lines of the bulk data."""
    begins = [i for i, line in enumerate(lines) if "EGIN" in line.text[:80].upper() and _BEGIN.match(line.text)]
    if len(begins) > 1:
        where = lines[begins[1]]
        raise FileError(f"{where.file} has parts of its own (superelements, line {where.at}). Remedy: a deck of each")
    for line in lines[begins[0] + 1 if begins else 0 :]:
        if "NDDATA" in line.text.upper() and line.text.lstrip()[:7].upper() == "ENDDATA":
            return
        yield line
    if begins:
        raise FileError(f"{path.name} has no ENDDATA: it ends where more should follow. Remedy: write the whole deck")


def _fields(line: _Line) -> tuple[str, tuple[str, ...], str]:
    """Return name, fields and mark of continuation of a line; fields that are left out are blank."""
    if "," in line.text:
        name, *fields = (part.strip() for part in line.text.rstrip(", ").split(","))
        most = 4 if "*" in name and not name.startswith("=") else 8
        if len(fields) > most + 1:
            raise FileError(
                f"{line.file} has {len(fields)} fields in line {line.at}, where {most} and a continuation are possible."
                " Remedy: several lines"
            )
        return name.upper(), (*fields[:most], *_BLANK[: max(most - len(fields), 0)]), "".join(fields[most:]).upper()
    text = line.text.expandtabs(8)
    name = text[:8].strip().upper()
    width = 16 if "*" in name else 8
    own = tuple([text[i : i + width].strip() for i in range(8, 72, width)])
    return name, own, text[72:80].strip().upper()


def _repeat(found: list[Card], name: str, fields: tuple[str, ...], line: _Line) -> None:
    """Add the card before once more or several times: "=" is its field, "==" all of the rest, "*x" raised by x.

    A line that repeats its own card, ``=(n)``, raises its fields as the card before was raised: the rule is that of
    the fields which this line has.
    """
    counted = _REPEATED.fullmatch(name)
    if not found or (name != "=" and counted is None):
        raise FileError(
            f"{line.file} begins line {line.at} with {name!r}, and no card is before it that is repeated. Remedy: "
            "repeated cards behind their cards"
        )
    before = found[-1]
    if len(before.fields) > len(fields):
        raise FileError(f"{line.file} repeats a card of several lines (line {line.at}). Remedy: write it out")
    if counted is not None and not any(fields):
        if len(found) < 2:
            raise FileError(f"{line.file} repeats what was not raised before (line {line.at}). Remedy: write it out")
        steps = [_step(a, b) for a, b in zip(found[-2].fields, before.fields, strict=True)]
        fields = tuple(a if step is None else f"*{step!r}" for a, step in zip(before.fields, steps, strict=True))
    for _ in range(int(counted[1]) if counted is not None else 1):
        found.append(Card(found[-1].name, _raised(found[-1], fields, line), line.file, line.at))


def _step(a: str, b: str) -> int | float | None:
    """Return by what a field was raised from one card to the next; None if it is the same."""
    if a == b:
        return None
    first, second = as_number(a or "0"), as_number(b or "0")
    is_whole = a.lstrip("+-").isdigit() and b.lstrip("+-").isdigit()
    return int(second) - int(first) if is_whole else second - first


def _raised(before: Card, fields: tuple[str, ...], line: _Line) -> tuple[str, ...]:
    made: list[str] = []
    for i, field in enumerate(fields):
        last = before.fields[i] if i < len(before.fields) else ""
        if field == "==":
            return (*made, *before.fields[i:])
        raised = _RAISED.fullmatch(field)
        if field == "=":
            made.append(last)
        elif raised is None:
            made.append(field)
        else:
            step = Card(before.name, (raised[1],), line.file, line.at)
            if last.lstrip("+-").isdigit():
                made.append(str(int(last) + step.whole(2)))
            else:
                made.append(repr(before.number(i + 2) + step.number(2)))
    return tuple(made)
