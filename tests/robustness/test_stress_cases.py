"""The stress cases in their short form, the longer ones by `pytest -m slow`; in full by `pytest -m stress`."""

from __future__ import annotations

import pytest

from kanefe.checks.robustness.case import Effort, StressCase
from kanefe.checks.robustness.runner import run_case
from kanefe.checks.robustness.table import Row
from robustness.registry import CASES
from robustness.stress import main

NEEDS_MESH = {"slivers", "aspect-ratio", "incompressible", "unit-systems"}

LONG = {
    *("massless", "events", "large-steps", "determinism", "snap-through"),
    *("unit-systems", "sticking", "spin", "tethers", "stiffness-ratio"),
    *("incompressible", "slivers", "undamped", "aspect-ratio"),
}
"""Cases whose short form takes more than a second."""


def check(case: StressCase, effort: Effort) -> None:
    rows = list(run_case(case, effort))
    assert rows
    for row in rows:
        assert isinstance(row, Row), row
        assert row.passed, f"{row.tried} ({row.note}): {row.figure} {row.worst:.3g} > {row.limit:.3g}, {row.reason}"


def marked(case: StressCase, *long: pytest.MarkDecorator) -> object:
    marks = [pytest.mark.fenicsx] if case.name in NEEDS_MESH else []
    return pytest.param(case, marks=[*marks, *long] if case.name in LONG else marks, id=case.name)


@pytest.mark.parametrize("case", [marked(case, pytest.mark.slow) for case in CASES])
def test_in_short_form(case: StressCase) -> None:
    check(case, Effort(is_quick=True))


@pytest.mark.stress
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("case", [marked(case) for case in CASES])
def test_in_full(case: StressCase) -> None:
    check(case, Effort())


def test_every_case_has_a_name_of_its_own() -> None:
    names = [case.name.casefold() for case in CASES]
    assert len(set(names)) == len(names)
    assert {*NEEDS_MESH, *LONG, "spin-stiffening", "drift"} <= {*names}


def test_the_command_refuses_what_is_not_there(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--method", "nope"]) == main(["--quick", "nope"]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert "'nope' is no method with fixed steps" in said.err
    assert "no stress case 'nope'. Remedy: one or more of drift, singular-loops" in said.err
