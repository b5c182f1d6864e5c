"""The search on manufactured answers, whose errors are known."""

from __future__ import annotations

import numpy as np
import pytest

from kanefe.certified.limits import Limits
from kanefe.certified.report_of_search import accuracy_of
from manufactured import EXACT, Manufactured, manufactured


def test_bounds_hold_for_random_answers() -> None:
    """Single numbers may cancel by chance in a difference; that is what the factor of two is for."""
    refused, ratios = 0, []
    for seed in range(300):
        made, accuracy = manufactured(seed)
        search = made.search(accuracy)
        found = accuracy_of(search)
        error = float(np.abs(search.best.answer - EXACT).max())
        assert error <= 2.0 * found.bounds[0], seed
        ratios.append(error / found.bounds[0])
        refused += not found.is_met
        if found.is_met:
            assert error <= 2.0 * found.allowed[0], seed
    assert refused <= 15  # 5 %: nothing but levels that end
    assert np.mean(np.array(ratios) <= 1.0) >= 0.95
    assert np.median(ratios) > 0.05


def test_it_stops_as_soon_as_the_bound_is_met() -> None:
    """A source with a hundredth of the error stays at the level where that was seen."""
    made = Manufactured(np.array([[1e-1], [1e-5]]), np.array([0.1, 0.1]))
    search = made.search(1e-2)
    assert search.best.levels[1] == 0
    assert 1 <= search.best.levels[0] <= 3
    assert search.evaluations <= 6


def test_answers_that_do_not_converge_have_no_bound() -> None:
    made = Manufactured(np.ones((2, 3)), np.array([0.1, 0.2]), noise=0.3)
    found = accuracy_of(made.search(1e-3))
    assert not found.is_met
    assert "contradict" in found.reason
    assert np.isinf(found.bounds).all()


def test_levels_that_end_are_told() -> None:
    found = accuracy_of(Manufactured(np.ones((1, 3)), np.array([0.4]), levels=3).search(1e-4))
    assert not found.is_met
    assert "source 0" in found.reason
    assert "no finer levels" in found.reason
    assert found.bounds[0] >= 0.16  # what is left at the last level


def test_time_is_limited_and_what_it_would_take_is_told() -> None:
    found = accuracy_of(Manufactured(np.ones((1, 3)), np.array([0.4])).search(1e-4, Limits(seconds=1.0)))
    assert "most_seconds=1" in found.reason
    assert "would take" in found.reason


def test_the_cheapest_setting_is_enough() -> None:
    made = Manufactured(np.array([[1e-1], [1e-3], [1e-2]]), np.array([0.05, 0.05, 0.05]))
    search = made.search(1e-2)
    found = accuracy_of(search)
    assert found.is_met
    code = found.cheapest or found.setting
    levels = tuple(int(line.rpartition("=")[2]) for line in code.splitlines())
    assert abs(made.values(levels)[0] - EXACT) <= found.allowed[0]
    assert sum(levels) <= sum(search.best.levels)


def test_a_pair_at_random_is_measured_again() -> None:
    """Sources that act on each other: the pair of one is five times as large at the final levels of the other."""

    class Together(Manufactured):
        def values(self, levels: tuple[int, ...]) -> np.ndarray:
            first, second = 0.3 ** levels[0], 0.3 ** levels[1]
            return EXACT + self.errors[0] * first * (5.0 - 4.0 * second) + self.errors[1] * second * (5.0 - 4.0 * first)

    made = Together(np.array([[0.02], [0.02]]), np.array([0.3, 0.3]))
    search = made.search(1e-3)
    assert search.effectivity > 1.5
    assert float(np.abs(search.best.answer - EXACT).max()) <= 2.0 * search.bounds[0]


@pytest.mark.parametrize("seconds", [None, 1e3])
def test_the_table_names_every_source(seconds: float | None) -> None:
    text = str(accuracy_of(Manufactured(np.ones((3, 2)), np.array([0.1, 0.2, 0.05])).search(1e-2, Limits(seconds))))
    assert text.startswith("accuracy met")
    assert all(f"source {i}" in text for i in range(3))
    assert "falls by" in text
    assert "evaluations" in text
