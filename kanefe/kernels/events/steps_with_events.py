"""Runs with events of loads: steps, what happened in them, and how they continue, without leaving compiled code.

Python is asked where an event changes the scene or ends the run. What is found where is that of
`kanefe.kernels.events.event_search`, which `kanefe.integrate.events.event_search` takes too, for events of the user.
"""

import numpy as np

from kanefe.kernels.events import event_changes
from kanefe.kernels.events.closing_call import close_at
from kanefe.kernels.events.event_search import Within, noise_after, passes_at, time_tolerance
from kanefe.kernels.events.foreseen_events import FORESIGHT, smooth_until, time_to_event
from kanefe.kernels.events.kinks import steps_again
from kanefe.kernels.events.lookout import look_at_states, look_through, put_closed, put_state, value_at
from kanefe.kernels.events.roots_of_step import find_roots, first_acting, is_near, sample
from kanefe.kernels.events.watched_run import IS_CUT, Does, Going, Lookout, Lookouts, Passage, Question, WatchedRun
from kanefe.kernels.impacts.contact_questions import Asks, margin_of, no_blurs, question_of
from kanefe.kernels.language import call_address, copy, entry, exact, inlined, kernel
from kanefe.kernels.steppers.step_commands import Command, Run, await_output, begin_at, step_of, take_back_outputs

LEAST_FORESEEN = 1e8
"""Step, in multiples of the shortest, below which no event is foreseen, and which none is made shorter for: values in
it differ by round-off."""


@entry()
def pass_steps(
    going: Going, lookouts: Lookouts, watched: WatchedRun, run: Run, restart_share: float
) -> tuple[int, bool]:
    """Continue with a run over its events, until one of the last step needs Python, or as `integrate` does.

    Parameters
    ----------
    going : Going
    lookouts : Lookouts
    watched : WatchedRun
    run : Run
    restart_share : float
        Of `Passage`.

    Returns
    -------
    command : int
        What the method wants.
    is_done : bool
        Whether all that happened in the last step is dealt with.
    """
    passage, step = Passage(lookouts, watched, run, restart_share), step_of(run)
    most = len(watched.records) - len(watched.found) - len(lookouts.single.contacts.inquiry.reports)
    while True:
        was_cut = watched.counts[IS_CUT] != 0
        watched.counts[IS_CUT] = 0
        if not was_cut:
            command = _take_step(going, run)
            if command != Command.ACCEPTED:
                return command, False
            if step.stored == len(run.times) and step.time > run.times[-1]:
                watched.counts[IS_CUT] = 1  # more outputs of this step are wanted before its events
                return command, True
        is_at_zero, start = _is_at_zero(watched), step.time_old
        lookout = lookouts.fresh if is_at_zero else lookouts.quiet
        look_through(lookout, run, start, step.time)
        found = find_roots(lookout, passage, start)
        if not was_cut and steps_again(watched, run, found):
            continue
        if not _deal_with(lookout, passage, start, found):
            return Command.ACCEPTED.value, False
        if step.stage != 0:  # it goes on behind the step
            if is_at_zero:
                look_through(lookouts.quiet, run, start, step.time)
            _foresee(passage)
        is_full = watched.counts[0] > most
        if step.stored == len(run.times) or step.steps >= run.most_steps or is_full:
            return Command.ACCEPTED.value, True


@kernel
def _take_step(going: Going, run: Run) -> int:
    """Have the method take one step; return what it wants."""
    step, (places, numbers) = step_of(run), (going.call.places, going.call.numbers)
    places[going.most_at] = step.steps + 1
    call_address(going.call.address, (places, numbers))
    step.to_event = np.inf
    return int(numbers[going.command_at])


