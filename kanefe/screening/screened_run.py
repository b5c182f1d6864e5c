"""Outputs of a screened run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from kanefe.result import Result


@dataclass(frozen=True, eq=False)
class ScreenedRun:
    """A run of which only windows were integrated; made by `screen`.

    Attributes
    ----------
    result : Result
        As of a whole run, at the same output times. What friction and damping took is known in windows only, so that
        its energy balance is not a number.
    windows : tuple of (float, float)
        What was integrated, s.
    reasons : tuple of str
        Of each window: what came near, or why nothing could be superposed.
    bound : dict of str to float
        By event: the largest bound of what was left out of what it looks at, in the unit of that.
    grazing : dict of str to int
        How many events of a name are there by less than a millionth: an unbroken run may have them or not.
    """

    result: Result
    windows: tuple[tuple[float, float], ...]
    reasons: tuple[str, ...]
    bound: Mapping[str, float]
    grazing: Mapping[str, int]

    @property
    def events(self) -> Mapping[str, np.ndarray]:
        """Times of all events by name, s."""
        return self.result.events

    @property
    def share(self) -> float:
        """Share of the time that was integrated."""
        times = self.result.times
        return float(sum(end - begin for begin, end in self.windows) / (times[-1] - times[0]))

    def __str__(self) -> str:
        count = sum(map(len, self.events.values()))
        what = f"{len(self.windows)} windows" if len(self.windows) != 1 else "1 window"
        return f"{count} events; {what} integrated, {100 * self.share:.3g} % of {self.result.times[-1]:.6g} s"
