"""Runs with events of loads: steps, what happened in them, and how they continue, without leaving compiled code.

Python is asked where an event changes the scene or ends the run. What is found where is that of
`kanefe.kernels.steppers.event_search`, which `kanefe.integrate.events.event_search` takes too, for events of the user.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels.algebra.vectors import copy
from kanefe.kernels.compiler._numba import exact, inlined, kernel
from kanefe.kernels.compiler.arrays import RealRows, Reals
from kanefe.kernels.compiler.calls import call_address
from kanefe.kernels.compiler.entries import entry
from kanefe.kernels.impacts.contact_questions import (
    BLUR,
    BLURS,
    IS_DECIDED,
    LENGTH,
    REPORT_COUNT,
    RUN_END,
    RUN_RTOL,
    RUN_SPAN,
    TOUCH,
    WHAT,
    WHEN,
)
from kanefe.kernels.steppers.closing_call import ClosingCall, close_at
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
from kanefe.kernels.steppers.foreseen_events import step_to_event
from kanefe.kernels.steppers.step_commands import (
    ACCEPTED,
    COMMAND,
    IS_FIXED,
    NEXT_OUTPUT,
    NEXT_STEP,
    RELATIVE,
    SMALLEST,
    STAGE,
    START,
    STATE,
    STEPS,
    STORED,
    TIME,
    TIME_EXCESS,
    TIME_OLD,
    TO_EVENT,
    Run,
)
from kanefe.kernels.steppers.watched_run import (
    ACTS,
    BOUND,
    BOUND_CHANGES,
    CHANGES,
    ENDS_STEP,
    REPORTS,
    STORM_SHARE,
    Going,
    Lookout,
    WatchedRun,
)
from kanefe.kernels.sweeps.drives import put_drives

Single = tuple[Lookout, ClosingCall]
"""A lookout with one place, and what closes the loops of the state there."""

LEAST_FORESEEN, LEAST_RTOL = 1e8, 1e-9
"""Step, in multiples of the shortest, and relative tolerance below which no event is foreseen: where a rate jumps,
such as that of an anchor, it is crossed by steps so short that only the error finds them."""

AT_TIME = 0
"""Index of the time in a prepared call of `look_at`."""


@entry()
def pass_steps(
    going: Going,
    quiet: Lookout,
    fresh: Lookout,
    single: Lookout,
    closing: ClosingCall,
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
    closing : ClosingCall
        What closes the loops of states at which values are looked for one by one.
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
    most = len(watched.records) - len(watched.found) - len(single.contacts.reports)
    while True:
        places[going.most_at] = integers[STEPS] + 1
        call_address(going.call.address, (places, numbers))
        run.reals[TO_EVENT] = np.inf
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
        if not _deal_with(lookout, (single, closing), watched, run, vectors, restart_share):
            return command, False
        if integers[STAGE] != 0:  # it goes on behind the step
            if is_at_zero:
                _look_through(quiet, run, vectors)
            _foresee(quiet, watched, run)
        is_full = watched.counts[0] > most
        if integers[STORED] == len(run.times) or integers[STEPS] >= run.most_steps or is_full:
            return command, True


@entry()
def foresee(quiet: Lookout, watched: WatchedRun, run: Run, vectors: RealRows) -> None:
    """Do what `pass_steps` does behind a step without an event that acts, which Python has looked through."""
    _look_through(quiet, run, vectors)
    _foresee(quiet, watched, run)


@exact
def _foresee(quiet: Lookout, watched: WatchedRun, run: Run) -> None:
    """Write how far the next step may go, by the values in the last one; where steps are short the error alone says."""
    reals = run.reals
    is_fine = reals[NEXT_STEP] < LEAST_FORESEEN * reals[SMALLEST] or reals[RELATIVE] < LEAST_RTOL
    if run.integers[IS_FIXED] == 0 and not is_fine:
        of_events = watched.columns, watched.directions, watched.noise
        last_step = reals[TIME] - reals[TIME_OLD]
        reals[TO_EVENT] = step_to_event(quiet.found, *of_events, last_step, reals[NEXT_STEP])


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
    lookout: Lookout, single: Single, watched: WatchedRun, run: Run, vectors: RealRows, restart_share: float
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
        if _is_storm(watched, acting, found) or not _put_closed(single, run, vectors, acting):
            return False
        if not _change(single, watched, acting, found):
            return False
    for i in range(found):
        watched.records[watched.counts[0], 0], watched.records[watched.counts[0], 1] = watched.found[i]
        watched.counts[0] += 1
        watched.last[int(watched.found[i, 1])] = watched.found[i, 0]
    _set_noise(lookout, single, watched, run, vectors, found, acting < np.inf)
    for event in range(len(watched.values)):
        watched.values[event] = lookout.found[-1, watched.columns[event]]
    if acting < np.inf:
        copy(watched.after, single[0].states[0])
        _take_reports(single[0], watched)
        _mark_action(watched, acting, found)
        _restart(single, run, vectors, acting, restart_share)
        _begin(single, watched, acting, found)
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
    lookout: Lookout, single: Single, watched: WatchedRun, run: Run, vectors: RealRows, is_quiet_alone: bool
) -> int:
    """Write what happened in the last step, in order of time; return how much that is, -1 if it is not looked for."""
    total, start = 0, run.reals[TIME_OLD]
    for event in range(len(watched.values)):
        count = _sample(lookout, watched, event, start)
        is_bound = watched.kinds[event] >= BOUND
        if is_quiet(watched.times, watched.samples, count) and not (is_bound and watched.samples[0] < 0.0):
            continue
        if is_quiet_alone or watched.kinds[event] == BOUND:
            return -1
        noise = watched.noise[event]
        first = first_with_sign(watched.samples, count, noise)
        # what must not be below zero happens wherever it is
        is_below = is_bound and watched.samples[first] < -noise
        data = (single, run, vectors, watched.columns[event], noise if is_below else 0.0)
        if is_below:
            watched.brackets[0, 0], watched.brackets[0, 1] = watched.times[max(first - 1, 0)], watched.times[first]
            brackets = 1
        else:
            samples = watched.times, watched.samples, count, first
            brackets = find_brackets(value_at, data, *samples, watched.directions[event], watched.brackets)
        for k in range(min(brackets, len(watched.found) - total)):
            a, b = watched.brackets[k, 0], watched.brackets[k, 1]
            t = root_in(value_at, data, a, b, watched.span, is_bound or watched.kinds[event] < CHANGES)
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


@kernel
def _changes(watched: WatchedRun, event: int, t: float, found: int) -> bool:
    """Return whether an event changes states at the time at which the step ends."""
    happens = False
    for i in range(found):
        happens = happens or (int(watched.found[i, 1]) == event and watched.found[i, 0] >= t)
    return happens and (watched.kinds[event] == CHANGES or watched.kinds[event] == BOUND_CHANGES)


@kernel
def _is_storm(watched: WatchedRun, t: float, found: int) -> bool:
    """Return whether changes follow each other without end, which Python tells."""
    is_any = False
    for event in range(len(watched.kinds)):
        is_any = is_any or _changes(watched, event, t, found)
    return is_any and t - watched.actions[1] <= STORM_SHARE * watched.span


@kernel
def _change(single: Single, watched: WatchedRun, t: float, found: int) -> bool:
    """Write the state after what happens, in the order of the events; return whether it is known.

    The energy that changes is taken into account; the state before is that of the lookout.
    """
    lookout, _ = single
    y = lookout.states[0]
    lookout.contacts.asked[REPORT_COUNT] = 0.0
    for event in range(len(watched.kinds)):
        if not _changes(watched, event, t, found):
            continue
        lookout.times[0] = t
        if watched.kinds[event] == BOUND_CHANGES:
            is_known, gained = _change_contacts(single, watched, t, watched.changes[event, 0])
            if not is_known:
                return False
        else:
            for i in range(len(lookout.change)):
                lookout.change[i] = watched.changes[event, i]
            _look_at_states(lookout)
            lookout.change[0] = -1
            gained = lookout.found[0, 0]
        y[watched.first_quadrature + (0 if gained < 0.0 else 1)] += abs(gained)
    copy(y, watched.after)
    return True


@kernel
def _change_contacts(single: Single, watched: WatchedRun, t: float, what: int) -> tuple[bool, float]:
    """Change speeds and states of rigid contacts; return whether that is decided, and the energy gained, J."""
    lookout, closing = single
    contacts, y = lookout.contacts, lookout.states[0]
    copy(y, contacts.states[0])
    if not _ask_contacts(lookout, watched, t, what):
        return False, 0.0
    if closing.has_loops and not close_at(closing, t, 0.0, y):
        return False, 0.0
    copy(y, contacts.states[1])
    gained = 0.0
    for i in range(2):
        contacts.times[i] = t
        put_drives(lookout.motions, t, contacts.drives[i])
        copy(lookout.held, contacts.inputs[i])
        lookout.fill(t, contacts.states[i], contacts.inputs[i])
    call_address(contacts.balancing.address, (contacts.balancing.places, contacts.balancing.numbers))
    for i in range(3):
        gained += contacts.balances[1, i] - contacts.balances[0, i]
    return True, gained


@kernel
def _ask_contacts(lookout: Lookout, watched: WatchedRun, t: float, what: int) -> bool:
    """Ask for what follows an event of rigid contacts, or for blurs; return whether it is decided."""
    contacts, asked = lookout.contacts, lookout.contacts.asked
    asked[WHAT], asked[WHEN], asked[RUN_RTOL], asked[LENGTH] = what, t, watched.rtol, watched.length
    asked[RUN_SPAN], asked[RUN_END] = watched.span, watched.stop
    call_address(contacts.changing.address, (contacts.changing.places, contacts.changing.numbers))
    return asked[IS_DECIDED] != 0.0


@kernel
def _take_reports(lookout: Lookout, watched: WatchedRun) -> None:
    """Write to the records what rigid contacts tell, with negative numbers."""
    contacts = lookout.contacts
    for i in range(int(contacts.asked[REPORT_COUNT])):
        row = watched.counts[0]
        watched.records[row, 0], watched.records[row, 1] = contacts.reports[i, 0], -1.0 - contacts.reports[i, 1]
        watched.counts[0] = row + 1


@kernel
def _mark_action(watched: WatchedRun, t: float, found: int) -> None:
    """Write the time of an action that changes states to the last ones."""
    is_any = False
    for event in range(len(watched.kinds)):
        is_any = is_any or _changes(watched, event, t, found)
    if is_any:
        for i in range(len(watched.actions) - 1):
            watched.actions[i] = watched.actions[i + 1]
        watched.actions[-1] = t


@exact
def _set_noise(
    lookout: Lookout, single: Single, watched: WatchedRun, run: Run, vectors: RealRows, found: int, has_acted: bool
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
            data = (single, run, vectors, watched.columns[event], 0.0)
            watched.noise[event] = noise_after(value_at, data, root, start, watched.span, largest)
        elif later > watched.noise[event]:
            watched.noise[event] = 0.0  # also where a step ends by chance just before the next zero


@kernel
def _restart(single: Single, run: Run, vectors: RealRows, t: float, restart_share: float) -> None:
    """Continue from the state at a time of the last step; outputs behind it are written again."""
    integers, reals = run.integers, run.reals
    copy(single[0].states[0], vectors[STATE])  # where it has been put
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
def _begin(single: Single, watched: WatchedRun, t: float, found: int) -> None:
    """Set the state from which a run continues, and the events that just happened there."""
    lookout, _ = single
    lookout.times[0] = t
    _look_at_states(lookout)
    if lookout.contacts.changing.address != 0 and not _ask_contacts(lookout, watched, t, BLURS):
        lookout.contacts.asked[BLUR : BLUR + 4] = 0.0
    for event in range(len(watched.values)):
        value, has_happened = lookout.found[0, watched.columns[event]], False
        for i in range(found):
            has_happened = has_happened or (int(watched.found[i, 1]) == event and watched.found[i, 0] >= t)
        watched.values[event] = value
        if watched.kinds[event] == BOUND_CHANGES:
            watched.noise[event] = lookout.contacts.asked[BLUR + watched.changes[event, 0] - TOUCH]
        elif not has_happened or abs(value) > watched.noise[event]:
            watched.noise[event] = 0.0


@kernel
def value_at(data: Any, t: float) -> float:
    """Return the value of a column at a time of the last step, above a level."""
    single, run, vectors, column, above = data
    lookout, _ = single
    lookout.times[0] = t
    _put_closed(single, run, vectors, t)
    _look_at_states(lookout)
    return lookout.found[0, column] + above


@kernel
def _put_closed(single: Single, run: Run, vectors: RealRows, t: float) -> bool:
    """Write the state at a time of the last step, its loops closed; return whether they are."""
    lookout, closing = single
    _put_state(run, vectors, t, lookout.states[0])
    return not closing.has_loops or close_at(closing, t, 0.0, lookout.states[0])


@entry()
def look_at(lookout: Lookout, run: Run, vectors: RealRows, t: float) -> None:
    """Write the values at a time of the last step; the lookout has one place."""
    lookout.times[0] = t
    _look(lookout, run, vectors)


@kernel
def _look(lookout: Lookout, run: Run, vectors: RealRows) -> None:
    """Write the values at the times of the lookout."""
    for i in range(len(lookout.times)):
        _put_state(run, vectors, lookout.times[i], lookout.states[i])
    _look_at_states(lookout)


@kernel
def _look_at_states(lookout: Lookout) -> None:
    """Write the values at the states and times of the lookout."""
    for i in range(len(lookout.times)):
        t, y = lookout.times[i], lookout.states[i]
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
