"""Rows of a matrix in groups that have nothing to do with each other."""

from __future__ import annotations

import numpy as np

from kanefe.frames import Matrix


def groups_of_rows(J: Matrix) -> list[np.ndarray]:
    """Return the numbers of the rows of a matrix (m, n) in groups between which no column is shared, each ascending.

    What is dense work within a group, an elimination or an eigenvalue problem, then grows with the number of loops that
    are apart, and not with its cube.
    """
    has = np.asarray(J) != 0.0
    left, groups = np.ones(len(has), dtype=bool), []
    for first in range(len(has)):
        if not left[first]:
            continue
        inside, columns, added = np.zeros(len(has), dtype=bool), np.zeros(has.shape[1], dtype=bool), np.array([first])
        while len(added):
            inside[added] = True
            new = has[added].any(axis=0) & ~columns
            columns |= new
            added = np.flatnonzero(has[:, new].any(axis=1) & ~inside)
        left &= ~inside
        groups.append(np.flatnonzero(inside))
    return groups
