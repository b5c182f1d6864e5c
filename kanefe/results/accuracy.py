"""Accuracy: how wrong an answer may be, of what, what was chosen and what it cost."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True, eq=False)
class SourceOfError:
    """A line of the table: what is left of a source.

    Attributes
    ----------
    name : str
        Such as "modes of arm".
    chosen : str
        Its level in the answer.
    errors : ndarray, shape (quantities,)
        What is left of it, with the safety, in the units of the quantities; nan where no pair has measured it.
    ratio : float
        Ratio of the errors of two levels, as three levels show it; nan where it is assumed.
    levels : tuple of str
        Those that were evaluated.
    apart : ndarray, shape (pairs, quantities)
        Differences between them, as pairs measured them.
    note : str
        What there is to say, such as why it was not varied.
    """

    name: str
    chosen: str
    errors: np.ndarray
    ratio: float = np.nan
    levels: tuple[str, ...] = ()
    apart: np.ndarray = field(default_factory=lambda: np.zeros((0, 0)))
    note: str = ""


@dataclass(frozen=True, eq=False)
class Accuracy:
    """How wrong an answer may be; ``print(result.accuracy)`` shows a table.

    Attributes
    ----------
    quantities : tuple of str
    units : tuple of str
        Empty for functions.
    sizes : ndarray, shape (quantities,)
        Largest magnitudes, in these units.
    allowed : ndarray, shape (quantities,)
        Largest errors that were asked for.
    bounds : ndarray, shape (quantities,)
        Bounds of the errors; inf where pairs contradict each other.
    is_met : bool
        Whether every bound is at most what is allowed.
    reason : str
        Why not.
    sources : tuple of SourceOfError
        The largest first; those that were not varied last.
    effectivity : float
        Of a pair that was measured again at the final levels of the other sources, relative to what was stated; nan if
        none was.
    checked : str
        The same in words.
    evaluations : int
    seconds, last_seconds : float
        CPU time of all evaluations, and of that of the answer with the making of its bodies, s.
    setting : str
        The setting of the answer, as code to paste.
    cheapest : str
        The cheapest setting whose bound, by the same pairs, is enough.
    """

    quantities: tuple[str, ...]
    units: tuple[str, ...]
    sizes: np.ndarray
    allowed: np.ndarray
    bounds: np.ndarray
    is_met: bool
    reason: str
    sources: tuple[SourceOfError, ...]
    effectivity: float
    checked: str
    evaluations: int
    seconds: float
    last_seconds: float
    setting: str
    cheapest: str

    @property
    def work(self) -> float:
        """CPU time of all evaluations, relative to that of the answer."""
        return self.seconds / max(self.last_seconds, 1e-9)

    def __str__(self) -> str:
        head = "accuracy met" if self.is_met else f"accuracy not met: {self.reason}"
        lines = [head, *self._of_quantities(), "", *self._of_sources(), ""]
        lines.append(
            f"{self.evaluations} evaluations, {self.seconds:.3g} s of CPU: {self.work:.2g} times that of the answer; "
            f"checked: {self.checked or 'no'}"
        )
        for title, code in (("setting", self.setting), ("cheapest setting that is enough", self.cheapest)):
            if code:
                lines += [f"{title}:", *(f"    {line}" for line in code.splitlines())]
        return "\n".join(lines)

    def _of_quantities(self) -> list[str]:
        rows: list[tuple[str, ...]] = [("quantity", "size", "bound", "relative", "allowed")]
        for i, name in enumerate(self.quantities):
            unit, size = self.units[i], self.sizes[i]
            share = f"{self.bounds[i] / size:.1e}" if size > 0.0 else "-"
            numbers = (f"{value:.3g} {unit}".strip() for value in (size, self.bounds[i]))
            rows.append((name, *numbers, share, f"{self.allowed[i]:.3g} {unit}".strip()))
        return _table(rows)

    def _of_sources(self) -> list[str]:
        """Return a row for each source: the part of what is allowed that it takes of the worst quantity."""
        rows: list[tuple[str, ...]] = [("source", "chosen", "error / allowed", "falls by", "note")]
        for source in self.sources:
            share = np.max(source.errors / self.allowed) if len(source.errors) else np.nan
            falls = f"1/{1.0 / source.ratio:.2g}" if source.ratio > 0.0 else ""
            error = f"{share:.2g}" if np.isfinite(share) else "not measured"
            rows.append((source.name, source.chosen, error, falls, source.note))
        return _table(rows)


def _table(rows: list[tuple[str, ...]]) -> list[str]:
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    return [
        "  " + "  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip() for row in rows
    ]
