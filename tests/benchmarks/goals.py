"""Figures with goals: what a benchmark measured, whether the goal is met, and how both are shown."""

from __future__ import annotations

import json
import math
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

WIDTH = 100
"""Largest width of a remark in the table, in characters."""


@dataclass(frozen=True)
class Goal:
    """An upper limit that a figure should keep.

    Attributes
    ----------
    what : str
        What is measured, with its unit.
    limit : float
    """

    what: str
    limit: float

    @property
    def text(self) -> str:
        """The goal as it is shown."""
        return f"<= {self.limit:g}"

    def figure(self, value: float, remark: str = "") -> Figure:
        """Return what was measured; NaN never meets a goal."""
        return Figure(self.what, float(value), self.text, bool(value <= self.limit), remark)

    def skipped(self, reason: str) -> Figure:
        """Return the figure of what could not be measured: not met."""
        return Figure(self.what, f"skipped: {reason}", self.text, False)


@dataclass(frozen=True)
class Figure:
    """One measured figure.

    Attributes
    ----------
    what : str
        What was measured, with its unit.
    value : float or str
        The figure; a text where there is none, and why.
    goal : str
        What it should be.
    met : bool
    remark : str
        What the figure was made from; in the table only.
    """

    what: str
    value: float | str
    goal: str
    met: bool
    remark: str = ""


def median(values: Sequence[float]) -> float:
    """Return the middle value, or the mean of the two in the middle.

    Raises
    ------
    ValueError
        If there is none, or one is not finite: a clock that failed must not look like a fast run.
    """
    if not values or not all(math.isfinite(x) for x in values):
        raise ValueError(f"no median of {values!r}")
    ordered = sorted(values)
    middle = len(ordered) // 2
    return ordered[middle] if len(ordered) % 2 else 0.5 * (ordered[middle - 1] + ordered[middle])


def median_ratio(ours: Sequence[float], theirs: Sequence[float]) -> float:
    """Return the median of the ratios of runs that were made side by side.

    The clock of a shared machine drifts by more than the runs of a pair differ, so pairs are compared, not medians.

    Raises
    ------
    ValueError
        If the runs do not come in pairs, or a time is not positive.
    """
    if len(ours) != len(theirs) or not all(x > 0.0 for x in (*ours, *theirs)):
        raise ValueError(f"no ratio of {ours!r} to {theirs!r}")
    return median([a / b for a, b in zip(ours, theirs, strict=True)])


def shown(value: float | str) -> tuple[str, str]:
    """Return a value as a short text, numbers with three digits, and the reason that follows a colon in it."""
    if isinstance(value, str):
        text, _, reason = value.partition(": ")
        return text, reason
    return f"{value:.3g}", ""


def table(figures: Sequence[Figure]) -> str:
    """Return the figures as a table for a terminal; remarks and reasons stand below their figure."""
    rows, notes = [("what", "value", "goal", "met")], [""]
    for figure in figures:
        value, reason = shown(figure.value)
        rows.append((figure.what, value, figure.goal, "yes" if figure.met else "NO"))
        notes.append(reason or figure.remark)
    widths = [max(len(row[i]) for row in rows) for i in range(4)]
    lines = []
    for row, note in zip(rows, notes, strict=True):
        lines.append("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip())
        lines += [f"    {line}" for line in textwrap.wrap(note, WIDTH)]
    return "\n".join([*lines, f"{sum(figure.met for figure in figures)} of {len(figures)} goals met"])


def write_json(figures: Sequence[Figure], path: Path) -> None:
    """Write a list of {"what", "value", "goal", "met"}."""
    found = [{"what": f.what, "value": f.value, "goal": f.goal, "met": bool(f.met)} for f in figures]
    path.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
