"""Interface to PETSc and SLEPc on several processes: matrices by rows, factors by MUMPS, modes by shift-invert.

All functions but `is_there` are tasks of a `Team`; matrices and factors are those of `Team.kept`, by their numbers, and
arrays have the rows of each process. The only file that uses slepc4py.
"""

from __future__ import annotations

import importlib.util
import socket
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp

from kanefe.errors import MissingDependency, ModelError
from kanefe_fem._petsc import factor_by_mumps, insufficient_support, refuse_failure
from kanefe_fem.machine.memory import free_memory
from kanefe_fem.multigrid import lobpcg
from kanefe_fem.multigrid._petsc import Hierarchy, by_columns, in_blocks
from kanefe_fem.multigrid.factor import tell_of_step
from kanefe_fem.processes.team import Team

TOLERANCE = 1e-12
"""Residual of a mode that SLEPc is asked for, relative to the product of its eigenvalue and its shape."""

RESTARTS = 200
"""Number of restarts of the Krylov-Schur method from which it gives up."""

Rows = Sequence[np.ndarray]
"""An array of each process, on the leader."""


class _Factor(NamedTuple):
    """A factored matrix: itself, PETSc's solver that owns the factor, and the factor."""

    matrix: Any
    ksp: Any
    factor: Any

    def destroy(self) -> None:
        """Free the memory."""
        self.ksp.destroy()
        self.matrix.destroy()


class ProcessMemory(NamedTuple):
    """What a factorisation takes on a process, and the free memory of its machine, bytes; None if unknown."""

    host: str
    needed: float
    free: float | None


def is_there() -> bool:
    """Return whether PETSc and SLEPc are installed."""
    return all(importlib.util.find_spec(name) is not None for name in ("petsc4py", "slepc4py"))


def sizes(team: Team, own: None, matrix: int) -> list[int]:
    """Return the number of rows of each process."""
    return [int(size) for size in team.comm.allgather(team.kept[matrix].getLocalSize()[0])]


def put(team: Team, own: Sequence[Rows] | None, columns: Sequence[int], like: int) -> int:
    """Keep a matrix that the leader has as rows of each process (starts, columns, values).

    Its rows are distributed as those of the matrix `like`, and its columns by their number on each process.
    """
    petsc = _petsc()
    starts, places, values = (team.deal(parts) for parts in (own or (None, None, None)))
    rows = team.kept[like].getLocalSize()[0]
    csr = (starts.astype(petsc.IntType), places.astype(petsc.IntType), values)
    size = ((rows, petsc.DETERMINE), (columns[team.rank], sum(columns)))
    return team.keep(petsc.Mat().createAIJ(size, csr=csr, comm=team.comm))


def projected(team: Team, own: None, matrix: int, motion: int) -> int:
    """Keep ``P^T A P`` of a symmetric A; P is not needed any more."""
    found = coarse(team, own, matrix, motion)
    team.kept.pop(motion).destroy()
    return found


def times(team: Team, own: Rows | None, matrix: int) -> list[np.ndarray]:
    """Return the products of a matrix with columns, by rows of each process."""
    return team.collect(_times(team.kept[matrix], team.deal(own)))


def absolute(team: Team, own: None, matrix: int) -> int:
    """Keep the matrix of the absolute values."""
    starts, places, values = team.kept[matrix].getValuesCSR()
    size = team.kept[matrix].getSizes()
    return team.keep(_petsc().Mat().createAIJ(size, csr=(starts, places, abs(values)), comm=team.comm))


def some_rows(team: Team, own: Rows | None, matrix: int) -> tuple[Rows, Rows, Rows]:
    """Return some rows of each process, by their own numbers there: numbers of entries, columns, values."""
    wanted = team.deal(own)
    first, _ = team.kept[matrix].getOwnershipRange()
    rows = [team.kept[matrix].getRow(first + int(row)) for row in wanted]
    none: list[Any] = [np.zeros(0)]
    counts = np.array([len(places) for places, _ in rows], dtype=np.int64)
    places = np.concatenate([np.zeros(0, dtype=np.int64), *(one for one, _ in rows)])
    return team.collect(counts), team.collect(places), team.collect(np.concatenate(none + [one for _, one in rows]))


def diagonal(team: Team, own: None, matrix: int) -> list[np.ndarray]:
    """Return the diagonal."""
    return team.collect(np.array(team.kept[matrix].getDiagonal().array))


def drop(team: Team, own: None, number: int) -> None:
    """Forget a matrix."""
    team.kept.pop(number).destroy()


