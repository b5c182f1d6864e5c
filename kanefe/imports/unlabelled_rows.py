"""Rows of Nastran's matrices without labels (op4, op2): which grid point and component each of them is.

Matrices of all grid points have six rows for each. A Craig-Bampton model has the boundary first, by SUPORT in MYSTRAN,
and then its modes. Grid points are in ascending labels (MSC and NX Nastran), or in the order of their cards (MYSTRAN):
that order is taken in which rigid motions are free.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple, TypeAlias

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from kanefe.errors import ModelError
from kanefe.fe_model.given_pattern import ROUND_OFF
from kanefe.fe_model.model import rigid_motion
from kanefe.imports.card import Card
from kanefe.imports.direct_matrices import extern_freedoms, scalar_points
from kanefe.imports.labelled import GENERALISED, given_freedoms
from kanefe.imports.node_table import NodeTable

Boundary: TypeAlias = Sequence[tuple[int, int | str]]
"""Grid points and their components written together, such as (27, 123456)."""

REDUCED = ("KXX", "MXX")
"""Names of the matrices of a Craig-Bampton model."""


class GivenRows(NamedTuple):
    """What the user says of the rows: see `read_nastran`."""

    freedoms: np.ndarray | Sequence[tuple[int, int]] | None
    boundary: Boundary | None


def rows_of(
    K: sp.csr_matrix, name: str, given: GivenRows, cards: Sequence[Card], order: np.ndarray, table: NodeTable
) -> np.ndarray:
    """Return (label, number) of the rows of a stiffness matrix, shape (N, 2).

    Parameters
    ----------
    K : csr_matrix, shape (N, N)
    name : str
        Its name in the file.
    given : GivenRows
    cards : sequence of Card
    order : ndarray of int
        Labels of the grid points in the order of their cards.
    table : NodeTable
        The same in ascending labels.

    Raises
    ------
    ModelError
        If no rule gives as many rows as K has, a grid point is not there, or two orders are possible.
    """
    size = K.shape[0]
    if given.freedoms is not None:
        return given_freedoms(given.freedoms, "freedoms", "grid")
    named, scalar = extern_freedoms(cards), scalar_points(cards)
    supported = [] if len(scalar) or named is not None or name not in REDUCED else _supported(cards)
    boundary = _pairs(given.boundary) if given.boundary is not None else supported
    if given.boundary is None and named is not None and len(named) == size:
        return named
    found = []
    for labels in (table.labels, order):
        if boundary:
            found.append(_boundary_first(boundary, labels, size, table))
        else:
            rows = np.array([(label, number) for label in labels for number in range(1, 7)])
            if len(rows) != size and len(scalar):
                rows = np.concatenate((rows, np.column_stack((scalar, np.zeros_like(scalar)))))
                rows = rows[np.argsort(rows[:, 0], kind="stable")]
            found.append(rows)
    if len(found[0]) != size or np.array_equal(found[0], found[1]):
        return found[0]
    return _free_order(K, name, found, table)


def _free_order(K: sp.csr_matrix, name: str, found: list[np.ndarray], table: NodeTable) -> np.ndarray:
    """Return the rows with which rigid motions are free."""
    fits = [rows for rows in found if _resistance(K, rows, table) <= ROUND_OFF]
    if len(fits) == 1:
        return fits[0]
    if len(fits) == 2:
        sorted_ones = [K[at][:, at] for at in (np.lexsort(rows.T[::-1]) for rows in fits)]
        if abs(sorted_ones[0] - sorted_ones[1]).max() > ROUND_OFF * abs(K).max() or name in REDUCED:
            raise ModelError(
                f"the rows of {name} can be grid points in ascending labels or in the order of their cards: rigid "
                "motions are free in both. Remedy: freedoms=[(grid, component), ...] of all rows"
            )
    return found[0]


def _resistance(K: sp.csr_matrix, rows: np.ndarray, table: NodeTable) -> float:
    """Return the largest force of K for a unit rigid motion, relative to its largest row sum."""
    is_nodal = rows[:, 1] != GENERALISED
    at = table.places(rows[is_nodal, 0], "the matrix")
    points = table.points - table.points[np.unique(at)].mean(axis=0)
    motions = rigid_motion(points, np.zeros(3), ("x", "y", "z", "rx", "ry", "rz")).reshape(-1, 6, 6)
    if table.axes is not None:
        motions = np.einsum("npq,npc->nqc", np.kron(np.eye(2), table.axes), motions)
    R = np.zeros((len(rows), 6))
    R[is_nodal] = motions[at, rows[is_nodal, 1] - 1]
    R = R / np.maximum(np.linalg.norm(R, axis=0), 1e-300)
    return float(np.linalg.norm(K @ R, axis=0).max() / (spla.norm(K, np.inf) or 1.0))


def _boundary_first(boundary: list[tuple[int, int]], labels: np.ndarray, size: int, table: NodeTable) -> np.ndarray:
    """Return the rows of a boundary, its points in the order of labels, and of generalised coordinates behind them."""
    table.places(np.array([label for label, _ in boundary]), "the boundary")
    if len(boundary) > size:
        raise ModelError(
            f"the boundary has {len(boundary)} components, the matrices have {size} rows. Remedy: boundary= of the run "
            "that wrote them"
        )
    place = {int(label): i for i, label in enumerate(labels)}
    rows = sorted(boundary, key=lambda row: (place[row[0]], row[1]))
    free = int(labels.max()) + 1
    return np.array(rows + [(free + i, GENERALISED) for i in range(size - len(rows))], dtype=np.int64)


def _supported(cards: Iterable[Card]) -> list[tuple[int, int]]:
    """Return grid points and components of SUPORT cards."""
    given: list[tuple[int, int | str]] = []
    for card in cards:
        if card.name == "SUPORT":
            given += [(card.whole(i), card.field(i + 1)) for i in range(2, 2 + len(card.fields), 2) if card.field(i)]
    return _pairs(given)


def _pairs(boundary: Boundary) -> list[tuple[int, int]]:
    """Return each grid point with each of its components, each once."""
    found: dict[tuple[int, int], None] = {}
    for entry in boundary:
        try:
            label, components = entry
            numbers = [int(c) for c in str(components)]
            pairs = [(int(label), number) for number in numbers]
        except (TypeError, ValueError):
            pairs, numbers = [], []
        if not numbers or not all(1 <= n <= 6 for n in numbers):
            raise ModelError(
                f"boundary must be grid points and their components, such as [(27, 123456), (50, '123')], not {entry!r}"
            )
        found |= dict.fromkeys(pairs)
    return list(found)
