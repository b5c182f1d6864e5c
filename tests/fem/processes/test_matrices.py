"""Matrices on a team: on its leader they are what sparse matrices of scipy are."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp

from kanefe.errors import ModelError
from kanefe_fem.multigrid.factor import Discretisation
from kanefe_fem.processes.matrices import SharedRows, TeamMatrix, Told
from kanefe_fem.processes.solvers import TeamSolver, checked_residual


class Rows(SharedRows):
    """Rows of two processes that are both here."""

    def __init__(self, matrix: sp.csr_matrix) -> None:
        order = np.random.default_rng(1).permutation(matrix.shape[0])
        super().__init__(None, 0, (order[:7], order[7:]))  # type: ignore[arg-type]
        object.__setattr__(self, "matrix", matrix)

    def times(self, columns: np.ndarray) -> np.ndarray:
        return self.matrix @ columns

    def diagonal(self) -> np.ndarray:
        return self.matrix.diagonal()

    def some_rows(self, wanted: np.ndarray) -> sp.csr_matrix:
        return self.matrix[wanted]


def matrix(size: int = 20) -> sp.csr_matrix:
    random = sp.random(size, size, 0.2, random_state=0, format="csr")
    return (random + random.T + 5.0 * sp.identity(size)).tocsr()


def motion(size: int = 20, count: int = 12) -> sp.csr_matrix:
    """Single nodes, then columns of several, as the ties of interfaces."""
    several = sp.random(size, 4, 0.3, random_state=2)
    return sp.hstack((sp.identity(size, format="csr")[:, : count - 4], several), format="csr")


@pytest.fixture
def both() -> tuple[TeamMatrix, sp.csr_matrix]:
    A, T = matrix(), motion()
    return TeamMatrix.of(Rows(A), Told()).projected(T), (T.T @ A @ T).tocsr()


def same(found: np.ndarray, expected: np.ndarray) -> None:
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-13 * np.abs(expected).max())


def test_products(both: tuple[TeamMatrix, sp.csr_matrix]) -> None:
    ours, theirs = both
    x = np.random.default_rng(0).standard_normal((12, 3))
    same(ours @ x, theirs @ x)
    same(ours @ x[:, 0], theirs @ x[:, 0])
    assert (ours @ x[:, :0]).shape == (12, 0)
    assert ours.shape == theirs.shape
    same(ours.T[2:5] @ x, theirs[2:5] @ x)


def test_parts(both: tuple[TeamMatrix, sp.csr_matrix]) -> None:
    ours, theirs = both
    rows, columns = np.array([9, 1, 3]), np.array([11, 0])
    same(ours[rows][:, columns].toarray(), theirs[rows][:, columns].toarray())
    same(ours[:5, :5].tocsr().toarray(), theirs[:5, :5].toarray())
    same(ours[columns][:, rows].tocoo().toarray(), theirs[columns][:, rows].toarray())
    assert set(ours[rows].indices) == set(theirs[rows].indices)
    same(ours.toarray(), theirs.toarray())
    same(ours.diagonal(), theirs.diagonal())


def test_arithmetic_of_matrices_is_refused(both: tuple[TeamMatrix, sp.csr_matrix]) -> None:
    ours, _ = both
    with pytest.raises(ModelError, match="Krylov"):
        ours - 2.0 * ours


def test_rows_of_processes() -> None:
    shared = Rows(matrix())
    columns = np.random.default_rng(0).standard_normal((20, 2))
    parts = shared.dealt(columns)
    assert [len(part) for part in parts] == [7, 13]
    assert np.array_equal(shared.joined(parts), columns)


def test_other_matrices_are_factored_here() -> None:
    A, b = matrix().tocsc(), np.ones(20)
    mesh = Discretisation(np.zeros((0, 3)), (), ())
    same(A @ TeamSolver(mesh, "auto")(A).solve(b), b)


def test_residuals_are_checked() -> None:
    assert checked_residual("normal mode", 1e-9) == 1e-9
    for residual in (1e-3, np.nan):
        with pytest.raises(ModelError, match="residual of a normal mode"):
            checked_residual("normal mode", residual)
