"""Drives of a sampled controller that grow from sample to sample by one factor, as those of an unstable loop do."""

from __future__ import annotations

from bisect import bisect_left
from typing import NamedTuple

import numpy as np

from kanefe.frames import Vector
from kanefe.kernels.steppers.sampling import FEW_SAMPLES

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
    """The largest changes so far of the drives of a controller, one call of `add` a sample."""

    def __init__(self, drives: int) -> None:
        self._count = 0
        self._last: list[float] = []
        self._first = [0.0] * drives
        self._largest: list[list[float]] = [[] for _ in range(drives)]
        self._when: list[list[int]] = [[] for _ in range(drives)]

    def add(self, values: Vector) -> None:
        """Take the drives of a sample."""
        given = values.tolist()  # of few numbers, each by itself is quicker
        for drive, last in enumerate(self._last):
            change, largest = abs(given[drive] - last), self._largest[drive]
            if self._count <= FEW_SAMPLES and change > self._first[drive]:
                self._first[drive] = change
            if change > (largest[-1] if largest else 0.0):
                largest.append(change)
                self._when[drive].append(self._count)
        self._count += 1
        self._last = given

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
