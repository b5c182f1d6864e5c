"""How a stiffness is solved: by its factors or by multigrid, with time and memory of the choice told before."""

from __future__ import annotations

import time
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal, get_args

import numpy as np
import scipy.sparse as sp

from kanefe.errors import ModelError
from kanefe.fe_model.factorise import Factorise
from kanefe.fe_model.progress import tell
from kanefe_fem._petsc import Factor, TooCostly, factorise
from kanefe_fem.machine.factor_plan import Analysis
from kanefe_fem.machine.memory import SHARE, free_memory, rough_size
from kanefe_fem.multigrid.factor import Discretisation, MultigridFactor

Solver = Literal["auto", "direct", "multigrid"]

SHAPES = 44
"""Number of shapes for which times are compared: 12 of interfaces, 12 of inertia loads, 20 modes."""

PRODUCTS = 200
"""Products with K a shape that multigrid takes: 15 to 25 applications of 8 products each."""


def check_solver(solver: Any, reduction: Any) -> None:
    """Raise a ModelError if a solver is unknown, or is asked for a body that is not reduced."""
    if solver not in get_args(Solver):
        raise ModelError(f"solver={solver!r} is not known. Remedy: one of {', '.join(map(repr, get_args(Solver)))}")
    if reduction is None and solver == "multigrid":
        raise ModelError(
            "solver='multigrid' is for the shapes of a reduction, and reduction=None keeps all of K. Remedy: "
            "reduction=CraigBampton(modes=...), or leave solver= out"
        )


@dataclass(frozen=True)
class BodySolver:
    """The function that factors the matrices of a body: see `kanefe.fe_model.factorise.Factorise`.

    Attributes
    ----------
    mesh : Discretisation
    solver : "auto", "direct" or "multigrid"
        How K of the interior is solved; other matrices are factored. "auto": by its factors if these fit into the free
        memory, and take less time than multigrid for a usual number of shapes.
    """

    mesh: Discretisation
    solver: Solver = "auto"

    def __call__(self, matrix: sp.csc_matrix, /, *, definite: bool = True) -> Factor:
        """Return the factors of a matrix."""
        return factorise(matrix, definite=definite)

    def by_motion(self, motion: sp.csr_matrix) -> Factorise:
        """Return the function that factors, or not, a K whose coordinates move the nodes by `motion` (N, n)."""
        return self if self.solver == "direct" else partial(self._chosen, motion)

    def _chosen(self, motion: sp.csr_matrix, matrix: sp.csc_matrix, /, *, definite: bool = True) -> Factor:
        def accepts(analysis: Analysis, seconds: float) -> bool:
            free = free_memory()
            fits = free is None or analysis.in_memory <= SHARE * free
            return fits and seconds <= multigrid_seconds(matrix)

        if self.solver == "auto":
            try:
                return factorise(matrix, definite=definite, accepts=accepts)
            except TooCostly:
                pass
        size = matrix.shape[0]
        tell(
            f"{size} unknowns by multigrid: {1e-9 * multigrid_bytes(matrix):.2g} GB of memory, about "
            f"{multigrid_seconds(matrix):.2g} s for {SHAPES} shapes"
        )
        return MultigridFactor(matrix, self.mesh, motion)


def multigrid_seconds(matrix: sp.spmatrix) -> float:
    """Return about the time of multigrid for a usual number of shapes in s, from that of a product."""
    x = np.ones(matrix.shape[1])
    start = time.perf_counter()
    matrix @ x
    return (time.perf_counter() - start) * PRODUCTS * SHAPES


def multigrid_bytes(matrix: sp.spmatrix) -> float:
    """Return about the memory of multigrid: K in blocks, the factors of the coarse level, and the shapes of LOBPCG."""
    size = matrix.shape[0]
    return 9.0 * matrix.nnz + rough_size(size // 8) + 8.0 * size * 9 * SHAPES / 2
