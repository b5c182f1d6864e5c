"""What skipping saves: each skip of a scene that needs less, timed with and without it, and that both agree."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from kanefe_fem.bench.clocks import Race

SAME = 1e-9
"""Largest difference of what both give, as a part of the largest number: other sums, rounded in other places."""


@dataclass(frozen=True)
class Skip:
    """A skip and what it saves.

    Attributes
    ----------
    what : str
        What is skipped, and where.
    timed : str
        Of what the times are.
    sparing, full : float
        CPU seconds with the skip and without it.
    difference : float
        Of the results, as a part of the largest number.
    """

    what: str
    timed: str
    sparing: float
    full: float
    difference: float

    @property
    def agrees(self) -> bool:
        """Whether both give the same."""
        return bool(self.difference <= SAME)

    def told(self) -> dict[str, Any]:
        """Return the skip as JSON has it."""
        return {**asdict(self), "saved": 1.0 - self.sparing / self.full, "agrees": self.agrees}


Clock = Callable[[], float]


def compared(what: str, timed: str, clocks: tuple[Clock, Clock], values: tuple[Any, Any], rounds: int) -> Skip:
    """Return a skip from its two clocks (s), with and without it, and what both give."""
    race = Race(*clocks, rounds)
    with_skip, without = (np.asarray(value, dtype=float).ravel() for value in values)
    difference = float(np.abs(with_skip - without).max() / np.abs(without).max())
    return Skip(what, timed, race.ours, race.theirs, difference)


def skips_table(rows: Sequence[Skip]) -> str:
    """Return the skips as a table for a terminal."""
    lines = [("skipped", "of", "with the skip", "without", "saved", "results differ by", "")]
    for row in rows:
        lines.append(
            (row.what, row.timed, _time(row.sparing), _time(row.full), f"{100 * (1 - row.sparing / row.full):.0f} %",
             f"{row.difference:.1e}", "" if row.agrees else "NO")
        )  # fmt: skip
    widths = [max(len(line[i]) for line in lines) for i in range(len(lines[0]))]
    return "\n".join("  ".join(c.ljust(w) for c, w in zip(line, widths, strict=True)).rstrip() for line in lines)


def _time(seconds: float) -> str:
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("us", 1e-6)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{1e9 * seconds:.3g} ns"
