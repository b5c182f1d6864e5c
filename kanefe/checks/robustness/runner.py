"""Run stress cases: ``kanefe stress``."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from numpy.linalg import LinAlgError

from kanefe.checks.robustness.case import Effort, Finding, StressCase
from kanefe.checks.robustness.registry import select_cases
from kanefe.checks.robustness.table import Row, Table, check_target, stress_report, write_json
from kanefe.errors import KanefeError, MissingDependency


@dataclass(frozen=True)
class NotRun:
    """A case, or the rest of one, that lacks a package."""

    case: str
    package: str
    reason: str


def stress(
    names: Sequence[str] = (),
    *,
    quick: bool = False,
    method: str | None = None,
    json_path: str | None = None,
    html_path: str | None = None,
) -> int:
    """Run stress cases and print a line for each thing that was tried, as soon as it is known.

    Parameters
    ----------
    names : sequence of str
        Which cases; all if empty. Upper and lower case are the same.
    quick : bool
        The short form: fewer states, scenes and steps of every kind.
    method : str, optional
        Method of the long runs; default: see `kanefe.checks.robustness.drift`.
    json_path : str, optional
        Also write the findings as JSON: a list of objects with the keys case, tried, count, figure, worst, limit,
        reason, note, seconds, passed and is_known_limit. "-" writes to the standard output, and the table to the
        standard error.
    html_path : str, optional
        Also write the table as one HTML page.

    Returns
    -------
    int
        Exit code: 0 if all passed, 1 if one failed or a case asked for could not run.

    Raises
    ------
    ModelError
        If there is no such case or method; the message lists those there are.
    FileError
        If a file cannot be written; looked at before anything runs.

    Examples
    --------
    >>> stress(["mass-ratio"], quick=True)  # doctest: +SKIP
    """
    from kanefe.checks.robustness.runs import check_long_method

    cases = select_cases(names)
    if method is not None:
        check_long_method(method)
    for path in (json_path, html_path):
        if path is not None:
            check_target(path)
    effort = Effort(quick, method)
    table = Table(sys.stderr if json_path == "-" else sys.stdout)
    rows: list[Row] = []
    not_run: list[NotRun] = []
    began = time.perf_counter()
    for case in cases:
        for outcome in run_case(case, effort):
            if isinstance(outcome, Row):
                table.add(outcome)
                rows.append(outcome)
            else:
                table.note(outcome.case, f"not run: needs {outcome.package}")
                not_run.append(outcome)
    table.summarise(rows, time.perf_counter() - began, [f"{n.case}: {n.reason}" for n in not_run])
    if json_path is not None:
        write_json(rows, json_path)
    if html_path is not None:
        stress_report(rows, quick, [f"{n.case}: {n.reason}" for n in not_run]).to_html(html_path, pictures=False)
    return int(not all(row.passed for row in rows) or (bool(names) and bool(not_run)))


def run_case(case: StressCase, effort: Effort) -> Iterator[Row | NotRun]:
    """Run one case and yield its rows as they come; an error that ends it is a row that did not pass."""
    findings = _findings(case, effort)
    while True:
        began = time.perf_counter()
        try:
            finding = next(findings, None)
        except MissingDependency as problem:
            yield NotRun(case.name, problem.package, str(problem))
            return
        except (KanefeError, LinAlgError, ArithmeticError, ValueError) as problem:
            text = f"ended by {type(problem).__name__}: {problem}"
            finding = Finding(case.title, 1, text, float("nan"), 0.0, "a case runs to its end")
            yield Row.of(case.name, finding, time.perf_counter() - began)
            return
        if finding is None:
            return
        yield Row.of(case.name, finding, time.perf_counter() - began)


def _findings(case: StressCase, effort: Effort) -> Iterator[Finding]:
    yield from case.run(effort)  # also starts a plain function at the first `next`, where its errors are caught
