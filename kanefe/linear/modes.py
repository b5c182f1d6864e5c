"""Eigenmodes of a linearised scene: frequencies, damping ratios, shapes by body, and who takes part."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.linalg

from kanefe.frames import Matrix, Vector
from kanefe.linear.eigenpairs import eigenpairs
from kanefe.linear.eigenvalues import OfEigenvalues
from kanefe.linear.shapes import Shapes
from kanefe.linear.small_motions import SmallMotions
from kanefe.linear.state_space import StateSpace

RIGID = 1e-7
"""Eigenvalue, of the largest, that counts as zero: one that is double is known to the root of round-off only."""

SYMMETRIC = 1e-10
"""Asymmetry of the stiffness and size of the factor of the rates, of their largest entries, that count as none."""


@dataclass(frozen=True, eq=False)
class Modes(OfEigenvalues, Shapes):
    """Modes ``x = Re(v exp(lambda t))`` of a linearised scene, lowest frequency first; ``print`` shows a table.

    One of each pair of conjugate eigenvalues is listed, that with a positive imaginary part; real eigenvalues each by
    themselves; of a motion that nothing resists, one.

    Attributes
    ----------
    linearisation : Linearisation
    eigenvalues : ndarray of complex, shape (modes,)
        1/s.
    vectors : ndarray of complex, shape (states, modes)
        Of the states of the linearisation, without driven coordinates; of unit kinetic energy measure z^H M z.
    is_rigid : ndarray of bool, shape (modes,)
        Whether nothing resists.
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
        """``|lambda| / 2 pi``, Hz: the frequencies without damping, where damping is proportional."""
        return np.asarray(np.abs(self.eigenvalues) / (2.0 * np.pi))

    @property
    def state_names(self) -> tuple[str, ...]:
        """Names of the states of the linearisation."""
        return self.linearisation.state_names

    @cached_property
    def metric(self) -> Matrix:
        """Mass matrix over the free speeds, shape (free, free)."""
        n = self.linearisation.model.free_count
        return self.linearisation.small.mass()[:n, :n]

    @cached_property
    def tangents(self) -> np.ndarray:
        """Shapes as tangents of the tree (free, modes), complex: what `Model.advance` takes."""
        small = self.linearisation.small
        p = len(small.positions.leading) - len(small.drives)
        n = self.linearisation.model.free_count
        return np.asarray(small.along_positions.z[:n, :p] @ self.vectors[:p])

    def _repr_html_(self) -> str:
        """Return what a notebook shows of the modes."""
        from kanefe.views.modes_card import modes_card

        rows = []
        for i, value in enumerate(self.eigenvalues):
            if self.is_rigid[i]:
                kind = ("rigid motion", "")
            elif value.imag == 0.0:
                kind = (f"{value.real:.4g} 1/s", "")
            else:
                damping = 100 * self.damping_ratios[i] if abs(value.real) > self._noise else 0.0
                kind = (f"{self.frequencies[i]:.6g} Hz", f"{damping:.3g} %")
            rows.append((str(i), *kind, self.describe(i) + (" (unstable)" if self.grows[i] else "")))
        return modes_card(self.eigenvalues, self.grows, rows)

    def __str__(self) -> str:
        head = f"{'frequency [Hz]':>14}  {'[rad/s]':>11}  {'damping [%]':>11}"
        rigid, others = np.flatnonzero(self.is_rigid), np.flatnonzero(~self.is_rigid)
        lines = ["rigid motions, which nothing resists:"] if len(rigid) else []
        lines += [f"{i:4d}  {self.describe(int(i))}" for i in rigid]
        lines += [f"{'mode':>4}  {head}  moves (share of kinetic energy)"] if len(others) else []
        noise = self._noise
        for i in others.tolist():
            value = self.eigenvalues[i]
            if value.imag == 0.0:
                word = "diverges" if value.real > 0.0 else "decays"
                kind = f"{word:>14}  {'':>11}  {f'{value.real:.4g} 1/s':>11}"
            else:
                damping = 100 * self.damping_ratios[i] if abs(value.real) > noise else 0.0
                kind = f"{self.frequencies[i]:14.6g}  {value.imag:11.6g}  {damping:11.4g}"
            lines.append(f"{i:4d}  {kind}  {self.describe(i)}{'  (unstable)' if self.grows[i] else ''}")
        return "\n".join(lines)


