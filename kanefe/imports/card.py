"""Cards of bulk data: their fields, one by one, or those of many cards at once."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from kanefe.errors import FileError
from kanefe.imports.text import number as as_number
from kanefe.imports.text import plain_numbers

SMALL, LARGE = 8, 16
"""Numbers of characters of small and of large fields."""

FREE = 0
"""Number in place of the width of fields that commas separate."""

LINE = 64
"""Number of characters of the fields of a line."""

_NO_LETTER = re.compile(r"(?<=[\d.])(?=[-+]\d)")  # 1.5-3 is 1.5e-3

_WHOLE = b"0123456789+-, "

_IS_PART = np.isin(np.arange(256), list(_WHOLE), invert=True)  # of a number that is not whole, by its character

_BLANK, _COMMA, _ZERO = b" ,0"


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
        Its fields in columns, of whole lines, or each with a comma behind it; None: they are of several widths.
    width : int
        Of its columns, or `FREE`.
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

    def go_on(self, body: str, width: int) -> None:
        """Add the fields of a line that continues it."""
        if self.body is None or width != self.width:
            self._fields, self.body = self.fields + split(body, width), None
        else:
            self._fields, self.body = None, self.body + body

    @property
    def count(self) -> int:
        """Number of its fields, of whole lines."""
        if self.body is None:
            return len(self.fields)
        return self.body.count(",") if self.width == FREE else len(self.body) // self.width

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
    """Return the fields of columns, or of a text with a comma behind each."""
    if width == FREE:
        return tuple([field.strip() for field in body.split(",")[:-1]])
    return tuple([body[i : i + width].strip() for i in range(0, len(body), width)])


class CardColumns(NamedTuple):
    """Fields of many cards, (n, k): whole numbers, 0 where a field is left out, and where that is."""

    values: np.ndarray
    is_blank: np.ndarray


class CardTable:
    """Fields of many cards at once."""

    def __init__(self, cards: Sequence[Card]) -> None:
        self.cards = cards

    @cached_property
    def counts(self) -> list[int]:
        """How many fields each card has, of whole lines."""
        return [card.count for card in self.cards]

    def refuse_more(self, most: int) -> None:
        """Refuse cards that go on behind the fields that they have: a FileError with the line.

        A line that was lost leaves its continuation to the card before.
        """
        if max(self.counts, default=0) <= most:
            return
        for card in self.cards:
            if any(card.fields[most:]):
                raise card.refused(
                    f"goes on behind its {most} fields. Remedy: check that the lines before are complete"
                )

    def wholes(self, first: int, count: int) -> CardColumns:
        """Return whole numbers of some fields, counted from 2; a FileError names field and line if one is none."""
        found = self._at_once(first - 2, count, is_whole=True)
        if found is not None:
            return CardColumns(found[0].astype(np.int64), found[1])
        fields = range(first, first + count)
        is_blank = np.array([[not card.field(i) for i in fields] for card in self.cards], dtype=bool)
        rows = [[card.whole(i) if card.field(i) else 0 for i in fields] for card in self.cards]
        return CardColumns(np.array(rows, dtype=np.int64).reshape(-1, count), is_blank.reshape(-1, count))

    def numbers(self, first: int, count: int) -> np.ndarray:
        """Return numbers of some fields (n, k), 0 where one is left out; see `wholes`."""
        found = self._at_once(first - 2, count, is_whole=False)
        if found is not None:
            return found[0]
        return np.array([card.numbers(first, count) for card in self.cards]).reshape(-1, count)

    def _at_once(self, begin: int, count: int, is_whole: bool) -> tuple[np.ndarray, np.ndarray] | None:
        """Return numbers of fields and which are blank; None where they are not plain, which the slow way tells."""
        if not self.cards or self._bodies is None:
            return None
        bodies, width = self._bodies
        if width == FREE:
            return self._separated(begin, count, is_whole)
        text = "".join([body[begin * width : (begin + count) * width].ljust(count * width) for body in bodies])
        codes = np.frombuffer(text.encode("latin-1"), dtype=np.uint8).reshape(len(bodies), count, width)
        is_blank = (codes == _BLANK).all(axis=2)
        table = np.full((len(bodies), count, width + 1), _COMMA, dtype=np.uint8)
        table[:, :, :width] = codes
        table[is_blank, 0] = _ZERO
        plain = table.tobytes()[:-1]
        if is_whole and plain.translate(None, _WHOLE):
            return None
        values = _plain(plain.decode("latin-1"), is_blank.size)
        return None if values is None else (values.reshape(-1, count), is_blank)

    def _separated(self, begin: int, count: int, is_whole: bool) -> tuple[np.ndarray, np.ndarray] | None:
        if self._fields is None:
            return None
        whole = [np.zeros((len(self.cards), count), dtype=some.dtype) for some in self._fields]
        for wanted, some in zip(whole, self._fields, strict=True):
            there = some[:, begin : begin + count]
            wanted[:, : there.shape[1]] = there
        values, is_given, is_part = whole
        return None if is_whole and is_part.any() else (values, ~is_given)

    @cached_property
    def _bodies(self) -> tuple[list[str], int] | None:
        """Fields of all cards, and their width; None: there are several."""
        bodies = [card.body for card in self.cards if card.body is not None]
        width = self.cards[0].width
        is_one = len(bodies) == len(self.cards) and all(card.width == width for card in self.cards)
        return (bodies, width) if is_one else None

    @cached_property
    def _fields(self) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
        """Free fields of all cards (n, k): numbers, which are given, and which of them are not whole."""
        if self._bodies is None:
            return None
        bodies, most = self._bodies[0], max(self.counts)
        if min(self.counts) < most:
            bodies = [body + "," * (most - count) for body, count in zip(bodies, self.counts, strict=True)]
        text = "".join(bodies).lstrip()
        for apart, joined in ((", ", ","), (" ,", ",")):
            while apart in text:
                text = text.replace(apart, joined)
        codes = np.frombuffer(text.encode("latin-1"), dtype=np.uint8).copy()
        commas = np.flatnonzero(codes == _COMMA)
        is_given = np.diff(commas, prepend=-1) > 1
        column = np.arange(len(commas)) % most
        longest = int(column[is_given].max(initial=-1)) + 1
        is_kept = column < longest
        is_part = np.zeros(len(commas), dtype=bool)
        is_part[np.searchsorted(commas, np.flatnonzero(_IS_PART[codes]))] = True
        codes[commas[~is_kept]] = 0
        plain = np.insert(codes, commas[is_kept & ~is_given], _ZERO).tobytes().translate(None, b"\0")
        values = _plain(plain[:-1].decode("latin-1"), int(is_kept.sum()))
        if values is None:
            return None
        given, part = (some[is_kept].reshape(-1, longest) for some in (is_given, is_part))
        return values.reshape(-1, longest), given, part


def _plain(text: str, count: int) -> np.ndarray | None:
    """Return so many numbers with commas between; None where they are not plain."""
    values = plain_numbers(text, " , ")
    if values is None:
        values = plain_numbers(_NO_LETTER.sub("E", text.upper().replace("D", "E")), " , ")
    return values if values is not None and values.size == count else None
