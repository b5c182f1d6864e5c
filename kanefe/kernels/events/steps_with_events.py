"""Runs with events of loads: steps, what happened in them, and how they continue, without leaving compiled code.

Python is asked where an event changes the scene or ends the run. What is found where is that of
`kanefe.kernels.events.event_search`, which `kanefe.integrate.events.event_search` takes too, for events of the user.
"""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.vectors import copy
from kanefe.kernels.compiler._numba import exact, inlined, kernel
from kanefe.kernels.compiler.arrays import RealRows
from kanefe.kernels.compiler.calls import call_address
from kanefe.kernels.compiler.entries import entry
from kanefe.kernels.events.closing_call import ClosingCall, close_at
from kanefe.kernels.events.event_changes import ask_contacts, change_states, is_storm, mark_action, take_reports
from kanefe.kernels.events.event_search import noise_after, passes_at, time_tolerance
from kanefe.kernels.events.foreseen_events import FARTHEST_SHARP, SHARPENED, smooth_until, time_to_event
from kanefe.kernels.events.kinks import steps_again
from kanefe.kernels.events.lookout import (
    Single,
    look_ahead,
    look_at_states,
    look_through,
    put_closed,
    put_state,
    value_at,
)
from kanefe.kernels.events.roots_of_step import find_roots, first_acting, is_near, sample
from kanefe.kernels.events.watched_run import (
    ACTS,
    BOUND,
    BOUND_CHANGES,
    IS_CUT,
    REPORTS,
    Going,
    Lookout,
    WatchedRun,
)
from kanefe.kernels.impacts.contact_questions import (
    BLUR,
    BLURS,
    TOUCH,
)
from kanefe.kernels.steppers.step_commands import (
    ACCEPTED,
    IS_FIXED,
    IS_LEFT_OPEN,
    LONGEST_RESTART,
    NEXT_STEP,
    REACH,
    SHARE_STIFFNESS,
    SMALLEST,
    STAGE,
    STATE,
    STEPS,
    STORED,
    TIME,
    TIME_OLD,
    TO_EVENT,
    Run,
    await_output,
    begin_at,
    take_back_outputs,
)

LEAST_FORESEEN = 1e8
"""Step, in multiples of the shortest, below which no event is foreseen, and which none is made shorter for: values in
it differ by round-off."""


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
        Of the step before, with which the method begins after an event that has not happened before; with 0 it finds a
        first step itself, whenever states may have changed.

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
        command = ACCEPTED
        if watched.counts[IS_CUT] == 0:
            places[going.most_at] = integers[STEPS] + 1
            call_address(going.call.address, (places, numbers))
            run.reals[TO_EVENT] = np.inf
            command = int(numbers[going.command_at])
            if command != ACCEPTED:
                return command, False
            if integers[STORED] == len(run.times) and run.reals[TIME] > run.times[-1]:
                watched.counts[IS_CUT] = 1  # more outputs of this step are wanted before its events
                return command, True
        was_cut = watched.counts[IS_CUT] != 0
        watched.counts[IS_CUT] = 0
        is_at_zero = _is_at_zero(watched)
        lookout = fresh if is_at_zero else quiet
        look_through(lookout, run, vectors)
        found = find_roots(lookout, (single, closing), watched, run, vectors, run.reals[TIME_OLD])
        if not was_cut and steps_again(watched, run, vectors, found):
            continue
        if not _deal_with(lookout, (single, closing), watched, run, vectors, run.reals[TIME_OLD], found, restart_share):
            return command, False
        if integers[STAGE] != 0:  # it goes on behind the step
            if is_at_zero:
                look_through(quiet, run, vectors)
            _foresee(quiet, (single, closing), watched, run, vectors, restart_share)
        is_full = watched.counts[0] > most
        if integers[STORED] == len(run.times) or integers[STEPS] >= run.most_steps or is_full:
            return command, True


