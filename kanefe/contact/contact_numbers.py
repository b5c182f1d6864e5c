"""A contact as numbers, and what the functions that are compiled make of them in Python."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from kanefe.contact.touching_point import Touch
from kanefe.frames import Vector
from kanefe.kernels.contact import contact_forces as kernels
from kanefe.kernels.contact.contact_places import POINT_NUMBERS, POINTS, ContactNumbers, PointNumbers
from kanefe.kernels.contact.detection import located, met_by
from kanefe.kernels.force_elements.blocks import flat
from kanefe.kernels.force_elements.bushing import nine
from kanefe.kernels.force_elements.places import WRENCH, WRENCHES, A
from kanefe.loads.action import Action, End, LoadKernel

if TYPE_CHECKING:
    from kanefe.contact.contact import Contact

NO_INPUTS: list[float] = []


def numbers_of(contact: Contact) -> Vector:
    """Return the numbers of a contact: see `ContactNumbers`."""
    law, friction, rest = contact.normal, contact.friction, contact.rest
    points = [flat(PointNumbers(float(end), *probe)) for end, probe in contact.probes]
    parts = [np.concatenate(points)]
    begin = [POINTS, POINTS + len(parts[0])]  # of these, and of what comes next

    def put(part: Any) -> float:
        parts.append(np.ravel(part))
        begin.append(begin[-1] + len(parts[-1]))
        return float(begin[-2])

    rests_at = 0.0
    if rest is not None:
        rests_at = put(np.hstack((rest.material, rest.marks, rest.turns.reshape(-1, 9))))
    head = ContactNumbers(
        points=len(points),
        ends=len(contact.ends),
        shape=put(np.append(float(contact.shape.kind), contact.shape.numbers)),
        rests_at=rests_at,
        softness=0.0 if rest is None else rest.softness,
        belt=contact.belt,
        reports_points=contact.reports_points,
        normal=law.kind,
        normal_at=put(flat(law.block)),
        stiffness=law.stiffness,
        impact=contact.impact_state,
        branches=law.has_branch,
        friction=0.0 if friction is None else friction.kind,
        friction_at=0.0 if friction is None else put(flat(friction.block)),
        holds=friction is not None and friction.holds,
        has_memory=friction is not None and friction.has_memory,
        turning=0.0 if friction is None else friction.turning_states,
        relaxation=0.0 if friction is None else friction.relaxation,
        spring=0.0 if friction is None else friction.spring,
        first=contact.begins,
        each=contact.each,
    )
    return np.concatenate((flat(head), *parts))


def kernel_of(contact: Contact) -> LoadKernel:
    """Return the compiled functions of a contact, with its numbers."""
    return LoadKernel(kernels.contact, contact.numbers, kernels.contact, kernels.contact_watch)


class Met(NamedTuple):
    """A point of a contact at a state: depth (m), normal and place in N."""

    depth: float
    normal: tuple[float, ...]
    point: tuple[float, ...]


class InPython:
    """The functions of a contact, called in Python with its ends and states as lists of numbers.

    Parameters
    ----------
    contact : Contact
    ends : sequence of End
    states : ndarray
    """

    def __init__(self, contact: Contact, ends: Sequence[End], states: Vector) -> None:
        self.contact, self.ends = contact, ends
        self._numbers = contact.listed
        self._ends = np.concatenate([x for end in ends for x in (end.p, end.A.ravel(), end.v, end.w)]).tolist()
        self._states = np.asarray(states).tolist()
        self._axes = nine(self._ends, A)

    def _met(self) -> Iterator[tuple[int, Met]]:
        met = met_by(self._numbers, self._ends) if self.contact.is_found_by_kernel else None
        for i, (number, _) in enumerate(self.contact.probes):
            if met is None:
                yield i, self.contact.found(self.ends[0], self.ends[number])
            else:
                own = POINTS + POINT_NUMBERS * i
                yield i, Met(*located(self._numbers, own, self._ends, met))

    def action(self) -> Action:
        """Return the forces on the surface and on what touches it (Eq. 11)."""
        last = WRENCHES + WRENCH * len(self.ends)
        out: list[Any] = [0.0] * (last + len(self._states))
        for i, met in self._met():
            kernels.put_point(self._numbers, i, *met, self._axes, self._ends, self._states, out)
        potential, taken, given = out[:WRENCHES]
        wrenches = np.array(out[WRENCHES:last]).reshape(-1, WRENCH)
        return Action(wrenches, potential, taken, given, np.array(out[last:]))

    def watched(self) -> list[float]:
        """Return what the events of the contact look at, in their order."""
        points = len(self.contact.probes) if self.contact.reports_points else 0
        out: list[Any] = [0.0] * (self.contact.events_of_each * (1 + points))
        seen = kernels.nothing_seen()
        for i, met in self._met():
            seen = kernels.watched(self._numbers, i, *met, self._axes, self._ends, self._states, out, seen)
        kernels.put_seen(self._numbers, seen, out)
        return out

    def touches(self) -> list[Touch]:
        """Return what each point does."""
        return [self._touch(i, met) for i, met in self._met()]

    def _touch(self, i: int, met: Met) -> Touch:
        contact, number = self.contact, self.contact.probes[i][0]
        given = self._numbers, i, *met, self._axes, self._ends, self._states
        place, normal = np.array(met.point), np.array(met.normal)
        if met.depth <= 0.0 and (contact.rest is None or contact.rest.softness == 0.0):
            at = contact.begins + contact.each * i
            stretch = self._states[at : at + 3] if contact.friction is not None and contact.rest is None else (0, 0, 0)
            return Touch(met.depth, number, place, normal, stretch=self.ends[0].A @ stretch)
        _, along, _, _, pressed, (w, drag, w_rate, _, _, beyond) = kernels.touching(*given)
        moment = np.zeros(3)
        if contact.friction is not None and contact.friction.turning_states:
            out: list[Any] = [0.0] * (WRENCHES + WRENCH * len(self.ends) + len(self._states))
            moment = -np.array(
                kernels.turned(self._numbers, i, met.normal, self._axes, self._ends, pressed[0], self._states, out)
            )
        vectors = [np.array(x) for x in (along, drag, w, w_rate)]
        return Touch(met.depth, number, place, normal, pressed[0], *vectors, reserve=beyond, moment=moment)
