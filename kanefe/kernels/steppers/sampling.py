"""Sampled controllers in a run: what is due, what they read, drives that act later, and a log of all that.

A run stays in compiled code over its samples where the functions of its controllers are compiled; those in Python are
asked for one by one.
"""

from typing import NamedTuple

import numpy as np

from kanefe.kernels.compiler.arrays import IntegerRows, Integers, Prepared, RealRows, Reals
from kanefe.kernels.events.closing_call import ClosingCall, close_at
from kanefe.kernels.language import Record, Rows, call_address, copy, entry, inlined, kernel
from kanefe.kernels.steppers.step_commands import Command, Run, begin_at, is_finite, step_of


class Limits(NamedTuple):
    """From where on times of samples count."""

    end_share: float = 1e-9
    """Time between a sample and the end of a run, relative to the sampling interval, below which the sample is
    skipped."""
    few_samples: int = 3
    """Number of first samples of a controller with whose changes of the drives later ones are compared."""
    ulps: float = 16.0 * float(np.finfo(float).eps)
    """Smallest step relative to a time."""


LIMITS = Limits()


class Sampled(Record):
    """A controller. Its sample k whose drives act later has the row ``first_late + k % late_room`` of `late`."""

    first_read: int
    reads: int
    first_drive: int
    drives: int
    first_memory: int
    address: int  # of its function; 0: that is in Python
    count: int  # samples taken
    first_late: int
    late_room: int
    late_done: int
    row: int  # of the log, of the sample that is being taken; below zero without
    first_change: int  # row of `changes`
    start: float  # s
    every: float
    delay: float
    level: float  # by which factor a drive may change more than at first before Python looks at it


class Controllers(Rows[Sampled]):
    """All controllers."""


class Progress(Record):
    """How far sampling has come."""

    asked: int  # the controller whose function is next, -1 where nothing is sampled
    logged: int  # rows of the log and of `acted`
    acted: int
    is_alarmed: bool  # a drive has changed by more than its level
    is_closed: bool  # the loops where a sample is due
    end: float  # of the run, s
    together: float  # time difference below which samples are simultaneous, s


# Columns of the log: the controller, the time, and from here on what it read, then its drives
BY, AT_TIME, VALUES = range(3)


