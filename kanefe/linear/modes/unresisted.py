"""Motions without restoring force, from elastic or geometric stiffness, gravity or loads.

They are found by rank, not by low frequencies. Small motions ``M a = F x`` stay constant or drift if

    T dx/dt = X x,   X = [[A_11, A_12], [M A_21, M A_22]],   T = [[1, 0], [0, M]]

has them in the null space of X, or leads them into it: ``X x = T c`` with c found before. Each entry of X is a sum with
terms of known sizes, and thus of known round-off: rows and columns are scaled so that the largest terms in each are
one, and the sums are compared with these.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy.linalg

from kanefe.frames import Matrix, Vector
from kanefe.linear.imbalance import force_sizes
from kanefe.linear.losses import condensed
from kanefe.linear.modes.eigenpairs import rate_weights
from kanefe.linear.modes.hill import hill_matrix
from kanefe.linear.overflow import refuse_overflow
from kanefe.linear.small_motions import SmallMotions
from kanefe.linear.tangents import DIFFERENCE_STEP, tangent_steps

NOTHING = {True: 1e-11, False: 1e-9}
"""Singular value of scaled sums of terms of size one that is round-off, with exact derivatives and without."""

LEAST = 1e-20
"""Stiffness, relative to that of the fastest entry over the same masses, that always counts as zero: times `NOTHING`
its frequency is round-off of the highest."""

ALIKE = 1e-6
"""Position of a unit motion that counts as zero, and rate of its positions below which it is at rest."""

STATELESS = 1e-10
"""Size of the states of a scaled null vector of unit size that is round-off."""

SCALINGS, EVEN = 30, 0.1
"""Largest number of rounds of scaling rows and columns, and deviation of their largest entries from one that is
accepted: little compared with the powers of ten between round-off and stiffness."""


@dataclass(frozen=True, eq=False)
class Unresisted:
    """Motions without restoring force: constant displacements and constant speeds.

    Attributes
    ----------
    motions : ndarray, shape (states, k)
        Basis: each changes one of the leading states by one, and none of the other leading states.
    leading : ndarray of int, shape (k,)
    still : int
        Number of the first ones that are constant displacements: the rigid motions.
    drifts : ndarray, shape (speeds, d)
        Constant speeds that need no displacement.
    """

    motions: Matrix
    leading: np.ndarray
    still: int
    drifts: Matrix


class _Sums(NamedTuple):
    """``T dx/dt = X x`` with the sizes of the terms of X, and the weights of the states."""

    T: Matrix
    X: Matrix
    sizes: Matrix
    weights: Vector
    rates: Vector
    p: int


def _sums(small: SmallMotions, A: Matrix) -> _Sums:
    drives = len(small.drives)
    p, r = len(small.positions.leading) - drives, len(small.speeds.leading) - drives
    mass, Z, N = small.mass, small.along_positions.z[:, :p], small.speeds.N[:, :r]
    M = N.T @ mass @ N
    rates, speeds = rate_weights(A, p)[:p], np.sqrt(np.diag(M))
    places = rates * np.sqrt(np.abs(np.einsum("ik,ij,jk->k", Z, mass, Z)))
    T = scipy.linalg.block_diag(np.eye(p), M)
    sizes, weights = np.abs(T) @ np.abs(A), np.concatenate((places, speeds))
    sizes[p:] += _of_loads(small, Z, N) + LEAST * rates.max(initial=0.0) * np.outer(speeds, weights)
    return _Sums(T, T @ A, sizes, weights, rates, p)


def unresisted_around(points: Sequence[SmallMotions], matrices: np.ndarray, rate: float, reach: int) -> int:
    """Return the number of motions about a periodic motion without restoring force at any azimuth.

    Parameters
    ----------
    points : sequence of SmallMotions
        At equal steps of a period.
    matrices : ndarray, shape (n, x, x)
        A at each.
    rate : float
        rad/s.
    reach : int
        Number of harmonics on either side that they may have.
    """
    moving = len(points[0].positions.leading) + len(points[0].speeds.leading)
    matrices = np.array([condensed(A, moving) for A in matrices])
    sums = [_sums(small, A) for small, A in zip(points, matrices, strict=True)]
    turns = rate * np.arange(-reach, reach + 1).repeat(matrices.shape[1])
    Ts, Xs = np.array([each.T for each in sums]), np.array([each.X for each in sums])
    T, X = (hill_matrix(np.fft.fft(each, axis=0) / len(points), 0.0, reach) for each in (Ts, Xs))
    sizes, masses = np.max([each.sizes for each in sums], axis=0), np.abs(Ts).max(axis=0)
    sizes, masses = (np.tile(each, (2 * reach + 1, 2 * reach + 1)) for each in (sizes, masses))
    weights, p = np.max([each.weights for each in sums], axis=0), sums[0].p
    weights, equations = (np.tile(each, 2 * reach + 1) for each in (weights, _of_equations(weights, p)))
    found = np.zeros((len(turns), 0))
    is_exact = all(small.derivatives.is_exact for small in points)
    while True:
        wider = np.hstack((sizes + masses * np.abs(turns), masses @ np.abs(found)))
        null = _null_space(np.hstack((X - 1j * T * turns, T @ found)), wider, weights, equations, NOTHING[is_exact])
        if null.shape[1] <= found.shape[1]:
            return found.shape[1]
        found = _by_weight(null, weights)


def unresisted(small: SmallMotions, A: Matrix) -> Unresisted:
    """Return the motions without restoring force, with fixed driven coordinates.

    Parameters
    ----------
    small : SmallMotions
    A : ndarray, shape (states, states)
        Its state matrix, without the states of drives.
    """
    sums = _sums(small, A)
    p, weights, found = sums.p, sums.weights, np.zeros((len(A), 0))
    equations, nothing = _of_equations(weights, p), NOTHING[small.derivatives.is_exact]
    while True:
        wider = np.hstack((sums.sizes, np.abs(sums.T) @ np.abs(found)))
        null = _null_space(np.hstack((sums.X, sums.T @ found)), wider, weights, equations, nothing)
        if null.shape[1] <= found.shape[1]:  # each space contains the one before; a smaller one is round-off
            break
        found = _by_weight(null, weights)
    return _led(found, (weights[:p] / sums.rates)[:, None] * (A[:p] @ found), weights)


def _led(found: Matrix, moving: Matrix, weights: Vector) -> Unresisted:
    """Return motions with leading states that are large in them by weight, constant displacements first.

    `moving` are the rates of positions in unit motions.
    """
    p, count = len(moving), found.shape[1]
    if not count:
        return Unresisted(found, np.zeros(0, dtype=int), 0, found[p:])
    _, values, right = np.linalg.svd(weights[:p, None] * found[:p])
    drifts = found[p:] @ right[int(np.count_nonzero(values > ALIKE)) :].T
    _, values, right = np.linalg.svd(moving)
    still = count - int(np.count_nonzero(values > ALIKE))
    basis = weights[:, None] * (found @ right[::-1].T)
    leading = _pivots(basis[:p, :still])
    rest = basis[:, still:] - basis[:, :still] @ np.linalg.solve(basis[leading, :still], basis[leading, still:])
    leading = np.concatenate((leading, _pivots(rest)))
    basis = basis / weights[:, None]
    return Unresisted(basis @ np.linalg.inv(basis[leading]), leading, still, drifts)


def _pivots(basis: Matrix) -> np.ndarray:
    """Return the rows that separate vectors best, one for each column."""
    if not basis.size:
        return np.zeros(0, dtype=int)
    return np.asarray(scipy.linalg.qr(basis.T, mode="r", pivoting=True)[1][: basis.shape[1]])


def _of_loads(small: SmallMotions, Z: Matrix, N: Matrix) -> Matrix:
    """Return how much the acting forces may change with each state, (r, states), a measure of their round-off.

    They are taken to change by their own size over a large displacement, or over a speed as large as the present ones.
    """
    model, n = small.model, small.model.free_count
    forces = np.abs(N).T @ force_sizes(small.here)[small.columns]
    of_places, of_speeds = (DIFFERENCE_STEP / tangent_steps(model, along[:n]) for along in (Z, N))
    driven = model.driven_speeds(small.t)[0] if model.driven_count else np.zeros(0)
    fastest = float(np.abs(driven).max(initial=0.0))
    if small.u.any():
        fastest = max(fastest, DIFFERENCE_STEP / float(tangent_steps(model, small.u[:, None])[0]))
    return np.outer(forces, np.concatenate((of_places, of_speeds / fastest if fastest else 0.0 * of_speeds)))


def _by_weight(space: Matrix, weights: Vector) -> Matrix:
    """Return a space of motions, orthonormal by weight.

    Without weights its parts would differ by powers of the units, and more motions within it would be lost.
    """
    return np.asarray(np.linalg.qr(weights[:, None] * space)[0] / weights[:, None])


def _of_equations(weights: Vector, p: int) -> Vector:
    """Return weights of ``T dx/dt = X x`` from those of the states: the same for p positions, inverse for speeds."""
    return np.concatenate((weights[:p], 1.0 / weights[p:]))


def _null_space(X: Matrix, sizes: Matrix, weights: Vector, equations: Vector, tolerance: float) -> Matrix:
    """Return a basis of the states of the null space of a matrix of sums with terms of known sizes, (states, k).

    Null vectors without states are of rows where terms much larger than all others leave no more than their round-off.
    The first columns are of states. The scaling is not unique: it begins with the weights of these and of the
    equations, in which soft motions stand out as they do in frequencies.
    """
    columns = np.ones(X.shape[1])
    columns[: len(weights)] = 1.0 / weights
    largest = equations * (sizes * columns).max(axis=1, initial=0.0)
    # a row with larger terms than these is round-off alone
    top = (equations[:, None] * np.abs(X) * columns).max(initial=0.0) / tolerance
    rows = equations * np.minimum(1.0, top / np.where(largest > 0.0, largest, 1.0))
    for _ in range(SCALINGS):
        scaled = rows[:, None] * sizes * columns
        by_row, by_column = (
            np.where(largest > 0.0, largest, 1.0)
            for largest in (scaled.max(axis=1, initial=0.0), scaled.max(axis=0, initial=0.0))
        )
        if max(np.abs(by_row - 1.0).max(initial=0.0), np.abs(by_column - 1.0).max(initial=0.0)) < EVEN:
            break
        rows, columns = rows / np.sqrt(by_row), columns / np.sqrt(by_column)
    scaled = rows[:, None] * X * columns
    refuse_overflow("the state matrix", sizes, scaled)
    _, values, right = np.linalg.svd(scaled)
    rank = int(np.count_nonzero(values > tolerance))
    space, values, _ = np.linalg.svd(right[rank:, : len(weights)].conj().T, full_matrices=False)
    return np.asarray(columns[: len(weights), None] * space[:, values > STATELESS])
