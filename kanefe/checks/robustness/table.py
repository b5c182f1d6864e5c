"""How findings are shown: a table as they come, a JSON file, a page of HTML."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from itertools import groupby
from typing import TextIO

from kanefe.checks.robustness.case import Finding
from kanefe.checks.verification.report import check_json_path
from kanefe.report.blocks import Block, Heading, Paragraph
from kanefe.report.blocks import Table as ReportTable
from kanefe.report.document import Report
from kanefe.storage.files import write_whole

HEADER, WIDTHS = ("case", "how many", "worst", "limit", "worst of", "tried"), (16, 8, 8, 8, 48, 0)
"""Long texts come last, where they leave the figures in their columns."""


@dataclass(frozen=True)
class Row:
    """One line of the table and one object of the JSON list: see `kanefe.checks.robustness.case.Finding`."""

    case: str
    tried: str
    count: int
    figure: str
    worst: float
    limit: float
    reason: str
    note: str
    seconds: float
    passed: bool
    is_known_limit: bool

    @classmethod
    def of(cls, case: str, finding: Finding, seconds: float) -> Row:
        """Return the row of a finding that took some seconds."""
        is_known_limit = finding.is_known_limit
        return cls(case, **asdict(finding), seconds=seconds, passed=finding.passed, is_known_limit=is_known_limit)

    @property
    def texts(self) -> tuple[str, ...]:
        """The columns of `HEADER` as texts."""
        note = f" ({self.note})" if self.note else ""
        worst, limit = (f"{x:.3g}" if 0.1 <= abs(x) < 1e5 or x == 0 else f"{x:.1e}" for x in (self.worst, self.limit))
        return self.case, str(self.count), worst, limit, self.figure, self.tried + note


class Table:
    """A table that grows row by row."""

    def __init__(self, stream: TextIO) -> None:
        self.stream = stream
        self._print(HEADER, "")

    def add(self, row: Row) -> None:
        """Print a row."""
        self._print(row.texts, "  FAILED" if not row.passed else "  (known limit)" if row.is_known_limit else "")

    def note(self, case: str, text: str) -> None:
        """Print a line about a case that has no figure."""
        print(f"{case:{WIDTHS[0]}} {text}", file=self.stream, flush=True)

    def summarise(self, rows: Sequence[Row], seconds: float, not_run: Sequence[str]) -> None:
        """Print how many passed, what failed and what could not run."""
        failed = [row for row in rows if not row.passed]
        print(f"{_verdict(rows)}; {seconds:.0f} s", file=self.stream)
        for row in failed:
            print(f"  failed: {row.case}, {row.tried}: {row.figure}; limit: {row.reason}", file=self.stream)
        for text in not_run:
            print(f"  not run: {text}", file=self.stream)

    def _print(self, texts: Sequence[str], mark: str) -> None:
        right = (False, True, True, True, False, False)
        cells = [f"{t:>{w}}" if r else f"{t:{w}}" for t, w, r in zip(texts, WIDTHS, right, strict=True)]
        print("  ".join(cells).rstrip() + mark, file=self.stream, flush=True)


def _verdict(rows: Sequence[Row]) -> str:
    passed = [row for row in rows if row.passed]
    known = sum(row.is_known_limit for row in passed)
    return f"{len(passed)} of {len(rows)} pass" + (f", {known} of them at known limits" if known else "")


def check_target(path: str) -> None:
    """Raise a FileError if a file could not be written at `path` ("-" is the standard output)."""
    check_json_path(path)


def write_json(rows: Sequence[Row], path: str) -> None:
    """Write the rows as a JSON list to a file, or to the standard output if `path` is "-".

    Numbers that are not finite become null, which JSON knows.

    Raises
    ------
    FileError
        If the file cannot be written; an old one stays as it was.
    """
    objects = [
        {key: None if isinstance(x, float) and not math.isfinite(x) else x for key, x in asdict(row).items()}
        for row in rows
    ]
    text = json.dumps(objects, indent=1, allow_nan=False) + "\n"
    if path == "-":
        sys.stdout.write(text)
        sys.stdout.flush()
        return
    write_whole(path, lambda file: file.write(text.encode("utf-8")))


def stress_report(rows: Sequence[Row], is_quick: bool, not_run: Sequence[str]) -> Report:
    """Return the table as a report, with the reasons of the limits."""
    failed = [row for row in rows if not row.passed]
    blocks: list[Block] = [Paragraph(f"{_verdict(rows)}{', in the short form' if is_quick else ''}.")]
    blocks += [Paragraph(f"failed: {row.case}, {row.tried}", warning=True) for row in failed]
    blocks += [Paragraph(f"not run: {text}", warning=True) for text in not_run]
    for name, group in groupby(rows, key=lambda row: row.case):
        cells = [(*row.texts[1:], row.reason, f"{row.seconds:.1f}", "yes" if row.passed else "NO") for row in group]
        blocks += [Heading(name), ReportTable((*HEADER[1:], "why this limit", "seconds", "passed"), cells, True)]
    return Report("Stress tests of kanefe", tuple(blocks))
