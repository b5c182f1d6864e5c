"""Sparse matrices that live on a team of processes, for the code that reduces a body on its leader.

The leader has vectors of all rows, and the matrices only as operators ``L^T A R``: A is assembled by all processes,
each with its own rows, and L and R are thin sparse matrices of the leader, such as the ties of interfaces. A is the
same for any number of processes, but for the order of its rows, which `TeamMatrix` hides.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, NoReturn

import numpy as np
import scipy.sparse as sp

from kanefe.errors import ModelError
from kanefe_fem._petsc import insufficient_support
from kanefe_fem.processes import _petsc as tasks
from kanefe_fem.processes.team import Team


@dataclass(eq=False)
class Told:
    """What a reduction on several processes tells of itself.

    Attributes
    ----------
    statics, modes : float
        Largest residual of the static shapes, ``|K u - f| / |f|``, and of the normal modes,
        ``|K x - w^2 M x| / |K x|``.
    megabytes : list of int
        Memory of the factor on each process, MB.
    """

    statics: float = 0.0
    modes: float = 0.0
    megabytes: list[int] = field(default_factory=list)


@dataclass(frozen=True, eq=False)
class SharedRows:
    """A symmetric matrix on a team.

    Attributes
    ----------
    team : Team
    number : int
        Its number in `Team.kept`.
    rows : tuple of ndarray of int
        The numbers, for the leader, of the rows of each process.
    """

    team: Team
    number: int
    rows: tuple[np.ndarray, ...]

    @property
    def size(self) -> int:
        """Number of rows."""
        return sum(map(len, self.rows))

    @property
    def owner(self) -> np.ndarray:
        """The process of each row, shape (n,)."""
        found = np.empty(self.size, dtype=int)
        for rank, rows in enumerate(self.rows):
            found[rows] = rank
        return found

    def dealt(self, columns: np.ndarray) -> list[np.ndarray]:
        """Return the rows of each process, of an array with all rows."""
        return [columns[rows] for rows in self.rows]

    def joined(self, parts: list[np.ndarray]) -> np.ndarray:
        """Return the array with all rows, of the rows of each process."""
        whole = np.empty((self.size, *parts[0].shape[1:]))
        for rows, part in zip(self.rows, parts, strict=True):
            whole[rows] = part
        return whole

    def times(self, columns: np.ndarray) -> np.ndarray:
        """Return the product with columns, shape (n, m)."""
        return self.joined(self.team.run(tasks.times, self.number, own=self.dealt(columns)))

    def diagonal(self) -> np.ndarray:
        """Return the diagonal, shape (n,)."""
        return self.joined(self.team.run(tasks.diagonal, self.number))

    def put(self, matrix: sp.csr_matrix, columns: tuple[np.ndarray, ...]) -> int:
        """Put a matrix of the leader with the same rows on the team; its columns are those of each process."""
        place = np.empty(matrix.shape[1], dtype=np.int64)
        place[np.concatenate(columns)] = np.arange(matrix.shape[1])
        parts = [matrix[rows] for rows in self.rows]
        own = (
            [part.indptr.astype(np.int64) for part in parts],
            [place[part.indices] for part in parts],
            [part.data.astype(float) for part in parts],
        )
        return int(self.team.run(tasks.put, [len(one) for one in columns], self.number, own=own))

    def some_rows(self, wanted: np.ndarray) -> sp.csr_matrix:
        """Return some rows, shape (wanted, n)."""
        owner, place = self.owner, np.empty(self.size, dtype=int)
        for rows in self.rows:
            place[rows] = np.arange(len(rows))
        order = np.argsort(owner[wanted], kind="stable")
        asked = [place[wanted[owner[wanted] == rank]] for rank in range(len(self.rows))]
        found = self.team.run(tasks.some_rows, self.number, own=asked)
        counts, places, values = (np.concatenate(parts) for parts in found)
        starts = np.concatenate(([0], np.cumsum(counts)))
        in_order = sp.csr_matrix((values, np.concatenate(self.rows)[places], starts), (len(wanted), self.size))
        return in_order[np.argsort(order)]


@dataclass(frozen=True, eq=False)
class TeamMatrix:
    """The matrix ``L^T A R`` on the leader: what the reduction of a body asks of a sparse matrix.

    Attributes
    ----------
    shared : SharedRows
        A, shape (N, N).
    left, right : csc_matrix, shapes (N, n) and (N, m)
    told : Told
    """

    shared: SharedRows
    left: sp.csc_matrix
    right: sp.csc_matrix
    told: Told

    @classmethod
    def of(cls, shared: SharedRows, told: Told) -> TeamMatrix:
        """Return the whole of a matrix."""
        whole = sp.identity(shared.size, format="csc")
        return cls(shared, whole, whole, told)

    def like(self, matrix: sp.csr_matrix) -> TeamMatrix:
        """Return a symmetric matrix of the leader on the team, with its rows where those of this one are."""
        number = self.shared.put(matrix, self.shared.rows)
        return TeamMatrix.of(replace(self.shared, number=number), self.told)

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of rows and columns."""
        return self.left.shape[1], self.right.shape[1]

    @property
    def T(self) -> TeamMatrix:  # as of other matrices
        """The transpose."""
        return replace(self, left=self.right, right=self.left)

    def about(self) -> dict[str, Any]:
        """Return what a body tells of its processes, json-able."""
        return {
            "count": self.shared.team.size,
            "residuals": {"statics": self.told.statics, "modes": self.told.modes},
            "factor_megabytes": self.told.megabytes,
        }

    def projected(self, motion: sp.spmatrix) -> TeamMatrix:
        """Return ``motion^T A motion``."""
        motion = sp.csc_matrix(motion)
        return replace(self, left=(self.left @ motion).tocsc(), right=(self.right @ motion).tocsc())

    def __matmul__(self, columns: np.ndarray) -> np.ndarray:
        """Return the product with a vector (m,) or columns (m, k)."""
        given = np.asarray(columns, dtype=float)
        product = self.shared.times(self.right @ given.reshape(len(given), -1))
        return np.asarray(self.left.T @ product).reshape(self.shape[0], *given.shape[1:])

    def __getitem__(self, chosen: Any) -> TeamMatrix:
        """Return some rows, or rows and columns."""
        rows, columns = chosen if isinstance(chosen, tuple) else (chosen, slice(None))
        return replace(self, left=self.left[:, rows], right=self.right[:, columns])

    def __abs__(self) -> TeamMatrix:
        """Return ``|L|^T |A| |R|``, of which no entry is below the absolute value of that of this matrix."""
        number = self.shared.team.run(tasks.absolute, self.shared.number)
        return replace(self, shared=replace(self.shared, number=number), left=abs(self.left), right=abs(self.right))

    def tocsr(self) -> sp.csr_matrix:
        """Return the entries, of a matrix with few rows or columns."""
        if self.left.getnnz() > self.right.getnnz():
            return self.T.tocsr().T.tocsr()
        across = self.left.tocsr()
        rows = np.flatnonzero(np.diff(across.indptr))
        return (across[rows].T @ self.shared.some_rows(rows) @ self.right).tocsr()

    def tocsc(self) -> TeamMatrix:
        """Return the matrix itself, which is factored as it is."""
        return self

    def tocoo(self) -> sp.coo_matrix:
        """Return the entries, of a matrix with few rows or columns."""
        return self.tocsr().tocoo()

    def toarray(self) -> np.ndarray:
        """Return the dense matrix."""
        if self.shape[1] <= self.shape[0]:
            return self @ np.eye(self.shape[1])
        return self.T.toarray().T

    @property
    def indices(self) -> np.ndarray:
        """The columns of the entries of few rows."""
        return np.asarray(self.tocsr().indices)

    def diagonal(self) -> np.ndarray:
        """Return the diagonal of a square matrix, shape (n,)."""
        found = (self.left.multiply(self.right)).T @ self.shared.diagonal()
        several = np.flatnonzero(np.maximum(np.diff(self.left.indptr), np.diff(self.right.indptr)) > 1)
        if len(several):
            left, right = self.left[:, several].tocsr(), self.right[:, several].tocsr()
            rows = np.flatnonzero(np.diff(left.indptr))
            pulled = self.shared.some_rows(rows) @ right
            found[several] = np.asarray(left[rows].multiply(pulled).sum(axis=0)).ravel()
        return np.asarray(found)

    def _refuse(self, *_: Any) -> NoReturn:
        raise ModelError(
            "this reduction combines stiffness and mass into a new matrix, such as Krylov with a frequency above zero, "
            "which is not possible on several processes. Remedy: CraigBampton, or one process"
        )

    __add__ = __sub__ = __mul__ = __rmul__ = _refuse

    def gathered(self) -> SharedRows:
        """Return a symmetric matrix by rows on the team: each where the first row of A is that it moves."""
        A = self.shared
        if np.any(np.diff(self.right.indptr) == 0):
            raise insufficient_support("a coordinate moves no node")
        of_column = A.owner[self.right.sorted_indices().indices[self.right.indptr[:-1]]]
        columns = tuple(np.flatnonzero(of_column == rank) for rank in range(len(A.rows)))
        motion = A.put(self.right.tocsr(), columns)
        return SharedRows(A.team, A.team.run(tasks.projected, A.number, motion), columns)
