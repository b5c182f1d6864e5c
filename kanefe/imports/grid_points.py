"""Grid points of Nastran's bulk data in basic coordinates, and the coordinate systems that they are given in."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import NamedTuple

import numpy as np

from kanefe.errors import FileError
from kanefe.imports.card import Card, CardTable
from kanefe.imports.coordinate_systems import BASIC, CoordinateSystem, axes_at, in_basic, right_handed

CP, CD = 3, 7
"""Numbers of the fields of a grid point with the systems of its place and of its displacements."""

FIELDS = 8
"""Number of fields of a grid point."""

PLACES = ("CORD1R", "CORD1C", "CORD1S", "CORD2R", "CORD2C", "CORD2S")
"""Cards of coordinate systems that are read."""

UNREAD = (
    *("CORD1RX", "CORD2RX", "CORD3C", "CORD3G", "CORD3R", "CORD3S", "GMCORD", "GRIDA", "GRIDB", "GRIDF", "GRIDS"),
    *("GMBC", "GMSURF", "GMCURV", "FEFACE", "FEEDGE", "POINT", "EGRID", "GRIDG", "CGEN"),
    *("AXIC", "AXIF", "RINGAX", "RINGFL", "POINTAX", "CCONEAX", "CYAX", "CYJOIN"),
    *("CSUPER", "CSUPEXT", "SEBULK", "SECONCT", "SELOC", "SEMPLN"),
)
"""Cards that place or make nodes, or parts of a body, and are not read."""


class GridPoints(NamedTuple):
    """Grid points of a deck, in the order of their cards.

    Attributes
    ----------
    labels : ndarray of int, shape (n,)
    points : ndarray, shape (n, 3)
        In basic coordinates, in units of the deck.
    axes : ndarray, shape (n, 3, 3), or None
        A_Gd: columns are the axes of the displacements of a point in basic ones. None: those of basic for all.
    """

    labels: np.ndarray
    points: np.ndarray
    axes: np.ndarray | None


def grid_points(cards: Iterable[Card]) -> GridPoints:
    """Return the grid points among some cards.

    CP and CD that are blank are those of a GRDSET; 0 is basic.

    Raises
    ------
    FileError
        If a card is not as it should be, places nodes in a way that is not read, or uses a system that is not there
        or is placed by itself. The message has the line.
    """
    by_label, table, systems = _sorted(cards)
    return _placed(by_label, table, systems, systems.usual)


def coordinate_system(cards: Iterable[Card], number: int, by: Card) -> CoordinateSystem:
    """Return the coordinate system of a number among some cards; errors name the card that uses it."""
    return _sorted(cards)[2].of(number, by)


def _sorted(cards: Iterable[Card]) -> tuple[dict[int, Card], CardTable, _Systems]:
    """Return the grid points by label and as a table, and the coordinate systems."""
    grids: list[Card] = []
    systems: dict[int, tuple[Card, int]] = {}
    usual: Card | None = None
    for card in cards:
        if card.name == "GRID":
            grids.append(card)
        elif card.name == "GRDSET":
            if usual is not None:
                raise FileError(f"{card.file} has GRDSET twice (line {card.at}). Remedy: one of them")
            usual = card
        elif card.name in PLACES:
            for first in (2, 6) if card.name[4] == "1" else (2,):
                if card.field(first):
                    known_system, at = systems.setdefault(card.whole(first), (card, first))
                    if (known_system is not card or at != first) and known_system.fields != card.fields:
                        raise FileError(
                            f"{card.file} has coordinate system {card.field(first)} twice (line {card.at}). Remedy: "
                            "one of them"
                        )
        elif card.name in UNREAD:
            raise card.refused(
                "places nodes in a way that is not read. Remedy: one deck with all points in systems CORD1 and CORD2"
            )
    by_label, table = _once(grids)
    return by_label, table, _Systems(by_label, systems, usual)


def _once(grids: list[Card]) -> tuple[dict[int, Card], CardTable]:
    """Return cards by label, and their table; those that say the same as one before are left out."""
    table = CardTable(grids)
    table.refuse_more(FIELDS)
    labels = table.wholes(2, 1)
    if labels.is_blank.any():
        grids[int(np.flatnonzero(labels.is_blank[:, 0])[0])].whole(2)
    found = dict(zip(labels.values[:, 0].tolist(), grids, strict=True))
    if len(found) == len(grids):
        return found, table
    found = {}
    for label, card in zip(labels.values[:, 0].tolist(), grids, strict=True):
        known = found.setdefault(label, card)
        if known is not card and _entries(known) != _entries(card):
            raise FileError(f"{card.file} has grid point {label} twice (line {card.at}). Remedy: one of them")
    return found, CardTable(list(found.values()))


def _entries(card: Card) -> tuple[object, ...]:
    return (card.field(CP), *card.numbers(4, 3), card.field(CD))


def _system_of(card: Card, number: int, usual: Card | None) -> int:
    """Return the number of the system in a field of a grid point, or in that of GRDSET; 0: basic."""
    if card.field(number):
        return card.whole(number)
    return usual.whole(number) if usual is not None and usual.field(number) else 0


class _Systems:
    """The coordinate systems of a deck, each placed when it is first asked for."""

    def __init__(self, grids: Mapping[int, Card], systems: Mapping[int, tuple[Card, int]], usual: Card | None) -> None:
        self.grids, self.systems, self.usual = grids, systems, usual
        self.placed: dict[int, CoordinateSystem] = {0: BASIC}
        self.open: list[int] = []

    def of(self, number: int, by: Card) -> CoordinateSystem:
        """Return a system that a card uses."""
        if number in self.placed:
            return self.placed[number]
        if number not in self.systems:
            raise by.refused(f"is in coordinate system {number}, which is not there. Remedy: write the whole deck")
        if number in self.open:
            raise by.refused(f"is in coordinate system {number}, which is placed by itself. Remedy: check the systems")
        self.open.append(number)
        card, first = self.systems[number]
        corners = self._of_grids(card, first) if card.name[4] == "1" else self._of_numbers(card)
        self.placed[number] = _through(card, corners)
        self.open.pop()
        return self.placed[number]

    def _of_numbers(self, card: Card) -> list[np.ndarray]:
        within = self.of(card.whole(3) if card.field(3) else 0, card)
        return [in_basic(within, np.array([card.numbers(i, 3)]))[0] for i in (4, 7, 10)]

    def _of_grids(self, card: Card, first: int) -> list[np.ndarray]:
        corners = []
        for i in range(first + 1, first + 4):
            grid = self.grids.get(card.whole(i))
            if grid is None:
                raise card.refused(
                    f"is placed by grid point {card.field(i)}, which is not there. Remedy: write the whole deck"
                )
            within = self.of(_system_of(grid, CP, self.usual), grid)
            corners.append(in_basic(within, np.array([grid.numbers(4, 3)]))[0])
        return corners


def _through(card: Card, corners: list[np.ndarray]) -> CoordinateSystem:
    """Return the system of an origin, a point on its third axis, and one in the plane of the first and the third."""
    origin, along, beside = corners
    axes = right_handed(along - origin, beside - origin)
    if axes is None:
        raise card.refused("has three points on one line. Remedy: a third point beside its axis")
    return CoordinateSystem(card.name[5], origin, axes[:, [1, 2, 0]])


def _placed(grids: Mapping[int, Card], table: CardTable, systems: _Systems, usual: Card | None) -> GridPoints:
    """Return the points of cards in basic coordinates, and the axes of their displacements."""
    given = table.numbers(4, 3)
    points, axes, is_turned = np.zeros_like(given), np.zeros((len(given), 3, 3)), False
    for system, rows in _by_system(table, CP, systems, usual):
        points[rows] = in_basic(system, given[rows])
    for system, rows in _by_system(table, CD, systems, usual):
        axes[rows] = axes_at(system, points[rows])
        is_turned = is_turned or system is not BASIC
    return GridPoints(np.array(list(grids), dtype=np.int64), points, axes if is_turned else None)


def _by_system(
    table: CardTable, number: int, systems: _Systems, usual: Card | None
) -> Iterator[tuple[CoordinateSystem, np.ndarray]]:
    """Yield each system that a field of grid points names, and the rows of those points."""
    own = table.wholes(number, 1)
    default = usual.whole(number) if usual is not None and usual.field(number) else 0
    named = np.where(own.is_blank, default, own.values)[:, 0]
    if number == CD:
        named[named == -1] = 0  # a point of a fluid has no axes
    for which in np.unique(named):
        rows = np.flatnonzero(named == which)
        yield systems.of(int(which), table.cards[rows[0]]), rows
