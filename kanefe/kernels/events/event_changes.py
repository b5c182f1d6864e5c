"""What events change: states by loads and rigid contacts, in compiled code, and what is told of it."""

from kanefe.kernels.evaluation.momenta import Balances
from kanefe.kernels.events.closing_call import close_at
from kanefe.kernels.events.lookout import look_at_states, put_given
from kanefe.kernels.events.watched_run import STORM_SHARE, Does, Lookout, Passage, WatchedRun
from kanefe.kernels.impacts.contact_questions import Reports, WhyNot, question_of
from kanefe.kernels.language import call_address, copy, inlined, kernel


@inlined
def happens(watched: WatchedRun, event: int, t: float, found: int) -> bool:
    """Return whether an event is among what was found, at a time or later."""
    is_found = False
    for i in range(found):
        is_found = is_found or (int(watched.found[i, 1]) == event and watched.found[i, 0] >= t)
    return is_found


@kernel
def _changes(watched: WatchedRun, event: int, t: float, found: int) -> bool:
    """Return whether an event changes states at the time at which the step ends."""
    does = watched.kinds[event]
    return (does == Does.CHANGES or does == Does.BOUND_CHANGES) and happens(watched, event, t, found)


@kernel
def _are_changed(watched: WatchedRun, t: float, found: int) -> bool:
    """Return whether any event changes states."""
    is_any = False
    for event in range(len(watched.kinds)):
        is_any = is_any or _changes(watched, event, t, found)
    return is_any


@kernel
def is_storm(watched: WatchedRun, t: float, found: int) -> bool:
    """Return whether changes follow each other without end, which Python tells."""
    return _are_changed(watched, t, found) and t - watched.actions[1] <= STORM_SHARE * watched.span


@kernel
def change_states(passage: Passage, t: float, found: int) -> bool:
    """Write the state after what happens, in the order of the events; return whether it is known.

    The energy that changes is taken into account; the state before is that of the lookout for one.
    """
    lookout, watched = passage.lookouts.single, passage.watched
    y = lookout.states[0]
    question_of(lookout.contacts.inquiry).reports = 0
    for event in range(len(watched.kinds)):
        if not _changes(watched, event, t, found):
            continue
        lookout.times[0] = t
        if watched.kinds[event] == Does.BOUND_CHANGES:
            is_known, gained = _change_contacts(passage, t, watched.changes[event, 0])
            if not is_known:
                return False
        else:
            for i in range(len(lookout.change)):
                lookout.change[i] = watched.changes[event, i]
            look_at_states(lookout)
            lookout.change[0] = -1
            gained = lookout.found[0, 0]
        y[watched.first_quadrature + (0 if gained < 0.0 else 1)] += abs(gained)
    copy(y, watched.after)
    return True


@kernel
def _change_contacts(passage: Passage, t: float, what: int) -> tuple[bool, float]:
    """Change speeds and states of rigid contacts; return whether that is decided, and the energy gained, J."""
    lookout, closing = passage.lookouts.single, passage.lookouts.closing
    contacts, states, y = lookout.contacts, lookout.contacts.states, lookout.states[0]
    copy(y, states.states[0])
    if not ask_contacts(lookout, passage.watched, t, what):
        return False, 0.0
    if closing.has_loops and not close_at(closing, t, 0.0, y):
        return False, 0.0
    copy(y, states.states[1])
    for i in range(2):
        states.times[i] = t
        put_given(lookout, t, states.drives[i], states.states[i], states.inputs[i])
    call_address(contacts.balancing.address, (contacts.balancing.places, contacts.balancing.numbers))
    before, after = Balances(contacts.balances)[0], Balances(contacts.balances)[1]
    return True, after.kinetic - before.kinetic + (after.elastic - before.elastic) + (after.weight - before.weight)


@kernel
def ask_contacts(lookout: Lookout, watched: WatchedRun, t: float, what: int) -> bool:
    """Ask for what follows an event of rigid contacts, or for blurs; return whether it is decided."""
    contacts, asked = lookout.contacts, question_of(lookout.contacts.inquiry)
    asked.what, asked.when, asked.rtol, asked.length = what, t, watched.rtol, watched.length
    asked.span, asked.stop = watched.span, watched.stop
    call_address(contacts.changing.address, (contacts.changing.places, contacts.changing.numbers))
    return asked.why_not == WhyNot.FOUND


@kernel
def take_reports(lookout: Lookout, watched: WatchedRun) -> None:
    """Write to the records what rigid contacts tell, with negative numbers."""
    reports = Reports(lookout.contacts.inquiry.reports)
    for i in range(question_of(lookout.contacts.inquiry).reports):
        row = watched.counts[0]
        watched.records[row, 0], watched.records[row, 1] = reports[i].t, -1.0 - reports[i].code
        watched.counts[0] = row + 1


@kernel
def mark_action(watched: WatchedRun, t: float, found: int) -> None:
    """Write the time of an action that changes states to the last ones."""
    if _are_changed(watched, t, found):
        for i in range(len(watched.actions) - 1):
            watched.actions[i] = watched.actions[i + 1]
        watched.actions[-1] = t
