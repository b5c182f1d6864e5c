"""Run verification cases: ``kanefe verify``."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator, Sequence
from itertools import groupby
from operator import attrgetter

from kanefe.checks.registry import select
from kanefe.checks.runner import NotRun, outcomes
from kanefe.checks.table import check_target, write_json
from kanefe.checks.verification.case import Case, Check
from kanefe.checks.verification.references import load_references
from kanefe.checks.verification.registry import registered_cases
from kanefe.checks.verification.report import Row, Table
from kanefe.checks.verification.tolerance import tolerances_times


def verify(case_ids: Sequence[str] = (), json_path: str | None = None, factor: float = 1.0) -> int:
    """Run verification cases and print a line for each quantity as it is computed.

    A case that needs a package which is not installed is not run. That is a failure only if the case was requested by
    its id.

    Parameters
    ----------
    case_ids : sequence of str
        Ids of cases; all if empty. Not case-sensitive.
    json_path : str, optional
        Also write the results as JSON: a list of objects with the keys case, quantity, value, reference, error,
        tolerance, seconds and passed. "-" writes to the standard output, and the table to the standard error.
    factor : float
        Factor on the relative tolerance of every run of a case, to see how errors depend on it. The tolerances of the
        checks do not change.

    Returns
    -------
    int
        Exit code: 0 if all passed, 1 if one missed or a requested case could not run.

    Raises
    ------
    ModelError
        If there is no such case; the message lists the known ones. If the factor is not a finite number above zero.
    FileError
        If the JSON file cannot be written; checked before the cases run.

    Examples
    --------
    >>> verify(["E03"])  # doctest: +SKIP
    """
    cases = select("verification", registered_cases(), case_ids, attrgetter("id"))
    check_target(json_path)
    started = time.perf_counter()
    with tolerances_times(factor):
        table = Table(sys.stderr if json_path == "-" else sys.stdout)
        for name, parts in groupby(cases, key=lambda case: case.id):
            began = time.perf_counter()
            for part in parts:
                for outcome in run_case(part):
                    table.add(outcome)
            table.note(name, f"took {time.perf_counter() - began:.2f} s")
    table.summarise(bool(case_ids), time.perf_counter() - started)
    if json_path is not None:
        write_json(table.rows, json_path)
    return table.exit_code(bool(case_ids))


def run_case(case: Case) -> Iterator[Row | NotRun]:
    """Run one case and yield its rows as they are known; an error of the run is a row that did not pass."""
    reference = load_references()[case.id]

    def ended(text: str) -> Check:
        return Check(text, float("nan"), float("nan"), float("nan"), 0.0)

    def row(check: Check, seconds: float) -> Row:
        if check.tolerance and not reference.allows(check.tolerance):
            raise ValueError(f"{case.id}, {check.quantity}: {check.tolerance:g} is not a tolerance of the reference")
        return Row.of(case.id, check, seconds)

    return outcomes(case.id, lambda: case.run(reference), ended, row)
