"""Run of one case: its findings with their times, and errors that end it."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import TypeVar

from numpy.linalg import LinAlgError

from kanefe.errors import KanefeError, MissingDependency

SomeFinding = TypeVar("SomeFinding")
SomeRow = TypeVar("SomeRow")


@dataclass(frozen=True)
class NotRun:
    """A case, or the rest of one, that needs a package which is not installed."""

    case: str
    package: str
    reason: str


def outcomes(
    case: str,
    run: Callable[[], Iterable[SomeFinding]],
    ended: Callable[[str], SomeFinding],
    row: Callable[[SomeFinding, float], SomeRow],
) -> Iterator[SomeRow | NotRun]:
    """Run a case and yield its rows as they are known; an error that ends it is a row that did not pass.

    ``ended(text)`` returns the finding that represents an error, ``row(finding, seconds)`` the row of a finding, with
    the time since the previous one.
    """
    findings = _started(run)
    while True:
        began = time.perf_counter()
        try:
            finding = next(findings)
        except StopIteration:
            return
        except MissingDependency as problem:
            yield NotRun(case, problem.package, str(problem))
            return
        except (KanefeError, LinAlgError, ArithmeticError, ValueError) as problem:
            yield row(ended(f"ended by {type(problem).__name__}: {problem}"), time.perf_counter() - began)
            return
        yield row(finding, time.perf_counter() - began)


def _started(run: Callable[[], Iterable[SomeFinding]]) -> Iterator[SomeFinding]:
    yield from run()  # so that a plain function also starts at the first `next`, where errors are caught
