"""Lowest places of functions, against those that are known."""

from __future__ import annotations

import math

import pytest

from kanefe.integrate.events.minimise import lowest_between


def test_the_lowest_place_is_found_and_one_below_zero_is_enough():
    place, value = lowest_between(lambda x: (x - 0.3) ** 2 + 0.1, 0.0, 1.0, 1e-6)
    assert place == pytest.approx(0.3, abs=1e-5)
    assert value == pytest.approx(0.1, abs=1e-9)
    assert lowest_between(lambda x: (x - 0.3) ** 2 - 0.1, 0.0, 1.0, 1e-6)[1] < 0.0


def test_it_ends_between_neighbours():
    """As after a touch, of which the next is looked for at once."""
    a = 0.3238293233259115
    assert lowest_between(lambda x: 1.0 + x, a, math.nextafter(a, 1.0), 1e-20)[0] == pytest.approx(a)
