"""Cases of seas and ships."""

from __future__ import annotations

from pathlib import Path

import pytest

from kanefe.checks.verification import runner, waves
from kanefe.checks.verification.case import Case
from kanefe.checks.verification.report import Row
from kanefe.environment import read_rao
from ship_motions import write_veres

ALWAYS = (*waves.CASES[:3], pytest.param(waves.CASES[3], marks=pytest.mark.slow))


@pytest.mark.parametrize("case", ALWAYS, ids=lambda case: case.id)
def test_cases_pass(case: Case) -> None:
    rows = list(runner.run_case(case))
    assert len(rows) > 2
    assert [row for row in rows if not row.passed] == []


def test_a_file_of_another_ship_is_noticed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    other = read_rao(write_veres(tmp_path / "other.re1", (0.0, 11.0)))
    monkeypatch.setattr(waves, "read_rao", lambda path: other)
    rows = [row for row in runner.run_case(waves.CASES[2]) if isinstance(row, Row)]
    assert any(not row.passed for row in rows)