@exact
def _foresee(
    quiet: Lookout, single: Single, watched: WatchedRun, run: Run, vectors: RealRows, restart_share: float
) -> None:
    """Go on from the next event, if it is just behind the last step; else write how far the next step may go.

    See `kanefe.kernels.events.foreseen_events`. Where steps are short the error alone says how far they go.
    """
    reals = run.reals
    start, last_step, least = reals[TIME], reals[TIME] - reals[TIME_OLD], LEAST_FORESEEN * reals[SMALLEST]
    if run.integers[IS_FIXED] != 0 or min(last_step, reals[NEXT_STEP]) < least:
        return
    left = time_to_event(quiet.found, watched, start, last_step, reals[NEXT_STEP])
    reach = reals[REACH] * last_step
    if reach < left < FARTHEST_SHARP * last_step:
        near = SHARPENED * left
        look_ahead(quiet, run, vectors, start + near)
        rest = time_to_event(quiet.found, watched, start + near, near, left)
        left = near + rest if rest < np.inf else left
    if left > reach:
        reals[TO_EVENT] = max(left / (1.0 + 0.5 * reals[REACH]), least)
        return
    end = min(start + reach, smooth_until(run))
    if end > start:
        look_ahead(quiet, run, vectors, end)
        found = find_roots(quiet, single, watched, run, vectors, start)
        _deal_with(quiet, single, watched, run, vectors, start, found, restart_share)


@inlined
def _is_at_zero(watched: WatchedRun) -> bool:
    """Return whether a function is at a zero, so that its sign is not known."""
    found = False
    for event in range(len(watched.values)):
        found = found or watched.noise[event] != 0.0 or watched.values[event] == 0.0
    return found


@exact
def _deal_with(
    lookout: Lookout,
    single: Single,
    watched: WatchedRun,
    run: Run,
    vectors: RealRows,
    start: float,
    found: int,
    restart_share: float,
) -> bool:
    """Take in what was found from a time on, up to the end of the lookout; return whether nothing of it needs Python.

    What is reported is written to the records, up to and with the first event that ends the step; there the run goes
    on anew. Behind the last step each event does that, and without one nothing is taken in.
    """
    is_ahead = start == run.reals[TIME]
    if found < 0:
        return False
    acting = first_acting(watched, found, is_ahead)
    if is_ahead and not acting < np.inf:
        return True
    if acting < np.inf:
        limit = acting + 2.0 * time_tolerance(watched.span, acting)
        count = 0
        while count < found and watched.found[count, 0] <= limit:
            if watched.found[count, 0] >= acting and watched.kinds[int(watched.found[count, 1])] == ACTS:
                return False
            count += 1
        for late in range(count, found):
            event = int(watched.found[late, 1])
            data = (single, watched, run, vectors, event, 0.0)
            if watched.kinds[event] < BOUND and passes_at(
                value_at, data, acting, watched.found[late, 0], start, lookout.times[-1], watched.span
            ):
                if watched.kinds[event] == ACTS:
                    return False
                watched.found[count, 0], watched.found[count, 1] = acting, watched.found[late, 1]
                count += 1
        found = count
        if is_storm(watched, acting, found) or not put_closed(single, run, vectors, acting):
            return False
        if not change_states(single, watched, acting, found):
            return False
    for i in range(found):
        watched.records[watched.counts[0], 0], watched.records[watched.counts[0], 1] = watched.found[i]
        if len(watched.before) > 0:
            put_closed(single, run, vectors, watched.found[i, 0])
            copy(single[0].states[0], watched.before[watched.counts[0]])
        watched.counts[0] += 1
        watched.last[int(watched.found[i, 1])] = watched.found[i, 0]
    _set_noise(lookout, single, watched, run, vectors, start, found, acting < np.inf)
    for event in range(len(watched.values)):
        watched.values[event] = lookout.found[-1, watched.columns[event]]
        watched.known[event] = 1.0 if is_near(lookout, watched, event) else 0.0
    if acting < np.inf:
        copy(watched.after, single[0].states[0])
        take_reports(single[0], watched)
        mark_action(watched, acting, found)
        _restart(single, watched, run, vectors, acting, found, restart_share)
        _begin(single, watched, acting, found)
    return True


