"""Systems in an envelope: solutions, pivots and what is left out are those of dense algebra."""

from __future__ import annotations

import numpy as np
import pytest

from kanefe.kernels.algebra import pivoted
from kanefe.kernels.algebra.envelope import Envelope, factor_envelope, solve_envelope

TOLERANCE = 1e-10


def weakest_of(system: Envelope, tolerance: float, begin: int, end: int) -> float:
    """Factor a system; return its least pivot of the largest."""
    least, largest = factor_envelope(system, tolerance, begin, end)
    return least / largest


def envelope(A: np.ndarray, firsts: list[int], blocks: list[int], scale: np.ndarray) -> Envelope:
    """Return a system whose row a begins at ``firsts[a]`` and is of a block that ends at ``blocks[a]``."""
    m = len(A)
    ends = np.cumsum([0, *(a - first + 1 for a, first in enumerate(firsts))])
    entries = np.concatenate([A[a, first : a + 1] for a, first in enumerate(firsts)])
    spare = [np.full(m, np.nan, dtype=A.dtype) for _ in range(4)]
    order = np.arange(m)
    factors = np.full(len(entries), np.nan, dtype=A.dtype)
    return Envelope(ends, np.array(blocks), order, order, entries, factors, scale, *spare)


def chained(rng: np.random.Generator, count: int, width: int, loss: int) -> tuple[np.ndarray, list[int], list[int]]:
    """Return a chain of blocks, each in common with some before it, and its firsts and blocks."""
    sizes = rng.integers(1, 6, count)
    starts = np.concatenate(([0], np.cumsum(sizes))).tolist()
    A = np.zeros((starts[-1], starts[-1]))
    for b in range(count):
        own = slice(starts[max(0, b - width)], starts[b + 1])
        n = own.stop - own.start
        B = rng.standard_normal((n, max(1, n - loss)))
        A[own, own] += B @ B.T
    firsts = [starts[max(0, b - width)] for b in range(count) for _ in range(sizes[b])]
    return A, firsts, [starts[b + 1] for b in range(count) for _ in range(sizes[b])]


@pytest.mark.parametrize("seed", range(60))
def test_consistent_systems_are_solved(seed: int) -> None:
    rng = np.random.default_rng(seed)
    A, firsts, blocks = chained(rng, int(rng.integers(1, 7)), int(rng.integers(0, 3)), seed % 2)
    m = len(A)
    scale = 1.0 / np.sqrt(np.diag(A))
    scale[rng.random(m) < 0.15] = 0.0
    live = scale > 0.0
    system = envelope(A, firsts, blocks, scale)
    weakest = weakest_of(system, TOLERANCE, 0, m)
    right = np.where(live[:, None], A[:, live] @ rng.standard_normal((int(live.sum()), 2)), np.nan)
    x = np.full((m, 2), np.nan)
    solve_envelope(system, right, 0, m, x)
    assert not x[~live].any()
    # round-off over the weakest pivot; those that are dependent have none
    np.testing.assert_allclose(
        A[np.ix_(live, live)] @ x[live], right[live], rtol=0, atol=1e-13 * m / max(weakest, 1e-6)
    )


def test_a_full_system_has_the_pivots_of_the_dense_one() -> None:
    rng = np.random.default_rng(1)
    B = rng.standard_normal((7, 5))
    A = B @ B.T
    scale = 1.0 / np.sqrt(np.diag(A))
    system = envelope(A, [0] * 7, [7] * 7, scale)
    weakest = weakest_of(system, TOLERANCE, 0, 7)
    L, inverses, order, column = np.zeros((7, 7)), np.zeros(7), np.zeros(7), np.zeros(7)
    rank, expected = pivoted.factor(A, scale, TOLERANCE, pivoted.Pivots(L, inverses, order, column))
    assert rank == 5 == np.count_nonzero(system.inverses)
    assert weakest == pytest.approx(expected, rel=1e-10)
    np.testing.assert_allclose(system.inverses[:5], inverses[:5], rtol=1e-10)
    np.testing.assert_array_equal(system.taken[:5], order[:5])


