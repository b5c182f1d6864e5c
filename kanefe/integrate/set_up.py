"""What a run has before its first step; of scenes without functions of the user it is kept for the next run like it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from kanefe.equations.model import Model, is_for_many
from kanefe.integrate.auto.choice import Choice, choose
from kanefe.integrate.breakpoints import accelerations_at, sample_times
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.events.contact_changes import changes_of_contacts, reported_contact_events
from kanefe.integrate.events.event import Event, checked_events
from kanefe.integrate.events.event_search import EventWatch
from kanefe.integrate.events.load_events import events_of_loads
from kanefe.integrate.events.requested_events import with_what_is_asked
from kanefe.integrate.loop import FIRST_CHUNK
from kanefe.integrate.options import RunOptions
from kanefe.integrate.run_checks.joint_ranges import ends_of_ranges
from kanefe.integrate.stepper import Stepper, looks_out

MOST_KEPT = 8
"""Largest number of combinations of options for which a model keeps what its runs have at the start."""


@dataclass(eq=False)
class SetUp:
    """What a run has before its first step.

    Attributes
    ----------
    choice : Choice
    told : tuple of Event
        Those that are reported.
    dynamics : Dynamics
    stepper : Stepper
    watch : EventWatch or None
    chunk : int
        Number of steps with which the run begins, see `kanefe.integrate.loop.RunLoop`.
    is_for_many : bool
        Whether the next run may begin with it.
    """

    choice: Choice
    told: tuple[Event, ...]
    dynamics: Dynamics
    stepper: Stepper
    watch: EventWatch | None
    chunk: int
    is_for_many: bool
    _begun: tuple[Mapping[str, np.ndarray], Mapping[str, np.ndarray]] | None = None

    def start(self) -> None:
        """Put stepper and watch to the start of the run, as they were in the run before if there was one."""
        watch = self.watch
        if self._begun is not None:
            self.stepper.resume(self._begun[0])
            if watch is not None:
                watch.resume(self._begun[1])
            return
        if watch is not None:
            watch.start(self.stepper)
        if self.is_for_many:
            self._begun = self.stepper.snapshot(), {} if watch is None else watch.snapshot()


def set_up(model: Model, options: RunOptions) -> SetUp:
    """Return what a run has before its first step: that of the run before, if it was given back.

    Raises
    ------
    ModelError
        If an option makes no sense for the model.
    SimulationError
        If the run cannot begin.
    """
    kept = _kept(model, options)
    if kept:
        return kept.pop()
    (start, stop), watched = options.span, options.watched
    check_motions(model, start, stop, may_end=any(event.terminal for event in watched))
    choice = choose(model, options)
    told = reported_events(model, choice, options)
    watch, dynamics = watch_of(model, choice, options, told), Dynamics(model)
    stepper = choice.make(dynamics)
    if choice.rivals:
        stepper = with_trials(choice, dynamics, stepper, watch, options)
    return SetUp(choice, told, dynamics, stepper, watch, FIRST_CHUNK, kept is not None and choice.is_compiled)


def with_trials(
    choice: Choice, dynamics: Dynamics, stepper: Stepper, watch: EventWatch | None, options: RunOptions
) -> Stepper:
    """Return a stepper that tries other methods in the run."""
    from kanefe.integrate.auto.tried_methods import TriedMethods
    from kanefe.integrate.auto.work import WorkCounter

    model = dynamics.model
    by_single_steps = watch is not None and not (not model.controllers and looks_out(stepper) and stepper.can_look_out)
    counter = WorkCounter(model, by_single_steps, dynamics.calls_for_jacobian(options.span[0]))
    return TriedMethods(stepper, tuple(choice.rivals.values()), dynamics, options.span, choice.control["rtol"], counter)


def give_back(model: Model, options: RunOptions, used: SetUp) -> None:
    """Let the next run with the same options have what this one had, of which nothing is read any more.

    Not where something of it may be otherwise then: functions and events of the user, controllers; nor where a method
    is not compiled, or where a start is warned of, each time.
    """
    kept = _kept(model, options)
    if kept is not None and used.is_for_many:
        kept.append(used)


def _kept(model: Model, options: RunOptions) -> list[SetUp] | None:
    """Return what is kept for runs with such options; None for those of which nothing is."""
    is_own = options.watched or options.resume is not None or options.checkpoint is not None
    if is_own or not is_for_many(model) or model.controllers:
        return None
    key = (*options.span, options.method, options.rtol, options.atol, options.step)
    of_all = model.set_ups
    if key not in of_all:
        if len(of_all) >= MOST_KEPT:
            of_all.clear()
        of_all[key] = []
    return of_all[key]


def check_motions(model: Model, start: float, stop: float, may_end: bool = False) -> None:
    """Raise a ModelError if a motion is not known in the whole of a run, or not possible, or its rates do not fit it.

    Parameters
    ----------
    model : Model
    start, stop : float
        Of the run, s.
    may_end : bool
        Whether it may end before: then motions need not be known up to its end.
    """
    model.looks.clear()
    for motion, what in model.motions:
        for t in (start,) if may_end else (start, stop):
            motion.check_known(t, what)
        first, last = max(start, motion.known[0]), min(stop, motion.known[1])
        if motion.pieces is None and math.isfinite(last - first):
            times = sample_times(first, last)
            motion.check_over(times, what, accelerations_at(model, motion, times))
    for load in model.loads:
        load.check_during(start, stop)


def reported_events(model: Model, choice: Choice, options: RunOptions) -> tuple[Event, ...]:
    """Return the events that a run reports: those of the user, of loads and of contacts."""
    of_loads = (*events_of_loads(model, choice.keeps_steps), *reported_contact_events(model, choice.name))
    own = [event for event in options.watched if event.function is not None]
    return checked_events(own, with_what_is_asked(of_loads, options.watched))


def watch_of(model: Model, choice: Choice, options: RunOptions, told: Sequence[Event]) -> EventWatch | None:
    """Return the watch of all events of a run, reported and others; None if there are none."""
    start, stop = options.span
    watched = (
        *told,
        *ends_of_ranges(model, start),
        *changes_of_contacts(model, choice.name, start, stop, choice.control.get("rtol", 0.0)),
    )
    return EventWatch(model, watched, stop - start) if watched else None
