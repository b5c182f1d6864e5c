"""The block Lanczos method against dense algebra and scipy's ARPACK."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg as spla

import kanefe as kf
from kanefe.fe_model.residuals import LARGEST
from kanefe.reduction.block_lanczos import TOLERANCE, lowest_modes


def plate(nx: int, ny: int) -> tuple[sp.csc_matrix, sp.csr_matrix]:
    """Return K and M of a membrane held at its rim: its modes come in pairs where nx = ny."""

    def line(n: int) -> tuple[sp.csr_matrix, sp.csr_matrix]:
        off = np.ones(n - 1)
        K = sp.diags([-off, 2.0 * np.ones(n), -off], [-1, 0, 1])
        M = sp.diags([off, 4.0 * np.ones(n), off], [-1, 0, 1]) / 6.0
        return K.tocsr(), M.tocsr()

    (Kx, Mx), (Ky, My) = line(nx), line(ny)
    return (sp.kron(Kx, My) + sp.kron(Mx, Ky)).tocsc(), sp.kron(Mx, My).tocsr()


class Counted:
    """Solves with the factors of K, and counts."""

    def __init__(self, K: sp.csc_matrix) -> None:
        self._factors = spla.splu(K)
        self.calls = self.sides = 0

    def __call__(self, b: np.ndarray) -> np.ndarray:
        assert b.ndim == 2
        self.calls, self.sides = self.calls + 1, self.sides + b.shape[1]
        return self._factors.solve(b)


@pytest.mark.parametrize("shape", [(24, 24), (31, 20)], ids=["double modes", "single modes"])
@pytest.mark.parametrize("count", [1, 5, 20, 60])
def test_modes_are_those_of_dense_algebra(shape: tuple[int, int], count: int) -> None:
    K, M = plate(*shape)
    squares, modes = lowest_modes(M, count, Counted(K))
    dense = scipy.linalg.eigh(K.toarray(), M.toarray(), eigvals_only=True, subset_by_index=(0, count - 1))
    # errors of eigenvalues are the squares of the residuals; what is left is round-off of the dense solution
    np.testing.assert_allclose(squares, dense, rtol=1e-11)
    np.testing.assert_allclose(modes.T @ (M @ modes), np.eye(count), atol=1e-11)
    residual = K @ modes - (M @ modes) * squares
    # TOLERANCE is in the norm of the inverse of M; M is well conditioned (27 at most)
    assert np.linalg.norm(residual, axis=0).max() < 30 * TOLERANCE * np.linalg.norm(K @ modes, axis=0).max()


def test_forces_of_modes_are_balanced_as_far_as_is_told() -> None:
    # modes of little mass beside others of much: what is left of these is small in the norm of M, but not in forces
    squares_of_all, masses = np.arange(1.0, 801.0), np.where(np.arange(800) < 8, 1.0, 1e8)
    K, M = sp.diags(masses * squares_of_all).tocsc(), sp.diags(masses).tocsr()
    squares, modes = lowest_modes(M, 8, Counted(K))
    asked = (M @ modes) * squares
    left = np.linalg.norm(K @ modes - asked, axis=0) / np.linalg.norm(asked, axis=0)
    assert left.max() < LARGEST / 10.0  # UNBALANCED, by the sizes of forces before the last product


def test_a_singular_mass_matrix() -> None:
    # every other point of a string has no mass: it follows its neighbours
    n, count = 801, 10
    K = sp.diags([-np.ones(n - 1), 2.0 * np.ones(n), -np.ones(n - 1)], [-1, 0, 1]).tocsc()
    M = sp.diags(np.arange(n) % 2.0).tocsr()
    squares, modes = lowest_modes(M, count, Counted(K))
    # masses 1 on a string of stiffness 1/2 between them, 401 spans: w = 2 sqrt(1/2) sin(k pi / (2 * 401))
    exact = 2.0 * np.sin(np.arange(1, count + 1) * np.pi / (2 * 401)) ** 2
    np.testing.assert_allclose(squares, exact, rtol=1e-10)
    between = modes[2:-1:2] - 0.5 * (modes[1:-2:2] + modes[3::2])
    assert abs(between).max() < 1e-9 * abs(modes).max()


def test_the_same_in_every_run() -> None:
    K, M = plate(25, 20)
    first, second = (lowest_modes(M, 6, Counted(K)) for _ in range(2))
    np.testing.assert_array_equal(first[1], second[1])


def test_sides_are_solved_for_together() -> None:
    K, M = plate(60, 40)
    solve = Counted(K)
    lowest_modes(M, 20, solve)
    assert solve.calls <= 20
    # ARPACK needs some 55 solves of one side each; a side costs a fifth in a block of eight
    assert solve.sides <= 8 * 20


def test_more_modes_than_there_is_mass() -> None:
    n = 600
    K = sp.diags([-np.ones(n - 1), 2.0 * np.ones(n), -np.ones(n - 1)], [-1, 0, 1]).tocsc()
    M = sp.diags((np.arange(n) < 3).astype(float)).tocsr()
    with pytest.raises(kf.ModelError, match=r"5 normal modes were not found .*every part of the body has mass"):
        lowest_modes(M, 5, Counted(K))
