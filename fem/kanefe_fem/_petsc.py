"""Interface to PETSc: start of MPI without mpirun, sparse factorisation by MUMPS. The only file that uses petsc4py."""

from __future__ import annotations

import importlib
import importlib.util
import os
import shutil
import time
import weakref
from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import scipy.sparse as sp

from kanefe.errors import ModelError, SingularStiffness
from kanefe.storage import hdf5
from kanefe_fem.machine.factor_plan import Analysis, planned
from kanefe_fem.machine.memory import free_memory, rough_size

SMALL = 10_000
"""Number of unknowns up to which SuperLU is as fast as MUMPS, including the import of petsc4py."""

ROUGHLY = 0.5
"""Fraction of the free memory above which the size of a factor is not only estimated but computed by MUMPS."""

TOLD = 200_000
"""Number of unknowns from which time and memory are computed before in any case: a twentieth of the time."""

PIECE = 20_000
"""Number of rows of the piece of a matrix that is factored to know how fast this machine is."""

CONDITION = 1e15
"""Scaled condition number, estimated by one solve, above which a matrix is regarded as singular."""

AUTOMATIC, PORD, METIS = 7, 4, 5
"""Numbers of orderings of MUMPS. By itself it takes METIS where it has it, which needs 26 % fewer operations than PORD
in a cube of quadratic tetrahedra, and 22 % more in a bar of 1 x 0.1 x 0.05 m and in a sheet."""

PIVOTING_ROOM = 50
"""Memory for the pivots of an indefinite matrix that MUMPS may take beyond its estimate, in per cent."""


Accepts = Callable[[Analysis, float], bool]
"""Function of the analysis of a factorisation and of its time in s: whether it is worth it."""


class TooCostly(Exception):
    """A factorisation is not accepted before it begins; the message is for no user."""


class Factor(Protocol):
    """A factorised matrix."""

    def solve(self, rhs: np.ndarray) -> np.ndarray:
        """Return A^-1 rhs for rhs of shape (n,) or (n, m)."""


def start_mpi() -> None:
    """Prepare the first import of MPI in a process without mpirun.

    Without this, OpenMPI searches for a helper program on the PATH and aborts the interpreter if there is none. The
    wheel of dolfinx finds its MPI library only after its own package was imported. Its PETSc exposes its HDF5 to all
    libraries that are loaded later, with which an h5py of another version fails; so h5py is imported first.
    """
    os.environ.setdefault("OMPI_MCA_ess_singleton_isolated", "1")
    if importlib.util.find_spec("dolfinx_solver") is not None:
        hdf5.come_first()
        importlib.import_module("dolfinx_solver")


def factorise(matrix: sp.spmatrix, /, *, definite: bool = True, accepts: Accepts | None = None) -> Factor:
    """Factorise a symmetric matrix by the fastest solver for its size.

    Parameters
    ----------
    matrix : sparse matrix, shape (n, n)
    definite : bool
        Whether it has to be positive definite.
    accepts : callable, optional
        Is asked before a factorisation that takes long or much memory: see `MumpsFactor`.

    Returns
    -------
    Factor
        SuperLU up to `SMALL` unknowns or if petsc4py is not installed, otherwise MUMPS through PETSc.

    Raises
    ------
    ModelError
        If a matrix that has to be positive definite is not, because the structure is insufficiently supported, or if
        there is not enough memory.
    RuntimeError
        If an indefinite matrix is singular.

    Examples
    --------
    >>> import scipy.sparse as sp
    >>> factorise(sp.diags([2.0, 4.0]).tocsc()).solve(np.ones(2))
    array([0.5 , 0.25])
    """
    if matrix.shape[0] > SMALL and importlib.util.find_spec("petsc4py") is not None:
        return MumpsFactor(matrix, definite, accepts)
    from kanefe.fe_model.factorise import splu_factorise

    factor: Factor = splu_factorise(matrix, definite=definite)
    return factor


