"""Cases of seas and ships; the data of one are not part of kanefe."""

from __future__ import annotations

from pathlib import Path

import pytest

from kanefe.checks.runner import NotRun
from kanefe.checks.verification import runner, waves
from kanefe.checks.verification.case import Case
from kanefe.checks.verification.report import Row
from ship_motions import write_veres

ALWAYS = (*waves.CASES[:2], pytest.param(waves.CASES[3], marks=pytest.mark.slow))


@pytest.mark.parametrize("case", ALWAYS, ids=lambda case: case.id)
def test_cases_pass(case: Case) -> None:
    rows = list(runner.run_case(case))
    assert len(rows) > 2
    assert [row for row in rows if not row.passed] == []


def test_the_container_ship_is_run_where_its_file_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    case = waves.CASES[2]
    monkeypatch.delenv(waves.WHERE, raising=False)
    (row,) = runner.run_case(case)
    assert isinstance(row, NotRun)
    assert f"set {waves.WHERE} to its path" in row.reason
    # a file of another ship is noticed
    monkeypatch.setenv(waves.WHERE, str(write_veres(tmp_path / "other.re1", (0.0, 11.0))))
    rows = [row for row in runner.run_case(case) if isinstance(row, Row)]
    assert any(not row.passed for row in rows)
