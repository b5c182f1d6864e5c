"""A run in compiled code that looks out for events of loads: its calls, prepared once."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from kanefe.kernels.compiler.entries import LATER, Bound, Call
from kanefe.kernels.events import watched_run as kernels
from kanefe.kernels.events.closing_call import ClosingCall
from kanefe.kernels.events.lookout import AT_TIME, look_at
from kanefe.kernels.events.steps_with_events import pass_steps
from kanefe.kernels.events.watched_run import NO_CONTACTS, Going, Lookout, WatchedRun
from kanefe.kernels.loads.watching import NEAR
from kanefe.kernels.steppers.step_commands import Run
from kanefe.order_n.evaluated import Evaluated
from kanefe.tree.looks import first_look_shares, look_shares

STEP_END = np.ones(1)


class Lookouts:
    """The lookouts of a run: of one thread at a time.

    Parameters
    ----------
    route : Evaluated
        Of an autonomous scene.
    closing : ClosingCall
    inputs : ndarray
        Of the run: values of loads, with those that controllers hold.
    size : int
        Numbers of a state.
    """

    def __init__(self, route: Evaluated, closing: ClosingCall, inputs: np.ndarray, size: int) -> None:
        self._route, self._closing, self._inputs, self._size = route, closing, inputs, size
        self._passing: Call | None = None
        self._given: Run | None = None
        self._looking: Call | None = None

    def passing(self, going: Call, run: Run, watched: WatchedRun, restart_share: float) -> Call:
        """Return the call of `pass_steps` around the one of `integrate` that a run has."""
        if self._passing is None:
            signature = going.signature
            step = Going(going.for_kernels(), signature.place_of("run", "most_steps"), signature.number_count)
            fresh, single = self._lookout(first_look_shares(self._route.model)), self._at_a_time[0]
            lookouts = kernels.Lookouts(self._quiet, fresh, single, self._closing)
            bound = pass_steps.bound(step, lookouts, LATER, LATER, LATER)
            self._passing = bound.prepared(watched, run, restart_share)
        elif self._given is not run:
            self._passing.give(watched, run, restart_share)
        self._given = run
        return self._passing

    def values_at(self, run: Run, t: float) -> np.ndarray:
        """Return the values of all watched loads at a time of the last step."""
        lookout, looking = self._at_a_time
        if self._looking is None:
            empty = run._replace(times=np.zeros(0), states=np.zeros((0, self._size)))
            self._looking = looking.prepared(empty, t)
        self._looking.numbers[AT_TIME] = t
        self._looking()
        return lookout.found[0]

    @cached_property
    def _quiet(self) -> Lookout:
        return self._lookout(look_shares(self._route.model))

    @cached_property
    def _at_a_time(self) -> tuple[Lookout, Bound]:
        lookout = self._lookout(STEP_END)
        if self._route.model.rigid_contacts:
            from kanefe.order_n.contact_changing import contact_calls

            contacts = contact_calls(self._route, self._closing.motions, self._inputs, lookout.states[0])
            lookout = lookout._replace(contacts=contacts)
        return lookout, look_at.bound(lookout, LATER, LATER)

    def _lookout(self, shares: np.ndarray) -> Lookout:
        route, count, size = self._route, len(shares), self._size
        times, drives = np.empty(count), np.empty((count, len(route.model.drives), 3))
        inputs, states = np.empty((count, len(self._inputs))), np.empty((count, size))
        change, only = np.array((-1, 0, 0, 0)), np.array((NEAR,))
        looking, found, near = route.watching.prepared(times, drives, inputs, states, change, only)
        held = self._closing.motions, route.fill, self._inputs
        arrays = times, drives, inputs, states, found, change, only, near
        return Lookout(looking.for_kernels(), shares, *held, *arrays, NO_CONTACTS)
