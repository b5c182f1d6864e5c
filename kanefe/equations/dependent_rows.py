"""Which rows of the constraints depend on rows before them."""

from __future__ import annotations

import numpy as np

from kanefe.frames import Matrix
from kanefe.tree.row_groups import groups_of_rows
from kanefe.tree.row_rates import RANK_TOLERANCE


def dependent_rows(directions: Matrix, J: Matrix) -> set[int]:
    """Return the numbers of the rows that depend on rows before them.

    Rows of loops that share no speed cannot depend on each other, so that each group of loops is searched by itself:
    the work grows with the number of groups, and with the cube of the size of one.

    Parameters
    ----------
    directions : ndarray, shape (m, n)
        The rows in a metric that makes them comparable, of length up to one: `ConstrainedSolver.scaled_rows`.
    J : ndarray, shape (m, n)
        The rows over the speeds, whose zeros say which speeds a row has.
    """
    return {int(rows[i]) for rows in groups_of_rows(J) for i in _dependent(directions[rows])}


def _dependent(directions: Matrix) -> list[int]:
    kept = np.empty((min(directions.shape), directions.shape[1]))
    dependent: list[int] = []
    count = 0
    for i, direction in enumerate(directions):
        rest, basis = direction, kept[:count]
        for _ in range(2):  # twice is enough against round-off (Kahan, Parlett)
            rest = rest - (basis @ rest) @ basis
        size = float(np.linalg.norm(rest))
        if size <= np.sqrt(RANK_TOLERANCE):
            dependent.append(i)
        else:
            kept[count] = rest / size
            count += 1
    return dependent
