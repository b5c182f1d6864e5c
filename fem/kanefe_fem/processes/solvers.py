"""Solutions and modes of matrices on a team: by factors, or by multigrid, with the memory of the choice told before."""

from __future__ import annotations

import contextlib
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp

from kanefe.errors import ModelError, outside
from kanefe.fe_model.factorise import Factorisation, Factorise
from kanefe.fe_model.progress import tell
from kanefe.fe_model.residuals import LARGEST
from kanefe_fem._petsc import TOLD, TooCostly, insufficient_support
from kanefe_fem._petsc import factorise as factorise_alone
from kanefe_fem.machine.memory import SHARE, MemoryWarning
from kanefe_fem.multigrid.choice import Solver
from kanefe_fem.multigrid.factor import GUARD, CoarseSpace, Discretisation, coarse_space
from kanefe_fem.processes import _petsc as tasks
from kanefe_fem.processes.matrices import TeamMatrix


class TeamFactor:
    """The factors of a symmetric matrix on a team, by MUMPS.

    Parameters
    ----------
    matrix : TeamMatrix
    definite : bool
        Whether it has to be positive definite.
    declines : bool
        Whether to raise TooCostly instead of a warning.

    Raises
    ------
    SingularStiffness
        If a matrix that has to be positive definite is not.
    TooCostly
        If the factors do not fit into the free memory, and others are taken then.

    Warns
    -----
    MemoryWarning
        If they do not fit, and are tried.
    """

    def __init__(self, matrix: TeamMatrix, definite: bool, declines: bool = False) -> None:
        self.told = matrix.told
        self.shared = matrix.gathered()
        if self.shared.size > TOLD:
            found = self.shared.team.run(tasks.forecast, self.shared.number, definite)
            lacking = told_of_memory(self.shared.size, found)
            if lacking and declines:
                self.shared.team.run(tasks.drop, self.shared.number)
                raise TooCostly
            if lacking:
                warnings.warn(lacking, MemoryWarning, stacklevel=outside())
        if definite and not np.all(self.shared.diagonal() > 0.0):
            raise insufficient_support("a degree of freedom has no stiffness at all")
        self.number, self.told.megabytes = self.shared.team.run(tasks.factor, self.shared.number, definite)

    def solve(self, loads: np.ndarray) -> np.ndarray:
        """Return A^-1 b for b of shape (n,) or (n, m)."""
        columns = loads.reshape(len(loads), -1)
        parts, residual = self.shared.team.run(tasks.solved, self.number, own=self.shared.dealt(columns))
        self.told.statics = max(self.told.statics, checked_residual("static shape", residual))
        return self.shared.joined(parts).reshape(loads.shape)

    def lowest_modes(self, mass: TeamMatrix, count: int) -> tuple[np.ndarray, np.ndarray]:
        """Return w^2 and M-orthonormal shapes of the lowest modes by SLEPc, ascending; (count,) and (n, count)."""
        heavy = mass.gathered()
        squares, parts, residuals = self.shared.team.run(tasks.modes, self.number, heavy.number, count)
        self.shared.team.run(tasks.drop, heavy.number)
        self.told.modes = max(self.told.modes, checked_residual("normal mode", float(residuals.max(initial=0.0))))
        return squares, self.shared.joined(parts)


