"""Output of the findings of stress cases: a table that grows as they are known, and an HTML page."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from itertools import groupby

from kanefe.checks.robustness.case import Finding
from kanefe.checks.table import GrowingTable
from kanefe.documents.blocks import Block, Heading, Paragraph
from kanefe.documents.blocks import Table as ReportTable
from kanefe.documents.document import Report


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
        """The cells of the row as texts."""
        note = f" ({self.note})" if self.note else ""
        worst, limit = (f"{x:.3g}" if 0.1 <= abs(x) < 1e5 or x == 0 else f"{x:.1e}" for x in (self.worst, self.limit))
        return self.case, str(self.count), worst, limit, self.figure, self.tried + note

    @property
    def mark(self) -> str:
        """Text after the last column."""
        return "  FAILED" if not self.passed else "  (known limit)" if self.is_known_limit else ""


class Table(GrowingTable[Row]):
    """A table that grows row by row."""

    # long texts come last, so that the numbers stay aligned
    header = ("case", "count", "worst", "limit", "worst of", "tried")
    formats = ("16", ">8", ">8", ">8", "48", "")
    gap = "  "

    def summarise(self, seconds: float) -> None:
        """Print how many passed, which failed and which could not run."""
        print(f"{_verdict(self.rows)}; {seconds:.0f} s", file=self.stream)
        for row in self.rows:
            if not row.passed:
                print(f"  failed: {row.case}, {row.tried}: {row.figure}; limit: {row.reason}", file=self.stream)
        for part in self.not_run:
            print(f"  not run: {part.case}: {part.reason}", file=self.stream)


def _verdict(rows: Sequence[Row]) -> str:
    passed = [row for row in rows if row.passed]
    known = sum(row.is_known_limit for row in passed)
    return f"{len(passed)} of {len(rows)} pass" + (f", {known} of them at known limits" if known else "")


def stress_report(table: Table, is_quick: bool) -> Report:
    """Return the table as a report, with the reasons of the limits."""
    blocks: list[Block] = [Paragraph(f"{_verdict(table.rows)}{', in the short form' if is_quick else ''}.")]
    blocks += [Paragraph(f"failed: {row.case}, {row.tried}", warning=True) for row in table.rows if not row.passed]
    blocks += [Paragraph(f"not run: {part.case}: {part.reason}", warning=True) for part in table.not_run]
    header = (*Table.header[1:], "reason for the limit", "seconds", "passed")
    for name, group in groupby(table.rows, key=lambda row: row.case):
        cells = [(*row.texts[1:], row.reason, f"{row.seconds:.1f}", "yes" if row.passed else "NO") for row in group]
        blocks += [Heading(name), ReportTable(header, cells, True)]
    return Report("Stress tests of kanefe", tuple(blocks))
