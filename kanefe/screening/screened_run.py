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
    """A run of which only windows were integrated, returned by `screen`.

    Attributes
    ----------
    result : Result
        As of a full run, at the same output times. The work of friction and damping is known in windows only, so that
        the energy balance is NaN.
    windows : tuple of (float, float)
        The integrated intervals, s.
    reasons : tuple of str
        For each window, the event that came near, or the reason why superposition was not possible.
    bound : dict of str to float
        Largest error bound of the function of each event, in its unit.
    grazing : dict of str to int
        Number of events by name that exceed their limit by less than a millionth: a full run may not have them.
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
