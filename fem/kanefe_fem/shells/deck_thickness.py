"""Thickness of shells at the corners of their elements, as decks of Nastran give it (T1 to T4)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from kanefe.imports.card import Card
from kanefe.imports.grid_points import GridPoints
from kanefe.imports.node_table import rows_of

EVEN = 1e-9
"""Largest difference of two thicknesses of one grid point, relative to them."""


@dataclass(frozen=True, eq=False)
class ThicknessOfNodes:
    """A function of points (n, 3) in m that returns the thickness at the nearest known one, shape (n,), m.

    Parameters
    ----------
    points : ndarray, shape (k, 3)
        Corners of elements, the middles of their sides and their centres, m.
    values : ndarray, shape (k,)
        m.
    """

    points: np.ndarray
    values: np.ndarray

    def __call__(self, x: np.ndarray) -> np.ndarray:
        """Return the thickness at points."""
        return np.asarray(self.values[cKDTree(self.points).query(x)[1]])


def thickness_of_corners(
    elements: Sequence[Card], places: Sequence[tuple[int, ...]], flags: Sequence[int], usual: float, grids: GridPoints
) -> float | ThicknessOfNodes:
    """Return the thickness of the elements of a property, m: a number if none gives its own at its corners.

    Parameters
    ----------
    elements : sequence of Card
    places, flags : sequence
        Their fields of T1 to T4, and of TFLAG: 1 if these are relative to `usual`.
    usual : float
        Of the property, where a corner has none, m.
    grids : GridPoints

    Raises
    ------
    FileError
        If a thickness is not positive, or a grid point has two; the message has the line.
    """
    if not any(card.field(place) for card, own in zip(elements, places, strict=True) for place in own):
        return usual
    of_grid: dict[int, float] = {}
    points, values = [], []
    for card, own, flag in zip(elements, places, flags, strict=True):
        scale = usual if card.field(flag) and card.whole(flag) == 1 else 1.0
        t = np.array([scale * card.number(place) if card.field(place) else usual for place in own])
        labels = [card.whole(4 + i) for i in range(len(own))]
        if not (t > 0.0).all():
            raise card.refused(f"has the thickness {t.min():g} at a corner. Remedy: positive ones")
        for label, one in zip(labels, t.tolist(), strict=True):
            known = of_grid.setdefault(label, one)
            if abs(known - one) > EVEN * known:
                raise card.refused(
                    f"has the thickness {one:g} at grid point {label}, where another element of its property has "
                    f"{known:g}. Remedy: a property for each, or one thickness"
                )
        x = grids.points[rows_of(np.array([labels]), grids.labels)[0]]
        points += [x, (x + np.roll(x, -1, axis=0)) / 2.0, x.mean(axis=0)[None]]
        values += [t, (t + np.roll(t, -1)) / 2.0, t.mean()[None]]
    return ThicknessOfNodes(np.concatenate(points), np.concatenate(values))
