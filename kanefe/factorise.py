"""Factoring symmetric positive definite sparse matrices: the protocol, and the solver that scipy brings."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from kanefe.errors import ModelError


class Factorisation(Protocol):
    """A factored symmetric positive definite matrix."""

    def solve(self, b: np.ndarray) -> np.ndarray:
        """Return ``A^-1 b`` for b of shape (n,) or (n, m)."""
        ...


Factorise = Callable[[sp.csc_matrix], Factorisation]


class _SuperLU:
    def __init__(self, matrix: sp.csc_matrix) -> None:
        self._lu = spla.splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})

    def solve(self, b: np.ndarray) -> np.ndarray:
        return np.asarray(self._lu.solve(np.ascontiguousarray(b)))


def splu_factorise(matrix: sp.csc_matrix) -> Factorisation:
    """Factor a symmetric positive definite matrix by SuperLU, best below some 10,000 rows."""
    return _SuperLU(sp.csc_matrix(matrix))


def factor_interior(matrix: sp.csc_matrix, factorise: Factorise) -> Factorisation:
    """Factor K of the interior of a body and check it on one solve: a mechanism or loose part shows here.

    Raises
    ------
    ModelError
        If the matrix is empty, or singular to working precision.
    """
    remedy = "Remedy: check the mesh for loose parts or hinges, and the interfaces"
    if matrix.shape[0] == 0:
        raise ModelError(
            "all nodes of the body belong to interfaces: nothing is left to deform. Remedy: refine the mesh"
        )
    try:
        factors = factorise(matrix)
    except RuntimeError as error:
        raise ModelError(f"the stiffness matrix of the interior is singular ({error}). {remedy}") from error
    probe = np.cos(np.arange(matrix.shape[0]))  # a fixed vector with a part along every mode
    force = matrix @ probe
    error_size = np.linalg.norm(factors.solve(force) - probe) / np.linalg.norm(probe)
    if not error_size < 1e-3:
        raise ModelError(
            "the stiffness matrix of the interior is singular or nearly so (a solve is wrong by "
            f"{error_size:.1e}). {remedy}"
        )
    return factors
