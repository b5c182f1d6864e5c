"""Door to PETSc: starting MPI alone, and a sparse factorisation by MUMPS. The only file that imports petsc4py."""

from __future__ import annotations

import importlib
import importlib.util
import os
from typing import Any, Protocol

import numpy as np
import scipy.sparse as sp

from kanefe.errors import ModelError

SMALL = 10_000
"""Up to this many unknowns SuperLU is as fast as MUMPS, counting the import of petsc4py."""

CONDITION = 1e15
"""Least scaled condition number, estimated by one solve, from which a matrix counts as singular."""


class Factor(Protocol):
    """What `factorise` returns."""

    def solve(self, rhs: np.ndarray) -> np.ndarray:
        """Return A^-1 rhs for rhs of shape (n,) or (n, m)."""


def start_mpi() -> None:
    """Make the first import of MPI safe in a process without mpirun.

    OpenMPI else looks for a helper program on the PATH and aborts the interpreter when it is not there; and the wheel
    of dolfinx finds its MPI library only after its own package was imported.
    """
    os.environ.setdefault("OMPI_MCA_ess_singleton_isolated", "1")
    if importlib.util.find_spec("dolfinx_solver") is not None:
        importlib.import_module("dolfinx_solver")


def factorise(matrix: sp.spmatrix) -> Factor:
    """Factorise a symmetric positive definite matrix by the fastest solver for its size.

    Parameters
    ----------
    matrix : sparse matrix, shape (n, n)
        Symmetric positive definite.

    Returns
    -------
    Factor
        SuperLU up to `SMALL` unknowns or when petsc4py is not installed, else PETSc's Cholesky by MUMPS.

    Raises
    ------
    ModelError
        The matrix is singular or not positive definite: the structure is not held enough.

    Examples
    --------
    >>> import scipy.sparse as sp
    >>> factorise(sp.diags([2.0, 4.0]).tocsc()).solve(np.ones(2))
    array([0.5 , 0.25])
    """
    if matrix.shape[0] > SMALL and importlib.util.find_spec("petsc4py") is not None:
        return MumpsFactor(matrix)
    from kanefe.factorise import splu_factorise

    factor: Factor = splu_factorise(matrix)
    return factor


class MumpsFactor:
    """Cholesky factor ``A = L D L^T`` by MUMPS through PETSc.

    Parameters
    ----------
    matrix : sparse matrix, shape (n, n)
        Symmetric positive definite.
    """

    def __init__(self, matrix: sp.spmatrix) -> None:
        start_mpi()
        from petsc4py import PETSc

        self._petsc: Any = PETSc
        csr = sp.csr_matrix(matrix)
        csr.sort_indices()
        self.size = csr.shape[0]
        integer = PETSc.IntType
        arrays = (csr.indptr.astype(integer), csr.indices.astype(integer), csr.data.astype(PETSc.ScalarType))
        self._matrix = PETSc.Mat().createAIJ(csr.shape, csr=arrays, comm=PETSc.COMM_SELF)
        self._matrix.setOption(PETSc.Mat.Option.SYMMETRIC, True)
        self._pc = PETSc.PC().create(comm=PETSc.COMM_SELF)
        self._pc.setOperators(self._matrix)
        self._pc.setType(PETSc.PC.Type.CHOLESKY)
        try:
            self._pc.setFactorSolverType("mumps")
            self._pc.setFactorSetUpSolverType()
            self._factor = self._pc.getFactorMatrix()
            self._factor.setMumpsIcntl(13, 1)  # no parallel root: else the inertia below is not counted
            self._factor.setMumpsIcntl(24, 1)  # look for null pivots
            self._pc.setUp()
        except PETSc.Error as problem:
            raise _insufficient_support(f"MUMPS cannot factorise it ({problem})") from problem
        failure, null = self._factor.getMumpsInfog(1), self._factor.getMumpsInfog(28)
        negative = self._factor.getMumpsInfog(12)
        if failure < 0:
            raise _insufficient_support(f"MUMPS stopped with the error {failure}, {self._factor.getMumpsInfog(2)}")
        if null or negative:
            raise _insufficient_support(f"{null} pivots vanish and {negative} are negative")
        self._refuse_singular(csr)

    def solve(self, rhs: np.ndarray) -> np.ndarray:
        """Return A^-1 rhs for rhs of shape (n,) or (n, m), in the same shape."""
        rhs = np.asarray(rhs, dtype=float)
        if rhs.ndim == 1:
            return self._solve_columns(rhs[:, None])[:, 0]
        return self._solve_columns(rhs)

    def _solve_columns(self, rhs: np.ndarray) -> np.ndarray:
        petsc = self._petsc
        columns = np.array(rhs, order="F")
        solution = np.zeros_like(columns)
        if columns.shape[1] == 1:
            b = petsc.Vec().createWithArray(columns[:, 0], comm=petsc.COMM_SELF)
            x = petsc.Vec().createWithArray(solution[:, 0], comm=petsc.COMM_SELF)
            self._factor.solve(b, x)
            x.destroy()
            b.destroy()
            return solution
        shape = columns.shape
        dense_b = petsc.Mat().createDense(shape, array=columns, comm=petsc.COMM_SELF)
        dense_x = petsc.Mat().createDense(shape, array=solution, comm=petsc.COMM_SELF)
        dense_b.assemble()
        dense_x.assemble()
        self._factor.matSolve(dense_b, dense_x)
        result = np.array(dense_x.getDenseArray())
        dense_x.destroy()
        dense_b.destroy()
        return result

    def _refuse_singular(self, csr: sp.csr_matrix) -> None:
        """Estimate the condition of the scaled matrix by one solve: a lower bound, huge if a motion is free."""
        scale = np.sqrt(np.abs(csr.diagonal()))
        if not np.all(scale > 0.0):
            raise _insufficient_support("a degree of freedom has no stiffness at all")
        b = np.random.default_rng(0).standard_normal(self.size)
        growth = np.linalg.norm(scale * self.solve(scale * b)) / np.linalg.norm(b)
        if not growth < CONDITION / np.sqrt(self.size):
            raise _insufficient_support(f"its condition number is above {growth:.0e}")


def _insufficient_support(reason: str) -> ModelError:
    return ModelError(
        f"the stiffness matrix is singular: the structure is insufficiently supported ({reason}). Remedy: clamp an "
        "interface that holds all rigid motions, and check that the mesh has no part that hangs by an edge or a point"
    )
