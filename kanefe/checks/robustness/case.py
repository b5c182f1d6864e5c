"""What a stress case is: something extreme that is tried many times, and the worst figure that may come of it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

KNOWN_LIMIT = "known limit: "


@dataclass(frozen=True)
class Finding:
    """What came of one thing that was tried: one line of the table.

    Attributes
    ----------
    tried : str
        What was tried.
    count : int
        How many: states, scenes, runs or steps, as `tried` says.
    figure : str
        What the worst figure measures, with its unit, or "relative".
    worst, limit : float
        The worst figure of all, and the largest that passes.
    reason : str
        Why the limit is what it is; begins with `KNOWN_LIMIT` where it is wider than one would wish.
    note : str
        What else there is to say, such as the method.
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
        """Whether the worst figure is within its limit; one that is not a number is not."""
        return bool(self.worst <= self.limit)

    @property
    def is_known_limit(self) -> bool:
        """Whether what is promised here is less than one would wish, and that is known."""
        return self.reason.startswith(KNOWN_LIMIT)

    @classmethod
    def of(
        cls, tried: str, figures: Sequence[float] | np.ndarray, figure: str, limit: float, reason: str, note: str = ""
    ) -> Finding:
        """Return the finding of several figures, of which one that is not a number is the worst.

        Raises
        ------
        ValueError
            If there are none: what tries nothing shows nothing.

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
    """How much is tried.

    Attributes
    ----------
    is_quick : bool
        A short form, for the ordinary tests; every kind of thing is still tried.
    method : str or None
        Method of the long runs of `kanefe.checks.robustness.drift`; None: the best of those there are.
    """

    is_quick: bool = False
    method: str | None = None

    def count(self, full: int, quick: int) -> int:
        """Return how many of something to try."""
        return quick if self.is_quick else full


@dataclass(frozen=True)
class StressCase:
    """A stress case.

    Attributes
    ----------
    name : str
        By which it is asked for.
    title : str
        What is stressed, in a few words.
    run : callable
        Effort -> findings, yielded one by one as they are known.
    """

    name: str
    title: str
    run: Callable[[Effort], Iterator[Finding]]
