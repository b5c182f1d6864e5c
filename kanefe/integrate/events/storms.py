"""The failure of a run in which events follow each other without end: what happened, to what, and what helps there."""

from __future__ import annotations

from kanefe.integrate.events.contact_changes import ContactChange
from kanefe.integrate.events.event import Event
from kanefe.integrate.stepper import StepFailure

WITHOUT_END = "infinitely many events in a finite time"


def without_end(event: Event, what: str) -> StepFailure:
    """Return the failure of a run in which an event follows itself; `what` it did in what time."""
    if isinstance(event, ContactChange):
        return StepFailure(
            f"{', '.join(event.titles) or event.name}: {event.kind} {what}: {WITHOUT_END}",
            "a smaller rtol, another restitution, method='moreau-jean' with step=1e-3, whose steps go over impacts, or "
            "a contact that yields, kanefe.HuntCrossley(...)",
        )
    return StepFailure(
        f"event {event.name!r} {what}: {WITHOUT_END}",
        "let its action bring the scene to rest once it is slow, make the event terminal, or give the contact a "
        "stiffness (kf.CoordinateForce with limits, a spring)",
    )
