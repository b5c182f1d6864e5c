"""Kinds of events: what one does, as compiled code has it."""

from __future__ import annotations

from kanefe.integrate.events.contact_changes import ContactChange
from kanefe.integrate.events.event import Event
from kanefe.integrate.events.load_events import EventOfLoad
from kanefe.kernels.events.watched_run import Does
from kanefe.loads.by_kernel import ActionByKernel


def ends_step_alone(event: Event) -> bool:
    """Return whether an event ends a step and changes nothing."""
    return isinstance(event, EventOfLoad) and event.ends_step_alone


def kind_for_kernels(event: Event) -> int:
    """Return what an event does, as `WatchedRun.kinds` has it."""
    if isinstance(event, ContactChange):
        return Does.BOUND_CHANGES
    if isinstance(event, EventOfLoad) and isinstance(event.of.action, ActionByKernel) and not event.acts_as_asked:
        return Does.CHANGES
    return Does.ACTS if event.acts and not ends_step_alone(event) else int(event.acts)
