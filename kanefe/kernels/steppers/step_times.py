"""How long steps take by the wall clock: their count, the longest, and a histogram from which a quantile is read.

The clock is a C function of the system that is called by its address: kernels need no Python for it.
"""

import numpy as np

from kanefe.kernels.language import Integers, call_address, kernel

# Places: address of the clock (0: none) and its number, what it writes, time of the last look (ns, 0: none), steps and
# the longest of them (ns), steps in each class of lengths
CLOCK, CLOCK_NUMBER, SECONDS, NANOSECONDS, LAST_LOOK, COUNTED, LONGEST, FIRST_CLASS = range(8)

CLASSES_PER_OCTAVE, OCTAVES = 16, 40
"""Classes of lengths: of each the longest is 1.044 times the shortest, up to 1100 s."""

PLACES = FIRST_CLASS + CLASSES_PER_OCTAVE * OCTAVES


@kernel
def add_length(times: Integers, nanoseconds: int) -> None:
    """Count a step of a length."""
    times[COUNTED] += 1
    times[LONGEST] = max(times[LONGEST], nanoseconds)
    found = int(CLASSES_PER_OCTAVE * np.log2(max(nanoseconds, 1)))
    times[FIRST_CLASS + min(found, CLASSES_PER_OCTAVE * OCTAVES - 1)] += 1


@kernel
def look_at_clock(times: Integers, is_step: bool) -> None:
    """Look at the clock; at the end of a step count it."""
    call_address(times[CLOCK], (times[CLOCK_NUMBER], times[SECONDS:LAST_LOOK]))
    now = 1_000_000_000 * times[SECONDS] + times[NANOSECONDS]
    if is_step:
        add_length(times, now - times[LAST_LOOK])
    times[LAST_LOOK] = now
