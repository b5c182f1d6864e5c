"""Definition of a stress case: extreme inputs that are tried many times, and the largest error allowed."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

KNOWN_LIMIT = "known limit: "


@dataclass(frozen=True)
class Finding:
    """Worst result of one series of trials: one line of the table.

    Attributes
    ----------
    tried : str
        What was tried.
    count : int
        Number of trials: states, scenes, runs or steps, see `tried`.
    figure : str
        What `worst` measures, with its unit, or "relative".
    worst, limit : float
        The largest value of all trials, and the largest that passes.
    reason : str
        Reason for the limit; begins with `KNOWN_LIMIT` where the limit is wider than desirable.
    note : str
        Further information, such as the method.
    """

    tried: str
    count: int
    figure: str
    worst: float
    limit: float
    reason: str
    note: str = ""

    @property
    def passed(self) -> bool:
        """Whether the worst value is within its limit; nan is not."""
        return bool(self.worst <= self.limit)

    @property
    def is_known_limit(self) -> bool:
        """Whether the limit is known to be wider than desirable."""
        return self.reason.startswith(KNOWN_LIMIT)

    @classmethod
    def of(
        cls, tried: str, figures: Sequence[float] | np.ndarray, figure: str, limit: float, reason: str, note: str = ""
    ) -> Finding:
        """Return the finding of several values; if one is not finite, the worst is nan.

        Raises
        ------
        ValueError
            If there are no values.

        Examples
        --------
        >>> Finding.of("angles near a turn", [1e-15, 3e-15], "error [rad]", 1e-12, "round-off").worst
        3e-15
        """
        values = np.asarray(figures, dtype=float).ravel()
        if not values.size:
            raise ValueError(f"{tried}: nothing was tried")
        worst = float(values.max()) if np.all(np.isfinite(values)) else float("nan")
        return cls(tried, values.size, figure, worst, limit, reason, note)


@dataclass(frozen=True)
class Effort:
    """Extent of the trials.

    Attributes
    ----------
    is_quick : bool
        Whether to run the short form, for the ordinary tests; it contains every kind of trial.
    method : str or None
        Method of the long runs of `kanefe.checks.robustness.drift`; None: all that suit long runs.
    """

    is_quick: bool = False
    method: str | None = None

    def count(self, full: int, quick: int) -> int:
        """Return the number of trials, for the full or the short form."""
        return quick if self.is_quick else full


@dataclass(frozen=True)
class StressCase:
    """A stress case.

    Attributes
    ----------
    name : str
        Name on the command line.
    title : str
        What is tested, in a few words.
    run : callable
        Effort -> findings, yielded one by one.
    """

    name: str
    title: str
    run: Callable[[Effort], Iterator[Finding]]
