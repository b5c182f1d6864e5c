"""Drives of a sampled controller that grow from sample to sample by one factor, as those of an unstable loop do."""

from __future__ import annotations

from bisect import bisect_left
from typing import NamedTuple

import numpy as np

from kanefe.kernels.steppers.sampling import LIMITS

GROWN, EARLY, LATE = 10.0, 1e3, 1e6
"""Growth of the drives, in multiples of their initial changes: at which a run that ends for another reason names the
controller, at which a warning is issued, and at which the run ends."""

ALIKE = 2.0
"""Ratio of the longest to the shortest of three times in which changes grow by the same factor: for a polynomial over
time it is more than five, for a jump infinite."""


class Grown(NamedTuple):
    """A drive whose changes have grown: its number, how many times, and the change of now."""

    drive: int
    times: float
    change: float


class DriveGrowth:
    """The largest changes so far of the drives of a controller, of samples that `take` is given."""

    def __init__(self, drives: int) -> None:
        self._count = 0
        self._last = np.zeros((0, drives))
        self._first = [0.0] * drives
        self._largest: list[list[float]] = [[] for _ in range(drives)]
        self._when: list[list[int]] = [[] for _ in range(drives)]

    def take(self, drives: np.ndarray) -> None:
        """Take the drives of some samples, (K, drives)."""
        first = self._count + 1 - len(self._last)  # the sample of the first change
        changes = np.abs(np.diff(np.concatenate((self._last, drives)), axis=0))
        for drive, own in enumerate(changes.T):
            largest, when = self._largest[drive], self._when[drive]
            self._first[drive] = max(self._first[drive], *own[: max(LIMITS.few_samples + 1 - first, 0)].tolist(), 0.0)
            before = np.maximum.accumulate(np.append(largest[-1:] or [0.0], own))[:-1]
            grown = np.flatnonzero(own > before)
            largest += own[grown].tolist()
            when += (first + grown).tolist()
        self._count += len(drives)
        self._last = drives[-1:].copy()

    def grown(self, times: float) -> Grown | None:
        """Return a drive whose changes have grown so many times, lately by one factor from sample to sample.

        The times in which they grew by each third of that, in powers, must be alike.
        """
        for drive, (largest, when) in enumerate(zip(self._largest, self._when, strict=True)):
            first = max(self._first[drive], largest[0]) if largest else 0.0
            if not first or largest[-1] < times * first:
                continue
            for factor in (times, largest[-1] / first):
                passed = [when[bisect_left(largest, largest[-1] / factor**share)] for share in (1.0, 2 / 3, 1 / 3, 0.0)]
                spans = np.diff(passed)
                if spans.min() > 0 and spans.max() <= ALIKE * spans.min() + 1.0:
                    return Grown(drive, largest[-1] / first, largest[-1])
        return None
