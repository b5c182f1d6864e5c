"""Cards of Nastran's bulk data: fields of all widths, continuations, replication and included files."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from kanefe.errors import FileError
from kanefe.imports.card import FREE, LARGE, LINE, SMALL, Card, split
from kanefe.imports.included import DeckFile
from kanefe.imports.text import number as as_number

_COMMAS = tuple("," * count for count in range(LINE // SMALL + 1))

_FIRST = {word: (word[0], word[0].lower(), " ", "\t") for word in ("INCLUDE", "BEGIN", "ENDDATA")}
"""First characters of lines with these words."""

_BEGIN = re.compile(r"\s*BEGIN +(BULK|SUPER)\b", re.IGNORECASE)

_REPEATED = re.compile(r"=\(?(\d+)\)?")  # the card before once more, or so many times

_RAISED = re.compile(r"\*\(?([^()]+)\)?")  # the field of the card before, raised by this


_Line = tuple[str, str, int]
"""Text of a line without its comment, name of the file, and number of the line in it."""


class _Head(NamedTuple):
    """Name that begins a line, in upper case, the width of its columns, and whether a card begins there."""

    name: str
    width: int
    is_card: bool


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
    columns: dict[str, _Head] = {}  # by the eight characters that begin a line
    free: dict[str, _Head] = {}  # by what is before its first comma
    for line in _bulk(_lines(DeckFile(path, path, trusted, reader))):
        text, file, at = line
        begin, comma, rest = text.partition(",")
        if comma:
            head = free.get(begin) or free.setdefault(begin, _head(begin))
            name, width, is_card = head
            rest = rest.rstrip(", ")
            left_out = LINE // width - rest.count(",")
            body, next_mark = (rest + _COMMAS[left_out], "") if left_out > 0 else _marked(rest, left_out, line)
            width = FREE
        else:
            text = text.expandtabs(8) if "\t" in text else text
            begin, body = text[:8], text[8:72].ljust(LINE)
            next_mark = text[72:80].strip().upper() if len(text) > 72 else ""
            head = columns.get(begin) or columns.setdefault(begin, _head(begin))
            name, width, is_card = head
        if is_card:
            found.append(Card(name, None, file, at, body, width))
        elif name[:1] == "=":
            _repeat(found, name, split(body, width), line)
        else:
            own, named = name.lstrip("+*"), mark.lstrip("+*")
            if not found or (own and named and own != named):
                raise FileError(
                    f"{file} goes on with {name or 'a blank field'!r} (line {at}), which the line before does not "
                    "name. Remedy: continuations behind their cards"
                )
            found[-1].go_on(body, width)
        mark = next_mark
    return found


def _head(begin: str) -> _Head:
    """Return what the first field of a line says."""
    name = begin.strip().upper()
    width = LARGE if "*" in name and name[0] != "=" else SMALL
    is_card = name[:1] not in ("", "+", "*", "=")
    return _Head(name.rstrip("*") if is_card else name, width, is_card)


def _lines(file: DeckFile) -> Iterator[_Line]:
    """Yield the lines of a file without comments, with those of the files that it includes in their places."""
    name, begins = file.path.name, _FIRST["INCLUDE"]
    text = iter(enumerate(file.text("Nastran deck").splitlines(), 1))
    for at, whole in text:
        bare = (whole.partition("$")[0] if "$" in whole else whole).rstrip()
        if not bare:
            continue
        if bare[0] not in begins or bare.lstrip()[:7].upper() != "INCLUDE":
            yield bare, name, at
            continue
        named = bare.lstrip()[7:].strip()
        while named[:1] in ("'", '"') and named.count(named[0]) < 2:  # a long name goes on in the next lines
            more = next(text, None)
            if more is None:
                raise FileError(f"{name}: INCLUDE (line {at}) has no end. Remedy: its second quotation mark")
            named += more[1].strip()
        yield from _lines(file.included(named.strip("'\" "), at))


def _bulk(lines: Iterator[_Line]) -> Iterator[_Line]:
    """Yield the lines of the bulk data: all, if none begins them."""
    first, last = _FIRST["BEGIN"], _FIRST["ENDDATA"]
    before: list[_Line] = []
    begins: _Line | None = None
    for line in lines:
        if line[0][0] in first and _BEGIN.match(line[0]):
            begins = line
            break
        before.append(line)
    for line in before if begins is None else lines:
        if line[0][0] in last and line[0].lstrip()[:7].upper() == "ENDDATA":
            return
        if line[0][0] in first and _BEGIN.match(line[0]):
            raise FileError(f"{line[1]} has parts of its own (superelements, line {line[2]}). Remedy: a deck of each")
        yield line
    if begins is not None:
        raise FileError(f"{begins[1]} has no ENDDATA: it ends where more should follow. Remedy: write the whole deck")


def _marked(rest: str, left_out: int, line: _Line) -> tuple[str, str]:
    """Return the fields of a line that has all, each with a comma behind it, and the mark of its continuation."""
    if left_out < 0:
        most = rest.count(",") + left_out
        raise FileError(
            f"{line[1]} has {rest.count(',') + 1} fields in line {line[2]}, where {most} and a continuation are "
            "possible. Remedy: several lines"
        )
    fields, _, mark = rest.rpartition(",")
    return fields + ",", mark.strip().upper()


def _repeat(found: list[Card], name: str, fields: tuple[str, ...], line: _Line) -> None:
    """Add the card before once more or several times: "=" is its field, "==" all of the rest, "*x" raised by x.

    A line that repeats its own card, ``=(n)``, raises its fields as the card before was raised: the rule is that of
    the fields which this line has.
    """
    counted = _REPEATED.fullmatch(name)
    if not found or (name != "=" and counted is None):
        raise FileError(
            f"{line[1]} begins line {line[2]} with {name!r}, and no card is before it that is repeated. Remedy: "
            "repeated cards behind their cards"
        )
    before = found[-1]
    if len(before.fields) > len(fields):
        raise FileError(f"{line[1]} repeats a card of several lines (line {line[2]}). Remedy: write it out")
    if counted is not None and not any(fields):
        if len(found) < 2:
            raise FileError(f"{line[1]} repeats what was not raised before (line {line[2]}). Remedy: write it out")
        steps = [_step(a, b) for a, b in zip(found[-2].fields, before.fields, strict=True)]
        fields = tuple(a if step is None else f"*{step!r}" for a, step in zip(before.fields, steps, strict=True))
    for _ in range(int(counted[1]) if counted is not None else 1):
        found.append(Card(found[-1].name, _raised(found[-1], fields, line), line[1], line[2]))


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
            step = Card(before.name, (raised[1],), line[1], line[2])
            if last.lstrip("+-").isdigit():
                made.append(str(int(last) + step.whole(2)))
            else:
                made.append(repr(before.number(i + 2) + step.number(2)))
    return tuple(made)
