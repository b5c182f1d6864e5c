"""``kanefe verify --tol``: the errors of the cases follow the tolerance of their runs, within a factor of ten."""

from __future__ import annotations

import pytest

from kanefe.checks.verification import dumbbell, loops, rigid, runner
from kanefe.checks.verification.case import Case
from kanefe.checks.verification.tolerance import scaled, tolerances_times
from kanefe.errors import ModelError

CASES = [*rigid.CASES, *(case for case in loops.CASES if case.id != "A02"), *dumbbell.CASES]


def error(case: Case, factor: float) -> float:
    """Return the error of the first quantity of a case, which is of a whole motion."""
    with tolerances_times(factor):
        row = next(iter(runner.run_case(case)))
    assert isinstance(row, runner.Row)
    return row.error


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.id)
def test_errors_follow_the_tolerance(case: Case) -> None:
    tight, middle, loose = (error(case, factor) for factor in (10.0, 1e3, 1e5))
    # a hundredth of the tolerance leaves a hundredth of the error, within a factor of ten
    assert 10.0 <= middle / tight <= 1000.0
    assert 10.0 <= loose / middle <= 1000.0


def test_the_factor_acts_on_runs_only_and_only_within() -> None:
    with tolerances_times(100.0):
        assert scaled(1e-8) == pytest.approx(1e-6, rel=1e-15)
        assert scaled(1e-2) == 0.1  # what is looser is no control at all
    assert scaled(1e-8) == 1e-8
    with tolerances_times(1e5):
        assert next(iter(runner.run_case(rigid.CASES[0]))).tolerance == 1e-8


@pytest.mark.parametrize("factor", [0.0, -1.0, float("nan"), float("inf")])
def test_a_factor_without_meaning_is_refused(factor: float) -> None:
    with pytest.raises(ModelError, match="factor on the tolerances must be above zero"):
        runner.verify(["E03"], factor=factor)


def test_each_case_tells_the_time_it_took(capsys: pytest.CaptureFixture[str]) -> None:
    assert runner.verify(["E03", "A01"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line[:11] for line in lines if " took " in line] == ["A01   took ", "E03   took "]
