"""The share of a build that is told: by the time that libraries take, not by their number."""

from __future__ import annotations

from itertools import count

import pytest

from kanefe.kernels.compiler import progress
from kanefe.kernels.compiler.libraries import ENGINE, LEAST_SECONDS, Library


class Clock:
    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now = 100.0
        monkeypatch.setattr(progress.time, "monotonic", lambda: self.now)


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    return Clock(monkeypatch)


BIG, SMALL = Library(ENGINE, ("kanefe.kernels.evaluation.evaluation",)), Library("small", ("kanefe.kernels.small",))


def test_a_library_counts_by_its_time(clock: Clock) -> None:
    said: list[str] = []
    found = progress.BuildProgress([BIG, SMALL], 1, said.append)
    assert "engine, small" in said[0]
    found.note("small", "done")
    assert found.share == pytest.approx(LEAST_SECONDS / (LEAST_SECONDS + BIG.seconds))
    found.note(ENGINE, "done")
    assert found.share == 1.0
    found.end()
    assert "the solver is prepared" in said[-1]


def test_between_what_builders_tell_time_goes_on_and_never_reaches_the_next_step_alone(clock: Clock) -> None:
    found = progress.BuildProgress([BIG], 1, lambda text: None)
    found.note(ENGINE, "")
    found.note(ENGINE, "0.2 0.4")
    assert found.share == pytest.approx(0.2)
    clock.now += 0.1 * BIG.seconds
    assert found.share == pytest.approx(0.3)
    clock.now += 10.0 * BIG.seconds  # on a slow machine
    assert found.share == pytest.approx(0.4)
    found.note(ENGINE, "0.4 1.0")
    clock.now += 10.0 * BIG.seconds
    assert found.share == pytest.approx(progress.ALMOST)


def test_the_share_never_falls_and_is_told_every_few_seconds(clock: Clock) -> None:
    said: list[str] = []
    found, shares = progress.BuildProgress([BIG, SMALL], 2, said.append), [0.0]
    for step in count():
        clock.now += 0.7
        if step == 10:
            found.note(ENGINE, "0.1 0.5")
        if step == 30:
            found.note(ENGINE, "0.5 1.0")
        if step == 40:
            break
        found.tell()
        shares.append(found.share)
    assert shares == sorted(shares)
    assert len(said) == 1 + int(40 * 0.7 / (progress.EVERY + 0.7 - progress.EVERY % 0.7))
