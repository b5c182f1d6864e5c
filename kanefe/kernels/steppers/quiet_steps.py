"""Runs that look out for events of loads: steps in which nothing happens are passed over without leaving compiled code.

What happens in a step that is not quiet is found by `kanefe.integrate.events.event_search`, which asks for values in
it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kanefe.kernels.algebra.vectors import copy
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.compiler.arrays import Filler, Prepared, RealBlocks, RealRows, Reals
from kanefe.kernels.compiler.calls import call_address
from kanefe.kernels.compiler.entries import entry
from kanefe.kernels.steppers.step_commands import ACCEPTED, STAGE, STATE, STEPS, STORED, TIME, TIME_OLD, Run
from kanefe.kernels.sweeps.drives import Drives, put_drives

LEAST_DIP = 0.3
"""Minimum of the parabola through three samples, relative to their largest, below which a pair of roots is searched."""

SHARES = np.arange(1, 5) / 4.0
"""Positions in a step at which functions are evaluated, relative to the step; the last is its end."""

AT_TIME = 0
"""Index of the time in a prepared call of `look_at`."""


class Going(NamedTuple):
    """A call of `kanefe.kernels.steppers.integration.integrate`.

    Attributes
    ----------
    call : Prepared
    most_at, command_at : int
        Where in its places the count of steps is at which it returns, and in its numbers the command.
    """

    call: Prepared
    most_at: int
    command_at: int


class Lookout(NamedTuple):
    """What a run needs that looks out for events.

    Attributes
    ----------
    looking : Prepared
        Call of `kanefe.kernels.loads.watching.watch_states` with the arrays below.
    shares : ndarray, shape (T,)
        Places in a step at which values are looked at, the last one its end, 1.
    motions : Drives
    fill : function (t, y, inputs)
    held : ndarray, shape (inputs,)
        Values of loads, those written that do not change in the run.
    times : ndarray, shape (T,)
    drives : ndarray, shape (T, driven, 3)
    inputs : ndarray, shape (T, inputs)
    states : ndarray, shape (T, state)
    found : ndarray, shape (T, values)
    """

    looking: Prepared
    shares: Reals
    motions: Drives
    fill: Filler
    held: Reals
    times: Reals
    drives: RealBlocks
    inputs: RealRows
    states: RealRows
    found: RealRows


@entry()
def pass_quiet_steps(going: Going, lookout: Lookout, run: Run, vectors: RealRows, before: Reals) -> tuple[int, bool]:
    """Continue with a run until something may have happened in its last step, or as `integrate` does.

    Parameters
    ----------
    going : Going
    lookout : Lookout
    run : Run
    vectors : ndarray, shape (vectors of the method, state)
    before : ndarray, shape (values,)
        Values where the run begins, none of them zero; in the end those before the last step, or after it if that was
        quiet.

    Returns
    -------
    command : int
        What the method wants.
    is_quiet : bool
        Whether nothing happened in the last step.
    """
    places, numbers = going.call.places, going.call.numbers
    integers = run.integers
    while True:
        places[going.most_at] = integers[STEPS] + 1
        call_address(going.call.address, (places, numbers))
        if numbers[-1] != 0.0:  # what is raised in there is raised here
            raise ZeroDivisionError
        command = int(numbers[going.command_at])
        if command != ACCEPTED:
            return command, False
        start, h = run.reals[TIME_OLD], run.reals[TIME] - run.reals[TIME_OLD]
        for i in range(len(lookout.shares)):
            lookout.times[i] = start + h * lookout.shares[i]
        lookout.times[-1] = run.reals[TIME]
        _look(lookout, run, vectors)
        for column in range(len(before)):
            if not _is_quiet(lookout, before[column], column):
                return command, False
        copy(lookout.found[-1], before)
        if integers[STORED] == len(run.times) or integers[STEPS] >= run.most_steps:
            return command, True


@entry()
def look_at(lookout: Lookout, run: Run, vectors: RealRows, t: float) -> None:
    """Write the values at a time of the last step; the lookout has one place."""
    lookout.times[0] = t
    _look(lookout, run, vectors)


@kernel
def _look(lookout: Lookout, run: Run, vectors: RealRows) -> None:
    """Write the values at the times of the lookout."""
    for i in range(len(lookout.times)):
        t, y = lookout.times[i], lookout.states[i]
        if run.integers[STAGE] != 0 and t < run.reals[TIME]:
            run.interpolate(run.integers, run.reals, vectors, run.table, t, y)
        else:
            copy(vectors[STATE], y)
        put_drives(lookout.motions, t, lookout.drives[i])
        copy(lookout.held, lookout.inputs[i])
        lookout.fill(t, y, lookout.inputs[i])
    call_address(lookout.looking.address, (lookout.looking.places, lookout.looking.numbers))


@inlined
def _is_quiet(lookout: Lookout, first: float, column: int) -> bool:
    """Return whether all values of a column have the sign of that before them and come nowhere near zero."""
    sign = np.sign(first)
    v0, v1, x1 = abs(first), 0.0, 0.0
    for i in range(len(lookout.shares)):
        v2, x2 = sign * lookout.found[i, column], lookout.shares[i]
        if not v2 > 0.0:
            return False
        x0 = lookout.shares[i - 2] if i > 1 else 0.0
        if i > 0 and dips(v0, v1, v2, 2.0 * (x1 - x0) / (x2 - x0) - 1.0):
            return False
        if i > 0:
            v0 = v1
        v1, x1 = v2, x2
    return True


@inlined
def dips(v0: float, v1: float, v2: float, x: float) -> bool:
    """Return whether the parabola through three values above zero, at -1, x and 1, comes near zero between them."""
    b = 0.5 * (v2 - v0)
    c = (0.5 * (v0 + v2) + b * x - v1) / (1.0 - x * x)
    if not (c > 0.0 and abs(b) < 2.0 * c):
        return False
    lowest = 0.5 * (v0 + v2) - c - b * b / (4.0 * c)
    return bool(lowest <= LEAST_DIP * max(v0, v1, v2))
