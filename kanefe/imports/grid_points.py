"""Grid points of Nastran's bulk data in basic coordinates, and the coordinate systems that they are given in."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import NamedTuple

import numpy as np

from kanefe.errors import FileError
from kanefe.imports.bulk_data import Card

CP, CD = 3, 7
"""Numbers of the fields of a grid point with the systems of its place and of its displacements."""

PLACES = ("CORD1R", "CORD1C", "CORD1S", "CORD2R", "CORD2C", "CORD2S")
"""Cards of coordinate systems that are read."""

UNREAD = (
    *("CORD1RX", "CORD2RX", "CORD3C", "CORD3G", "CORD3R", "CORD3S", "GMCORD", "GRIDA", "GRIDB", "GRIDF", "GRIDS"),
    *("GMBC", "GMSURF", "GMCURV", "FEFACE", "FEEDGE", "POINT", "EGRID", "GRIDG", "CGEN"),
)
"""Cards that place or make nodes, and are not read."""

PARALLEL = 1e-10
"""Sine of the angle between the two directions of a system below which they are one."""

ON_AXIS = 1e-12
"""Distance from the axis of a system, relative to the largest coordinate, below which a point is on it."""


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


class _System(NamedTuple):
    """A system placed in basic: kind R, C or S, origin, and axes as columns."""

    kind: str
    origin: np.ndarray
    axes: np.ndarray


BASIC = _System("R", np.zeros(3), np.eye(3))


def grid_points(cards: Iterable[Card]) -> GridPoints:
    """Return the grid points among some cards.

    CP and CD that are blank are those of a GRDSET; 0 is basic.

    Raises
    ------
    FileError
        If a card is not as it should be, places nodes in a way that is not read, or uses a system that is not there
        or is placed by itself. The message has the line.
    """
    grids: dict[int, Card] = {}
    systems: dict[int, tuple[Card, int]] = {}
    usual: Card | None = None
    for card in cards:
        if card.name == "GRID":
            known = grids.setdefault(card.whole(2), card)
            if known is not card and _entries(known) != _entries(card):
                raise FileError(
                    f"{card.file} has grid point {card.field(2)} twice (line {card.at}). Remedy: one of them"
                )
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
            raise card.refused("places nodes in a way that is not read. Remedy: write all points in the basic system")
    return _placed(grids, _Systems(grids, systems, usual), usual)


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
        self.placed: dict[int, _System] = {0: BASIC}
        self.open: list[int] = []

    def of(self, number: int, by: Card) -> _System:
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


def _through(card: Card, corners: list[np.ndarray]) -> _System:
    """Return the system of an origin, a point on its third axis, and one in the plane of the first and the third."""
    origin, along, beside = corners
    z, x = along - origin, beside - origin
    y = np.cross(z, x)
    if not np.linalg.norm(y) > PARALLEL * np.linalg.norm(z) * np.linalg.norm(x):
        raise card.refused("has three points on one line. Remedy: a third point beside its axis")
    z, y = z / np.linalg.norm(z), y / np.linalg.norm(y)
    return _System(card.name[5], origin, np.column_stack((np.cross(y, z), y, z)))


def in_basic(system: _System, given: np.ndarray) -> np.ndarray:
    """Return points (n, 3) in basic coordinates; angles are given in degrees: theta of C, theta from z and phi of S."""
    local = given
    if system.kind == "C":
        angle = np.radians(given[:, 1])
        local = np.column_stack((given[:, 0] * np.cos(angle), given[:, 0] * np.sin(angle), given[:, 2]))
    elif system.kind == "S":
        polar, azimuth = np.radians(given[:, 1]), np.radians(given[:, 2])
        across = given[:, 0] * np.sin(polar)
        local = np.column_stack((across * np.cos(azimuth), across * np.sin(azimuth), given[:, 0] * np.cos(polar)))
    return np.asarray(system.origin + local @ system.axes.T)


def axes_at(system: _System, points: np.ndarray) -> np.ndarray:
    """Return the axes (n, 3, 3), as columns in basic, of a system at points: of C and S along r, theta, z or phi.

    On the axis of a system theta and phi are taken as 0.
    """
    if system.kind == "R":
        return np.broadcast_to(system.axes, (len(points), 3, 3))
    x, y, z = ((points - system.origin) @ system.axes).T
    across = np.hypot(x, y)
    on_axis = across <= ON_AXIS * np.max(np.abs(points), initial=0.0)
    cos, sin = (np.where(on_axis, on, part / np.where(on_axis, 1.0, across)) for part, on in ((x, 1.0), (y, 0.0)))
    zero, one = np.zeros_like(z), np.ones_like(z)
    radial, around = np.stack((cos, sin, zero), axis=-1), np.stack((-sin, cos, zero), axis=-1)
    if system.kind == "C":
        local = np.stack((radial, around, np.stack((zero, zero, one), axis=-1)), axis=-1)
    else:
        far = np.hypot(across, z)
        polar_sin, polar_cos = (
            np.where(far > 0.0, part / np.where(far > 0.0, far, 1.0), on) for part, on in ((across, 0.0), (z, 1.0))
        )
        outward = np.stack((polar_sin * cos, polar_sin * sin, polar_cos), axis=-1)
        down = np.stack((polar_cos * cos, polar_cos * sin, -polar_sin), axis=-1)
        local = np.stack((outward, down, around), axis=-1)
    return np.asarray(system.axes @ local)


def _placed(grids: Mapping[int, Card], systems: _Systems, usual: Card | None) -> GridPoints:
    """Return the points of cards in basic coordinates, and the axes of their displacements."""
    cards = list(grids.values())
    given = np.array([card.numbers(4, 3) for card in cards]).reshape(-1, 3)
    points, axes, is_turned = np.zeros_like(given), np.zeros((len(given), 3, 3)), False
    for system, rows in _by_system(cards, CP, systems, usual):
        points[rows] = in_basic(system, given[rows])
    for system, rows in _by_system(cards, CD, systems, usual):
        axes[rows] = axes_at(system, points[rows])
        is_turned = is_turned or system is not BASIC
    return GridPoints(np.array(list(grids), dtype=np.int64), points, axes if is_turned else None)


def _by_system(
    cards: list[Card], number: int, systems: _Systems, usual: Card | None
) -> Iterator[tuple[_System, np.ndarray]]:
    """Yield each system that a field of grid points names, and the rows of those points."""
    named = np.array([_system_of(card, number, usual) for card in cards], dtype=np.int64)
    if number == CD:
        named[named == -1] = 0  # a point of a fluid has no axes
    for which in np.unique(named):
        rows = np.flatnonzero(named == which)
        yield systems.of(int(which), cards[rows[0]]), rows
