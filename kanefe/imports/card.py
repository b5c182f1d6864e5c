"""Cards of bulk data: their fields, one by one, or those of many cards at once."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from kanefe.errors import FileError
from kanefe.imports.text import number as as_number
from kanefe.imports.text import plain_numbers

SMALL, LARGE = 8, 16
"""Numbers of characters of small and of large fields."""

LINE = 64
"""Number of characters of the fields of a line."""

_NO_LETTER = re.compile(r"(?<=[\d.])(?=[-+]\d)")  # 1.5-3 is 1.5e-3

_WHOLE = b"0123456789+-, "


class Card:
    """A card of bulk data.

    Attributes
    ----------
    name : str
        Upper case, without its star.
    file : str
        Name of the file.
    at : int
        Number of its line in it.
    body : str or None
        Its fields in columns, of whole lines; None: they are free, or of several widths.
    width : int
        Of its columns.
    """

    __slots__ = ("_fields", "at", "body", "file", "name", "width")

    def __init__(
        self,
        name: str,
        fields: tuple[str, ...] | None,
        file: str,
        at: int,
        body: str | None = None,
        width: int = SMALL,
    ) -> None:
        self.name = name
        self.file = file
        self.at = at
        self.body = body
        self.width = width
        self._fields = fields

    @property
    def fields(self) -> tuple[str, ...]:
        """Fields after the name, each in its place; "" where one is left out."""
        if self._fields is None:
            self._fields = split(self.body or "", self.width)
        return self._fields

    def go_on(self, fields: tuple[str, ...] | None, body: str | None, width: int) -> None:
        """Add the fields of a line that continues it, or its columns."""
        if self.body is None or body is None or width != self.width:
            self._fields, self.body = self.fields + (split(body or "", width) if fields is None else fields), None
        else:
            self._fields, self.body = None, self.body + body

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
            values = [float(text) for text in found]
            if len(values) == count and math.isfinite(sum(values)) and "_" not in "".join(found):
                return values
        except ValueError:  # left out, or of another form
            pass
        return [self.number(first + i) for i in range(count)]

    def refused(self, reason: str) -> FileError:
        """Return the error of a card that is not as it should be; the reason is the end of a sentence."""
        return FileError(f"{self.file}: {self.name} {self.field(2)} (line {self.at}) {reason}")

    def _no_number(self, number: int, what: str) -> FileError:
        return FileError(
            f"{self.file}: field {number} of {self.name} (line {self.at}) is {self.field(number)!r}, and should be "
            f"{what}. Remedy: check that the file is complete, and the columns of its fields"
        )


def split(body: str, width: int) -> tuple[str, ...]:
    """Return the fields of columns."""
    return tuple([body[i : i + width].strip() for i in range(0, len(body), width)])


class CardColumns(NamedTuple):
    """Fields of many cards, (n, k): whole numbers, 0 where a field is left out, and where that is."""

    values: np.ndarray
    is_blank: np.ndarray


def longest(cards: Sequence[Card]) -> int:
    """Return how many fields the longest card has, of whole lines."""
    return max(len(card.body) // card.width if card.body is not None else len(card.fields) for card in cards)


def refuse_more(cards: Sequence[Card], most: int) -> None:
    """Refuse cards that go on behind the fields that they have: a FileError with the line.

    A line that was lost leaves its continuation to the card before.
    """
    for card in cards:
        if (len(card.body) > most * card.width if card.body is not None else len(card.fields) > most) and any(
            card.fields[most:]
        ):
            raise card.refused(f"goes on behind its {most} fields. Remedy: check that the lines before are complete")


def wholes(cards: Sequence[Card], first: int, count: int) -> CardColumns:
    """Return whole numbers of some fields of cards, counted from 2; a FileError names field and line if one is none."""
    found = _at_once(cards, first, count, is_whole=True)
    if found is not None:
        return CardColumns(found[0].astype(np.int64), found[1])
    fields = range(first, first + count)
    is_blank = np.array([[not card.field(i) for i in fields] for card in cards], dtype=bool).reshape(-1, count)
    rows = [[card.whole(i) if card.field(i) else 0 for i in fields] for card in cards]
    return CardColumns(np.array(rows, dtype=np.int64).reshape(-1, count), is_blank)


def numbers(cards: Sequence[Card], first: int, count: int) -> np.ndarray:
    """Return numbers of some fields of cards (n, k), 0 where one is left out; see `wholes`."""
    found = _at_once(cards, first, count, is_whole=False)
    if found is not None:
        return found[0]
    return np.array([card.numbers(first, count) for card in cards]).reshape(-1, count)


def _at_once(cards: Sequence[Card], first: int, count: int, is_whole: bool) -> tuple[np.ndarray, np.ndarray] | None:
    """Return numbers of fields and which are blank; None where they are not plain, which the slow way tells."""
    begin, end = first - 2, first - 2 + count
    bodies = [card.body for card in cards]
    widths = {card.width for card in cards}
    if len(widths) == 1 and None not in bodies:
        plain, is_blank = _columns(bodies, begin, end, widths.pop())
    else:
        rows = [card.fields[begin:end] for card in cards]
        flat = [text for row in rows for text in (*row, *[""] * (count - len(row)))]
        plain, is_blank = ",".join([text or "0" for text in flat]), np.array([not text for text in flat], dtype=bool)
    if is_whole and plain.encode("latin-1").translate(None, _WHOLE):
        return None
    values = plain_numbers(plain, " , ")
    if values is None and not is_whole:
        values = plain_numbers(_NO_LETTER.sub("E", plain.upper().replace("D", "E")), " , ")
    if values is None or values.size != is_blank.size:
        return None
    return values.reshape(-1, count), is_blank.reshape(-1, count)


def _columns(bodies: Sequence[str | None], begin: int, end: int, width: int) -> tuple[str, np.ndarray]:
    """Return the text of columns with commas between, 0 for blanks, and which are blank (n, k)."""
    text = "".join(
        [body[begin * width : end * width].ljust((end - begin) * width) for body in bodies if body is not None]
    )
    codes = np.frombuffer(text.encode("latin-1"), dtype=np.uint8).reshape(len(bodies), end - begin, width)
    is_blank = (codes == ord(" ")).all(axis=2)
    table = np.full((len(bodies), end - begin, width + 1), ord(","), dtype=np.uint8)
    table[:, :, :width] = codes
    table[is_blank, 0] = ord("0")
    return table.tobytes()[:-1].decode("latin-1"), is_blank