class TeamMultigrid:
    """Solutions and modes of a symmetric positive definite matrix on a team by multigrid.

    Parameters
    ----------
    matrix : TeamMatrix
    space : CoarseSpace
    block : int
        Number of degrees of freedom of a node.

    Raises
    ------
    SingularStiffness
        If the body is not held.
    """

    def __init__(self, matrix: TeamMatrix, space: CoarseSpace, block: int) -> None:
        self.told, self.space = matrix.told, space
        self.shared = matrix.gathered()
        team = self.shared.team
        if not np.all(self.shared.diagonal() > 0.0):
            raise insufficient_support("a degree of freedom has no stiffness at all")
        if not space.is_coarser:
            self.number = team.run(tasks.aggregated, self.shared.number, block, own=self.shared.dealt(space.rigid))
            return
        of_column = self.shared.owner[np.asarray(space.motion.argmax(axis=0)).ravel()]  # the corner itself
        self.columns = tuple(np.flatnonzero(of_column == rank) for rank in range(team.size))
        self.motion = self.shared.put(space.motion, self.columns)
        coarse = team.run(tasks.coarse, self.shared.number, self.motion)
        team.run(tasks.store_in_blocks, self.shared.number, block)
        held, self.told.megabytes = team.run(tasks.factor, coarse, True)
        self.number = team.run(tasks.multigrid, self.shared.number, self.motion, held)

    def solve(self, loads: np.ndarray) -> np.ndarray:
        """Return A^-1 b for b of shape (n,) or (n, m)."""
        columns = loads.reshape(len(loads), -1)
        parts, residual = self.shared.team.run(tasks.solved_by_multigrid, self.number, own=self.shared.dealt(columns))
        self.told.statics = max(self.told.statics, checked_residual("static shape", residual))
        return self.shared.joined(parts).reshape(loads.shape)

    def lowest_modes(self, mass: TeamMatrix, count: int) -> tuple[np.ndarray, np.ndarray]:
        """Return w^2 and M-orthonormal shapes of the lowest modes by LOBPCG, ascending; (count,) and (n, count)."""
        team, heavy = self.shared.team, mass.gathered()
        random = np.random.default_rng(0)  # a fixed seed for the same modes in every run
        if self.space.is_coarser:
            start = random.standard_normal((self.space.motion.shape[1], count + GUARD))
            own, motion = [start[one] for one in self.columns], self.motion
        else:
            own, motion = self.shared.dealt(random.standard_normal((self.shared.size, count + GUARD))), None
        found = team.run(tasks.modes_by_multigrid, self.number, motion, heavy.number, count, own=own)
        squares, parts, residuals = found
        team.run(tasks.drop, heavy.number)
        self.told.modes = max(self.told.modes, checked_residual("normal mode", float(residuals.max(initial=0.0))))
        return squares, self.shared.joined(parts)


def told_of_memory(size: int, found: Sequence[tasks.ProcessMemory]) -> str:
    """Tell what factors take on each process; return a warning that names the first machine they do not fit into.

    An empty text where they fit.
    """
    each = ", ".join(f"{1e-9 * one.needed:.2g}" for one in found)
    tell(f"{size} unknowns: {each} GB of memory on the {len(found)} processes")
    for host in dict.fromkeys(one.host for one in found):
        own = [one for one in found if one.host == host]
        needed, free = sum(one.needed for one in own), min((one.free for one in own if one.free), default=np.inf)
        if needed > SHARE * free:
            return (
                f"factoring the stiffness of {size} unknowns needs {1e-9 * needed:.3g} GB of memory on {host} for "
                f"{len(own)} processes, and {1e-9 * free:.3g} GB are free there: it may become very slow, or end them. "
                'Remedy: solver="multigrid", fewer processes on each machine, or more machines'
            )
    return ""


def checked_residual(what: str, residual: float) -> float:
    """Return a residual; raise a ModelError if it is too large."""
    if not residual <= LARGEST:
        raise ModelError(
            f"the residual of a {what} is {residual:.1e} of its load, above {LARGEST:.0e}: the stiffness is "
            "nearly singular. Remedy: check the mesh for parts that hang by an edge or a point, and for cells that are "
            "much stiffer than others"
        )
    return residual


@dataclass(frozen=True)
class TeamSolver:
    """The function that factors the matrices of a body where they are: see `BodySolver`.

    Attributes
    ----------
    mesh : Discretisation
    solver : "auto", "direct" or "multigrid"
    """

    mesh: Discretisation
    solver: Solver

    def __call__(self, matrix: Any, /, *, definite: bool = True) -> Factorisation:
        """Return the factors of a matrix, on the team or on the leader alone."""
        if isinstance(matrix, TeamMatrix):
            return TeamFactor(matrix, definite)
        return factorise_alone(matrix, definite=definite)

    def by_motion(self, motion: sp.csr_matrix) -> Factorise:
        """Return the function that factors, or not, a K whose coordinates move the nodes by `motion` (N, n)."""

        def chosen(matrix: Any, /, *, definite: bool = True) -> Factorisation:
            if not isinstance(matrix, TeamMatrix) or self.solver == "direct":
                return self(matrix, definite=definite)
            if self.solver == "auto":
                with contextlib.suppress(TooCostly):
                    return TeamFactor(matrix, definite, declines=True)
            tell(f"{matrix.shape[0]} unknowns by multigrid on {matrix.shared.team.size} processes")
            return TeamMultigrid(matrix, coarse_space(self.mesh, motion), len(self.mesh.components))

        return chosen
