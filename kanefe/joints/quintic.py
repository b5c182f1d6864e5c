"""Piecewise polynomials of the fifth degree: with given values and two derivatives at their ends, and splines."""

from __future__ import annotations

from math import factorial
from typing import Any

import numpy as np

from kanefe.frames import Matrix, Vector


def quintic_pieces(h: Vector, y: Matrix, moved: Matrix, dy: Matrix, ddy: Matrix) -> np.ndarray:
    """Return the powers 5 to 0 of each piece, shape (6, n, columns): Hermite's interpolation of two derivatives.

    Parameters
    ----------
    h : ndarray, shape (n, 1)
        Lengths of the pieces.
    y, dy, ddy : ndarray, shape (n + 1, columns)
        Values and derivatives at their ends.
    moved : ndarray, shape (n, columns)
        Change of y over each piece.
    """
    # value and derivatives at the end without the contribution of those at the start
    value = (moved - h * dy[:-1] - 0.5 * h**2 * ddy[:-1]) / h**3
    slope, bend = (dy[1:] - dy[:-1] - h * ddy[:-1]) / h**2, (ddy[1:] - ddy[:-1]) / h
    return np.array(
        (
            (6.0 * value - 3.0 * slope + 0.5 * bend) / h**2,
            (-15.0 * value + 7.0 * slope - bend) / h,
            10.0 * value - 4.0 * slope + 0.5 * bend,
            0.5 * ddy[:-1],
            dy[:-1],
            y[:-1],
        )
    )


def quintic_spline(x: Vector, y: Matrix, closed: bool) -> Any:
    """Return the spline of order 5 through points y at x, as polynomials; through fewer than six a single one."""
    from scipy.interpolate import PPoly, make_interp_spline

    if not closed and len(x) < 6:
        return PPoly(np.linalg.solve(np.vander(x), y)[:, None], x[[0, -1]])
    spline = make_interp_spline(x, y, k=5, bc_type="periodic" if closed else None)
    edges = np.unique(spline.t[5:-5])
    return PPoly(np.array([spline(edges[:-1], k) / factorial(k) for k in range(5, -1, -1)]), edges)
