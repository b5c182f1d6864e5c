"""UnreducedBody: a flexible body whose coordinates are all degrees of freedom of its mesh, with sparse matrices."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from kanefe.bodies.flexible import FlexibleBody
from kanefe.errors import FileError
from kanefe.fe_model.factorise import Factorisation, Factorise, splu_factorise
from kanefe.fe_model.model import TRANSLATIONS
from kanefe.storage.scipy_later import sp, spla
from kanefe.storage.serialise import NOT_SAVED

if TYPE_CHECKING:
    from kanefe.bodies.inertia_field import InertiaField

LISTED_FREQUENCIES = 12
"""Number of natural frequencies that an unreduced body lists."""


@dataclass(frozen=True, eq=False, repr=False)
class UnreducedBody(FlexibleBody):
    """A flexible body without reduction: coordinates are degrees of freedom (m, rad), matrices are sparse.

    The free coordinates are those of the interior, then the free components of the interfaces; the fixed ones come
    last. Without an interface fixed in G the body floats: G follows its mean motion, ``mean_motions @ eta = 0``.

    Attributes
    ----------
    basis, stiffness : csr_matrix, shape (n * components, K) and (K, K)
    damping : csr_matrix, shape (k, k)
    moments : InertiaField
    damping_factors : (float, float)
        Factors of M (1/s) and K (s) in C; a given `damping` matrix is added.
    rigid_motions : ndarray, shape (k, rigid)
        M-orthonormal rigid motions of a floating body; no columns if the body is held.
    massless : ndarray of int
        Free coordinates without mass, which the others move statically.
    factorise : callable
        Factors a symmetric positive definite sparse matrix. It is not written to files.
    """

    basis: sp.csr_matrix
    stiffness: sp.csr_matrix
    damping: sp.csr_matrix
    moments: InertiaField  # type: ignore[assignment]
    damping_factors: tuple[float, float] = (0.0, 0.0)
    rigid_motions: np.ndarray = field(default_factory=lambda: np.zeros((0, 0)))
    massless: np.ndarray = field(default_factory=lambda: np.zeros(0, dtype=int))
    factorise: Factorise = field(default=splu_factorise, metadata=NOT_SAVED)

    def __str__(self) -> str:
        """Return the representation, what its maker tells of it, and that nothing was left out."""
        return (
            f"{super().__str__()}\n  not reduced: all degrees of freedom of the mesh run in sparse matrices, "
            "milliseconds a step; reduction=kf.CraigBampton() takes microseconds"
        )

    def __post_init__(self) -> None:
        if not self.rigid_motions.shape[1]:
            object.__setattr__(self, "rigid_motions", np.zeros((self.free_count, 0)))
        super().__post_init__()

    def _matrices(self) -> list[np.ndarray]:
        return [self.basis.data, self.stiffness.data, self.damping.data, self.rigid_motions]

    @property
    def is_exact(self) -> bool:
        """Whether the inertia is exact (a mass field), or the nodal approximation."""
        return self.moments.is_exact

    @property
    def is_damped(self) -> bool:
        """Whether C is not zero."""
        return any(self.damping_factors) or self.damping.nnz > 0

    @cached_property
    def inertia_field(self) -> InertiaField:
        """Inertia of the free coordinates."""
        return self.moments.leading(self.free_count)

    @cached_property
    def free_stiffness(self) -> sp.csr_matrix:
        """K of the free coordinates, shape (k, k)."""
        k = self.free_count
        return self.stiffness[:k, :k].tocsr() if self.fixed_count else self.stiffness

    @cached_property
    def free_mass(self) -> sp.csr_matrix:
        """M of the free coordinates, shape (k, k)."""
        return self.inertia_field.elastic_mass

    @cached_property
    def held_factors(self) -> Factorisation:
        """Factors of K of the free coordinates, for a body that is held."""
        return self.factorise(self.free_stiffness.tocsc())

    def coordinate_scales(self, length: float) -> np.ndarray:
        """Return a large value of each free coordinate, (k,): `length` of displacements, 1 rad of rotations."""
        k = self.free_count
        by_column = self.basis[:, :k].tocsc()
        is_turn = np.array([c not in TRANSLATIONS for c in self.components])
        turns = is_turn[by_column.indices[by_column.indptr[:-1]] % len(self.components)]
        for frame in self.interfaces:
            moves = frame.motion[:, :k] != 0
            turns = np.where(moves.any(axis=0), moves[3:].any(axis=0), turns)
        return np.where(turns, 1.0, length)

    def damping_force(self, deta: np.ndarray) -> np.ndarray:
        """Return ``C deta``, shape (k,)."""
        of_mass, of_stiffness = self.damping_factors
        force = of_stiffness * (self.free_stiffness @ deta)
        if of_mass:
            force += of_mass * (self.free_mass @ deta)
        if self.damping.nnz:
            force += self.damping @ deta
        return np.asarray(force)

    def centred(self, motion: np.ndarray) -> np.ndarray:
        """Return coordinates or rates (k,) without their mean motion, which G has."""
        if not self.rigid_motions.shape[1]:
            return motion
        return np.asarray(motion - self.rigid_motions @ (self.mean_motions @ motion))

    @cached_property
    def mean_motions(self) -> np.ndarray:
        """Rigid motions of a floating body times M, shape (rigid, k): ``mean_motions @ eta = 0``."""
        return np.ascontiguousarray((self.free_mass @ self.rigid_motions).T)

    @property
    def frequencies(self) -> np.ndarray:
        """The lowest natural frequencies with the fixed interfaces held, at most 12, in Hz."""
        K, M, rigid = self.free_stiffness, self.free_mass, self.rigid_motions.shape[1]
        count = min(LISTED_FREQUENCIES + rigid, self.free_count - 1)
        shift = -1e-6 * float(K.diagonal().sum() / M.diagonal().sum())
        inverse = spla.LinearOperator(K.shape, matvec=self.factorise((K - shift * M).tocsc()).solve, dtype=float)
        start = np.random.default_rng(0).standard_normal(K.shape[0])
        squares = spla.eigsh(K, k=count, M=M, sigma=shift, OPinv=inverse, v0=start, return_eigenvectors=False)
        return np.sqrt(np.maximum(np.sort(squares)[rigid:], 0.0)) / (2 * np.pi)

    @cached_property
    def _total(self) -> tuple[float, np.ndarray, np.ndarray]:
        return self.moments.leading(0).total()

    @property
    def mass(self) -> float:
        """Mass in kg."""
        return self._total[0]

    @property
    def center_of_mass(self) -> np.ndarray:
        """Undeformed centre of mass in G, shape (3,), m."""
        return self._total[1] / self.mass

    @property
    def inertia(self) -> np.ndarray:
        """Undeformed inertia about the origin of G, in components of G, shape (3, 3), kg m2."""
        return self._total[2]

    def save(self, path: str | Path) -> None:
        """Refuse: an unreduced body is as large as its model.

        Raises
        ------
        FileError
            Always.
        """
        raise FileError(
            f"an unreduced body is not written to {path}: it is as large as its matrices. Remedy: make it again from "
            "the model, or save a reduced one, reduction=CraigBampton()"
        )
