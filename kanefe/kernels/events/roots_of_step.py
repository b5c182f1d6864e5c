"""When events happened in a step: the zeros of their functions, in order of time."""

import numpy as np

from kanefe.kernels.events.event_search import Sought, StepSamples, insert, is_known, is_over, is_still, zeros_of
from kanefe.kernels.events.lookout import value_at
from kanefe.kernels.events.watched_run import Does, Lookout, Passage, Question, WatchedRun
from kanefe.kernels.language import exact


@exact
def sample(lookout: Lookout, watched: WatchedRun, event: int, start: float) -> int:
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
def is_near(lookout: Lookout, watched: WatchedRun, event: int) -> bool:
    """Return whether the values of an event in the lookout are no estimates."""
    load = watched.loads[event]
    return bool(load == len(lookout.near) or lookout.near[load] > 0.0)


@exact
def _know_starts(lookout: Lookout, passage: Passage, start: float) -> None:
    """Look at the start of a step at what comes near in it and was only estimated before.

    An estimate beside values would look like a function that jumps, and may come back to zero.
    """
    watched, found = passage.watched, passage.lookouts.single.found
    for event in range(len(watched.values)):
        if watched.known[event] > 0.0 or not is_near(lookout, watched, event):
            continue
        value_at(Question(passage, event, 0.0), start)
        other = event
        while other < len(watched.values) and watched.loads[other] == watched.loads[event]:
            watched.values[other], watched.known[other] = found[0, watched.columns[other]], 1.0
            other += 1


@exact
def find_roots(lookout: Lookout, passage: Passage, start: float) -> int:
    """Write what happened from a time on, in order of time; return how much that is, -1 if it is not looked for."""
    watched, total = passage.watched, 0
    _know_starts(lookout, passage, start)
    for event in range(len(watched.values)):
        is_one_side = watched.values[event] * lookout.found[0, watched.columns[event]] > 0.0
        if is_one_side and not is_near(lookout, watched, event):
            continue  # it is on one side in all of the step
        of = StepSamples(watched.times, watched.samples, sample(lookout, watched, event, start), 0)
        if is_still(of, watched.kinds[event] >= Does.BOUND):
            continue
        if watched.kinds[event] == Does.BOUND:
            return -1
        total = _add_roots(passage, event, of, total)
    return total


@exact
def _add_roots(passage: Passage, event: int, of: StepSamples, total: int) -> int:
    """Put the roots of an event with some samples among those that are found; return how many these are then."""
    watched, does, noise = passage.watched, passage.watched.kinds[event], passage.watched.noise[event]
    # what changes as a point lands depends on the force there: there is none before
    is_bound, is_beyond = does >= Does.BOUND, does >= Does.BOUND or does <= Does.CHANGES
    wanted = Sought(watched.directions[event], noise, is_bound, is_beyond, watched.span)
    data, raised = Question(passage, event, 0.0), Question(passage, event, noise)
    roots = zeros_of(value_at, data, raised, of, wanted, watched.brackets)
    for k in range(min(roots, len(watched.found) - total)):
        t = watched.brackets[k, 0]
        # else another event ended the step at that moment
        if does != Does.REPORTS or not is_known(t, watched.last[event], watched.span):
            total = insert(watched.found, total, t, event)
    return total


@exact
def first_acting(watched: WatchedRun, found: int, is_any: bool) -> float:
    """Return the time of the first event, on request of any that does more than to be reported; infinity without."""
    for i in range(found):
        t, event = watched.found[i, 0], int(watched.found[i, 1])
        is_again = watched.kinds[event] == Does.ENDS_STEP and is_over(t, watched.last[event], watched.span)
        if is_any or (watched.kinds[event] != Does.REPORTS and not is_again):
            return t
    return np.inf
