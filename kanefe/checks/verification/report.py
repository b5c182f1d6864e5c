"""Output of verification results: a table that grows as they are known."""

from __future__ import annotations

from dataclasses import asdict, dataclass

from kanefe.checks.table import GrowingTable
from kanefe.checks.verification.case import Check


@dataclass(frozen=True)
class Row:
    """One line of the table and one object of the JSON list: see `kanefe.checks.verification.case.Check`.

    Attributes
    ----------
    seconds : float
        Time from the previous row to this one, s.
    """

    case: str
    quantity: str
    value: float
    reference: float
    error: float
    tolerance: float
    seconds: float
    passed: bool

    @classmethod
    def of(cls, case: str, check: Check, seconds: float) -> Row:
        """Return the row of a check that took some seconds."""
        return cls(case, **asdict(check), seconds=seconds, passed=check.passed)

    @property
    def texts(self) -> tuple[str, ...]:
        """The cells of the row as texts."""
        values = f"{self.value:.10g}", f"{self.reference:.10g}"
        return self.case, self.quantity, *values, f"{self.error:.1e}", f"{self.tolerance:.1e}", f"{self.seconds:.2f}"

    @property
    def mark(self) -> str:
        """Text after the last column."""
        return "" if self.passed else "  MISSED"


class Table(GrowingTable[Row]):
    """A table that grows row by row."""

    header = ("case", "quantity", "value", "reference", "error", "tolerance", "seconds")
    formats = ("5", "92", ">16", ">16", ">8", ">9", ">7")

    def summarise(self, was_asked: bool, seconds: float) -> None:
        """Print how many passed, which missed and which could not run."""
        missed = [row for row in self.rows if not row.passed]
        count, cases = len(self.rows), len({row.case for row in self.rows})
        parts = [f"{count - len(missed)} of {count} quantities of {cases} cases pass"]
        if self.not_run:
            names = ", ".join(dict.fromkeys(part.case for part in self.not_run))
            counts = "requested, so this counts as a miss" if was_asked else "not counted as a miss"
            parts.append(f"not run or not completely run: {names} ({counts})")
        print(f"{'; '.join(parts)}; {seconds:.1f} s", file=self.stream)
        for row in missed:
            print(f"  missed: {row.case}, {row.quantity}", file=self.stream)
        for reason in dict.fromkeys(part.reason for part in self.not_run):
            print(f"  {reason}", file=self.stream)
