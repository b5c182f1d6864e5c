"""When events happened in a step: the zeros of their functions, in order of time."""

from __future__ import annotations

import numpy as np

from kanefe.kernels.compiler._numba import exact
from kanefe.kernels.events.event_search import (
    StepSamples,
    find_brackets,
    first_with_sign,
    is_known,
    is_over,
    is_quiet,
    root_in,
)
from kanefe.kernels.events.lookout import value_at
from kanefe.kernels.events.watched_run import Does, Lookout, Passage, Question, WatchedRun


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
        count, is_bound = sample(lookout, watched, event, start), watched.kinds[event] >= Does.BOUND
        if is_quiet(watched.times, watched.samples, count) and not (is_bound and watched.samples[0] < 0.0):
            continue
        if watched.kinds[event] == Does.BOUND:
            return -1
        total = _add_roots(passage, event, count, total)
    return total


@exact
def _add_roots(passage: Passage, event: int, count: int, total: int) -> int:
    """Put the roots of an event with so many samples among those that are found; return how many these are then."""
    watched, does = passage.watched, passage.watched.kinds[event]
    is_bound, noise = does >= Does.BOUND, watched.noise[event]
    first = first_with_sign(watched.samples, count, noise)
    # what must not be below zero happens wherever it is
    is_below = is_bound and watched.samples[first] < -noise
    of = Question(passage, event, noise if is_below else 0.0)
    if is_below:
        watched.brackets[0, 0], watched.brackets[0, 1] = watched.times[max(first - 1, 0)], watched.times[first]
        brackets = 1
    else:
        samples = StepSamples(watched.times, watched.samples, count, first)
        brackets = find_brackets(value_at, of, samples, watched.directions[event], watched.brackets)
    for k in range(min(brackets, len(watched.found) - total)):
        a, b = watched.brackets[k, 0], watched.brackets[k, 1]
        # what changes as a point lands depends on the force there: there is none before
        t = root_in(value_at, of, a, b, watched.span, is_bound or does <= Does.CHANGES)
        if does == Does.REPORTS and is_known(t, watched.last[event], watched.span):
            continue  # another event ended the step at that moment
        at = total
        while at > 0 and watched.found[at - 1, 0] > t:
            watched.found[at, 0], watched.found[at, 1] = watched.found[at - 1, 0], watched.found[at - 1, 1]
            at -= 1
        watched.found[at, 0], watched.found[at, 1] = t, event
        total += 1
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
