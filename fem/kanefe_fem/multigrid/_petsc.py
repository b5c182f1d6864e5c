"""Interface to PETSc for multigrid: a matrix in blocks, a smoother, a coarse level, and conjugate gradients.

The same on one process and on several; arrays have the rows of this process.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from kanefe.errors import ModelError
from kanefe_fem._petsc import start_mpi

TOLERANCE = 1e-12
"""Residual of a solution relative to its load: shapes that depend on others differ from them by less than the part
(`kanefe.reduction.orthonormal.DEPENDENT`) from which they count as shapes of their own."""

ITERATIONS = 400
"""Number of iterations from which conjugate gradients give up; 15 to 40 are usual."""

SWEEPS = 3
"""Number of products with the matrix in the smoother, before and after the coarse level."""

_PREFIX = "kanefe_multigrid_"

_SMOOTHER = {
    "ksp_type": "chebyshev",
    "ksp_max_it": str(SWEEPS),
    "esteig_ksp_max_it": "20",
    # of the estimate of the largest eigenvalue: a tenth of it up to a tenth above it
    "ksp_chebyshev_esteig": "0,0.1,0,1.1",
}

_AGGREGATION = {"pc_gamg_threshold": "0.01", "mg_levels_ksp_max_it": str(SWEEPS), "mg_levels_pc_type": "pbjacobi"}


class Hierarchy:
    """A symmetric positive definite matrix with its preconditioner.

    Parameters
    ----------
    matrix : PETSc matrix
        In blocks of the components of a node, where it has them.
    """

    def __init__(self, matrix: Any) -> None:
        start_mpi()
        from petsc4py import PETSc

        self._petsc: Any = PETSc
        self.matrix = matrix
        self._ksp = PETSc.KSP().create(matrix.comm)
        self._ksp.setOperators(matrix)
        self._ksp.setType(PETSc.KSP.Type.CG)
        self._ksp.setNormType(PETSc.KSP.NormType.UNPRECONDITIONED)
        self._ksp.setTolerances(rtol=TOLERANCE, atol=0.0, max_it=ITERATIONS)
        self.pc = self._ksp.getPC()
        self.iterations = self.applications = 0

    def on_coarse_level(self, interpolation: Any, coarse: Any) -> None:
        """Let the preconditioner be a smoother and a coarse level, whose solver is a preconditioner of PETSc."""
        self.pc.setType("mg")
        self.pc.setMGLevels(2)
        self.pc.setMGInterpolation(1, interpolation)
        solver = self.pc.getMGCoarseSolve()
        solver.setType("preonly")
        solver.setPC(coarse)
        solver.setOperators(*coarse.getOperators())
        smoother = self.pc.getMGSmoother(1)
        smoother.setOptionsPrefix(_PREFIX)
        block = self.matrix.getBlockSize()
        with_options(self._petsc, {**_SMOOTHER, "pc_type": "pbjacobi" if block > 1 else "jacobi"}, smoother)
        self._ksp.setUp()

    def by_aggregation(self, rigid: np.ndarray) -> None:
        """Let the preconditioner be multigrid by aggregation, whose coarse spaces have given rigid motions."""
        aggregation(self._petsc, self.pc, self.matrix, rigid)
        self._ksp.setUp()

    def _columns(self, apply: Callable[[Any, Any], None], given: np.ndarray) -> np.ndarray:
        return by_columns(self._petsc, self.matrix.comm, apply, given)

    def times(self, columns: np.ndarray) -> np.ndarray:
        """Return the product with columns, shape (n, m)."""
        return self._columns(self.matrix.mult, columns)

    def precondition(self, columns: np.ndarray) -> np.ndarray:
        """Return the preconditioner's approximation of solutions, shape (n, m)."""
        self.applications += columns.shape[1]
        return self._columns(self.pc.apply, columns)

    def solve(self, loads: np.ndarray) -> np.ndarray:
        """Return solutions of loads, shape (n, m).

        Raises
        ------
        ModelError
            If conjugate gradients do not converge.
        """
        return self._columns(self._solved, loads)

    def _solved(self, b: Any, x: Any) -> None:
        self._ksp.solve(b, x)
        count = self._ksp.getIterationNumber()
        self.iterations = max(self.iterations, count)
        self.applications += count + 1
        if self._ksp.getConvergedReason() < 0:
            raise ModelError(
                f"multigrid: {count} iterations leave {self._ksp.getResidualNorm() / (b.norm() or 1.0):.1e} of a load "
                f'unbalanced. Remedy: solver="direct"; check the mesh for slivers and for materials whose stiffness '
                "differs by many orders"
            )


