"""Eigenmodes of a linearised scene: frequencies, damping ratios, shapes by body, and participation."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.linalg

from kanefe.frames import Matrix, Vector
from kanefe.linear.losses import following
from kanefe.linear.modes.bodies_alone import alone_in_words
from kanefe.linear.modes.eigenpairs import eigenpairs, rate_weights
from kanefe.linear.modes.eigenvalues import OfEigenvalues
from kanefe.linear.modes.mode_shapes import Shapes
from kanefe.linear.modes.unresisted import Unresisted
from kanefe.linear.small_motions import SmallMotions
from kanefe.linear.state_space import StateSpace
from kanefe.linear.unsettled import imbalance_in_words

ROUND_OFF = 1e-14
"""Imaginary part, relative to the largest eigenvalue, below which an eigenvalue is real."""

SLOWEST = 1e-15
"""Frequency of a single coordinate, relative to the largest, above which it is used to scale the coordinate."""

SYMMETRIC = 1e-10
"""Asymmetry of the stiffness and size of the factor of the rates, relative to their largest entries, that count as
zero."""


@dataclass(frozen=True, eq=False)
class Modes(OfEigenvalues, Shapes):
    """Modes ``x = Re(v exp(lambda t))`` of a linearised scene, lowest frequency first; ``print`` shows a table.

    Of each pair of conjugate eigenvalues the one with positive imaginary part is listed; all real eigenvalues; and one
    for each motion without restoring force.

    Attributes
    ----------
    linearisation : Linearisation
    eigenvalues : ndarray of complex, shape (modes,)
        1/s.
    vectors : ndarray of complex, shape (states, modes)
        Over the states of the linearisation, without driven coordinates; with unit kinetic energy measure z^H M z.
    is_rigid : ndarray of bool, shape (modes,)
        Whether there is no restoring force.
    """

    linearisation: StateSpace
    eigenvalues: np.ndarray
    vectors: np.ndarray
    is_rigid: np.ndarray

    @property
    def _small(self) -> SmallMotions:
        return self.linearisation.small

    @property
    def natural_frequencies(self) -> Vector:
        """``|lambda| / 2 pi``, Hz: undamped frequencies if damping is proportional; damped ones: `frequencies`."""
        return np.asarray(np.abs(self.eigenvalues) / (2.0 * np.pi))

    @property
    def loss_factors(self) -> Vector:
        """``Im / Re`` of ``-lambda^2``: of a structure with the same loss factor everywhere this one in all modes.

        For a mode with a small damping ratio it is twice that.
        """
        squares = -(self.eigenvalues**2)
        return np.divide(squares.imag, squares.real, out=np.zeros(len(squares)), where=squares.real > 0.0)

    @property
    def state_names(self) -> tuple[str, ...]:
        """Names of the states of the linearisation."""
        return self.linearisation.state_names

    @cached_property
    def metric(self) -> Matrix:
        """Mass matrix over the free speeds, shape (free, free)."""
        n = self.linearisation.model.free_count
        return self.linearisation.small.mass[:n, :n]

    @cached_property
    def tangents(self) -> np.ndarray:
        """Shapes as tangents of the tree (free, modes), complex: what `Model.advance` takes."""
        small = self.linearisation.small
        p = len(small.positions.leading) - len(small.drives)
        n = self.linearisation.model.free_count
        return np.asarray(small.along_positions.z[:n, :p] @ self.vectors[:p])

    def _repr_html_(self) -> str:
        """Return the card of the modes that notebooks show."""
        from kanefe.views.cards.modes_card import modes_card

        rows = []
        for i, value in enumerate(self.eigenvalues):
            if self.is_rigid[i]:
                kind = ("rigid motion", "")
            elif value.imag == 0.0:
                kind = (f"{value.real:.4g} 1/s", "")
            else:
                damping = 100 * self.damping_ratios[i] if abs(value.real) > self._noise[i] else 0.0
                kind = (f"{self.frequencies[i]:.6g} Hz", f"{damping:.3g} %")
            rows.append((str(i), *kind, self.describe(i) + (" (unstable)" if self.grows[i] else "")))
        return modes_card(self.eigenvalues, self.grows, rows)

    def __str__(self) -> str:
        head = f"{'frequency [Hz]':>14}  {'[rad/s]':>11}  {'damping [%]':>11}"
        rigid, others = np.flatnonzero(self.is_rigid), np.flatnonzero(~self.is_rigid)
        lines = ["rigid motions (without restoring force):"] if len(rigid) else []
        lines += [f"{i:4d}  {self.describe(int(i))}" for i in rigid]
        lines += [f"{'mode':>4}  {head}  moves (share of kinetic energy)"] if len(others) else []
        noise = self._noise
        for i in others.tolist():
            value = self.eigenvalues[i]
            if value.imag == 0.0:
                word = "diverges" if value.real > 0.0 else "decays"
                kind = f"{word:>14}  {'':>11}  {f'{value.real:.4g} 1/s':>11}"
            else:
                damping = 100 * self.damping_ratios[i] if abs(value.real) > noise[i] else 0.0
                kind = f"{self.frequencies[i]:14.6g}  {value.imag:11.6g}  {damping:11.4g}"
            lines.append(f"{i:4d}  {kind}  {self.describe(i)}{'  (unstable)' if self.grows[i] else ''}")
        return "\n".join(lines + alone_in_words(self._small.model) + imbalance_in_words(self.linearisation.imbalance))


def modes_of(linearisation: StateSpace) -> Modes:
    """Return the modes of a linearised scene with fixed driven coordinates.

    Motions without restoring force are found by rank and separated, so that they do not mix with low frequencies.
    Without damping and gyroscopic terms and with symmetric stiffness, the others are found from the symmetric problem,
    which has more accurate low frequencies.
    """
    small, drives = linearisation.small, len(linearisation.small.drives)
    A: np.ndarray = linearisation._undriven
    moving = linearisation.moving_count - 2 * drives
    free, arms = linearisation._unresisted, len(A) - moving
    if arms:
        free = replace(free, motions=np.vstack((free.motions, -following(A, moving) @ free.motions)))
    H = linearisation.structural
    if H is not None:
        A = A + 1j * linearisation._without_drives(H)
    rest = _symmetric(linearisation, A, free) if small.is_holonomic and not arms and H is None else None
    values, vectors = rest or _general(A, free, len(small.positions.leading) - drives, arms)
    still = free.motions[:, : free.still]
    return _sorted(
        linearisation,
        np.concatenate((np.zeros(still.shape[1]), values)),
        np.hstack((still, vectors)),
        np.arange(still.shape[1] + len(values)) < still.shape[1],
    )


def _symmetric(linearisation: StateSpace, A: Matrix, free: Unresisted) -> tuple[np.ndarray, np.ndarray] | None:
    """Return eigenvalues and vectors of the resisted motions if there is only a symmetric stiffness, else None."""
    p = len(A) // 2
    M, K = linearisation.mass[:p, :p], linearisation.stiffness[:p, :p]
    factor = (linearisation.damping + linearisation.gyroscopic)[:p, :p]
    scale = 1.0 / np.sqrt(np.diag(M))
    K_1, C_1 = K * np.outer(scale, scale), factor * np.outer(scale, scale)
    size = np.abs(K_1).max(initial=0.0)
    if np.abs(K_1 - K_1.T).max(initial=0.0) > SYMMETRIC * size or np.any(np.abs(C_1) > SYMMETRIC * np.sqrt(size)):
        return None
    led = free.leading[: free.still]
    Z, others = free.motions[:p, : free.still], np.setdiff1d(np.arange(p), led)
    # orthogonal to the unresisted motions, so that K is that of the other coordinates
    V = np.eye(p)[:, others] - Z @ np.linalg.solve(Z.T @ M @ Z, Z.T @ M[:, others])
    squares, z = _squares(0.5 * (K + K.T)[np.ix_(others, others)], V.T @ M @ V)
    values, vectors = [], []
    # a statically unstable motion has a growing and a decaying solution: both are listed
    for square, shape in zip(squares, (V @ z).T, strict=True):
        root = complex(np.sqrt(complex(-square)))
        for value in (root, -root) if square < 0.0 else (root,):
            values.append(value)
            vectors.append(np.concatenate((shape, value * shape - A[:p, :p] @ shape)))
    return np.array(values), np.array(vectors).T.reshape(2 * p, -1)


def _squares(K: Matrix, M: Matrix) -> tuple[Vector, Matrix]:
    """Return the squares of frequencies and the shapes, ``K z = square M z``.

    For a positive definite stiffness by the singular values of ``L_K^-1 L_M``, which are 1 / frequency: squares of low
    frequencies next to much higher ones would have half as many digits.
    """
    if not K.size:
        return np.zeros(0), K
    scale = 1.0 / np.sqrt(np.diag(M))
    M = M * np.outer(scale, scale)
    try:
        if np.diag(K).min() <= 0.0:
            raise np.linalg.LinAlgError("not positive definite")
        stiff = 1.0 / np.sqrt(np.diag(K))
        L_K = np.linalg.cholesky(K * np.outer(stiff, stiff)) / stiff[:, None]
    except np.linalg.LinAlgError:
        squares, z = scipy.linalg.eigh(K * np.outer(scale, scale), M)
        return squares, scale[:, None] * z
    L_M = np.linalg.cholesky(M) / scale[:, None]
    left, periods, _ = np.linalg.svd(scipy.linalg.solve_triangular(L_K, L_M, lower=True))
    return 1.0 / periods**2, scipy.linalg.solve_triangular(L_K, left, lower=True, trans="T")


def _general(A: np.ndarray, free: Unresisted, p: int, arms: int) -> tuple[np.ndarray, np.ndarray]:
    """Return eigenvalues and vectors of the resisted motions, one of each conjugate pair."""
    led = free.leading
    others = np.setdiff1d(np.arange(len(A)), led)
    Z = free.motions[others]
    rest = A[np.ix_(others, others)] - Z @ A[np.ix_(led, others)]
    values, shapes = eigenpairs(rest, rate_weights(A, p, SLOWEST, arms)[others])
    noise = ROUND_OFF * np.abs(values).max(initial=0.0)
    is_real = np.abs(values.imag) <= noise
    values = np.where(is_real, values.real, values)
    kept = is_real | (values.imag > 0.0)
    values, shapes = values[kept], shapes[:, kept]
    # the part of the vectors along unresisted motions
    along = A[np.ix_(led, led)] + A[np.ix_(led, others)] @ Z
    pushed = A[np.ix_(led, others)] @ shapes
    moved = [
        np.linalg.solve(value * np.eye(len(led)) - along, push) for value, push in zip(values, pushed.T, strict=True)
    ]
    vectors = np.zeros((len(A), len(values)), dtype=complex)
    vectors[led] = np.reshape(moved, (len(values), len(led))).T
    vectors[others] = shapes + Z @ vectors[led]
    return values, vectors


def _sorted(linearisation: StateSpace, values: np.ndarray, vectors: np.ndarray, is_rigid: np.ndarray) -> Modes:
    order = np.lexsort((-values.real, np.abs(values.imag), ~is_rigid))
    values, vectors, is_rigid = values[order], vectors[:, order].astype(complex), is_rigid[order]
    modes = Modes(linearisation, values, vectors, is_rigid)
    z = modes.tangents
    sizes = np.sqrt(np.einsum("ik,ij,jk->k", z.conj(), modes.metric, z).real)
    largest = z[np.abs(z).argmax(axis=0), np.arange(z.shape[1])] if z.size else np.ones(len(values))
    turn = np.where(np.abs(largest) > 0.0, np.abs(largest) / np.where(largest == 0.0, 1.0, largest), 1.0)
    return Modes(linearisation, values, vectors * (turn / np.where(sizes > 0.0, sizes, 1.0)), is_rigid)
