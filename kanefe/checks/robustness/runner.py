"""Run stress cases: ``kanefe stress``."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator, Sequence
from functools import partial
from operator import attrgetter

from kanefe.checks.registry import select
from kanefe.checks.robustness.case import Effort, Finding, StressCase
from kanefe.checks.robustness.cases import CASES
from kanefe.checks.robustness.table import Row, Table, stress_report
from kanefe.checks.runner import NotRun, outcomes
from kanefe.checks.table import check_target, write_json

SHORT = Effort(is_quick=True)


def stress(
    names: Sequence[str] = (),
    cases: Sequence[StressCase] = CASES,
    effort: Effort = SHORT,
    *,
    json_path: str | None = None,
    html_path: str | None = None,
) -> int:
    """Run stress cases and print a line for each finding as soon as it is known.

    Parameters
    ----------
    names : sequence of str
        Names of cases; all if empty. Not case-sensitive.
    cases : sequence of StressCase
        The cases to choose from; default: those of the package.
    effort : Effort
        Extent of the trials; default: the short form.
    json_path : str, optional
        Also write the findings as JSON: a list of objects with the keys case, tried, count, figure, worst, limit,
        reason, note, seconds, passed and is_known_limit. "-" writes to the standard output, and the table to the
        standard error.
    html_path : str, optional
        Also write the table as one HTML page.

    Returns
    -------
    int
        Exit code: 0 if all passed, 1 if one failed or a requested case could not run.

    Raises
    ------
    ModelError
        If there is no such case; the message lists the known ones.
    FileError
        If a file cannot be written; checked before the cases run.

    Examples
    --------
    >>> stress(["drift"])  # doctest: +SKIP
    """
    chosen = select("stress", cases, names, attrgetter("name"))
    check_target(json_path)
    check_target(html_path)
    table = Table(sys.stderr if json_path == "-" else sys.stdout)
    began = time.perf_counter()
    for case in chosen:
        for outcome in run_case(case, effort):
            table.add(outcome)
    table.summarise(time.perf_counter() - began)
    if json_path is not None:
        write_json(table.rows, json_path)
    if html_path is not None:
        stress_report(table, effort.is_quick).to_html(html_path, pictures=False)
    return table.exit_code(bool(names))


def run_case(case: StressCase, effort: Effort) -> Iterator[Row | NotRun]:
    """Run one case and yield its rows as they are known; an error that ends it is a row that did not pass."""

    def ended(text: str) -> Finding:
        return Finding(case.title, 1, text, float("nan"), 0.0, "a case runs to its end")

    return outcomes(case.name, lambda: case.run(effort), ended, partial(Row.of, case.name))
