"""Run verification cases: ``kanefe verify``."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain, groupby
from typing import TextIO

from numpy.linalg import LinAlgError

from kanefe.checks.verification.case import Case, Check, Reference
from kanefe.checks.verification.references import load_references
from kanefe.checks.verification.registry import select_cases
from kanefe.checks.verification.report import Row, Table, check_json_path, write_json
from kanefe.checks.verification.tolerance import tolerances_times
from kanefe.errors import KanefeError, MissingDependency


@dataclass(frozen=True)
class NotRun:
    """A case, or a part of one, that lacks a dependency."""

    case: str
    dependency: str
    reason: str


def verify(case_ids: Sequence[str] = (), json_path: str | None = None, factor: float = 1.0) -> int:
    """Run verification cases and print a line for each quantity as it is computed.

    A case that needs a package which is not installed is not run. That is a failure only if the case was asked for by
    its id.

    Parameters
    ----------
    case_ids : sequence of str
        Which cases; all if empty. Upper and lower case are the same.
    json_path : str, optional
        Also write the results as JSON: a list of objects with the keys case, quantity, value, reference, error,
        tolerance, seconds and passed. "-" writes to the standard output, and the table to the standard error.
    factor : float
        On the relative tolerance of every run that a case makes: how errors follow it. The tolerances of the checks
        stay.

    Returns
    -------
    int
        Exit code: 0 if all passed, 1 if one missed or a case asked for could not run.

    Raises
    ------
    ModelError
        If there is no such case; the message lists those there are. If the factor makes no sense.
    FileError
        If the JSON file cannot be written; looked at before anything runs.

    Examples
    --------
    >>> verify(["E03"])  # doctest: +SKIP
    """
    cases = select_cases(case_ids)
    if json_path is not None:
        check_json_path(json_path)
    table = Table(sys.stderr if json_path == "-" else sys.stdout)
    rows: list[Row] = []
    skipped: list[NotRun] = []
    started = time.perf_counter()
    with tolerances_times(factor):
        for name, parts in groupby(cases, key=lambda case: case.id):
            began = time.perf_counter()
            for outcome in chain.from_iterable(map(run_case, parts)):
                if isinstance(outcome, Row):
                    table.add(outcome)
                    rows.append(outcome)
                else:
                    table.note(outcome.case, f"not run: needs {outcome.dependency}")
                    skipped.append(outcome)
            table.note(name, f"took {time.perf_counter() - began:.2f} s")
    was_asked = bool(case_ids)
    _summarise(table.stream, rows, skipped, was_asked, time.perf_counter() - started)
    if json_path is not None:
        write_json(rows, json_path)
    return int(not all(row.passed for row in rows) or (was_asked and bool(skipped)))


def run_case(case: Case) -> Iterator[Row | NotRun]:
    """Run one case and yield its rows as they come; an error of the run is a row that did not pass."""
    reference = load_references()[case.id]
    checks = _checks(case, reference)
    while True:
        started = time.perf_counter()
        try:
            check = next(checks, None)
        except MissingDependency as problem:
            yield NotRun(case.id, problem.package, str(problem))
            return
        except (KanefeError, LinAlgError, ArithmeticError, ValueError) as problem:
            quantity = f"ended by {type(problem).__name__}: {problem}"
            yield _row(case, Check(quantity, float("nan"), float("nan"), float("nan"), 0.0), started)
            return
        if check is None:
            return
        if not reference.allows(check.tolerance):
            raise ValueError(f"{case.id}, {check.quantity}: {check.tolerance:g} is not a tolerance of the reference")
        yield _row(case, check, started)


def _checks(case: Case, reference: Reference) -> Iterator[Check]:
    yield from case.run(reference)  # also starts a plain function at the first `next`, where its errors are caught


def _row(case: Case, check: Check, started: float) -> Row:
    return Row(
        case=case.id,
        quantity=check.quantity,
        value=check.value,
        reference=check.reference,
        error=check.error,
        tolerance=check.tolerance,
        seconds=time.perf_counter() - started,
        passed=check.passed,
    )


def _summarise(stream: TextIO, rows: Sequence[Row], skipped: Sequence[NotRun], was_asked: bool, seconds: float) -> None:
    missed = [row for row in rows if not row.passed]
    parts = [f"{len(rows) - len(missed)} of {len(rows)} quantities of {len({r.case for r in rows})} cases pass"]
    if skipped:
        names = ", ".join(dict.fromkeys(s.case for s in skipped))
        counts = "asked for, so this counts as a miss" if was_asked else "not counted as a miss"
        parts.append(f"not run or not wholly run: {names} ({counts})")
    print(f"{'; '.join(parts)}; {seconds:.1f} s", file=stream)
    for row in missed:
        print(f"  missed: {row.case}, {row.quantity}", file=stream)
    for reason in dict.fromkeys(s.reason for s in skipped):
        print(f"  {reason}", file=stream)
