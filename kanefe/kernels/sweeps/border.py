"""Workspace of the elimination of the modes of a flexible body: see `kanefe.kernels.sweeps.modal_elimination`."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kanefe.kernels.compiler._numba import inlined
from kanefe.kernels.layout import BORDER, CARRIED_COUNT, COUNT


class Border(NamedTuple):
    """What couples k modes of a body to G and to its interfaces that carry something, n = 6 rows for each of these.

    Attributes
    ----------
    basis : ndarray, shape (n, k)
        B, the motion of the interfaces from the modes.
    lever : ndarray, shape (n, 6)
        H, their motion with G while the modes give way.
    inertia, force : ndarray, shapes (n, 6), (n,)
        A, a block of six for each interface, and f of what they carry.
    gram : ndarray, shape (n, n)
        B B^T.
    factors, pivots : ndarray, shapes (n, n), (n,)
        Those of 1 + A B B^T.
    series : ndarray, shape (n, 6)
        A' H.
    held, column : ndarray, shape (n,)
        y_0, and a column that is used on the way to it.
    push, change : ndarray, shapes (6,), (6, 6)
        What all that adds to the force and, in the upper triangle, to the inertia that G feels.
    """

    basis: np.ndarray
    lever: np.ndarray
    inertia: np.ndarray
    force: np.ndarray
    gram: np.ndarray
    factors: np.ndarray
    pivots: np.ndarray
    series: np.ndarray
    held: np.ndarray
    column: np.ndarray
    push: np.ndarray
    change: np.ndarray


def border_size(count: int, carried: int) -> int:
    """Return how many numbers the border of a body with `count` modes and `carried` carrying interfaces takes."""
    n = 6 * carried
    return n * (count + 18) + 2 * n * n + 4 * n + 6 + 36


@inlined
def border_in(border: np.ndarray, body: np.ndarray) -> Border:
    """Return the parts of the border of a body, in the border work array."""
    k, n, at = body[COUNT], 6 * body[CARRIED_COUNT], body[BORDER]
    sixes = at + n * k
    squares = sixes + 6 * (3 * n + 6)
    columns = squares + 2 * n * n
    ends = columns + 4 * n
    # as few reshapes as can be: each is a call
    six, square = border[sixes:squares].reshape(3 * n + 6, 6), border[squares:columns].reshape(2, n, n)
    return Border(
        basis=border[at:sixes].reshape(n, k),
        lever=six[:n],
        inertia=six[n : 2 * n],
        force=border[columns : columns + n],
        gram=square[0],
        factors=square[1],
        pivots=border[columns + n : columns + 2 * n],
        series=six[2 * n : 3 * n],
        held=border[columns + 2 * n : columns + 3 * n],
        column=border[columns + 3 * n : ends],
        push=border[ends : ends + 6],
        change=six[3 * n :],
    )
