"""What stands in the place of the factors of a large stiffness: conjugate gradients with multigrid, and LOBPCG.

The fine level is smoothed by Chebyshev polynomials of its diagonal blocks. The coarse one, of displacements that are
linear in each cell, is factored: it has an eighth of the unknowns, and all that moves far, so that the number of
iterations depends neither on the size of the mesh nor on how slender the body is. A mesh of order 1 has no such level:
there PETSc aggregates nodes, with the rigid motions as near null space.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from kanefe.fe_model.model import Cells, rigid_motion
from kanefe.fe_model.progress import tell
from kanefe.reduction.block_lanczos import lowest_modes as lanczos_modes
from kanefe.storage.unfinished import keep, kept
from kanefe_fem._petsc import MumpsFactor, insufficient_support
from kanefe_fem.multigrid import _petsc, lobpcg
from kanefe_fem.multigrid.corners import corner_interpolation

GUARD = 4
"""Number of shapes beside the sought modes: with them the last of these converge as fast as the others."""


class Discretisation(NamedTuple):
    """The nodes and cells of a matrix.

    Attributes
    ----------
    nodes : ndarray, shape (n, 3)
    components : tuple of str
        Degrees of freedom of each node.
    cells : sequence of Cells
    """

    nodes: np.ndarray
    components: tuple[str, ...]
    cells: Sequence[Cells]


class CoarseSpace(NamedTuple):
    """Shapes that are linear between the corners of cells, and rigid motions, in the coordinates of a matrix.

    Attributes
    ----------
    motion : csr_matrix, shape (n, c)
    rigid : ndarray, shape (n, 3 or 6)
    """

    motion: sp.csr_matrix
    rigid: np.ndarray

    @property
    def is_coarser(self) -> bool:
        """Whether the mesh has nodes between its corners."""
        return bool(2 * self.motion.shape[1] < self.motion.shape[0])  # a quarter or an eighth


def coarse_space(mesh: Discretisation, motion: sp.csr_matrix) -> CoarseSpace:
    """Return the coarse space of coordinates that move the nodes by `motion` (N, n); its columns are orthonormal.

    Corners whose degrees of freedom are no coordinates, such as those that are held, are left out.
    """
    width = len(mesh.components)
    values, corners = corner_interpolation(mesh.cells, len(mesh.nodes))
    dofs = (width * corners[:, None] + np.arange(width)).ravel()
    alone = np.flatnonzero(np.diff(motion.tocsc().indptr) == 1)
    is_coordinate = np.zeros(motion.shape[0], dtype=bool)
    is_coordinate[np.unique(motion[:, alone].nonzero()[0])] = True
    free = np.flatnonzero(is_coordinate[dofs])
    across = motion.T.tocsr() @ sp.kron(values, sp.identity(width), format="csr")
    rigid = motion.T @ rigid_motion(mesh.nodes, mesh.nodes.mean(axis=0), mesh.components)
    return CoarseSpace(across[:, free].tocsr(), rigid[:, abs(rigid).max(axis=0) > 0.0])


class MultigridFactor:
    """Solutions and modes of a symmetric positive definite stiffness by multigrid.

    Parameters
    ----------
    matrix : sparse matrix, shape (n, n)
    mesh : Discretisation
    motion : csr_matrix, shape (N, n)
        Motion of the nodes from the coordinates of the matrix.

    Raises
    ------
    SingularStiffness
        If the body is not held.
    """

    def __init__(self, matrix: sp.spmatrix, mesh: Discretisation, motion: sp.csr_matrix) -> None:
        csr = matrix.T if matrix.format == "csc" else sp.csr_matrix(matrix)  # symmetric
        self.size = csr.shape[0]
        if not np.all(csr.diagonal() > 0.0):
            raise insufficient_support("a degree of freedom has no stiffness at all")
        self.coarse: MumpsFactor | None = None
        self.space = coarse_space(mesh, motion)
        width = len(mesh.components)
        if not self.space.is_coarser:
            self.hierarchy = _petsc.Hierarchy(_petsc.in_rows(csr, width))
            self.hierarchy.by_aggregation(self.space.rigid)
            return
        P = self.space.motion
        self.coarse_matrix = (P.T.tocsr() @ (csr @ P)).tocsr()
        self.hierarchy = _petsc.Hierarchy(
            _petsc.in_blocks(csr, width) if self.size % width == 0 else _petsc.in_rows(csr, 1)
        )
        self.coarse = MumpsFactor(self.coarse_matrix)
        self.hierarchy.on_coarse_level(_petsc.in_rows(P, 1), self.coarse.preconditioner)

    def solve(self, rhs: np.ndarray) -> np.ndarray:
        """Return A^-1 rhs for rhs of shape (n,) or (n, m), in the same shape."""
        rhs = np.asarray(rhs, dtype=float)
        return self.hierarchy.solve(rhs.reshape(self.size, -1)).reshape(rhs.shape)

    def lowest_modes(self, M: sp.spmatrix, count: int) -> tuple[np.ndarray, np.ndarray]:
        """Return w^2 and M-orthonormal shapes of the lowest modes, ascending; (count,) and (n, count)."""
        name = f"{count} normal modes of {self.size} by multigrid"
        found = kept(name)
        start = self._first_shapes(M, count) if found is None else found["shapes"]
        if found is not None:
            tell("the shapes of a run that was ended are taken up")
        progress: list[tuple[float, float]] = []

        def step_done(shapes: np.ndarray, residuals: np.ndarray, seconds: float) -> None:
            keep(name, shapes=shapes)
            tell_of_step(progress, residuals, seconds)

        def weighted(columns: np.ndarray) -> np.ndarray:
            product = np.empty(columns.shape, order="F")
            for column in range(columns.shape[1]):
                product[:, column] = M @ columns[:, column]
            return product

        return lobpcg.lowest_modes(
            self.hierarchy.times, weighted, self.hierarchy.precondition, start, count, step_done=step_done
        )

    def _first_shapes(self, M: sp.spmatrix, count: int) -> np.ndarray:
        """Return the modes of the coarse level, or random shapes where there is none."""
        wanted = min(count + GUARD, self.size // 3)
        if self.coarse is None or 3 * wanted > self.space.motion.shape[1]:
            # a fixed seed for the same modes in every run
            return np.random.default_rng(0).standard_normal((self.size, wanted))
        P = self.space.motion
        _, shapes = lanczos_modes((P.T.tocsr() @ (M @ P)).tocsr(), wanted, self.coarse.solve)
        return np.asarray(P @ shapes)


def tell_of_step(progress: list[tuple[float, float]], residuals: np.ndarray, seconds: float) -> None:
    """Tell how many modes are found, and the time left; note the time and the largest residual of this step."""
    progress.append((seconds, float(np.log(residuals.max() / lobpcg.TOLERANCE))))
    number = np.count_nonzero(residuals <= lobpcg.TOLERANCE)
    tell(f"{number} of {len(residuals)} found{time_left(progress)}", is_noted=False)


def time_left(progress: list[tuple[float, float]]) -> str:
    """Return the time left as text, as far as residuals fall as they fell, from times and logarithms of residuals."""
    (first, high), (last, low) = progress[max(0, len(progress) - 4)], progress[-1]
    if low >= high or low <= 0.0:
        return ""
    return f", about {low * (last - first) / (high - low):.2g} s left"
