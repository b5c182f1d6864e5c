"""Moments of a contact: it touches and lifts, slips and sticks."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from kanefe.contact.contact_data import ContactData
from kanefe.contact.contact_evaluation import InPython
from kanefe.contact.touching_point import velocity_past
from kanefe.frames import Vector
from kanefe.kernels.contact.contact_forces import AT_THE_LIMIT
from kanefe.loads.action import End
from kanefe.loads.base import LoadEvent


def of_point(what: str, i: int) -> str:
    """Return the name of an event of one contact point."""
    return f"{what} of point {i}"


class Watched:
    """Event values of a contact, computed once for all of them at a state.

    Parameters
    ----------
    contact : ContactData
    """

    def __init__(self, contact: ContactData) -> None:
        self.contact = contact
        self._last: tuple[Sequence[End], list[float]] | None = None

    def __reduce__(self) -> tuple[type, tuple[ContactData]]:
        return Watched, (self.contact,)

    def events(self) -> tuple[LoadEvent, ...]:
        """Return them. At a touch the step ends, so that none goes through a surface and out again."""
        friction = self.contact.friction
        changes = {"touch": self.impact} if self.contact.normal.has_impact else {}
        if friction is not None and friction.has_memory:
            changes |= {"slip": partial(self.changed, 0.0), "stick": partial(self.changed, 1.0)}
        names = ["touch", "lift", "slip", "stick"][: self.contact.events_of_each]
        # what changes the states is done by those of the contact, which are found with those of its points
        all_names = [(name, name) for name in names]
        for i in range(len(self.contact.probes) if self.contact.reports_points else 0):
            all_names += [(of_point(name, i), name) for name in names]
        return tuple(
            LoadEvent(name, partial(self.value, k), -1 if k % 2 else 1, changes.get(name), ends_step=kind == "touch")
            for k, (name, kind) in enumerate(all_names)
        )

    def value(self, k: int, t: float, ends: Sequence[End], states: Vector) -> float:
        """Return an event value: see `kanefe.kernels.contact.contact_forces.watched`."""
        last = self._last
        if last is None or last[0] is not ends:
            last = self._last = ends, InPython(self.contact, ends, states).watched()
        return last[1][k]

    def impact(self, t: float, ends: Sequence[End], states: Vector) -> Vector:
        """Return the states after the event, with the damping for the approach speed."""
        after, contact = states.copy(), self.contact
        nearest = max(InPython(contact, ends, states).touches(), key=lambda touch: touch.depth)
        v = velocity_past(ends[0], ends[nearest.end], nearest.point)
        after[contact.impact_state] = contact.normal.damping_at(-float(v @ nearest.normal))
        return after

    def changed(self, to: float, t: float, ends: Sequence[End], states: Vector) -> Vector:
        """Return the states in which the points at their limit slip (0) or stick (1) from now on."""
        contact, after = self.contact, states.copy()
        sign = 1.0 if to == 0.0 else -1.0
        flags = states[contact.begins + 3 :: contact.each]
        concerned = [
            (i, sign * touch.slip_margin, touch.normal_force)
            for i, (touch, flag) in enumerate(zip(InPython(contact, ends, states).touches(), flags, strict=True))
            if touch.depth > 0.0 and (flag > 0.5) == (to == 0.0)
        ]
        extreme = max((slip_margin for _, slip_margin, _ in concerned), default=0.0)
        for i, slip_margin, normal_force in concerned:
            if slip_margin >= min(extreme, -AT_THE_LIMIT * normal_force):
                after[contact.begins + contact.each * i + 3] = to
        return after
