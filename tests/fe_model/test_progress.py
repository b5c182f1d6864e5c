"""The stages of a long computation, shown and timed."""

from __future__ import annotations

import sys
import time

import pytest

from kanefe.fe_model.progress import LARGE, Stages, report_size, stage, stages


def run(size: int, wanted: bool | None) -> Stages:
    with stages(3, wanted) as found:
        with stage("read"):
            report_size(size)
            time.sleep(0.02)
        for name in ("factor", "solve"):
            with stage(name):
                pass
    return found


def test_stages_are_timed() -> None:
    seconds = run(10, None).seconds
    assert list(seconds) == ["read", "factor", "solve"]
    assert 0.02 <= seconds["read"] < 2.0
    assert seconds["solve"] < 0.02


def test_a_stage_that_nobody_shows_is_only_run() -> None:
    ran = []
    report_size(10**9)
    with stage("alone"):
        ran.append(True)
    assert ran


@pytest.mark.parametrize(
    ("size", "wanted", "terminal", "shown"),
    [
        (LARGE + 1, None, True, True),
        (LARGE, None, True, False),
        (LARGE + 1, None, False, False),
        (1, True, False, True),
        (LARGE + 1, False, True, False),
    ],
)
def test_when_the_bar_is_shown(
    size: int,
    wanted: bool | None,
    terminal: bool,
    shown: bool,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(sys.stderr, "isatty", lambda: terminal)
    kept = run(size, wanted)  # a bar that nobody keeps goes by itself
    written = capsys.readouterr().err
    assert ("stages" in written) is shown
    if shown:
        assert "factor" in written
        assert written.endswith("\r")  # taken away at the end
    assert len(kept.seconds) == 3


def test_an_error_takes_the_bar_away_and_is_passed_on(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(ValueError, match="no mesh"), stages(2, True), stage("read"):
        raise ValueError("no mesh")
    assert capsys.readouterr().err.endswith("\r")
    with stage("after it"):  # nobody shows it any more
        pass
    assert capsys.readouterr().err == ""