class Samples(NamedTuple):
    """The sampled controllers of a run.

    Attributes
    ----------
    controllers : ndarray of int
    times : ndarray
        Of `Controllers`.
    progress : ndarray of int
    limits : ndarray
        Of `Progress`.
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


@inlined
def controllers_of(samples: Samples) -> Controllers:
    """Return the controllers."""
    return Controllers(samples.controllers, samples.times)


@inlined
def progress_of(samples: Samples) -> Progress:
    """Return how far sampling has come."""
    return Progress(samples.progress, samples.limits)


@inlined
def _late_row(own: Sampled, sample: int) -> int:
    """Return the row of the drives of a sample."""
    return own.first_late + sample % own.late_room


@kernel
def next_sample(samples: Samples) -> float:
    """Return when the next sample is, or drives begin to act, s; the end of the run if there is none before."""
    controllers, end = controllers_of(samples), progress_of(samples).end
    found = float(end)
    for c in range(len(controllers)):
        own = controllers[c]
        t = own.start + own.count * own.every
        if t < end - LIMITS.end_share * own.every:
            found = min(found, t)
        if own.late_done < own.count:
            found = min(found, float(samples.late[_late_row(own, own.late_done), 0]))
    return found


@kernel
def go_on_sampling(samples: Samples, t: float, y: np.ndarray) -> int:
    """Do what is due at a time; return the controller whose function Python has to call, -1: all is done, in y too."""
    progress, controllers = progress_of(samples), controllers_of(samples)
    if progress.asked < 0:  # all read what was before any of them drove
        for c in range(len(controllers)):
            _read(samples, c, t, y)
        progress.asked = 0
    while progress.asked < len(controllers):
        if not _has_called(samples, controllers[progress.asked], t):
            return progress.asked
        progress.asked += 1
    for c in range(len(controllers)):
        _drive(samples, controllers[c], t, y)
    samples.acted[progress.acted, 0] = t
    for i in range(samples.acted.shape[1] - 1):
        samples.acted[progress.acted, 1 + i] = y[samples.first_state + i]
    progress.acted += 1
    progress.asked = -1
    return -1


@kernel
def _has_called(samples: Samples, own: Sampled, t: float) -> bool:
    """Call the function of a controller whose sample is due; return whether that was possible and gave numbers."""
    if own.row < 0:
        return True
    if own.address == 0:
        return False
    row = samples.log[own.row]
    drives = row[samples.drives_at :]
    call_address(own.address, (t, row[VALUES:], samples.memory[own.first_memory :], drives))
    return is_finite(drives[: own.drives])


@kernel
def _read(samples: Samples, c: int, t: float, y: np.ndarray) -> None:
    """Begin a row of the log with what a controller reads, if its sample is due."""
    own, progress = controllers_of(samples)[c], progress_of(samples)
    at = own.start + own.count * own.every
    own.row = -1
    if at > t + progress.together or at >= progress.end - LIMITS.end_share * own.every:
        return
    own.row = progress.logged
    progress.logged += 1
    row = samples.log[own.row]
    row[BY], row[AT_TIME] = c, t
    for i in range(own.reads):
        found = 0.0
        for k in range(samples.read_at[own.first_read + i], samples.read_at[own.first_read + i + 1]):
            found += samples.read_by[k] * y[samples.read_of[k]]
        row[VALUES + i] = found


@kernel
def _drive(samples: Samples, own: Sampled, t: float, y: np.ndarray) -> None:
    """Write the drives of a controller that begin to act, and keep those that do so later."""
    late, first, progress = samples.late, own.first_drive, progress_of(samples)
    while own.late_done < own.count:
        waiting = late[_late_row(own, own.late_done)]
        if waiting[0] > t + progress.together:
            break
        for i in range(own.drives):
            y[first + i] = waiting[1 + i]
        own.late_done += 1
    if own.row < 0:
        return
    given, waiting = samples.log[own.row][samples.drives_at :], late[_late_row(own, own.count)]
    for i in range(own.drives):
        seen = samples.changes[own.first_change + i]
        change = abs(given[i] - seen[0]) if own.count > 0 else 0.0
        if own.count <= LIMITS.few_samples or seen[1] == 0.0:
            seen[1] = max(seen[1], change)
        elif change >= own.level * seen[1]:
            progress.is_alarmed = True
        seen[0] = waiting[1 + i] = given[i]
        if own.delay == 0.0:
            y[first + i] = given[i]
    waiting[0] = t + own.delay
    own.count += 1
    if own.delay == 0.0:
        own.late_done = own.count


@entry()
def sample_at(samples: Samples, t: float, y: Reals) -> int:
    """Do the same for a loop in Python: see `go_on_sampling`."""
    return go_on_sampling(samples, t, y)


@entry()
def pass_samples(
    going: Prepared, command_at: int, samples: Samples, closing: ClosingCall, inputs: Reals, run: Run
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

    Returns
    -------
    int
        What the method wants; SAMPLE: a function is to be called, and if none is asked for, the log to be emptied.
    """
    step, progress, most = step_of(run), progress_of(samples), len(samples.controllers)
    while True:
        if progress.asked < 0:
            target = next_sample(samples)
            if target > step.time or step.time >= progress.end:
                step.stop, step.smallest = target, max(step.smallest, LIMITS.ulps * abs(target))
                call_address(going.address, (going.places, going.numbers))
                command = int(going.numbers[command_at])
                if command != Command.DONE or step.time >= progress.end:
                    return command
            if progress.logged + most > len(samples.log) or progress.acted == len(samples.acted):
                return Command.SAMPLE.value
            if closing.has_loops and not progress.is_closed:
                progress.is_closed = True
                if not close_at(closing, step.time, step.share_stiffness, step.state):
                    return Command.PROJECT.value
        if go_on_sampling(samples, step.time, step.state) >= 0:
            return Command.SAMPLE.value
        _go_on_behind(samples, inputs, run)
        if progress.is_alarmed:
            return Command.SAMPLE.value


@kernel
def _go_on_behind(samples: Samples, inputs: np.ndarray, run: Run) -> None:
    """Let a run go on with other drives."""
    step, held = step_of(run), samples.held
    y, stored = step.state, step.stored
    progress_of(samples).is_closed, step.to_event = False, np.inf
    begin_at(step, step.time)
    step.continues = True
    for i in range(len(held)):
        inputs[held[i, 0]] = samples.factors[i] * y[held[i, 1]]
    if stored > 0 and run.times[stored - 1] == step.time:
        copy(y, run.states[stored - 1])
