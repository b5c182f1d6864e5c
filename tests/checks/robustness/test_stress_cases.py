"""The stress cases: all of them in their short form, and in full by ``pytest -m stress``."""

from __future__ import annotations

from importlib.util import find_spec

import pytest

from kanefe.checks.robustness.case import Effort, StressCase
from kanefe.checks.robustness.registry import OWN, REGISTRY
from kanefe.checks.robustness.runner import run_case
from kanefe.checks.robustness.table import Row

FEM_CASES = tuple(REGISTRY.of_plugins())

NEEDS_MESH = ("slivers", "aspect-ratio", "incompressible", "unit-systems")


def check(case: StressCase, effort: Effort) -> None:
    rows = list(run_case(case, effort))
    assert rows
    for row in rows:
        assert isinstance(row, Row), row
        assert row.passed, f"{row.tried} ({row.note}): {row.figure} {row.worst:.3g} > {row.limit:.3g}, {row.reason}"


def marked(case: StressCase) -> object:
    marks = [pytest.mark.fenicsx] if case.name in NEEDS_MESH else []
    return pytest.param(case, marks=marks, id=case.name)


CASES = [marked(case) for case in (*OWN, *FEM_CASES)]


@pytest.mark.slow
@pytest.mark.timeout(1200)  # the longest takes two and a half minutes of a core that it has for itself
@pytest.mark.parametrize("case", CASES)
def test_in_short_form(case: StressCase) -> None:
    check(case, Effort(is_quick=True))


@pytest.mark.stress
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("case", CASES)
def test_in_full(case: StressCase) -> None:
    check(case, Effort())


@pytest.mark.skipif(find_spec("kanefe_fem") is None, reason="the plugin is not installed")
def test_the_plugin_adds_its_cases() -> None:
    assert {case.name for case in FEM_CASES} >= {*NEEDS_MESH, "spin-stiffening"}
