"""The coarse space of a mesh of order 2: displacements that are linear between the corners of its cells."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp

from kanefe.fe_model.model import Cells
from kanefe.fe_model.shapes import shape


def corner_interpolation(cells: Sequence[Cells], count: int) -> tuple[sp.csr_matrix, np.ndarray]:
    """Return the values at all nodes from those at the corners, and the nodes that are corners.

    Parameters
    ----------
    cells : sequence of Cells
    count : int
        Number of nodes, n; all are in cells.

    Returns
    -------
    interpolation : csr_matrix, shape (n, c)
    corners : ndarray of int, shape (c,)
        In ascending order.

    Examples
    --------
    >>> values, corners = corner_interpolation([Cells("line3", np.array([[0, 2, 1]]))], 3)
    >>> values.toarray().tolist(), corners.tolist()
    ([[1.0, 0.0], [0.5, 0.5], [0.0, 1.0]], [0, 2])
    """
    is_corner = np.zeros(count, dtype=bool)
    for block in cells:
        is_corner[block.nodes[:, : shape(block.kind).corners]] = True
    corners = np.flatnonzero(is_corner)
    number = np.cumsum(is_corner) - 1
    parts = [sp.csr_matrix((np.ones(len(corners)), (corners, np.arange(len(corners)))), (count, len(corners)))]
    done = is_corner.copy()
    for block in cells:
        element = shape(block.kind)
        values = shape(element.corner_kind).values(element.nodes)
        for place in range(element.corners, len(element.nodes)):
            found, first = np.unique(block.nodes[:, place], return_index=True)
            new = ~done[found]
            found, first = found[new], first[new]
            done[found] = True
            weighed = np.flatnonzero(abs(values[place]) > 1e-12)  # above the round-off of weights of order 1
            columns = number[block.nodes[first][:, weighed]]
            rows = np.repeat(found, len(weighed))
            entries = np.tile(values[place][weighed], len(found))
            parts.append(sp.csr_matrix((entries, (rows, columns.ravel())), parts[0].shape))
    return sum(parts[1:], parts[0]).tocsr(), corners