@exact
def _foresee(passage: Passage) -> None:
    """Go on from the next event, if it is just behind the last step; else write how far the next step may go.

    See `kanefe.kernels.events.foreseen_events`. Where steps are short the error alone says how far they go.
    """
    run, quiet, watched = passage.run, passage.lookouts.quiet, passage.watched
    step = step_of(run)
    start, last_step, least = step.time, step.time - step.time_old, LEAST_FORESEEN * step.smallest
    if step.is_fixed or min(last_step, step.next_step) < least:
        return
    left = time_to_event(quiet.found, watched, start, last_step, step.next_step)
    reach = step.reach * last_step
    if reach < left < FORESIGHT.farthest_sharp * last_step:
        near = FORESIGHT.sharpened * left
        look_through(quiet, run, start, start + near)
        rest = time_to_event(quiet.found, watched, start + near, near, left)
        left = near + rest if rest < np.inf else left
    if left > reach:
        step.to_event = max(left / (1.0 + 0.5 * step.reach), least)
        return
    end = min(start + reach, smooth_until(run))
    if end > start:
        look_through(quiet, run, start, end)
        _deal_with(quiet, passage, start, find_roots(quiet, passage, start))


@inlined
def _is_at_zero(watched: WatchedRun) -> bool:
    """Return whether a function is at a zero, so that its sign is not known."""
    found = False
    for event in range(len(watched.values)):
        found = found or watched.noise[event] != 0.0 or watched.values[event] == 0.0
    return found


@exact
def _deal_with(lookout: Lookout, passage: Passage, start: float, found: int) -> bool:
    """Take in what was found from a time on, up to the end of the lookout; return whether nothing of it needs Python.

    What is reported is written to the records, up to and with the first event that ends the step; there the run goes
    on anew. Behind the last step each event does that, and without one nothing is taken in.
    """
    watched, is_ahead = passage.watched, start == step_of(passage.run).time
    if found < 0:
        return False
    acting = first_acting(watched, found, is_ahead)
    if is_ahead and not acting < np.inf:
        return True
    if acting < np.inf:
        found = _keep_acting(lookout, passage, start, found, acting)
        if found < 0 or event_changes.is_storm(watched, acting, found) or not put_closed(passage, acting):
            return False
        if not event_changes.change_states(passage, acting, found):
            return False
    _record(passage, found)
    _set_noise(lookout, passage, start, found, acting < np.inf)
    for event in range(len(watched.values)):
        watched.values[event] = lookout.found[-1, watched.columns[event]]
        watched.known[event] = 1.0 if is_near(lookout, watched, event) else 0.0
    if acting < np.inf:
        _go_on_behind(passage, acting, found)
    return True


@exact
def _keep_acting(lookout: Lookout, passage: Passage, start: float, found: int, acting: float) -> int:
    """Keep what happens up to the end of the step, and at that time; return how much it is, -1 if Python has to act."""
    watched, count = passage.watched, 0
    limit = acting + 2.0 * time_tolerance(watched.span, acting)
    while count < found and watched.found[count, 0] <= limit:
        if watched.found[count, 0] >= acting and watched.kinds[int(watched.found[count, 1])] == Does.ACTS:
            return -1
        count += 1
    for late in range(count, found):
        root, event = watched.found[late, 0], int(watched.found[late, 1])
        of, within = Question(passage, event, 0.0), Within(start, lookout.times[-1], watched.span)
        if watched.kinds[event] < Does.BOUND and passes_at(value_at, of, acting, root, within):
            if watched.kinds[event] == Does.ACTS:
                return -1
            watched.found[count, 0], watched.found[count, 1] = acting, event
            count += 1
    return count


@exact
def _record(passage: Passage, found: int) -> None:
    """Write what happened to the records, where that is wanted with the states before."""
    watched = passage.watched
    for i in range(found):
        row, t, event = watched.counts[0], watched.found[i, 0], watched.found[i, 1]
        watched.records[row, 0], watched.records[row, 1] = t, event
        if len(watched.before) > 0:
            put_closed(passage, t)
            copy(passage.lookouts.single.states[0], watched.before[row])
        watched.counts[0] += 1
        watched.last[int(event)] = t


