"""Models of MJCF drawn for the benchmark of robots: held by each kind of equality, they accelerate as MuJoCo has it."""

from __future__ import annotations

import pytest

from benchmarks.drawn_mjcf import Drawing, difference
from kanefe.robots import mjcf

pytestmark = pytest.mark.mjcf

SEEDS = {"<connect": 49, "<weld": 6, "<joint joint1": 290}
"""What a model has -> the number of one, without polynomials, which numba takes a second for."""


@pytest.mark.parametrize("what", SEEDS)
def test_models_with_equalities_accelerate_as_mujocos(what: str) -> None:
    assert what in Drawing(SEEDS[what]).text
    # round-off of some bodies
    assert difference(SEEDS[what]) < 1e-12


@pytest.mark.parametrize("what", SEEDS)
def test_the_comparison_sees_an_equality_that_is_not_read(what: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mjcf, "_add_equality", lambda *model: None)
    assert difference(SEEDS[what]) > 1e-3
