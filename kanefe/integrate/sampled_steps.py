"""Steps from sample to sample of controllers, where a run goes from one to the next in Python."""

from __future__ import annotations

import time

import numpy as np

from kanefe.integrate.events.event_search import EventWatch
from kanefe.integrate.pace import Pace
from kanefe.integrate.sampling import Sampler
from kanefe.integrate.state_rows import StateRows
from kanefe.integrate.stepper import Stepper


class SampledSteps:
    """Steps that end at samples: of a stepper with its sampler, the events watched, and the pace of the run."""

    def __init__(self, stepper: Stepper, sampler: Sampler, watch: EventWatch | None, pace: Pace) -> None:
        self._stepper, self._sampler, self._watch, self._pace = stepper, sampler, watch, pace

    def go(self, rows: StateRows, most: int, until: float) -> None:
        """Continue for so many steps, or up to a time of `time.perf_counter`.

        One step that is left of several is for the next go: the states within it, for which a call for one step may
        take evaluations, are not wanted, and where a go ends is a matter of time.
        """
        stepper, end = self._stepper, self._stepper.step_count + most
        while not rows.is_full and (left := end - stepper.step_count) > (most > 1):
            if self._sampler.next <= stepper.t < rows.end:
                self._sample(rows)
            target, first = self._sampler.next, rows.stored
            last = first + int(np.searchsorted(rows.times[first:], target, side="right"))
            is_cut = last == len(rows.times) and not rows.is_last  # the rest of the interval is in the next window
            if is_cut or (last > first and rows.times[last - 1] == target):
                rows.stored += stepper.integrate_through(rows.times[first:last], rows.states[first:last], left)
            else:
                beyond = np.empty((last - first + 1, rows.states.shape[1]))
                times = np.concatenate((rows.times[first:last], (target,)))
                try:
                    passed = stepper.integrate_through(times, beyond, left)
                finally:
                    rows.states[first:last] = beyond[:-1]
                rows.stored += min(passed, last - first)
            if self._watch or time.perf_counter() > until:
                return

    def _sample(self, rows: StateRows) -> None:
        """Do what is due at the time reached, and go on with other drives."""
        stepper, sampler, t = self._stepper, self._sampler, self._stepper.t
        y = sampler.sampled(t, stepper.state())
        stepper.aim(sampler.next)
        stepper.go_on_with(t, y)
        if sampler.has_alarm:
            self._pace.check_drives()
        if self._watch:
            self._watch.renew(t, y)
        if rows.stored and rows.times[rows.stored - 1] == t:
            rows.states[rows.stored - 1] = y
            rows.store_accelerations(rows.stored - 1, rows.stored)