@exact
def _set_noise(lookout: Lookout, passage: Passage, start: float, found: int, has_acted: bool) -> None:
    """Write below what functions have no sign: after roots at which a step ended, and else not any more."""
    watched = passage.watched
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
            of, within = Question(passage, event, 0.0), Within(start, lookout.times[-1], watched.span)
            watched.noise[event] = noise_after(value_at, of, root, within, largest)
        elif later > watched.noise[event]:
            watched.noise[event] = 0.0  # also where a step ends by chance just before the next zero


@kernel
def _go_on_behind(passage: Passage, t: float, found: int) -> None:
    """Go on from the state after what happened at a time, which is in the lookout for one."""
    single, watched, closing = passage.lookouts.single, passage.watched, passage.lookouts.closing
    copy(watched.after, single.states[0])
    event_changes.take_reports(single, watched)
    event_changes.mark_action(watched, t, found)
    step, run = step_of(passage.run), passage.run
    take_back_outputs(run, t)
    stored = step.stored
    while stored < len(run.times) and run.times[stored] <= t:
        put_state(run, run.times[stored], run.states[stored])
        if closing.has_loops and not close_at(closing, run.times[stored], step.share_stiffness, run.states[stored]):
            step.is_left_open = True
        stored += 1
    step.stored = stored
    await_output(run)
    copy(single.states[0], step.state)
    begin_at(step, t)
    if not step.is_fixed:
        step.next_step = _step_after(passage, t, found)
    _begin(passage, t, found)


@kernel
def _step_after(passage: Passage, t: float, found: int) -> float:
    """Return the step with which a run goes on after an event: the mean one up to the next when it last happened.

    The same forces act between the same events again and again: what their errors allowed is the best guess. The first
    time it is a share of the step before, or that itself where the event is only reported.
    """
    watched, step = passage.watched, step_of(passage.run)
    event, steps, regime = int(watched.found[found - 1, 1]), float(step.steps), watched.regime
    before = int(regime[0])
    if before >= 0 and steps > regime[2]:
        watched.usual[before] = (t - regime[1]) / (steps - regime[2])
    regime[0], regime[1], regime[2] = float(event), t, steps
    share = 1.0 if watched.kinds[event] == Does.REPORTS else passage.restart_share
    usual = watched.usual[event]
    wanted = usual if usual > 0.0 and share > 0.0 else share * step.next_step
    return min(wanted, step.longest_restart)


@kernel
def _begin(passage: Passage, t: float, found: int) -> None:
    """Set the state from which a run continues, and the events that just happened there."""
    lookout, watched = passage.lookouts.single, passage.watched
    lookout.times[0] = t
    look_at_states(lookout)
    blurs = question_of(lookout.contacts.inquiry).blurs
    if lookout.contacts.changing.address != 0 and not event_changes.ask_contacts(lookout, watched, t, Asks.BLURS.value):
        no_blurs(blurs)
    for event in range(len(watched.values)):
        value = lookout.found[0, watched.columns[event]]
        watched.values[event], watched.known[event] = value, 1.0
        if watched.kinds[event] == Does.BOUND_CHANGES:
            watched.noise[event] = margin_of(blurs, watched.changes[event, 0])
        elif abs(value) > watched.noise[event] or not event_changes.happens(watched, event, t, found):
            watched.noise[event] = 0.0
    for i in range(found):
        if watched.found[i, 0] >= t and watched.kinds[int(watched.found[i, 1])] < Does.BOUND:
            _share_noise(watched, int(watched.found[i, 1]))


@inlined
def _share_noise(watched: WatchedRun, happened: int) -> None:
    """Give the noise of what just happened to all of that value: a slip and a stick can be ways through one zero."""
    for event in range(len(watched.values)):
        if watched.kinds[event] < Does.BOUND and watched.values[event] == watched.values[happened]:
            watched.noise[event] = max(watched.noise[event], watched.noise[happened])
