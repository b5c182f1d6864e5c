"""Which intervals between samples of a function are searched for its zeros."""

from __future__ import annotations

import numpy as np
import pytest

from kanefe.kernels.events.event_search import StepSamples, find_brackets


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ((1.0, 0.0, 1.0), []),  # it comes to zero and goes back
        ((1.0, 0.0, -1.0), [(0.0, 1.0)]),
        ((1.0, 1.0, 0.0), [(1.0, 2.0)]),  # where it goes from there is not known yet
        ((-1.0, 0.0, -1.0), []),
        ((1.0, -1.0, -1.0), [(0.0, 1.0)]),
    ],
)
def test_a_zero_that_is_not_passed_is_no_bracket(
    values: tuple[float, ...], expected: list[tuple[float, float]]
) -> None:
    times, brackets = np.arange(3.0), np.empty((6, 2))

    def straight(data: object, t: float) -> float:
        return float(np.interp(t, times, values))

    found = find_brackets(straight, None, StepSamples(times, np.array(values), 3, 0), 0, brackets)
    assert [tuple(pair) for pair in brackets[:found]] == expected