@exact
def _set_noise(
    lookout: Lookout,
    single: Single,
    watched: WatchedRun,
    run: Run,
    vectors: RealRows,
    start: float,
    found: int,
    has_acted: bool,
) -> None:
    """Write below what functions have no sign: after roots at which a step ended, and else not any more."""
    for event in range(len(watched.values)):
        count, root = sample(lookout, watched, event, start), -np.inf
        for i in range(found):
            if int(watched.found[i, 1]) == event:
                root = watched.found[i, 0]
        largest, later = 0.0, 0.0
        for k in range(count):
            largest = max(largest, abs(watched.samples[k]))
            later = max(later, abs(watched.samples[k])) if k > 0 else 0.0
        if has_acted and root > -np.inf:
            data = (single, watched, run, vectors, event, 0.0)
            watched.noise[event] = noise_after(value_at, data, root, start, lookout.times[-1], watched.span, largest)
        elif later > watched.noise[event]:
            watched.noise[event] = 0.0  # also where a step ends by chance just before the next zero


@kernel
def _restart(
    single: Single,
    watched: WatchedRun,
    run: Run,
    vectors: RealRows,
    t: float,
    found: int,
    restart_share: float,
) -> None:
    """Continue from the state at a time of the last step or just behind it, and write the outputs up to there."""
    integers, (lookout, closing) = run.integers, single
    take_back_outputs(run, t)
    stored = integers[STORED]
    while stored < len(run.times) and run.times[stored] <= t:
        put_state(run, vectors, run.times[stored], run.states[stored])
        share = run.reals[SHARE_STIFFNESS]
        if closing.has_loops and not close_at(closing, run.times[stored], share, run.states[stored]):
            integers[IS_LEFT_OPEN] = 1
        stored += 1
    integers[STORED] = stored
    await_output(run)
    copy(lookout.states[0], vectors[STATE])  # where it has been put
    begin_at(integers, run.reals, t)
    if integers[IS_FIXED] == 0:
        run.reals[NEXT_STEP] = _step_after(watched, run, t, found, restart_share)


@kernel
def _step_after(watched: WatchedRun, run: Run, t: float, found: int, restart_share: float) -> float:
    """Return the step with which a run goes on after an event: the mean one up to the next when it last happened.

    The same forces act between the same events again and again: what their errors allowed is the best guess. The first
    time it is a share of the step before, or that itself where the event is only reported.
    """
    event, steps, regime = int(watched.found[found - 1, 1]), float(run.integers[STEPS]), watched.regime
    before = int(regime[0])
    if before >= 0 and steps > regime[2]:
        watched.usual[before] = (t - regime[1]) / (steps - regime[2])
    regime[0], regime[1], regime[2] = float(event), t, steps
    share = 1.0 if watched.kinds[event] == REPORTS else restart_share
    usual = watched.usual[event]
    wanted = usual if usual > 0.0 and share > 0.0 else share * run.reals[NEXT_STEP]
    return min(wanted, run.reals[LONGEST_RESTART])


@kernel
def _begin(single: Single, watched: WatchedRun, t: float, found: int) -> None:
    """Set the state from which a run continues, and the events that just happened there."""
    lookout, _ = single
    lookout.times[0] = t
    look_at_states(lookout)
    if lookout.contacts.changing.address != 0 and not ask_contacts(lookout, watched, t, BLURS):
        lookout.contacts.asked[BLUR : BLUR + 4] = 0.0
    for event in range(len(watched.values)):
        value, has_happened = lookout.found[0, watched.columns[event]], False
        for i in range(found):
            has_happened = has_happened or (int(watched.found[i, 1]) == event and watched.found[i, 0] >= t)
        watched.values[event], watched.known[event] = value, 1.0
        if watched.kinds[event] == BOUND_CHANGES:
            watched.noise[event] = lookout.contacts.asked[BLUR + watched.changes[event, 0] - TOUCH]
        elif not has_happened or abs(value) > watched.noise[event]:
            watched.noise[event] = 0.0
    for i in range(found):
        if watched.found[i, 0] >= t and watched.kinds[int(watched.found[i, 1])] < BOUND:
            _share_noise(watched, int(watched.found[i, 1]))


@inlined
def _share_noise(watched: WatchedRun, happened: int) -> None:
    """Give the noise of what just happened to all of that value: a slip and a stick can be ways through one zero."""
    for event in range(len(watched.values)):
        if watched.kinds[event] < BOUND and watched.values[event] == watched.values[happened]:
            watched.noise[event] = max(watched.noise[event], watched.noise[happened])
