"""Roots and lowest places of functions in a step, against those of scipy and those that are known."""

from __future__ import annotations

import math

import pytest
from scipy.optimize import brentq

from kanefe.kernels.events.event_search import crossing_between, lowest_between

FUNCTIONS = {
    "smooth": lambda x: math.cos(x) - x,
    "flat": lambda x: (x - 0.3) ** 9,
    "steep": lambda x: math.tanh(1e6 * (x - 0.123)),
    "jump": lambda x: -1.0 if x < 0.7 else 3.0,
    "falling": lambda x: 0.9 - x**3,
    "far from zero at one end": lambda x: math.exp(40.0 * x) - 2.0,
}


def called(function, t):
    return function(t)


@pytest.mark.parametrize("name", FUNCTIONS)
@pytest.mark.parametrize("width", [1e-6, 1e-13])
def test_roots_are_those_of_scipy(name, width):
    asked = []

    def f(x):
        asked.append(x)
        return FUNCTIONS[name](x)

    found = crossing_between(called, f, (0.0, f(0.0)), (1.0, f(1.0)), width)
    exact = 0.3 if name == "flat" else brentq(FUNCTIONS[name], 0.0, 1.0, xtol=1e-15)  # which does not end there
    # where it is flat values vanish in round-off around the root: (1e-33)^(1/9) of it
    assert abs(found - exact) <= (2e-4 if name == "flat" else width)
    assert len(asked) < (60 if name in ("jump", "steep", "flat") else 14)  # halves alone would take 44 for 1e-13
    assert all(0.0 <= x <= 1.0 for x in asked)


def test_an_end_may_be_the_root():
    assert crossing_between(called, lambda x: x, (0.0, 0.0), (1.0, 1.0), 1e-12) == 0.0
    assert crossing_between(called, lambda x: x - 1.0, (0.0, -1.0), (1.0, 0.0), 1e-12) == 1.0


def test_the_lowest_place_is_found_and_one_below_zero_is_enough():
    place, value = lowest_between(called, lambda x: (x - 0.3) ** 2 + 0.1, 1.0, 0.0, 1.0, 1e-6)
    assert place == pytest.approx(0.3, abs=1e-5)
    assert value == pytest.approx(0.1, abs=1e-9)
    assert lowest_between(called, lambda x: (x - 0.3) ** 2 - 0.1, 1.0, 0.0, 1.0, 1e-6)[1] < 0.0


def test_it_ends_between_neighbours():
    """As after a touch, of which the next is looked for at once."""
    a = 0.3238293233259115
    assert lowest_between(called, lambda x: 1.0 + x, 1.0, a, math.nextafter(a, 1.0), 1e-20)[0] == pytest.approx(a)


@pytest.mark.parametrize(("b", "width"), [(1.0, math.nan), (math.nan, 1e-12)])
def test_a_search_without_a_width_or_an_end_ends(b: float, width: float) -> None:
    """A step too short to move time on made both 0 / 0 once, and the run never returned."""
    assert not math.isinf(crossing_between(called, lambda x: x - 0.5, (0.0, -0.5), (b, 0.5), width))
