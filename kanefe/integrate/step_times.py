"""How long the steps of a run take by the wall clock, for what has to keep up with it."""

from __future__ import annotations

import ctypes
import time

import numpy as np

from kanefe.kernels.steppers.step_times import AT, CLASSES_PER_OCTAVE, PLACES, add_length

SHARE = 0.999
"""Share of the steps that take no longer than the time that is told."""


class StepTimes:
    """Lengths of steps, which compiled code or `add` counts.

    Attributes
    ----------
    places : ndarray of int
        See `kanefe.kernels.steppers.step_times`.
    """

    def __init__(self) -> None:
        self.places = np.zeros(PLACES, dtype=np.int64)

    def start_clock(self) -> None:
        """Have compiled code count from here on; where the system has no such clock it counts nothing."""
        try:
            clock = ctypes.CDLL(None).clock_gettime
        except (AttributeError, OSError, TypeError):
            return
        self.places[AT.clock] = ctypes.cast(clock, ctypes.c_void_p).value or 0
        self.places[AT.clock_number], self.places[AT.last_look] = time.CLOCK_MONOTONIC, 0

    def add(self, seconds: float) -> None:
        """Count a step."""
        add_length(self.places, int(1e9 * seconds))

    @property
    def told(self) -> list[float]:
        """The time that 99.9 % of the steps did not exceed, to 4 %, and the longest, s; empty without steps."""
        count, longest = int(self.places[AT.counted]), 1e-9 * float(self.places[AT.longest])
        if count == 0:
            return []
        number = int(np.searchsorted(np.cumsum(self.places[AT.first_class :]), SHARE * count))
        return [min(1e-9 * 2.0 ** ((number + 1) / CLASSES_PER_OCTAVE), longest), longest]