def by_columns(
    petsc: Any, comm: Any, apply: Callable[[Any, Any], None], given: np.ndarray, rows: int | None = None
) -> np.ndarray:
    """Return what a function of two vectors of PETSc makes of each of the columns (n, m), in the order of Fortran.

    `rows` is the number of those of the results on this process, by default that of the columns.
    """
    found = np.zeros((len(given) if rows is None else rows, given.shape[1]), order="F")
    for column in range(given.shape[1]):
        b = petsc.Vec().createWithArray(np.ascontiguousarray(given[:, column]), comm=comm)
        x = petsc.Vec().createWithArray(found[:, column], comm=comm)
        apply(b, x)
        x.destroy()
        b.destroy()
    return found


def aggregation(petsc: Any, pc: Any, matrix: Any, rigid: np.ndarray) -> None:
    """Let a preconditioner of a matrix be PETSc's multigrid by aggregation (GAMG), with rigid motions (n, m)."""
    vectors = [petsc.Vec().createWithArray(np.array(column), comm=matrix.comm) for column in rigid.T]
    for number, vector in enumerate(vectors):  # orthonormal over all processes
        for other in vectors[:number]:
            vector.axpy(-vector.dot(other), other)
        vector.normalize()
    matrix.setNearNullSpace(petsc.NullSpace().create(vectors=vectors, comm=matrix.comm))
    pc.setOperators(matrix)
    pc.setType("gamg")
    pc.setOptionsPrefix(_PREFIX)
    with_options(petsc, _AGGREGATION, pc)
    pc.setUp()


def with_options(petsc: Any, options: dict[str, str], thing: Any) -> None:
    """Give PETSc's object options that have no functions."""
    database = petsc.Options()
    for name, value in options.items():
        database[_PREFIX + name] = value
    thing.setFromOptions()
    for name in options:
        database.delValue(_PREFIX + name)


def in_blocks(csr: Any, block: int, comm: Any = None) -> Any:
    """Return PETSc's matrix of scipy's rows of this process in dense blocks; without a communicator on it alone."""
    start_mpi()
    from petsc4py import PETSc

    blocks = csr.tobsr((block, block))
    arrays = (blocks.indptr.astype(PETSc.IntType), blocks.indices.astype(PETSc.IntType), blocks.data)
    size = (csr.shape[0], PETSc.DETERMINE)
    return symmetric(PETSc, PETSc.Mat().createBAIJ((size, size), block, csr=arrays, comm=comm or PETSc.COMM_SELF))


def in_rows(csr: Any, block: int) -> Any:
    """Return PETSc's matrix on this process of scipy's, by rows."""
    start_mpi()
    from petsc4py import PETSc

    arrays = (csr.indptr.astype(PETSc.IntType), csr.indices.astype(PETSc.IntType), csr.data)
    made = PETSc.Mat().createAIJ(csr.shape, csr=arrays, comm=PETSc.COMM_SELF)
    if block > 1 and csr.shape[0] == csr.shape[1] and csr.shape[0] % block == 0:
        made.setBlockSize(block)
    return symmetric(PETSc, made)


def symmetric(petsc: Any, matrix: Any) -> Any:
    """Return a matrix that PETSc knows to be symmetric, if it is square."""
    if matrix.getSize()[0] == matrix.getSize()[1]:
        matrix.setOption(petsc.Mat.Option.SYMMETRIC, True)
    return matrix
