"""Factorisation of symmetric sparse matrices, definite or not: the protocol, and the solver of scipy."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from kanefe.errors import ModelError, SingularStiffness
from kanefe.storage.scipy_later import sp, spla


class Factorisation(Protocol):
    """A factored symmetric matrix."""

    def solve(self, b: np.ndarray) -> np.ndarray:
        """Return ``A^-1 b`` for b of shape (n,) or (n, m)."""
        ...


class Factorise(Protocol):
    """A function that factors the matrices of a body."""

    def __call__(self, matrix: sp.csc_matrix, /, *, definite: bool = True) -> Factorisation:
        """Return the factors of a symmetric matrix.

        Parameters
        ----------
        matrix : csc_matrix, shape (n, n)
        definite : bool
            Whether it is positive definite, such as K of a body that is held. If not, such as ``K - w^2 M``, rows are
            pivoted, and a solution needs one or two steps of iterative refinement.

        Raises
        ------
        RuntimeError
            If the matrix is singular.
        """
        ...


INDEFINITE_PIVOTS = 0.01
"""Smallest pivot of an indefinite matrix relative to the largest entry of its column."""


class _SuperLU:
    def __init__(self, matrix: sp.csc_matrix, definite: bool) -> None:
        if definite:
            options = {"diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}
        else:
            options = {"diag_pivot_thresh": INDEFINITE_PIVOTS}
        self._lu = spla.splu(matrix, permc_spec="MMD_AT_PLUS_A", **options)

    def solve(self, b: np.ndarray) -> np.ndarray:
        return np.asarray(self._lu.solve(np.ascontiguousarray(b)))


class NothingInside:
    """Factors of a body without interior: all its nodes belong to interfaces."""

    def solve(self, b: np.ndarray) -> np.ndarray:
        """Return the empty solution."""
        return b


def splu_factorise(matrix: sp.csc_matrix, /, *, definite: bool = True) -> Factorisation:
    """Factor a symmetric matrix, positive definite or not, by SuperLU; efficient up to about 10,000 rows."""
    return _SuperLU(sp.csc_matrix(matrix), definite)


def factor_interior(matrix: sp.csc_matrix, factorise: Factorise) -> Factorisation:
    """Factor K of the interior of a body and check it by one solve, which reveals a mechanism or loose part.

    Raises
    ------
    ModelError
        If the matrix is empty.
    SingularStiffness
        If it is singular to working precision.
    """
    remedy = "Remedy: check the mesh for loose parts or hinges, and the interfaces"
    if matrix.shape[0] == 0:
        raise ModelError(
            "all nodes of the body belong to interfaces that are fixed in G: nothing is left to deform. Remedy: refine "
            "the mesh, or let an interface move, such as 'rigid' for 'clamped'"
        )
    try:
        factors = factorise(matrix)
    except RuntimeError as error:
        raise SingularStiffness(f"the stiffness matrix of the interior is singular ({error}). {remedy}") from error
    u = np.cos(np.arange(matrix.shape[0]))  # a fixed vector with a component along every mode
    error_size = np.linalg.norm(factors.solve(matrix @ u) - u) / np.linalg.norm(u)
    if not error_size < 1e-3:
        raise SingularStiffness(
            "the stiffness matrix of the interior is singular or nearly so (a solve is wrong by "
            f"{error_size:.1e}). {remedy}"
        )
    return factors
