"""Where the rows are and how they move: for functions of the user that look at the state, and for views."""

from __future__ import annotations

import numpy as np

from kanefe.kernels._numba import entry
from kanefe.kernels.layout import MODAL_SIZE, OMEGA, POSITION, VELOCITY, WORK, FlexibleTables, R, Tables
from kanefe.kernels.outward import sweep_outward
from kanefe.kernels.vectors import matrix, put, put_matrix, vector


@entry
def frames_of_rows(
    tables: Tables, flexible: FlexibleTables | None, drives: np.ndarray, q: np.ndarray, u: np.ndarray
) -> np.ndarray:
    """Return position, axes to N (9), velocity and angular velocity of every row, in N, shape (rows, 18)."""
    rows = WORK * len(tables.rows)
    modes = 0
    if flexible is not None:
        modes = flexible.sizes[MODAL_SIZE]
    room = np.empty(rows + modes)
    work = room[:rows].reshape(-1, WORK)
    sweep_outward(tables, flexible, drives, q, u, work, room[rows:])
    frames = np.empty((len(tables.rows), 18))
    for i in range(len(tables.rows)):
        put(frames, i, 0, vector(work, i, POSITION))
        put_matrix(frames, i, 3, matrix(work, i, R))
        put(frames, i, 12, vector(work, i, VELOCITY))
        put(frames, i, 15, vector(work, i, OMEGA))
    return frames
