"""The stiffness of a scene about a state, in coordinates of unit mass, and the steps against it."""

from __future__ import annotations

import numpy as np
import scipy.linalg

from kanefe.frames import Matrix, Vector
from kanefe.linear.overflow import refuse_overflow
from kanefe.linear.small_motions import SmallMotions

WEAKEST_MASS = 1e-12
"""Inertia along a motion, relative to unit inertia along each speed, below which it counts as this value."""

NEUTRAL = 1e-11
"""Singular value of the scaled stiffness, relative to the largest, below which a motion has no restoring force."""


def metric(M: Matrix) -> Matrix:
    """Return L of ``M = L L^T``, with the absolute values of the eigenvalues of M if it is not positive definite."""
    scale = np.sqrt(np.abs(np.diag(M)))
    scale = np.where(scale > 0.0, scale, 1.0)
    squares, vectors = np.linalg.eigh(M / np.outer(scale, scale))
    return np.asarray(scale[:, None] * vectors * np.sqrt(np.maximum(np.abs(squares), WEAKEST_MASS)))


def unit_mass(small: SmallMotions) -> tuple[Matrix, Matrix]:
    """Return the map to coordinates of unit mass, and that from accelerations to forces along them."""
    M = small.speeds.N.T @ small.mass @ small.speeds.N
    inverse = np.linalg.inv(metric(M))
    return inverse, inverse @ M


def stiffness_of(small: SmallMotions) -> tuple[Matrix, Matrix, Matrix]:
    """Return the stiffness in coordinates of unit mass of a scene without rolling, and the result of `unit_mass`."""
    inverse, weight = unit_mass(small)
    return -weight @ small.along_positions.ddu[small.speeds.leading] @ inverse.T, inverse, weight


def lowest(H: Matrix) -> float:
    """Return the lowest eigenvalue of the symmetric part of a stiffness if it is negative beyond round-off, else 0."""
    least = float(scipy.linalg.eigvalsh(0.5 * (H + H.T)).min(initial=0.0))
    return least if least < -1e-9 * float(np.abs(H).max(initial=0.0)) else 0.0


def along_neutral(H: Matrix, right: Vector) -> Vector:
    """Return the part of the right-hand side along motions without stiffness."""
    squares, shapes = np.linalg.eigh(0.5 * (H + H.T))
    neutral = shapes[:, np.abs(squares) <= NEUTRAL * np.abs(squares).max(initial=0.0)]
    return np.asarray(neutral @ (neutral.T @ right))


def solved(H: Matrix, right: Vector) -> tuple[Vector, Vector]:
    """Return the least-norm x of ``H x = right`` with scaled rows and columns, and what no stiffness meets.

    That is decided by the rank: nothing is left where it is full, however inaccurate x is.
    """
    if not H.size:
        return np.zeros(H.shape[1]), right
    refuse_overflow("the stiffness", H)
    rows, columns = _scales(H)
    x, _, rank, _ = np.linalg.lstsq(H / rows[:, None] / columns[None, :], right / rows, rcond=NEUTRAL)
    x = np.asarray(x / columns)
    return x, right - H @ x if rank < len(H) else np.zeros(len(H))


def rank_of(H: Matrix) -> int:
    """Return how many motions have a stiffness, as `solved` decides it."""
    if not H.size:
        return 0
    rows, columns = _scales(H)
    refuse_overflow("the stiffness", H)
    values = np.linalg.svd(H / rows[:, None] / columns[None, :], compute_uv=False)
    return int(np.count_nonzero(values > NEUTRAL * values.max()))


def _scales(H: Matrix) -> tuple[Vector, Vector]:
    """Return the sizes by which rows and columns of a stiffness are divided."""
    columns, rows = np.sqrt(np.abs(H).max(axis=0)), np.sqrt(np.abs(H).max(axis=1))
    floor = 1e-12 * max(float(columns.max()), 1e-300)
    return np.where(rows > floor, rows, 1.0), np.where(columns > floor, columns, 1.0)


def share(part: Vector, whole: Vector) -> float:
    """Return the size of a part of a vector, relative to the whole."""
    return float(np.linalg.norm(part)) / max(float(np.linalg.norm(whole)), 1e-300)
