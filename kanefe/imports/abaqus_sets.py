"""Sets of nodes and elements of an input file of Abaqus: names without regard to case, sets that add up."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from kanefe.imports.abaqus_input import Keyword
from kanefe.imports.text import number


class SetPiece(NamedTuple):
    """Members of a set that one line or keyword gives.

    Attributes
    ----------
    labels : ndarray of int
    block : Keyword
    at : int
        Number of the line, of several lines the first one.
    instance : str
        Key of the instance that they are of; "": of the part that the set is of.
    is_range : bool
        Whether labels may be of nothing, as in a range from one to another.
    elements : str
        Name of the element set whose nodes are meant, instead of labels; "": none.
    """

    labels: np.ndarray
    block: Keyword
    at: int
    instance: str = ""
    is_range: bool = False
    elements: str = ""


@dataclass
class NamedSet:
    """A set by its name as it is first written, and its members so far."""

    name: str
    pieces: list[SetPiece] = field(default_factory=list)


class Sets:
    """Sets of one kind of a part, or of the assembly.

    Attributes
    ----------
    by_key : dict of str to NamedSet
    others : dict of str to Sets
        Those of instances, by key, which may be named with the instance and a point before.
    """

    def __init__(self, others: dict[str, Sets] | None = None) -> None:
        self.by_key: dict[str, NamedSet] = {}
        self.others = others or {}

    def add(self, name: str, pieces: list[SetPiece]) -> None:
        """Add members to a set; one that is there goes on."""
        bare = name.strip("\"'")
        self.by_key.setdefault(key_of(name), NamedSet(bare)).pieces.extend(pieces)

    def read(self, block: Keyword, name: str) -> None:
        """Add the members that the data lines of a block name: labels, ranges with GENERATE, and sets before it.

        Raises
        ------
        FileError
            If a line has what is none of them.
        """
        instance = key_of(block.options.get("INSTANCE", ""))
        table = block.table()
        if table is not None and _are_labels(table.values) and "GENERATE" not in block.options:
            self.add(name, [SetPiece(table.values.astype(np.int64), block, block.at, instance)])
            return
        self.add(name, [])
        for at, fields in block.rows():
            if "GENERATE" in block.options:
                self.add(name, [_range(block, at, fields, instance)])
            else:
                pieces = [piece for text in fields if text for piece in self._members(text, block, at, instance)]
                self.add(name, _joined(pieces))

    def named(self, text: str, instance: str = "") -> tuple[str, NamedSet] | None:
        """Return a set by its name, perhaps with its instance and a point before, and the key of that; None: none."""
        key = key_of(text)
        of, _, bare = key.rpartition(".")
        if instance and instance in self.others and key in self.others[instance].by_key:
            return instance, self.others[instance].by_key[key]
        if key in self.by_key:
            return "", self.by_key[key]
        if of in self.others and bare in self.others[of].by_key:
            return of, self.others[of].by_key[bare]
        return None

    def _members(self, text: str, block: Keyword, at: int, instance: str) -> list[SetPiece]:
        label = _label(text)
        if label is not None:
            return [SetPiece(np.array([label]), block, at, instance)]
        found = self.named(text, instance)
        if found is not None:
            of, named = found
            return [piece if piece.instance else piece._replace(instance=of) for piece in named.pieces]
        of, _, bare = key_of(text).rpartition(".")
        label = _label(bare)
        if of in self.others and label is not None:
            return [SetPiece(np.array([label]), block, at, of)]
        raise block.refused(
            f"has {text!r}, which is no label and no set before it. Remedy: check the order and names of its sets", at
        )


def key_of(name: str) -> str:
    """Return what names that are the same have in common: case and blanks mean nothing, nor do quotation marks."""
    return "".join(name.strip("\"'").split()).upper()


def _joined(pieces: list[SetPiece]) -> list[SetPiece]:
    """Return pieces of one line with those in one that differ in their labels alone."""
    by_place: dict[tuple[object, ...], list[SetPiece]] = {}
    for piece in pieces:
        by_place.setdefault((id(piece.block), *piece[2:]), []).append(piece)
    return [some[0]._replace(labels=np.concatenate([p.labels for p in some])) for some in by_place.values()]


def _are_labels(values: np.ndarray) -> bool:
    return bool((values == np.floor(values)).all() and (values > 0).all())


def _label(text: str) -> int | None:
    try:
        value = number(text)
    except ValueError:
        return None
    return int(value) if value > 0 and value == int(value) else None


def _range(block: Keyword, at: int, fields: list[str], instance: str) -> SetPiece:
    if not 2 <= len(fields) <= 3:
        raise block.refused(f"has {len(fields)} numbers, where a range has two or three. Remedy: check it", at)
    first, last, step = (block.label(text, at) for text in (*fields, "1")[:3])
    if last < first:
        raise block.refused(f"has a range from {first} down to {last}. Remedy: the smaller one first", at)
    return SetPiece(np.arange(first, last + 1, step), block, at, instance, is_range=True)
