"""What pairs say of an error whose fall from level to level is known."""

from __future__ import annotations

import numpy as np
import pytest

from kanefe.certified.pairs import ASSUMED, LEAST, NOT_FALLING, SAFETY, Pair, left_of, ratio_of


def pairs_of(error: float, ratio: float, jumps: list[int]) -> list[Pair]:
    """Return the pairs of an error that falls by a ratio."""
    found, level = [], 0
    for jump in jumps:
        apart = error * (ratio**level - ratio ** (level + jump))
        level += jump
        found.append(Pair(level, jump, np.array([apart])))
    return found


@pytest.mark.parametrize("ratio", [0.02, 0.1, 0.25, 0.5, 0.74])
@pytest.mark.parametrize("jumps", [[1, 1], [1, 2], [2, 1], [2, 2], [1, 1, 1]])
def test_three_levels_show_the_ratio_and_what_is_left(ratio: float, jumps: list[int]) -> None:
    pairs = pairs_of(3.0, ratio, jumps)
    left = left_of(pairs)
    true = 3.0 * ratio ** sum(jumps)
    coarse, fine = pairs[-2:]
    assert ratio_of(coarse.apart[0], coarse.jump, fine.apart[0], fine.jump) == pytest.approx(ratio, abs=1e-9)
    assert left.errors[0] >= SAFETY * true * (1 - 1e-9)
    if ratio >= LEAST:
        assert left.errors[0] == pytest.approx(SAFETY * true, rel=1e-9)  # the bisection ends at round-off


def test_one_pair_assumes_the_fall_that_bounds_the_coarser_level() -> None:
    (pair,) = pairs_of(3.0, ASSUMED, [1])
    assert left_of([pair]).errors[0] == pytest.approx(SAFETY * 3.0 * ASSUMED)
    assert np.isnan(left_of([pair]).ratios[0])


def test_differences_that_do_not_fall_are_told() -> None:
    left = left_of([Pair(1, 1, np.array([1.0, 1.0])), Pair(2, 1, np.array([0.1, 0.9]))])
    assert left.is_erratic.tolist() == [False, True]
    assert left.errors[1] == pytest.approx(SAFETY * NOT_FALLING / (1 - NOT_FALLING))


def test_a_difference_that_is_small_by_chance_is_not_believed() -> None:
    left = left_of([Pair(1, 1, np.array([1.0])), Pair(2, 1, np.array([1e-9]))])
    assert left.errors[0] >= LEAST * LEAST


def test_no_difference_is_no_error() -> None:
    assert left_of([Pair(1, 1, np.zeros(2)), Pair(2, 1, np.zeros(2))]).errors.tolist() == [0.0, 0.0]
