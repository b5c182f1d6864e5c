"""Long work shows how long it still takes where somebody watches, and is what it is elsewhere."""

from __future__ import annotations

import pytest

from kanefe.storage import watched


def test_work_that_nobody_watches_is_returned_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(watched, "is_watched", lambda: False)
    parts = [1, 2, 3]
    assert watched.long_work("counting", parts) is parts


@pytest.mark.parametrize("delay", [0.0, 1e3])
def test_work_that_is_watched_shows_a_bar_once_it_is_long(
    delay: float, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(watched, "is_watched", lambda: True)
    monkeypatch.setattr(watched, "LONG", delay)
    assert list(watched.long_work("counting", iter([1, 2, 3]), 3)) == [1, 2, 3]
    assert ("counting:" in capsys.readouterr().err) == (delay == 0.0)