def modes_of(linearisation: StateSpace) -> Modes:
    """Return the modes of a linearised scene, its driven coordinates held.

    Where nothing damps or gyrates and the stiffness is symmetric, they come from the symmetric problem, which keeps
    low frequencies beside high ones to more digits.
    """
    small, drives = linearisation.small, len(linearisation.small.drives)
    p, r = len(small.positions.leading), len(small.speeds.leading)
    kept = np.r_[: p - drives, p : p + r - drives]
    A = linearisation.A[np.ix_(kept, kept)]
    if small.is_holonomic:
        held = slice(0, p - drives)
        M, K = linearisation.mass[held, held], linearisation.stiffness[held, held]
        factor = (linearisation.damping + linearisation.gyroscopic)[held, held]
        scale = 1.0 / np.sqrt(np.diag(M))
        K_1, C_1 = K * np.outer(scale, scale), factor * np.outer(scale, scale)
        size = np.abs(K_1).max(initial=0.0)
        if np.abs(K_1 - K_1.T).max(initial=0.0) <= SYMMETRIC * size and not np.any(
            np.abs(C_1) > SYMMETRIC * np.sqrt(size)
        ):
            return _undamped(linearisation, M, 0.5 * (K + K.T), scale)
    return _general(linearisation, A, p - drives)


def _undamped(linearisation: StateSpace, M: Matrix, K: Matrix, scale: Vector) -> Modes:
    squares, z = scipy.linalg.eigh(K * np.outer(scale, scale), M * np.outer(scale, scale))
    z = scale[:, None] * z
    # a motion that is unstable at rest grows, and decays when time runs backwards: both are listed
    is_rigid = np.abs(squares) <= RIGID**2 * np.abs(squares).max(initial=0.0)
    values, vectors, rigid = [], [], []
    a11 = linearisation.A[: len(M), : len(M)]
    for square, shape, still in zip(squares, z.T, is_rigid, strict=True):
        root = 0.0 if still else np.sqrt(complex(-square))
        for value in (root, -root) if square < 0.0 and not still else (root,):
            values.append(complex(value))
            vectors.append(np.concatenate((shape, value * shape - a11 @ shape)))
            rigid.append(still)
    return _sorted(linearisation, np.array(values), np.array(vectors).T, np.array(rigid, dtype=bool))


def _general(linearisation: StateSpace, A: Matrix, p: int) -> Modes:
    values, vectors = eigenpairs(A, p)
    largest = np.abs(values).max(initial=0.0)
    is_rigid = np.abs(values) <= RIGID * largest
    noise = 1e-12 * largest
    is_real = np.abs(values.imag) <= noise
    values = np.where(is_real, values.real, values)
    kept = np.flatnonzero(~is_rigid & (is_real | (values.imag > 0.0)))
    zeros = np.flatnonzero(is_rigid)
    chosen = np.concatenate((_distinct(vectors[:p, zeros], zeros), kept)).astype(int)
    found = np.where(is_rigid, 0.0, values)[chosen]
    return _sorted(linearisation, found, vectors[:, chosen], is_rigid[chosen])


def _distinct(shapes: np.ndarray, numbers: np.ndarray) -> np.ndarray:
    """Return those numbers whose shapes do not depend on others: a motion that nothing resists counts twice as zero."""
    if not len(numbers):
        return numbers
    size = np.linalg.norm(shapes, axis=0)
    _, triangle, order = scipy.linalg.qr(shapes / np.where(size > 0.0, size, 1.0), mode="economic", pivoting=True)
    pivots = np.abs(np.diag(triangle))
    return np.asarray(numbers[order[: np.count_nonzero(pivots > 1e-4)]])


def _sorted(linearisation: StateSpace, values: np.ndarray, vectors: np.ndarray, is_rigid: np.ndarray) -> Modes:
    order = np.lexsort((-values.real, np.abs(values.imag), ~is_rigid))
    values, vectors, is_rigid = values[order], vectors[:, order].astype(complex), is_rigid[order]
    modes = Modes(linearisation, values, vectors, is_rigid)
    z = modes.tangents
    sizes = np.sqrt(np.einsum("ik,ij,jk->k", z.conj(), modes.metric, z).real)
    largest = z[np.abs(z).argmax(axis=0), np.arange(z.shape[1])] if z.size else np.ones(len(values))
    turn = np.where(np.abs(largest) > 0.0, np.abs(largest) / np.where(largest == 0.0, 1.0, largest), 1.0)
    return Modes(linearisation, values, vectors * (turn / np.where(sizes > 0.0, sizes, 1.0)), is_rigid)