class MumpsFactor:
    """Factor ``A = L D L^T`` of a symmetric matrix by MUMPS through PETSc.

    Only the upper half of the matrix is stored. For a positive definite matrix MUMPS does not search for pivots, which
    is a fifth faster; it continues after a negative pivot, but counts them. For an indefinite matrix D also has blocks
    of two rows.

    Parameters
    ----------
    matrix : sparse matrix, shape (n, n)
        Symmetric.
    definite : bool
        Whether it has to be positive definite.
    accepts : callable, optional
        Is asked, once time and memory of a large factorisation are known, whether to begin.

    Raises
    ------
    ModelError
        If a matrix that has to be positive definite is not.
    TooCostly
        If it is not accepted.
    RuntimeError
        If an indefinite matrix is exactly singular. An almost singular one gives no error: check the solution.

    Warns
    -----
    MemoryWarning
        If the factorisation needs more memory than is free: see `kanefe_fem.machine.factor_plan`.
    """

    def __init__(self, matrix: sp.spmatrix, definite: bool = True, accepts: Accepts | None = None) -> None:
        start_mpi()
        from petsc4py import PETSc

        self._petsc: Any = PETSc
        csr = matrix.T if matrix.format == "csc" else sp.csr_matrix(matrix)  # symmetric
        csr.sort_indices()
        self.size, self.definite, self._ordering = csr.shape[0], definite, AUTOMATIC
        if definite and not np.all(csr.diagonal() > 0.0):
            raise insufficient_support("a degree of freedom has no stiffness at all")
        self._matrix = self._upper_half(csr)
        folder = self._planned(csr, accepts)
        try:
            self._pc, self._factor = self._set_up(folder=folder)
        except PETSc.Error as problem:
            raise self._singular(f"MUMPS cannot factorise it ({problem})") from problem
        refuse_failure(self._factor, self.size, definite)
        if definite:
            self._refuse_singular(csr)

    def _upper_half(self, csr: sp.csr_matrix) -> Any:
        """Return PETSc's matrix of the upper half of a symmetric matrix with sorted rows."""
        petsc = self._petsc
        size = csr.shape[0]
        rows = np.repeat(np.arange(size, dtype=csr.indices.dtype), np.diff(csr.indptr))
        upper = csr.indices >= rows
        starts = np.zeros(size + 1, dtype=petsc.IntType)
        np.cumsum(np.bincount(rows[upper], minlength=size), out=starts[1:])
        arrays = (starts, csr.indices[upper].astype(petsc.IntType), csr.data[upper].astype(petsc.ScalarType))
        matrix = petsc.Mat().createSBAIJ(csr.shape, 1, csr=arrays, comm=petsc.COMM_SELF)
        matrix.setOption(petsc.Mat.Option.SPD, self.definite)
        return matrix

    def _planned(self, csr: sp.csr_matrix, accepts: Accepts | None) -> Path | None:
        """Return the folder of the factors, None if they stay in memory; of large ones time and memory are told."""
        free = free_memory()
        if self.size <= TOLD and (free is None or rough_size(self.size) <= ROUGHLY * free):
            return None
        pc, factor = self._analysed()
        analysis = Analysis(
            unknowns=self.size,
            operations=factor.getMumpsRinfog(1),
            in_memory=1e6 * factor.getMumpsInfog(17),
            beside_disk=1e6 * factor.getMumpsInfog(27),
            factors=8.0 * _large(factor.getMumpsInfog(20)),
        )
        pc.destroy()
        rate = self._rate(csr)
        if accepts is not None and not accepts(analysis, analysis.operations / rate):
            self._matrix.destroy()
            raise TooCostly
        return planned(analysis, free, rate).folder

    def _analysed(self) -> tuple[Any, Any]:
        """Return a factor that MUMPS has only analysed, by the ordering that needs fewer operations."""
        found = self._set_up(megabytes=1)
        if found[1].getMumpsInfog(7) != METIS:
            return found
        self._ordering = PORD
        other = self._set_up(megabytes=1)
        if other[1].getMumpsRinfog(1) < found[1].getMumpsRinfog(1):
            found, other = other, found
        else:
            self._ordering = METIS
        other[0].destroy()
        return found

    def _rate(self, csr: sp.csr_matrix) -> float:
        """Return the operations per second by the clock in factoring a piece of the matrix."""
        size = min(PIECE, self.size)
        piece = self._upper_half(csr[:size, :size].sorted_indices())
        start = time.perf_counter()
        pc, factor = self._set_up(of=piece)
        seconds, operations = time.perf_counter() - start, factor.getMumpsRinfog(3)
        pc.destroy()
        piece.destroy()
        return float(max(operations, 1.0) / seconds)

    def _set_up(self, megabytes: int = 0, folder: Path | None = None, of: Any = None) -> tuple[Any, Any]:
        """Factorise; with one megabyte of memory, MUMPS stops after its analysis, which gives the memory it needs."""
        pc = self._petsc.PC().create(comm=self._petsc.COMM_SELF)
        pc.setOperators(self._matrix if of is None else of)
        factor = factor_by_mumps(pc, self.definite)
        factor.setMumpsIcntl(7, self._ordering)
        factor.setMumpsIcntl(23, megabytes)
        if folder is not None:
            os.environ["MUMPS_OOC_TMPDIR"] = str(folder)  # MUMPS reads it while it factors
            factor.setMumpsIcntl(22, 1)
            weakref.finalize(self, _drop, factor, pc, folder)
        pc.setUp()
        return pc, factor

    @property
    def preconditioner(self) -> Any:
        """PETSc's preconditioner that solves with the factors."""
        return self._pc

    def _singular(self, reason: str) -> Exception:
        """Return the error of a matrix that cannot be factored."""
        return _not_factored(reason, self.definite)

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
        """Raise an error if the condition number, estimated from below by one solve, is that of a free motion."""
        scale = np.sqrt(csr.diagonal())
        b = np.random.default_rng(0).standard_normal(self.size)
        growth = np.linalg.norm(scale * self.solve(scale * b)) / np.linalg.norm(b)
        if not growth < CONDITION / np.sqrt(self.size):
            raise self._singular(f"its condition number is above {growth:.0e}")