def forecast(team: Team, own: None, matrix: int, definite: bool) -> list[ProcessMemory]:
    """Return what a factorisation will take on each process, by MUMPS's analysis."""
    ksp, made = _ksp_by_mumps(team.kept[matrix], definite)
    made.setMumpsIcntl(23, 1)  # with one megabyte of memory it stops after its analysis
    ksp.setUp()
    needed = 1e6 * made.getMumpsInfo(15)
    ksp.destroy()
    return list(team.comm.allgather(ProcessMemory(socket.gethostname(), needed, free_memory())))


def _ksp_by_mumps(A: Any, definite: bool) -> tuple[Any, Any]:
    """Return PETSc's solver of a symmetric matrix by its factors, and these, still empty."""
    petsc = _petsc()
    A.setOption(petsc.Mat.Option.SYMMETRIC, True)
    A.setOption(petsc.Mat.Option.SPD, definite)
    ksp = petsc.KSP().create(A.comm)
    ksp.setOperators(A)
    ksp.setType(petsc.KSP.Type.PREONLY)
    return ksp, factor_by_mumps(ksp.getPC(), definite)


def factor(team: Team, own: None, matrix: int, definite: bool) -> tuple[int, list[int]]:
    """Factor a symmetric matrix, and keep it with the factor; return the memory of each process in MB.

    Raises
    ------
    SingularStiffness, ModelError
        Those of `kanefe_fem._petsc.MumpsFactor`.
    """
    petsc = _petsc()
    A = team.kept[matrix]
    ksp, made = _ksp_by_mumps(A, definite)
    try:
        ksp.setUp()
    except petsc.Error as problem:
        raise insufficient_support(f"MUMPS cannot factorise it ({problem})") from problem
    refuse_failure(made, A.getSize()[0], definite)
    ksp.getPC().setReusePreconditioner(True)  # SLEPc's shift is zero: it takes this factor
    megabytes = team.comm.allgather(int(made.getMumpsInfo(16)))
    return team.keep(_Factor(A, ksp, made)), megabytes


def solved(team: Team, own: Rows | None, number: int) -> tuple[list[np.ndarray], float]:
    """Return solutions by rows of each process, and the largest residual relative to its right-hand side."""
    held: _Factor = team.kept[number]
    loads = team.deal(own)
    b, x = (_dense(held.matrix, part) for part in (loads, np.zeros_like(loads)))
    held.factor.matSolve(b, x)
    found = np.array(x.getDenseArray())
    left = _times(held.matrix, found) - loads
    squares = team.comm.allreduce(np.stack([(part**2).sum(axis=0) for part in (left, loads)]))
    for one in (b, x):
        one.destroy()
    return team.collect(found), float(np.sqrt(squares[0] / np.maximum(squares[1], 1e-300)).max(initial=0.0))


def coarse(team: Team, own: None, matrix: int, motion: int) -> int:
    """Keep ``P^T A P`` of a symmetric A, beside P."""
    product = team.kept[matrix].PtAP(team.kept[motion])
    found = product.copy()  # without what the product keeps to be made again, which is as large
    product.destroy()
    return team.keep(found)


def store_in_blocks(team: Team, own: None, matrix: int, block: int) -> None:
    """Store a matrix in dense blocks from now on, where its rows beside each other are those of a node."""
    A = team.kept[matrix]
    starts, places, values = A.getValuesCSR()
    csr = sp.csr_matrix((values, places, starts), (len(starts) - 1, A.getSize()[1]))
    if all(team.comm.allgather(csr.shape[0] % block == 0)):
        A.destroy()  # before another copy is made
        team.kept[matrix] = in_blocks(csr, block, team.comm)


def multigrid(team: Team, own: None, matrix: int, motion: int, coarse_factor: int) -> int:
    """Keep the multigrid of a matrix with a factored coarse level."""
    held: _Factor = team.kept[coarse_factor]
    hierarchy = Hierarchy(team.kept[matrix])
    hierarchy.on_coarse_level(team.kept[motion], held.ksp.getPC())
    return team.keep(hierarchy)


def aggregated(team: Team, own: Rows | None, matrix: int, block: int) -> int:
    """Keep the multigrid by aggregation of a matrix, with the rows of its rigid motions."""
    A = team.kept[matrix]
    if all(team.comm.allgather(A.getLocalSize()[0] % block == 0)):
        A.setBlockSize(block)
    A.setOption(_petsc().Mat.Option.SYMMETRIC, True)
    hierarchy = Hierarchy(A)
    hierarchy.by_aggregation(team.deal(own))
    return team.keep(hierarchy)


def solved_by_multigrid(team: Team, own: Rows | None, number: int) -> tuple[list[np.ndarray], float]:
    """Return what `solved` returns."""
    hierarchy: Hierarchy = team.kept[number]
    loads = team.deal(own)
    found = hierarchy.solve(loads)
    left = hierarchy.times(found) - loads
    squares = team.comm.allreduce(np.stack([(part**2).sum(axis=0) for part in (left, loads)]))
    return team.collect(found), float(np.sqrt(squares[0] / np.maximum(squares[1], 1e-300)).max(initial=0.0))


