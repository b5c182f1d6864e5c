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
    inertia, force : ndarray, shapes (n, n), (n,)
        A and f of what they carry.
    gram, system : ndarray, shape (n, n)
        B B^T and 1 + A B B^T; the second is lost when it is solved.
    series, inverse : ndarray, shape (n, n)
        A' and (1 + A B B^T)^-1.
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
    system: np.ndarray
    series: np.ndarray
    inverse: np.ndarray
    held: np.ndarray
    column: np.ndarray
    push: np.ndarray
    change: np.ndarray


def border_size(count: int, carried: int) -> int:
    """Return how many numbers the border of a body with `count` modes and `carried` carrying interfaces takes."""
    n = 6 * carried
    return n * (count + 6) + 5 * n * n + 3 * n + 6 + 36


@inlined
def border_in(border: np.ndarray, body: np.ndarray) -> Border:
    """Return the parts of the border of a body, in the border work array."""
    k, n, at = body[COUNT], 6 * body[CARRIED_COUNT], body[BORDER]
    levers = at + n * k
    squares = levers + 6 * (n + 6)
    columns = squares + 5 * n * n
    ends = columns + 3 * n
    # as few reshapes as can be: each is a call
    sixes, square = border[levers:squares].reshape(n + 6, 6), border[squares:columns].reshape(5, n, n)
    return Border(
        basis=border[at:levers].reshape(n, k),
        lever=sixes[:n],
        inertia=square[0],
        force=border[columns : columns + n],
        gram=square[1],
        system=square[2],
        series=square[3],
        inverse=square[4],
        held=border[columns + n : columns + 2 * n],
        column=border[columns + 2 * n : ends],
        push=border[ends : ends + 6],
        change=sixes[n:],
    )
