"""Runs with events of loads: steps, what happened in them, and how they continue, without leaving compiled code.

Python is asked where an event changes the scene or ends the run. What is found where is that of
`kanefe.kernels.steppers.event_search`, which `kanefe.integrate.events.event_search` takes too, for events of the user.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from kanefe.kernels.algebra.vectors import copy
from kanefe.kernels.compiler._numba import exact, inlined, kernel
from kanefe.kernels.compiler.arrays import Filler, Integers, Prepared, RealBlocks, RealRows, Reals
from kanefe.kernels.compiler.calls import call_address
from kanefe.kernels.compiler.entries import entry
from kanefe.kernels.steppers.event_search import (
    find_brackets,
    first_with_sign,
    is_known,
    is_over,
    is_quiet,
    noise_after,
    root_in,
    time_tolerance,
)
from kanefe.kernels.steppers.step_commands import (
    ACCEPTED,
    COMMAND,
    IS_FIXED,
    NEXT_OUTPUT,
    NEXT_STEP,
    STAGE,
    START,
    STATE,
    STEPS,
    STORED,
    TIME,
    TIME_EXCESS,
    TIME_OLD,
    Run,
)
from kanefe.kernels.sweeps.drives import Drives, put_drives

SHARES = np.arange(1, 5) / 4.0
"""Positions in a step at which functions are evaluated, relative to its length; the last one is its end."""

FIRST_SHARES = np.append(10.0 ** np.arange(-9, -1), SHARES)
"""Positions in a step after an event, relative to its length, for a function that starts at zero: they show its sign
however near its next zero is."""

REPORTS, ENDS_STEP, ACTS, BOUND = range(4)
"""Values for the action of an event: it is only reported; it also ends the step without a change; or Python has to act;
or it does as soon as the function is below zero, also where that has not passed it."""

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


class WatchedRun(NamedTuple):
    """The events of a run, and what is known of them at the last place looked at.

    Attributes
    ----------
    columns, directions, kinds : ndarray of int, shape (events,)
        Of each its column among the values looked at, the way through zero that counts (1, -1, or 0 for both), and
        what it does: REPORTS, ENDS_STEP, ACTS or BOUND.
    values, noise, last : ndarray, shape (events,)
        Value, up to which size it has no sign, and time of the last event, s; minus infinity before the first.
    records : ndarray, shape (R, 2)
        Time and event of what happened.
    counts : ndarray of int, shape (1,)
        How many records there are.
    times, samples : ndarray, shape (T,)
        Of one function in a step, from its start on.
    brackets : ndarray, shape (2 T, 2)
    found : ndarray, shape (F, 2)
        Roots of a step, in order of time: time and event.
    span : float
        Of the run, s.
    """

    columns: Integers
    directions: Integers
    kinds: Integers
    values: Reals
    noise: Reals
    last: Reals
    records: RealRows
    counts: Integers
    times: Reals
    samples: Reals
    brackets: RealRows
    found: RealRows
    span: float


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
def pass_steps(
    going: Going,
    quiet: Lookout,
    fresh: Lookout,
    single: Lookout,
    watched: WatchedRun,
    run: Run,
    vectors: RealRows,
    restart_share: float,
) -> tuple[int, bool]:
    """Continue with a run over its events, until one of the last step needs Python, or as `integrate` does.

    Parameters
    ----------
    going : Going
    quiet, fresh, single : Lookout
        With SHARES, FIRST_SHARES, and one place.
    watched : WatchedRun
    run : Run
    vectors : ndarray, shape (vectors of the method, state)
    restart_share : float
        Of the step before, with which the method begins after an event; below zero: Python looks at all steps in which
        something may happen.

    Returns
    -------
    command : int
        What the method wants.
    is_done : bool
        Whether all that happened in the last step is dealt with.
    """
    places, numbers = going.call.places, going.call.numbers
    integers = run.integers
    most = len(watched.records) - len(watched.found)
    while True:
        places[going.most_at] = integers[STEPS] + 1
        call_address(going.call.address, (places, numbers))
        if numbers[-1] != 0.0:  # what is raised in there is raised here
            raise ZeroDivisionError
        command = int(numbers[going.command_at])
        if command != ACCEPTED:
            return command, False
        is_at_zero = _is_at_zero(watched)
        if is_at_zero and restart_share < 0.0:
            return command, False
        lookout = fresh if is_at_zero else quiet
        _look_through(lookout, run, vectors)
        if not _deal_with(lookout, single, watched, run, vectors, restart_share):
            return command, False
        is_full = watched.counts[0] > most
        if integers[STORED] == len(run.times) or integers[STEPS] >= run.most_steps or is_full:
            return command, True


@inlined
def _is_at_zero(watched: WatchedRun) -> bool:
    """Return whether a function is at a zero, so that its sign is not known."""
    found = False
    for event in range(len(watched.values)):
        found = found or watched.noise[event] != 0.0 or watched.values[event] == 0.0
    return found


@exact
def _look_through(lookout: Lookout, run: Run, vectors: RealRows) -> None:
    """Write the values at the places of the lookout in the last step."""
    start, h = run.reals[TIME_OLD], run.reals[TIME] - run.reals[TIME_OLD]
    for i in range(len(lookout.shares)):
        lookout.times[i] = start + h * lookout.shares[i]
    lookout.times[-1] = run.reals[TIME]
    _look(lookout, run, vectors)


@exact
def _deal_with(
    lookout: Lookout, single: Lookout, watched: WatchedRun, run: Run, vectors: RealRows, restart_share: float
) -> bool:
    """Take in what happened in the last step; return whether nothing of it needs Python.

    What is reported is written to the records, up to and with the first event that ends the step; there the run goes
    on anew.
    """
    found = _find_roots(lookout, single, watched, run, vectors, restart_share < 0.0)
    if found < 0:
        return False
    acting = _first_acting(watched, found)
    if acting < np.inf:
        limit = acting + 2.0 * time_tolerance(watched.span, acting)
        count = 0
        while count < found and watched.found[count, 0] <= limit:
            if watched.found[count, 0] >= acting and watched.kinds[int(watched.found[count, 1])] == ACTS:
                return False
            count += 1
        found = count
    for i in range(found):
        watched.records[watched.counts[0], 0], watched.records[watched.counts[0], 1] = watched.found[i]
        watched.counts[0] += 1
        watched.last[int(watched.found[i, 1])] = watched.found[i, 0]
    _set_noise(lookout, single, watched, run, vectors, found, acting < np.inf)
    for event in range(len(watched.values)):
        watched.values[event] = lookout.found[-1, watched.columns[event]]
    if acting < np.inf:
        _restart(single, watched, run, vectors, acting, restart_share)
        _begin(single, watched, run, vectors, acting, found)
    return True


@exact
def _sample(lookout: Lookout, watched: WatchedRun, event: int, start: float) -> int:
    """Write the samples of an event from the start of the step on, each time once; return how many there are."""
    watched.times[0], watched.samples[0] = start, watched.values[event]
    count = 1
    for i in range(len(lookout.times)):
        is_new = watched.times[count - 1] < lookout.times[i] < lookout.times[-1]
        if is_new or i == len(lookout.times) - 1:
            watched.times[count], watched.samples[count] = lookout.times[i], lookout.found[i, watched.columns[event]]
            count += 1
    return count


@exact
def _find_roots(
    lookout: Lookout, single: Lookout, watched: WatchedRun, run: Run, vectors: RealRows, is_quiet_alone: bool
) -> int:
    """Write what happened in the last step, in order of time; return how much that is, -1 if it is not looked for."""
    total, start = 0, run.reals[TIME_OLD]
    for event in range(len(watched.values)):
        count = _sample(lookout, watched, event, start)
        is_bound = watched.kinds[event] == BOUND
        if is_quiet(watched.times, watched.samples, count) and not (is_bound and watched.samples[0] < 0.0):
            continue
        if is_quiet_alone or is_bound:
            return -1
        data = (single, run, vectors, watched.columns[event])
        first = first_with_sign(watched.samples, count, watched.noise[event])
        samples = watched.times, watched.samples, count, first
        brackets = find_brackets(value_at, data, *samples, watched.directions[event], watched.brackets)
        for k in range(min(brackets, len(watched.found) - total)):
            a, b = watched.brackets[k, 0], watched.brackets[k, 1]
            t = root_in(value_at, data, a, b, watched.span, watched.kinds[event] != ACTS)
            if watched.kinds[event] == REPORTS and is_known(t, watched.last[event], watched.span):
                continue  # another event ended the step at that moment
            at = total
            while at > 0 and watched.found[at - 1, 0] > t:
                watched.found[at, 0], watched.found[at, 1] = watched.found[at - 1, 0], watched.found[at - 1, 1]
                at -= 1
            watched.found[at, 0], watched.found[at, 1] = t, event
            total += 1
    return total


@exact
def _first_acting(watched: WatchedRun, found: int) -> float:
    """Return the time of the first event that does more than to be reported; infinity without one."""
    for i in range(found):
        t, event = watched.found[i, 0], int(watched.found[i, 1])
        is_again = watched.kinds[event] == ENDS_STEP and is_over(t, watched.last[event], watched.span)
        if watched.kinds[event] != REPORTS and not is_again:
            return t
    return np.inf


@exact
def _set_noise(
    lookout: Lookout, single: Lookout, watched: WatchedRun, run: Run, vectors: RealRows, found: int, has_acted: bool
) -> None:
    """Write below what functions have no sign: after roots at which a step ended, and else not any more."""
    start = run.reals[TIME_OLD]
    for event in range(len(watched.values)):
        count, root = _sample(lookout, watched, event, start), -np.inf
        for i in range(found):
            if int(watched.found[i, 1]) == event:
                root = watched.found[i, 0]
        largest, later = 0.0, 0.0
        for k in range(count):
            largest = max(largest, abs(watched.samples[k]))
            later = max(later, abs(watched.samples[k])) if k > 0 else 0.0
        if has_acted and root > -np.inf:
            data = (single, run, vectors, watched.columns[event])
            watched.noise[event] = noise_after(value_at, data, root, start, watched.span, largest)
        elif later > watched.noise[event]:
            watched.noise[event] = 0.0  # also where a step ends by chance just before the next zero


@kernel
def _restart(single: Lookout, watched: WatchedRun, run: Run, vectors: RealRows, t: float, restart_share: float) -> None:
    """Continue from the state at a time of the last step; outputs behind it are written again."""
    integers, reals = run.integers, run.reals
    y = single.states[0]
    _put_state(run, vectors, t, y)
    copy(y, vectors[STATE])
    reals[TIME], reals[TIME_OLD], reals[TIME_EXCESS] = t, t, 0.0
    integers[COMMAND], integers[STAGE] = START, 0
    if integers[IS_FIXED] == 0:
        reals[NEXT_STEP] *= restart_share
    stored = integers[STORED]
    while stored > 0 and run.times[stored - 1] > t:
        stored -= 1
    integers[STORED] = stored
    reals[NEXT_OUTPUT] = run.times[stored] if stored < len(run.times) else np.inf


@kernel
def _begin(single: Lookout, watched: WatchedRun, run: Run, vectors: RealRows, t: float, found: int) -> None:
    """Set the state from which a run continues, and the events that just happened there."""
    single.times[0] = t
    _look(single, run, vectors)
    for event in range(len(watched.values)):
        value, has_happened = single.found[0, watched.columns[event]], False
        for i in range(found):
            has_happened = has_happened or (int(watched.found[i, 1]) == event and watched.found[i, 0] >= t)
        watched.values[event] = value
        if not has_happened or abs(value) > watched.noise[event]:
            watched.noise[event] = 0.0


@kernel
def value_at(data: Any, t: float) -> float:
    """Return the value of a column at a time of the last step."""
    single, run, vectors, column = data
    single.times[0] = t
    _look(single, run, vectors)
    return single.found[0, column]


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
        _put_state(run, vectors, t, y)
        put_drives(lookout.motions, t, lookout.drives[i])
        copy(lookout.held, lookout.inputs[i])
        lookout.fill(t, y, lookout.inputs[i])
    call_address(lookout.looking.address, (lookout.looking.places, lookout.looking.numbers))


@inlined
def _put_state(run: Run, vectors: RealRows, t: float, y: Reals) -> None:
    """Write the state at a time of the last step."""
    if run.integers[STAGE] != 0 and t < run.reals[TIME]:
        run.interpolate(run.integers, run.reals, vectors, run.table, t, y)
    else:
        copy(vectors[STATE], y)