def test_parts_are_factored_by_themselves() -> None:
    rng = np.random.default_rng(2)
    A, firsts, blocks = chained(rng, 4, 0, 0)
    m, half = len(A), blocks[len(A) // 2]
    system = envelope(A, firsts, blocks, 1.0 / np.sqrt(np.diag(A)))
    x, right = np.full((m, 1), np.nan), rng.standard_normal((m, 1))
    for begin, end in ((half, m), (0, half)):
        factor_envelope(system, TOLERANCE, begin, end)
        solve_envelope(system, right, begin, end, x)
    np.testing.assert_allclose(x, np.linalg.solve(A, right), rtol=1e-8)


def test_an_indefinite_system_is_told() -> None:
    system = envelope(np.diag((1.0, -1.0)), [0, 1], [1, 2], np.ones(2))
    assert weakest_of(system, TOLERANCE, 0, 2) == 0.0


def test_complex_systems_are_symmetric_and_not_hermitian() -> None:
    rng = np.random.default_rng(3)
    A, firsts, blocks = chained(rng, 3, 1, 0)
    A = A + 1e-3j * (A @ A)
    m = len(A)
    system = envelope(A, firsts, blocks, (1.0 / np.sqrt(np.diag(A.real))).astype(complex))
    # what the square fills in is outside of the envelope
    inside = np.array([[min(a, b) >= firsts[max(a, b)] for b in range(m)] for a in range(m)])
    A = np.where(inside, A, 0.0)
    factor_envelope(system, TOLERANCE, 0, m)
    x, right = np.full((m, 1), np.nan + 0j), rng.standard_normal((m, 1)) + 0j
    solve_envelope(system, right, 0, m, x)
    np.testing.assert_allclose(A @ x, right, rtol=0, atol=1e-9)


def test_unknowns_are_taken_in_the_order_given() -> None:
    rng = np.random.default_rng(4)
    A, firsts, blocks = chained(rng, 5, 1, 0)
    m = len(A)
    order = rng.permutation(m)
    scale = np.empty(m)
    scale[order] = 1.0 / np.sqrt(np.diag(A))
    system = envelope(A, firsts, blocks, scale)._replace(order=order, place=np.argsort(order))
    factor_envelope(system, TOLERANCE, 0, m)
    x, right = np.full((m, 1), np.nan), rng.standard_normal((m, 1))
    solve_envelope(system, right, 0, m, x)
    np.testing.assert_allclose(A @ x[order], right[order], rtol=0, atol=1e-9)
    assert sorted(system.taken.tolist()) == list(range(m))


def test_a_row_that_says_what_an_earlier_block_says_is_left_out() -> None:
    rng = np.random.default_rng(5)
    B = rng.standard_normal((3, 4))
    rows = np.vstack((B, [2.0, -1.0, 0.5] @ B))
    A = rows @ rows.T
    system = envelope(A, [0, 0, 0, 0], [3, 3, 3, 4], 1.0 / np.sqrt(np.diag(A)))
    weakest = weakest_of(system, TOLERANCE, 0, 4)
    assert weakest > 1e-3
    assert system.inverses[3] == system.whole[3] == 0.0
    x, right = np.full((4, 1), np.nan), A @ rng.standard_normal((4, 1))
    solve_envelope(system, right, 0, 4, x)
    assert x[3] == 0.0
    np.testing.assert_allclose(A @ x, right, rtol=0, atol=1e-12)


@pytest.mark.parametrize("least", [1e-8, 1e-10, 1e-12])
def test_pivots_fade_as_those_of_the_dense_system(least: float) -> None:
    A = np.array([[1.0, 0.6], [0.6, 0.36 + least]])
    system = envelope(A, [0, 0], [2, 2], np.ones(2))
    weakest = weakest_of(system, TOLERANCE, 0, 2)
    L, inverses, order, column = np.zeros((2, 2)), np.zeros(2), np.zeros(2), np.zeros(2)
    rank, expected = pivoted.factor(A, np.ones(2), TOLERANCE, pivoted.Pivots(L, inverses, order, column))
    # the pivot is what is left of numbers of 1
    assert weakest == pytest.approx(expected, rel=1e-12)
    np.testing.assert_allclose(system.inverses, inverses, rtol=1e-12)
    assert rank == 2
    assert (system.inverses[1] < 0.6 * system.whole[1]) == (least <= TOLERANCE)


def test_a_pivot_that_fades_is_taken_off_later_blocks_as_a_whole() -> None:
    # only what is solved for fades: the third pivot would be 0.25 larger or smaller without the second
    L, pivots = np.array([[1.0, 0.0, 0.0], [0.6, 1.0, 0.0], [0.3, 5e4, 1.0]]), np.array([1.0, TOLERANCE, 0.4])
    system = envelope(L @ np.diag(pivots) @ L.T, [0, 0, 0], [2, 2, 3], np.ones(3))
    factor_envelope(system, TOLERANCE, 0, 3)
    # the second pivot is what is left of numbers of 1: round-off of 1e-16 over its 1e-10
    np.testing.assert_allclose(1.0 / system.whole, pivots, rtol=1e-5)
    assert system.inverses[1] == pytest.approx(0.5 * system.whole[1], rel=1e-5)
    x, right = np.full((3, 1), np.nan), np.array([[1.0], [2.0], [3.0]])
    solve_envelope(system, right, 0, 3, x)
    expected = np.linalg.solve(L.T, system.inverses[:, None] * np.linalg.solve(L, right))
    np.testing.assert_allclose(x, expected, rtol=1e-4)


def test_an_indefinite_block_after_another_is_told() -> None:
    # what is left of the second row is below zero: 0.5 - 0.8**2
    system = envelope(np.array([[1.0, 0.8], [0.8, 0.5]]), [0, 0], [1, 2], np.ones(2))
    assert weakest_of(system, TOLERANCE, 0, 2) == 0.0


def test_a_part_of_which_no_row_counts_has_no_pivots() -> None:
    system = envelope(np.eye(3), [0, 1, 2], [1, 2, 3], np.zeros(3))
    assert factor_envelope(system, TOLERANCE, 0, 3) == (np.inf, 0.0)
    assert not system.inverses.any()