def factor_by_mumps(pc: Any, definite: bool) -> Any:
    """Let a preconditioner of PETSc, with its matrix, be Cholesky's factor by MUMPS; return the factor, still empty."""
    pc.setType("cholesky")
    pc.setFactorSolverType("mumps")
    pc.setFactorSetUpSolverType()
    factor = pc.getFactorMatrix()
    factor.setMumpsIcntl(13, 1)  # no parallel root, for which negative pivots are not counted
    if not definite:
        factor.setMumpsIcntl(14, PIVOTING_ROOM)
    return factor


def refuse_failure(factor: Any, size: int, definite: bool) -> None:
    """Raise an error if MUMPS lacked memory, or found a pivot that is zero or negative where it must not be."""
    failure, detail = factor.getMumpsInfog(1), factor.getMumpsInfog(2)
    if failure in (-9, -13, -19):
        raise ModelError(
            f"there is not enough memory to factor the stiffness of {size} unknowns: it takes "
            f"{factor.getMumpsInfog(17)} MB. Remedy: a coarser mesh where stresses do not matter, or a "
            "larger machine"
        )
    if failure in (-10, -40):
        raise _not_factored(f"pivot {detail} is zero", definite)
    if failure < 0:
        raise _not_factored(f"MUMPS stopped with the error {failure}, {detail}", definite)
    negative = factor.getMumpsInfog(12)
    if negative and definite:
        raise _not_factored(f"{negative} pivots are negative", definite)


def _not_factored(reason: str, definite: bool) -> Exception:
    return insufficient_support(reason) if definite else RuntimeError(reason)


def _drop(factor: Any, pc: Any, folder: Path) -> None:
    """Remove factors on the disk: MUMPS removes its files by itself, and fails without its folder."""
    factor.destroy()
    pc.destroy()
    shutil.rmtree(folder, ignore_errors=True)


def _large(count: int) -> float:
    """Return a count of MUMPS, which is given in millions, negative, where it is large."""
    return float(count) if count >= 0 else -1e6 * count


def insufficient_support(reason: str) -> SingularStiffness:
    """Return the error of a stiffness that is singular for a reason."""
    return SingularStiffness(
        f"the stiffness matrix is singular: the structure is insufficiently supported ({reason}). Remedy: clamp an "
        "interface that holds all rigid motions, and check that the mesh has no part that hangs by an edge or a point"
    )
