"""Sampled controllers in a run: what is due, what they read, drives that act later, and a log of all that.

A run stays in compiled code over its samples where the functions of its controllers are compiled; those in Python are
asked for one by one.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kanefe.kernels.compiler._numba import kernel
from kanefe.kernels.compiler.arrays import IntegerRows, Integers, Prepared, RealRows, Reals
from kanefe.kernels.compiler.calls import call_address
from kanefe.kernels.compiler.entries import entry
from kanefe.kernels.events.closing_call import ClosingCall, close_at
from kanefe.kernels.steppers.step_commands import (
    CONTINUES,
    DONE,
    PROJECT,
    SAMPLE,
    SHARE_STIFFNESS,
    SMALLEST,
    STATE,
    STOP,
    STORED,
    TIME,
    TO_EVENT,
    Run,
    begin_at,
)

END_SHARE = 1e-9
"""Time between a sample and the end of a run, relative to the sampling interval, below which the sample is skipped."""

FEW_SAMPLES = 3
"""Number of first samples of a controller with whose changes of the drives later ones are compared."""

ULPS = 16.0 * np.finfo(float).eps
"""Smallest step relative to a time."""

# Columns of `Samples.controllers`. Sample k whose drives act later has the row FIRST_LATE + k % LATE_ROOM of `late`.
(
    FIRST_READ,
    READS,
    FIRST_DRIVE,
    DRIVES,
    FIRST_MEMORY,
    ADDRESS,
    COUNT,
    FIRST_LATE,
    LATE_ROOM,
    LATE_DONE,
    ROW,
    FIRST_CHANGE,
) = range(12)

# Columns of `Samples.times`: the first sample, the time between samples, the delay (all in s), and by which factor a
# drive may change more than at first before Python looks at it
START, EVERY, DELAY, LEVEL = range(4)

# Places in `Samples.progress`: the controller whose function is next, -1 where nothing is sampled; rows of the log and
# of `acted`; whether a drive has changed by more than LEVEL; whether the loops are closed where a sample is due
ASKED, LOGGED, ACTED, IS_ALARMED, IS_CLOSED = range(5)

# Places in `Samples.limits`: the end of the run, and the time difference below which samples are simultaneous, s
END, TOGETHER = range(2)

# Columns of the log: the controller, the time, and from here on what it read, then its drives
BY, AT_TIME, VALUES = range(3)


class Samples(NamedTuple):
    """The sampled controllers of a run.

    Attributes
    ----------
    controllers : ndarray of int
        A row each, with the columns above.
    times : ndarray
        Likewise.
    progress : ndarray of int
    limits : ndarray
    read_at : ndarray of int, shape (reads + 1,)
        Where the terms of each reading begin.
    read_of : ndarray of int
        Place in the state of each term.
    read_by : ndarray
        Its factor.
    memory : ndarray
        Of compiled functions.
    late : ndarray, shape (rows, 1 + most drives)
        When drives act, s, and they.
    changes : ndarray, shape (drives, 2)
        The last value of each drive, and its largest change at first.
    log : ndarray, shape (rows, VALUES + most reads + most drives)
    drives_at : int
        Where the drives are in a row of the log.
    acted : ndarray, shape (rows, 1 + states)
        The times at which drives began to act, and the states of loads from then on.
    held : ndarray of int, shape (n, 2)
        Places in the values of loads, and in the state, of what is held.
    factors : ndarray, shape (n,)
    """

    controllers: IntegerRows
    times: RealRows
    progress: Integers
    limits: Reals
    read_at: Integers
    read_of: Integers
    read_by: Reals
    memory: Reals
    late: RealRows
    changes: RealRows
    log: RealRows
    drives_at: int
    acted: RealRows
    first_state: int
    held: IntegerRows
    factors: Reals


@kernel
def next_sample(samples: Samples) -> float:
    """Return when the next sample is, or drives begin to act, s; the end of the run if there is none before."""
    found = samples.limits[END]
    for c in range(len(samples.controllers)):
        own, times = samples.controllers[c], samples.times[c]
        t = times[START] + own[COUNT] * times[EVERY]
        if t < samples.limits[END] - END_SHARE * times[EVERY]:
            found = min(found, t)
        if own[LATE_DONE] < own[COUNT]:
            found = min(found, samples.late[own[FIRST_LATE] + own[LATE_DONE] % own[LATE_ROOM], 0])
    return found


@kernel
def go_on_sampling(samples: Samples, t: float, y: np.ndarray) -> int:
    """Do what is due at a time; return the controller whose function Python has to call, -1: all is done, in y too."""
    progress, log, drives_at = samples.progress, samples.log, samples.drives_at
    if progress[ASKED] < 0:  # all read what was before any of them drove
        for c in range(len(samples.controllers)):
            _read(samples, c, t, y)
        progress[ASKED] = 0
    while progress[ASKED] < len(samples.controllers):
        own = samples.controllers[progress[ASKED]]
        if own[ROW] >= 0:
            if own[ADDRESS] == 0:
                return progress[ASKED]
            drives = log[own[ROW]][drives_at:]
            call_address(own[ADDRESS], (t, log[own[ROW]][VALUES:], samples.memory[own[FIRST_MEMORY] :], drives))
            for i in range(own[DRIVES]):
                if not abs(drives[i]) < np.inf:
                    return progress[ASKED]
        progress[ASKED] += 1
    for c in range(len(samples.controllers)):
        _drive(samples, c, t, y)
    samples.acted[progress[ACTED], 0] = t
    for i in range(samples.acted.shape[1] - 1):
        samples.acted[progress[ACTED], 1 + i] = y[samples.first_state + i]
    progress[ACTED] += 1
    progress[ASKED] = -1
    return -1


@kernel
def _read(samples: Samples, c: int, t: float, y: np.ndarray) -> None:
    """Begin a row of the log with what a controller reads, if its sample is due."""
    own, times, progress = samples.controllers[c], samples.times[c], samples.progress
    at = times[START] + own[COUNT] * times[EVERY]
    own[ROW] = -1
    if at > t + samples.limits[TOGETHER] or at >= samples.limits[END] - END_SHARE * times[EVERY]:
        return
    own[ROW] = progress[LOGGED]
    progress[LOGGED] += 1
    row = samples.log[own[ROW]]
    row[BY], row[AT_TIME] = c, t
    for i in range(own[READS]):
        found = 0.0
        for k in range(samples.read_at[own[FIRST_READ] + i], samples.read_at[own[FIRST_READ] + i + 1]):
            found += samples.read_by[k] * y[samples.read_of[k]]
        row[VALUES + i] = found


@kernel
def _drive(samples: Samples, c: int, t: float, y: np.ndarray) -> None:
    """Write the drives of a controller that begin to act, and keep those that do so later."""
    own, times, late = samples.controllers[c], samples.times[c], samples.late
    first = own[FIRST_DRIVE]
    while own[LATE_DONE] < own[COUNT]:
        waiting = late[own[FIRST_LATE] + own[LATE_DONE] % own[LATE_ROOM]]
        if waiting[0] > t + samples.limits[TOGETHER]:
            break
        for i in range(own[DRIVES]):
            y[first + i] = waiting[1 + i]
        own[LATE_DONE] += 1
    if own[ROW] < 0:
        return
    given, waiting = samples.log[own[ROW]][samples.drives_at :], late[own[FIRST_LATE] + own[COUNT] % own[LATE_ROOM]]
    for i in range(own[DRIVES]):
        seen = samples.changes[own[FIRST_CHANGE] + i]
        change = abs(given[i] - seen[0]) if own[COUNT] > 0 else 0.0
        if own[COUNT] <= FEW_SAMPLES or seen[1] == 0.0:
            seen[1] = max(seen[1], change)
        elif change >= times[LEVEL] * seen[1]:
            samples.progress[IS_ALARMED] = 1
        seen[0] = waiting[1 + i] = given[i]
        if times[DELAY] == 0.0:
            y[first + i] = given[i]
    waiting[0] = t + times[DELAY]
    own[COUNT] += 1
    if times[DELAY] == 0.0:
        own[LATE_DONE] = own[COUNT]


@entry()
def sample_at(samples: Samples, t: float, y: Reals) -> int:
    """Do the same for a loop in Python: see `go_on_sampling`."""
    return go_on_sampling(samples, t, y)


@entry()
def pass_samples(
    going: Prepared, command_at: int, samples: Samples, closing: ClosingCall, inputs: Reals, run: Run, vectors: RealRows
) -> int:
    """Continue with a run over its samples, until one needs Python, or as `integrate` does.

    Parameters
    ----------
    going : Prepared
        A call of `kanefe.kernels.steppers.integration.integrate`.
    command_at : int
        Where in its numbers the command is.
    samples : Samples
    closing : ClosingCall
        What closes the loops of the states that are sampled.
    inputs : ndarray
        Values of loads.
    run : Run
    vectors : ndarray, shape (vectors of the method, state)

    Returns
    -------
    int
        What the method wants; SAMPLE: the function ASKED is to be called, and if that is -1, the log to be emptied.
    """
    reals, y, progress, most = run.reals, vectors[STATE], samples.progress, len(samples.controllers)
    while True:
        if progress[ASKED] < 0:
            target = next_sample(samples)
            if target > reals[TIME] or reals[TIME] >= samples.limits[END]:
                reals[STOP], reals[SMALLEST] = target, max(reals[SMALLEST], ULPS * abs(target))
                call_address(going.address, (going.places, going.numbers))
                command = int(going.numbers[command_at])
                if command != DONE or reals[TIME] >= samples.limits[END]:
                    return command
            if progress[LOGGED] + most > len(samples.log) or progress[ACTED] == len(samples.acted):
                return SAMPLE
            if closing.has_loops and progress[IS_CLOSED] == 0:
                progress[IS_CLOSED] = 1
                if not close_at(closing, reals[TIME], reals[SHARE_STIFFNESS], y):
                    return PROJECT
        if go_on_sampling(samples, reals[TIME], y) >= 0:
            return SAMPLE
        progress[IS_CLOSED], reals[TO_EVENT] = 0, np.inf
        begin_at(run.integers, reals, reals[TIME])
        run.integers[CONTINUES] = 1
        for i in range(len(samples.held)):
            inputs[samples.held[i, 0]] = samples.factors[i] * y[samples.held[i, 1]]
        stored = run.integers[STORED]
        if stored > 0 and run.times[stored - 1] == reals[TIME]:
            for i in range(len(y)):
                run.states[stored - 1, i] = y[i]
        if progress[IS_ALARMED] != 0:
            return SAMPLE
