"""A contact evaluated: its functions for compiled code, and the same functions run in Python."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from kanefe.contact.contact_data import ContactData, Met
from kanefe.contact.touching_point import Touch
from kanefe.frames import Vector
from kanefe.kernels.contact import contact_forces as kernels
from kanefe.kernels.contact import contact_outputs
from kanefe.kernels.contact.output_places import POINT_OUTPUTS
from kanefe.kernels.force_elements.bushing import nine
from kanefe.kernels.force_elements.places import WRENCH, WRENCHES, A
from kanefe.loads.action import Action, End, LoadKernel
from kanefe.loads.by_kernel import numbers_of


def kernel_of(contact: ContactData) -> LoadKernel:
    """Return the compiled functions of a contact, with its numbers."""
    changes = contact.normal.has_impact or (contact.friction is not None and contact.friction.has_memory)
    of = contact.functions
    return LoadKernel(of.force, contact.numbers, of.force, of.watch, of.change if changes else None, of.outputs)


def _one_of(numbers: Any, i: int, ends: Any, met: list[Met]) -> Met:
    """Return the place of a point among those that are known."""
    return met[i]


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
        self._numbers = contact.listed
        self._ends = numbers_of(ends)
        self._states = np.asarray(states).tolist()
        self._axes = nine(self._ends, A)
        self._met = contact.met(self._ends)
        self._given = self._met, self._numbers, self._ends, self._states

    def action(self) -> Action:
        """Return the forces on the surface and on what touches it (Eq. 11)."""
        last = WRENCHES + WRENCH * len(self.ends)
        out: list[Any] = [0.0] * (last + len(self._states))
        kernels.put_points(_one_of, *self._given, out)
        potential, taken, given = out[:WRENCHES]
        wrenches = np.array(out[WRENCHES:last]).reshape(-1, WRENCH)
        return Action(wrenches, potential, taken, given, np.array(out[last:]))

    def watched(self) -> list[float]:
        """Return the event values of the contact, in order."""
        points = len(self.contact.probes) if self.contact.reports_points else 0
        out: list[Any] = [0.0] * (self.contact.events_of_each * (1 + points))
        kernels.watch_points(_one_of, *self._given, out)
        return out

    def outputs(self) -> list[float]:
        """Return what the columns of the contact name."""
        out: list[Any] = [0.0] * len(self.contact.columns)
        contact_outputs.tell_whole(_one_of, *self._given, out)
        return out

    def point_outputs(self) -> list[float]:
        """Return the outputs of each point, one after the other."""
        out: list[Any] = [0.0] * (POINT_OUTPUTS * len(self.contact.probes))
        contact_outputs.tell_points(_one_of, *self._given, out)
        return out

    def touches(self) -> list[Touch]:
        """Return what each point does."""
        return [self._touch(i, met) for i, met in enumerate(self._met)]

    def _touch(self, i: int, met: Met) -> Touch:
        contact, number = self.contact, self.contact.probes[i][0]
        given = self._numbers, i, met, self._axes, self._ends, self._states
        place, normal = np.array(met.point), np.array(met.normal)
        is_apart = kernels.is_apart(self._numbers, i, met, self._ends)
        if met.share <= 0.0 or (is_apart and (contact.rest is None or contact.rest.softness == 0.0)):
            at = contact.begins + contact.each * i
            stretch = self._states[at : at + 3] if contact.friction is not None and contact.rest is None else (0, 0, 0)
            return Touch(met.depth, number, place, normal, stretch=self.ends[0].A @ stretch, share=met.share)
        _, along, _, _, pressed, (w, tangential, w_rate, _, _, beyond) = kernels.touching(*given)
        moment = np.zeros(3)
        if contact.friction is not None and contact.friction.turning_states:
            out: list[Any] = [0.0] * (WRENCHES + WRENCH * len(self.ends) + len(self._states))
            where = self._numbers, i, met.normal, met.share, self._axes, self._ends
            moment = -np.array(kernels.turned(*where, pressed[0], self._states, out))
        found = Touch(met.depth, number, place, normal, pressed[0], slip_margin=beyond, moment=moment, share=met.share)
        slides, friction, stretch, stretch_rate = (np.array(x) for x in (along, tangential, w, w_rate))
        return found._replace(along=slides, tangential=friction, stretch=stretch, stretch_rate=stretch_rate)
