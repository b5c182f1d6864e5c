"""How far the stress at a node is off because of the mesh, estimated from the cells around it.

Stresses of cells are best at their Gauss points. A polynomial of one order more than the cells extrapolate by, fitted
to these points of all cells around a node, is closer to the exact stress there than the mean of the cells
(superconvergent patch recovery: Zienkiewicz & Zhu, Int. J. Numer. Methods Eng. 33 (1992) 1331-1364); the difference is
the estimate. Jumps between cells are none: for cells of order 2 they fall faster than the error, since both
cells that meet at a node are off to the same side.
"""

from __future__ import annotations

from itertools import combinations_with_replacement
from typing import NamedTuple

import numpy as np

from kanefe_fem.recovery.scalars import von_mises

DEPENDENT = 1e-6
"""Part of a polynomial that the ones before it do not have, relative to it, below which it is left out."""


class Patch(NamedTuple):
    """Stresses at the points of cells around a node.

    Attributes
    ----------
    places : ndarray, shape (s, 3)
        From the node, m.
    stress : ndarray, shape (s, 6)
        Pa.
    mean : ndarray, shape (6,)
        Of the cells that meet at the node, Pa.
    order : int
        Of the cells.
    """

    places: np.ndarray
    stress: np.ndarray
    mean: np.ndarray
    order: int

    @property
    def error(self) -> float:
        """Von Mises' stress of the difference of the mean and the fit, Pa; NaN where there are too few points."""
        size = np.abs(self.places).max()
        own = _independent(self.places / size, self.order)
        if own is None:
            return float("nan")
        fitted = np.linalg.lstsq(own, self.stress, rcond=None)[0][0]  # the others vanish at the node
        return float(von_mises(fitted - self.mean))


def _independent(x: np.ndarray, order: int) -> np.ndarray | None:
    """Return the powers and products (s, m) at points (s, 3) that are independent there; None if points are too few."""
    factors = [c for n in range(1, order + 1) for c in combinations_with_replacement(range(3), n)]
    columns, basis = [np.ones(len(x))], np.full((len(x), 1), len(x) ** -0.5)
    for axes in factors:
        column = x[:, axes].prod(axis=1)
        rest = column - basis @ (basis.T @ column)
        rest -= basis @ (basis.T @ rest)
        if np.linalg.norm(rest) > DEPENDENT * np.linalg.norm(column):
            columns.append(column)
            basis = np.column_stack((basis, rest / np.linalg.norm(rest)))
    return np.column_stack(columns) if len(columns) < len(x) else None
