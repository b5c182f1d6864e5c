"""A contact evaluated: its functions for compiled code, and the same functions run in Python."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from kanefe.contact.contact_data import ContactData
from kanefe.contact.touching_point import Touch
from kanefe.frames import Vector
from kanefe.kernels.compiler.local_numbers import local_numbers
from kanefe.kernels.contact import contact_forces as kernels
from kanefe.kernels.contact import contact_outputs
from kanefe.kernels.contact.contact_places import AtState, ContactNumbers, Place
from kanefe.kernels.contact.meeting import look, look_up
from kanefe.kernels.contact.output_places import POINT_OUTPUTS
from kanefe.kernels.force_elements.places import WRENCH, WRENCHES, Done
from kanefe.loads.action import Action, End, LoadKernel
from kanefe.loads.by_kernel import numbers_of


def kernel_of(contact: ContactData) -> LoadKernel:
    """Return the compiled functions of a contact, with its numbers."""
    changes = contact.normal.has_impact or (contact.friction is not None and contact.friction.has_memory)
    change = kernels.contact_change if changes else None
    return LoadKernel(
        kernels.contact,
        contact.numbers,
        kernels.contact,
        kernels.contact_watch,
        change,
        contact_outputs.contact_outputs,
    )


class InPython:
    """The functions of a contact, called in Python with its ends and states as lists of numbers.

    Parameters
    ----------
    contact : ContactData
    ends : sequence of End
    states : ndarray
    """

    def __init__(self, contact: ContactData, ends: Sequence[End], states: Vector) -> None:
        self.contact, self.ends = contact, ends
        self._given = contact.listed, (), numbers_of(ends), np.asarray(states).tolist()
        self._states = self._given[3]

    def action(self) -> Action:
        """Return the forces on the surface and on what touches it (Eq. 11)."""
        last = WRENCHES + WRENCH * len(self.ends)
        out = self._written(kernels.contact, last + len(self._states))
        potential, taken, given = out[:WRENCHES]
        wrenches = np.array(out[WRENCHES:last]).reshape(-1, WRENCH)
        return Action(wrenches, potential, taken, given, np.array(out[last:]))

    def watched(self) -> list[float]:
        """Return the event values of the contact, in order."""
        points = len(self.contact.probes) if self.contact.reports_points else 0
        return self._written(kernels.contact_watch, self.contact.events_of_each * (1 + points))

    def outputs(self) -> list[float]:
        """Return what the columns of the contact name."""
        return self._written(contact_outputs.contact_outputs, len(self.contact.columns))

    def point_outputs(self) -> list[float]:
        """Return the outputs of each point, one after the other."""
        return self._written(contact_outputs.contact_point_outputs, POINT_OUTPUTS * len(self.contact.probes))

    def _written(self, function: Callable[..., None], count: int) -> list[Any]:
        """Return so many numbers that a kernel writes."""
        out: list[Any] = [0.0] * count
        function(0.0, *self._given, out)
        return out

    def touches(self) -> list[Touch]:
        """Return what each point does."""
        numbers, _, ends, states = self._given
        at = AtState(ContactNumbers(numbers), numbers, ends, states)
        met = look(at, local_numbers())
        return [self._touch(at, i, look_up(at, i, met)) for i in range(len(self.contact.probes))]

    def _touch(self, at: AtState, i: int, place: Place) -> Touch:
        contact, number = self.contact, self.contact.probes[i][0]
        touch = Touch(place.depth, number, _array(place.point), _array(place.normal), share=place.share)
        if place.share <= 0.0 or (
            kernels.is_apart(at, i, place) and (contact.rest is None or not contact.rest.softness)
        ):
            first = contact.begins + contact.each * i
            if contact.friction is None or contact.rest is not None:
                return touch
            return touch._replace(stretch=self.ends[0].A @ self._states[first : first + 3])
        found = kernels.touching(at, i, place)
        moment = np.zeros(3)
        if contact.friction is not None and contact.friction.turning_states:
            out: list[Any] = [0.0] * (WRENCHES + WRENCH * len(self.ends) + len(self._states))
            moment = -_array(kernels.turned(at, i, place, found.normal.force, Done(out)))
        rubbed = found.rubbed
        return touch._replace(
            normal_force=found.normal.force,
            along=_array(found.along),
            tangential=_array(rubbed.force),
            stretch=_array(found.stretch),
            stretch_rate=_array(rubbed.stretch_rate),
            slip_margin=rubbed.beyond,
            moment=moment,
        )


def _array(x: Any) -> Vector:
    """Return the numbers of a vector of kernels."""
    return np.array(x.numbers)
