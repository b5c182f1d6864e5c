"""Contacts: points of some frames touch a surface, and slide on it or stick to it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from kanefe.contact.contact_anchors import anchored, anchors_of
from kanefe.contact.contact_data import ContactData
from kanefe.contact.contact_evaluation import InPython, kernel_of
from kanefe.contact.contact_events import Watched
from kanefe.contact.rest import Rest
from kanefe.contact.starts import warn_of_start
from kanefe.frames import Vector, across, cross
from kanefe.kernels.contact.laws.normal_law import normal_law
from kanefe.loads.action import Action, End, LoadKernel, Tangent
from kanefe.loads.base import Load, LoadEvent
from kanefe.loads.reach import LoadReach
from kanefe.loads.screened import ScreenedLoad

if TYPE_CHECKING:
    from kanefe.contact.touching_point import Touch
    from kanefe.contact.wanted_contact import WantedContact
    from kanefe.loads.anchors import Anchor

OPEN, STICKS, SLIPS = range(3)


@dataclass(frozen=True, eq=False)
class Contact(ContactData):
    """A compliant contact with normal force and friction: see `ContactData`."""

    @property
    def screened(self) -> ScreenedLoad:  # type: ignore[override]
        """What of it screened runs do not have, and friction that holds so many times as much."""
        friction, hysteresis = self.friction, "a hysteresis" if self.normal.has_branch else ""
        if friction is None:
            return ScreenedLoad(hysteresis)
        return ScreenedLoad(
            hysteresis or friction.not_screened,
            slip_damping=friction.anchor(1.0, 0.0)[1],
            stuck=lambda factor: replace(self, friction=friction.stuck(factor)),
        )

    @classmethod
    def made(cls, wanted: WantedContact, **more: Any) -> Self:
        """Return the contact that a scene wants; a ModelError says what is wrong with its laws."""
        law, friction = normal_law(wanted.normal, wanted.label), wanted.friction
        if friction is not None:
            friction = friction.completed(law.straight, [probe.lever for _, probe in wanted.probes], wanted.label)
        return cls(wanted.name, wanted.ends, wanted.shape, wanted.probes, law, friction, wanted.belt, **more)

    def touches(self, ends: Sequence[End], states: Vector) -> list[Touch]:
        """Return the status of each contact point."""
        return InPython(self, ends, states).touches()

    def action(self, t: float, ends: Sequence[End], states: Vector) -> Action:
        """Return the forces on the surface and on what touches it (Eq. 11)."""
        return InPython(self, ends, states).action()

    def started(self, t: float, ends: Sequence[End]) -> Contact:
        """Return it with the points that slip at the start; warn of a bad start."""
        touches = self.touches(ends, replace(self, slides=()).initial_states)
        warn_of_start(self.name, self.probes, ends, touches)
        slides = [i for i, touch in enumerate(touches) if touch.depth <= 0.0 or touch.slip_margin > 0.0]
        return replace(self, slides=tuple(slides))

    def anchors(self, ends: Sequence[End], states: Vector) -> list[Anchor]:
        """Return those of its friction where it touches."""
        return anchors_of(self, ends, states)

    def anchored(
        self, ends: Sequence[End], states: Vector, tangentials: Sequence[Vector], slips: Sequence[bool]
    ) -> Vector:
        """Return the internal states with which these give some friction."""
        return anchored(self, ends, states, tangentials, slips)

    def resting(self, ends: Sequence[End], softness: float = 0.0) -> Contact:
        """Return the contact about a state of rest: what sticks hangs on springs to where it is now."""
        touches = self.touches(ends, self.initial_states)
        material = np.array([ends[touch.end].A.T @ (touch.point - ends[touch.end].p) for touch in touches])
        marks = np.array([ends[0].A.T @ (touch.point - ends[0].p) for touch in touches])
        turns = np.array([ends[0].A.T @ ends[touch.end].A for touch in touches])
        return replace(self, rest=Rest(material, marks, turns, softness))

    def rested(self, ends: Sequence[End], states: Vector) -> Vector:
        """Return the internal states at rest: anchors are stretched by what friction holds."""
        after, law = states.copy(), self.friction
        if law is None:
            return after
        for i, touch in enumerate(self.touches(ends, states)):
            lever = self.probes[i][1].lever
            k, at = law.anchor(touch.share, max(touch.normal_force, 1e-300))[0], self.begins + self.each * i
            after[at : at + 3] = ends[0].A.T @ touch.tangential / k if k > 0.0 else 0.0  # without a spring none is bent
            if law.has_memory:
                after[at + 3] = float(touch.depth > 0.0)
            turning = after[self.turning(i)]
            about = float(touch.moment @ touch.normal)
            if law.torsional > 0.0:
                turning[0] = -about / (k * law.torsional**2)
            if law.rolling > 0.0:
                turning[-3:] = -(ends[0].A.T @ (touch.moment - about * touch.normal)) / (k * lever**2)
        return after

    def tell(self, t: float, ends: Sequence[End], states: Vector) -> Vector:
        """Return what `columns` say of force, depth, slip, place, work of friction and status."""
        return np.array(InPython(self, ends, states).outputs())

    def tangent(self, t: float, ends: Sequence[End], states: Vector) -> Tangent | None:
        """Return stiffness and damping of closed and of sticking points: anchors stretch as its ends move."""
        rows, stiffness, damping = [], [], []
        for touch in self.touches(ends, states):
            if touch.depth <= 0.0:
                continue
            directions = [(touch.normal, self.normal.slope(touch.depth, touch.share), 0.0)]
            if self.friction is not None and touch.slip_margin <= 0.0:
                k, c = self.friction.anchor(touch.share, touch.normal_force)
                directions += [(along, k, c) for along in across(touch.normal)]
            for along, k, c in directions:
                row = np.zeros((len(ends), 6))
                for number, sign in ((touch.end, 1.0), (0, -1.0)):
                    row[number, :3] += sign * along
                    row[number, 3:] += sign * cross(touch.point - ends[number].p, along)
                rows.append(row.ravel())
                stiffness.append(k)
                damping.append(c)
        if not rows:
            return None
        return Tangent(np.array(rows), np.array(stiffness), np.array(damping))

    @property
    def reach(self) -> LoadReach | None:
        """Balls about its points, against the bounds of the surface; one about a rest acts at a distance."""
        if self.rest is not None and self.rest.softness > 0.0:
            return None
        law, decays = self.friction, np.zeros((len(self.initial_states), 2))
        if law is not None and self.rest is None:
            for i, (_, probe) in enumerate(self.probes):
                at, k = self.begins + self.each * i, probe.share * law.spring
                decays[at : at + 3] = law.relaxation, 0.5 * k
                for place, arm in enumerate(law.arms(probe.lever), self.turning(i).start):
                    decays[place] = law.relaxation, 0.5 * k * arm**2
        factor = self.normal.stiffness
        of_each = (-1.0, -1.0, -factor, factor)[: self.events_of_each]
        watched = of_each * (len(self.events) // len(of_each))
        balls = tuple((end, probe.point, probe.extent) for end, probe in self.probes)
        return LoadReach(balls, self.shape.bounds, decays, watched)

    @property
    def kernel(self) -> LoadKernel | None:
        """Its numbers, and the functions of `kanefe.kernels.contact.contact_forces`."""
        return kernel_of(self)

    def with_ends(self, ends: tuple[Any, ...]) -> Contact:
        """Return the same contact between other frames."""
        return replace(self, ends=ends)

    @property
    def events(self) -> tuple[LoadEvent, ...]:
        """When it touches and lifts, slips and sticks."""
        return Watched(self).events()

    def in_detail(self) -> Contact | None:
        """Return the contact with the events of each point; None for one point, and for boxes on boxes.

        What touches of two boxes changes from corners to edges: it is no point that is known from before.
        """
        is_of_points = len(self.probes) > 1 and self.probes[0][1].ring >= 0.0
        return replace(self, reports_points=True) if is_of_points else None


def compliant_contacts(loads: Sequence[Load]) -> Iterator[tuple[int, Contact]]:
    """Yield the compliant contacts among loads, each with its number there."""
    return ((i, load) for i, load in enumerate(loads) if isinstance(load, Contact))
