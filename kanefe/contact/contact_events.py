"""Moments of a contact: it touches and lifts, slips and sticks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from kanefe.contact.contact_data import ContactData
from kanefe.contact.contact_evaluation import InPython
from kanefe.frames import Vector
from kanefe.kernels.contact.contact_forces import contact_change
from kanefe.loads.action import End
from kanefe.loads.base import LoadEvent
from kanefe.loads.by_kernel import ActionByKernel


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
        has_memory = friction is not None and friction.has_memory
        acting = {"touch": self.contact.normal.has_impact, "slip": has_memory, "stick": has_memory}
        names = ["touch", "lift", "slip", "stick"][: self.contact.events_of_each]
        # what changes the states is done by those of the contact, which are found with those of its points
        all_names = [(name, name) for name in names]
        for i in range(len(self.contact.probes) if self.contact.reports_points else 0):
            all_names += [(of_point(name, i), name) for name in names]
        return tuple(
            LoadEvent(
                name,
                partial(self.value, k),
                -1 if k % 2 else 1,
                self._action(k) if acting.get(name, False) else None,
                ends_step=kind in ("touch", "lift"),
            )
            for k, (name, kind) in enumerate(all_names)
        )

    def _action(self, k: int) -> Callable[[float, Sequence[End], Vector], Vector]:
        return ActionByKernel(self.contact, contact_change, k)

    def value(self, k: int, t: float, ends: Sequence[End], states: Vector) -> float:
        """Return an event value: see `kanefe.kernels.contact.contact_forces.watched`."""
        last = self._last
        if last is None or last[0] is not ends:
            last = self._last = ends, InPython(self.contact, ends, states).watched()
        return last[1][k]
