"""Matrices on DMIG cards of Nastran, and what names the rows of those that have no labels: SPOINT and EXTRN."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import scipy.sparse as sp

from kanefe.errors import FileError, ModelError
from kanefe.imports.card import Card
from kanefe.imports.labelled import LabelledMatrix

SQUARE, SYMMETRIC = 1, 6
"""Forms of matrices, by the numbers of Nastran: written whole, and one half of it."""

REAL = (0, 1, 2)
"""Types of numbers that are real: of the machine, of single and of double precision."""


def direct_matrices(cards: Iterable[Card]) -> dict[str, LabelledMatrix]:
    """Return the square real matrices of DMIG cards by upper-case name; rows are named (label, component).

    Raises
    ------
    FileError
        If a card is not as it should be, or an entry is there twice; the message has the line.
    ModelError
        If a matrix is complex or not square.
    """
    forms: dict[str, int] = {}
    entries: dict[str, dict[tuple[tuple[int, int], tuple[int, int]], float]] = {}
    for card in cards:
        if card.name != "DMIG":
            continue
        name = card.field(2).upper()
        if card.field(3) == "0":
            forms[name] = _form(card)
            entries.setdefault(name, {})
            continue
        if name not in forms:
            raise card.refused("has a column before its head, the card with 0 behind the name. Remedy: punch it again")
        column = card.whole(3), card.whole(4) if card.field(4) else 0
        for first in range(6, 2 + len(card.fields), 4):
            if not card.field(first):
                continue
            row = card.whole(first), card.whole(first + 1) if card.field(first + 1) else 0
            if (row, column) in entries[name] or (forms[name] == SYMMETRIC and (column, row) in entries[name]):
                raise card.refused(f"has the entry of {row} and {column} twice. Remedy: punch it again")
            entries[name][row, column] = card.number(first + 2)
    return {name: _labelled(forms[name] == SYMMETRIC, found) for name, found in entries.items()}


def _form(head: Card) -> int:
    """Return the form of a matrix by its head."""
    form, kind = head.whole(4), head.whole(5) if head.field(5) else 0
    if kind not in REAL:
        raise ModelError(
            f"matrix {head.field(2)} in {head.file} is complex (line {head.at}). Remedy: export K without "
            "structural damping"
        )
    if form not in (SQUARE, SYMMETRIC):
        raise ModelError(
            f"matrix {head.field(2)} in {head.file} is not square (line {head.at}): it is not a mass, stiffness or "
            "damping matrix"
        )
    return form


def _labelled(is_half: bool, entries: dict[tuple[tuple[int, int], tuple[int, int]], float]) -> LabelledMatrix:
    """Return a matrix by its entries, its rows in ascending labels."""
    labels = sorted({end for pair in entries for end in pair})
    places = {label: i for i, label in enumerate(labels)}
    rows = np.array([places[row] for row, _ in entries], dtype=np.int64)
    columns = np.array([places[column] for _, column in entries], dtype=np.int64)
    values = np.array(list(entries.values()), dtype=float)
    matrix = sp.csr_matrix((values, (rows, columns)), shape=(len(labels), len(labels)))
    if is_half:
        matrix = matrix + matrix.T - sp.diags(matrix.diagonal())
    return LabelledMatrix(np.array(labels, dtype=np.int64).reshape(-1, 2), sp.csr_matrix(matrix))


def scalar_points(cards: Iterable[Card]) -> np.ndarray:
    """Return the labels of scalar points, ascending; each card lists some, or a range with THRU."""
    found: set[int] = set()
    for card in cards:
        if card.name != "SPOINT":
            continue
        if card.field(3).upper() == "THRU":
            found.update(range(card.whole(2), card.whole(4) + 1))
        else:
            found.update(card.whole(i) for i in range(2, 2 + len(card.fields)) if card.field(i))
    return np.array(sorted(found), dtype=np.int64)


def extern_freedoms(cards: Iterable[Card]) -> np.ndarray | None:
    """Return (label, component) of the rows of a superelement by its EXTRN card; None without one.

    Components are written together, 123456; that of a scalar point is 0.

    Raises
    ------
    FileError
        If there are two such cards.
    """
    found = [card for card in cards if card.name == "EXTRN"]
    if len(found) > 1:
        raise FileError(f"{found[1].file} has EXTRN twice (line {found[1].at}). Remedy: one superelement")
    rows = [
        (card.whole(i), int(component))
        for card in found
        for i in range(2, 2 + len(card.fields), 2)
        if card.field(i)
        for component in str(card.whole(i + 1) if card.field(i + 1) else 0)
    ]
    return np.array(rows, dtype=np.int64).reshape(-1, 2) if found else None
