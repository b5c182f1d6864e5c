"""What `kanefe stress` prints, writes and refuses."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from kanefe.checks.robustness.case import KNOWN_LIMIT, Effort, Finding, StressCase
from kanefe.checks.robustness.runner import stress
from kanefe.checks.robustness.table import Row, Table
from kanefe.errors import FileError, MissingDependency, ModelError, SimulationError
from robustness.outcomes import check_long_method


def fine(effort: Effort) -> Iterator[Finding]:
    yield Finding.of("good things", np.arange(3 if effort.is_quick else 30) * 1e-15, "error", 1e-12, "round-off")


def bad(effort: Effort) -> Iterator[Finding]:
    yield Finding("a thing that breaks", 7, "error [m]", 0.5, 0.1, "a <tenth>", "known")
    raise SimulationError("it broke. Remedy: none")


def limited(effort: Effort) -> Iterator[Finding]:
    yield Finding("a thing that is hard", 1, "error", 0.05, 0.1, f"{KNOWN_LIMIT}nobody does better")


def lacking(effort: Effort) -> Iterator[Finding]:
    raise MissingDependency("nothing", "the case", "install it")
    yield


CASES = (
    StressCase("fine", "1", fine),
    StressCase("bad", "2", bad),
    StressCase("lacking", "3", lacking),
    StressCase("limited", "4", limited),
)


def run(*names: str, effort: Effort = Effort(), **files: str) -> int:  # noqa: B008  (it is frozen)
    return stress(names, CASES, effort, **files)


def test_a_figure_that_is_not_a_number_fails() -> None:
    assert Finding.of("x", [0.0, 1.0], "f", 1.0, "r").passed
    assert not Finding.of("x", [0.0, np.nan], "f", 1.0, "r").passed
    assert not Finding.of("x", [0.0, np.inf], "f", np.inf, "r").passed
    with pytest.raises(ValueError, match="nothing was tried"):
        Finding.of("x", [], "f", 1.0, "r")


def test_exit_codes_and_the_table(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("FINE", effort=Effort(is_quick=True)) == 0
    out = capsys.readouterr().out
    assert "good things" in out
    assert "1 of 1 pass" in out
    assert run() == 1
    out = capsys.readouterr().out
    assert out.count("FAILED") == 2
    assert "ended by SimulationError: it broke" in out
    assert "not run: needs nothing" in out
    # what was asked for and cannot run is a failure; what was not is none
    assert run("lacking") == 1
    assert run("fine", "lacking") == 1


def test_known_limits_are_marked(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "out.json"
    assert run("fine", "limited", json_path=str(path)) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.endswith("(known limit)") for line in lines[1:3]] == [False, True]
    assert lines[3].startswith("2 of 2 pass, 1 of them at known limits")
    assert [row["is_known_limit"] for row in json.loads(path.read_text())] == [False, True]


def test_long_texts_leave_the_figures_in_their_columns(capsys: pytest.CaptureFixture[str]) -> None:
    row = Row.of("case", Finding("long " * 40, 7, "error", 0.05, 0.1, "r"), 0.0)
    table = Table(sys.stdout)
    table.add(row)
    header, line = capsys.readouterr().out.splitlines()
    for name in ("count", "worst", "limit"):
        assert line[: header.index(name) + len(name)].endswith(row.texts[Table.header.index(name)])


def test_files(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, page = tmp_path / "out.json", tmp_path / "out.html"
    assert run("fine", "bad", effort=Effort(is_quick=True), json_path=str(path), html_path=str(page)) == 1
    rows = json.loads(path.read_text())
    assert [row["passed"] for row in rows] == [True, False, False]
    assert rows[0]["count"] == 3
    assert rows[1]["worst"] == 0.5
    assert rows[2]["worst"] is None
    html = page.read_text()
    assert "a &lt;tenth&gt;" in html
    assert "1 of 3 pass, in the short form" in html
    capsys.readouterr()
    assert run("fine", json_path="-") == 0
    captured = capsys.readouterr()
    assert len(json.loads(captured.out)) == 1
    assert "good things" in captured.err


def test_what_cannot_be_is_refused_before_anything_runs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(ModelError, match=r"no stress case 'nope'. Remedy: one or more of fine, bad, lacking, limited"):
        run("fine", "nope")
    with pytest.raises(ModelError, match=r"'nope' is no method with fixed steps"):
        check_long_method("nope")
    with pytest.raises(FileError, match="there is no folder"):
        run("fine", html_path=str(tmp_path / "no" / "x.html"))
    assert capsys.readouterr().out == ""