def modes_by_multigrid(
    team: Team, own: Rows | None, number: int, motion: int | None, mass: int, count: int
) -> tuple[np.ndarray, list[np.ndarray], np.ndarray]:
    """Return what `modes` returns, from shapes to start with, `own`: of the coarse level, if there is a motion."""
    hierarchy: Hierarchy = team.kept[number]
    start, M = team.deal(own), team.kept[mass]
    if motion is not None:
        start = _products(team.kept[motion], start)
    progress: list[tuple[float, float]] = []

    def step_done(shapes: np.ndarray, residuals: np.ndarray, seconds: float) -> None:
        tell_of_step(progress, residuals, seconds)

    squares, shapes = lobpcg.lowest_modes(
        hierarchy.times,
        lambda columns: _products(M, columns),
        hierarchy.precondition,
        start,
        count,
        together=team.comm.allreduce,
        step_done=step_done,
    )
    pulled = hierarchy.times(shapes)
    left = pulled - squares * _products(M, shapes)
    sums = team.comm.allreduce(np.stack([np.einsum("ij,ij->j", part, part) for part in (left, pulled)]))
    return squares, team.collect(shapes), np.sqrt(sums[0] / sums[1])


def _products(matrix: Any, columns: np.ndarray) -> np.ndarray:
    """Return the products of a matrix with columns, one after the other."""
    return by_columns(_petsc(), matrix.comm, matrix.mult, columns, matrix.getLocalSize()[0])


def modes(team: Team, own: None, number: int, mass: int, count: int) -> tuple[np.ndarray, list[np.ndarray], np.ndarray]:
    """Return w^2 of the lowest modes of a factored K and M, M-orthonormal shapes by rows, and their residuals.

    The Krylov-Schur method (Stewart 2002, "A Krylov-Schur algorithm for large eigenproblems") on ``K^-1 M``. The
    residual is ``|K x - w^2 M x| / |K x|``.
    """
    from slepc4py import SLEPc

    held: _Factor = team.kept[number]
    eps = SLEPc.EPS().create(team.comm)
    eps.setOperators(held.matrix, team.kept[mass])
    eps.setProblemType(SLEPc.EPS.ProblemType.GHEP)
    eps.setDimensions(count)
    eps.setWhichEigenpairs(SLEPc.EPS.Which.TARGET_MAGNITUDE)
    eps.setTarget(0.0)
    eps.setTolerances(TOLERANCE, RESTARTS)
    st = eps.getST()
    st.setType(SLEPc.ST.Type.SINVERT)
    st.setKSP(held.ksp)
    eps.solve()
    if eps.getConverged() < count:
        raise ModelError(
            f"{count} normal modes were asked, and SLEPc found {eps.getConverged()} after {eps.getIterationNumber()} "
            "restarts. Remedy: ask for fewer modes, and check that every part of the body has mass and is held"
        )
    x = held.matrix.createVecRight()
    shapes = np.zeros((x.getLocalSize(), count), order="F")
    squares = np.zeros(count)
    for column in range(count):
        squares[column] = eps.getEigenpair(column, x).real
        shapes[:, column] = x.array
    eps.destroy()
    order = np.argsort(squares)
    squares, shapes = squares[order], shapes[:, order]
    pulled, heavy = _times(held.matrix, shapes), _times(team.kept[mass], shapes)
    parts = ((pulled - squares * heavy) ** 2, pulled**2, shapes * heavy)
    sums = team.comm.allreduce(np.stack([part.sum(axis=0) for part in parts]))
    return squares, team.collect(shapes / np.sqrt(sums[2])), np.sqrt(sums[0] / sums[1])


def _times(matrix: Any, columns: np.ndarray) -> np.ndarray:
    """Return the own rows of the product of a matrix with columns."""
    given = _dense(matrix, columns)
    product = matrix.matMult(given)
    found = np.array(product.getDenseArray())
    for one in (given, product):
        one.destroy()
    return found


def _dense(matrix: Any, columns: np.ndarray) -> Any:
    """Return PETSc's matrix of columns whose rows are distributed as those of a square matrix."""
    petsc = _petsc()
    size = ((columns.shape[0], matrix.getSize()[1]), (petsc.DECIDE, columns.shape[1]))
    made = petsc.Mat().createDense(size, array=np.array(columns, order="F"), comm=matrix.comm)
    made.assemble()
    return made


def _petsc() -> Any:
    try:
        from petsc4py import PETSc
    except ImportError as problem:
        remedy = "sudo apt-get install python3-petsc4py python3-slepc4py, or pip install 'kanefe[fenicsx]'"
        raise MissingDependency("petsc4py", "solid_body(comm=...)", remedy) from problem
    return PETSc
