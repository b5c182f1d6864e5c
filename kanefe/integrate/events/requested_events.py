"""Events of loads and contacts that a run asks for by name: some are looked for only then, others then do more."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fnmatch import fnmatchcase

from kanefe.equations.model import Model
from kanefe.errors import ModelError, did_you_mean
from kanefe.integrate.events.contact_changes import ReportedContactEvent
from kanefe.integrate.events.event import Event
from kanefe.integrate.events.load_events import EventOfLoad
from kanefe.loads.base import Load


def with_asked_events(model: Model, events: Sequence[Event]) -> Model:
    """Return the scene with loads that locate the events requested by name; without requests the scene itself.

    Raises
    ------
    ModelError
        If no load has such an event; lists those there are.
    """
    asked = [event.name for event in events if event.function is None]
    if not asked:
        return model
    detailed = [load.in_detail() or load for load in model.loads]
    known = [name for load in detailed for name in _names(load)]
    for name in asked:
        if not any(fnmatchcase(one, name) for one in known):
            raise ModelError(
                f"event {name!r} has no function, and no load or contact of the scene has such an event. "
                f"{did_you_mean(name, known)}Remedy: kanefe.Event({name!r}, function), or the name of one of these: "
                f"{', '.join(known) or 'none'}"
            )
    loads = [
        more if any(fnmatchcase(one, name) for one in _only_in(more, load) for name in asked) else load
        for load, more in zip(model.loads, detailed, strict=True)
    ]
    return replace(model, loads=tuple(loads))  # with the states of the start, which are the same


def with_what_is_asked(of_loads: Sequence[Event], events: Sequence[Event]) -> tuple[Event, ...]:
    """Return events of loads, those that end the run or act as the user asks.

    Raises
    ------
    ModelError
        If one is asked for twice, or an action is asked for of a rigid contact.
    """
    asked = [event for event in events if event.function is None]
    found = []
    for event in of_loads:
        by = [one for one in asked if fnmatchcase(event.name, one.name) and one.acts]
        if len(by) > 1:
            raise ModelError(
                f"event {event.name!r} is requested twice, as {by[0].name!r} and {by[1].name!r}. Remedy: once"
            )
        found.append(_asked(event, by[0]) if by else event)
    return tuple(found)


def _asked(event: Event, by: Event) -> Event:
    if isinstance(event, EventOfLoad):
        return replace(event, asked=by, terminal=by.terminal)
    if isinstance(event, ReportedContactEvent) and by.action is None:
        return replace(event, terminal=True)
    raise ModelError(
        f"event {event.name!r} is one of a rigid contact, after which the contact determines how the run continues. "
        "Remedy: terminal=True and another run from its end, or kanefe.HuntCrossley(...) in place of Rigid"
    )


def _names(load: Load) -> list[str]:
    """Return the names of the reported events of a load."""
    return [f"{load.subject} {what}" for what in load.told]


def _only_in(more: Load, load: Load) -> set[str]:
    """Return the names of the events of a load that it has in detail alone."""
    return {*_names(more)} - {*_names(load)}
