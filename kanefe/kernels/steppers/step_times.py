"""How long steps take by the wall clock: their count, the longest, and a histogram from which a quantile is read.

The clock is a C function of the system that is called by its address: kernels need no Python for it.
"""

from typing import NamedTuple

import numpy as np

from kanefe.kernels.language import Integers, call_address, kernel


class ClockPlaces(NamedTuple):
    """Where numbers of steps are."""

    clock: int = 0  # address of the clock, 0: none
    clock_number: int = 1
    seconds: int = 2  # what it writes
    nanoseconds: int = 3
    last_look: int = 4  # its time, ns, 0: none
    counted: int = 5  # steps
    longest: int = 6  # of them, ns
    first_class: int = 7  # steps in each class of lengths


AT = ClockPlaces()

CLASSES_PER_OCTAVE, OCTAVES = 16, 40
"""Classes of lengths: of each the longest is 1.044 times the shortest, up to 1100 s."""

PLACES = AT.first_class + CLASSES_PER_OCTAVE * OCTAVES


@kernel
def add_length(times: Integers, nanoseconds: int) -> None:
    """Count a step of a length."""
    times[AT.counted] += 1
    times[AT.longest] = max(times[AT.longest], nanoseconds)
    found = int(CLASSES_PER_OCTAVE * np.log2(max(nanoseconds, 1)))
    times[AT.first_class + min(found, CLASSES_PER_OCTAVE * OCTAVES - 1)] += 1


@kernel
def look_at_clock(times: Integers, is_step: bool) -> None:
    """Look at the clock; at the end of a step count it."""
    call_address(times[AT.clock], (times[AT.clock_number], times[AT.seconds : AT.last_look]))
    now = 1_000_000_000 * times[AT.seconds] + times[AT.nanoseconds]
    if is_step:
        add_length(times, now - times[AT.last_look])
    times[AT.last_look] = now
