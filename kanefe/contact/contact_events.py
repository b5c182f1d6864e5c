"""Moments of a contact: it touches and lifts, slips and sticks."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, Protocol

from kanefe.contact.laws.friction_laws import Coulomb
from kanefe.contact.laws.normal_laws import NormalLaw, Restitution
from kanefe.contact.touching_point import Touch, velocity_past
from kanefe.frames import Vector
from kanefe.loads.base import End, LoadEvent

if TYPE_CHECKING:
    from kanefe.contact.laws.bristles import LuGre

AT_THE_LIMIT = 1e-9
"""Of the normal force: probes this near to slipping or sticking do it with the first."""


def of_point(what: str, i: int) -> str:
    """Return the name of an event of one probe of a contact."""
    return f"{what} of point {i}"


class Touching(Protocol):
    """What is watched: see `kanefe.contact.contact.Contact`."""

    @property
    def probes(self) -> Sequence[Any]:
        """Its probes."""
        ...

    @property
    def normal(self) -> NormalLaw:
        """Its normal law."""
        ...

    @property
    def friction(self) -> Coulomb | LuGre | None:
        """Its friction."""
        ...

    @property
    def reports_points(self) -> bool:
        """Whether events of each probe are looked for."""
        ...

    @property
    def begins(self) -> int:
        """Where the states of the first probe are."""
        ...

    @property
    def each(self) -> int:
        """How many states a probe has."""
        ...

    def touches(self, ends: Sequence[End], states: Vector) -> list[Touch]:
        """Return what each probe does."""
        ...


class Watched:
    """What the events of a contact look at, found once for all of them at a state.

    Parameters
    ----------
    contact : Touching
    """

    def __init__(self, contact: Touching) -> None:
        self.contact = contact
        self._last: tuple[Sequence[End], list[Touch]] | None = None

    def __reduce__(self) -> tuple[type, tuple[Touching]]:
        return Watched, (self.contact,)

    def events(self) -> tuple[LoadEvent, ...]:
        """Return them. At a touch the step ends, so that none goes through a surface and out again."""
        law, friction = self.contact.normal, self.contact.friction
        impact = partial(self.impact, law) if isinstance(law, Restitution) else None
        found = [LoadEvent("touch", self.depth, 1, impact, ends_step=True), LoadEvent("lift", self.depth, -1)]
        if isinstance(friction, Coulomb):
            slip, stick = (partial(self.changed, to) if friction.has_memory else None for to in (0.0, 1.0))
            found += [LoadEvent("slip", self.above, 1, slip), LoadEvent("stick", self.below, -1, stick)]
        for i in range(len(self.contact.probes) if self.contact.reports_points else 0):
            found += self._events_of(i, isinstance(friction, Coulomb))
        return tuple(found)

    def _events_of(self, i: int, can_stick: bool) -> list[LoadEvent]:
        """Return those of a probe; what changes the states is done by those of the contact, which are found with it."""
        depth = partial(self.depth_of, i)
        found = [
            LoadEvent(of_point("touch", i), depth, 1, ends_step=True),
            LoadEvent(of_point("lift", i), depth, -1),
        ]
        if can_stick:
            found += [
                LoadEvent(of_point("slip", i), partial(self.above_of, i), 1),
                LoadEvent(of_point("stick", i), partial(self.below_of, i), -1),
            ]
        return found

    def touches(self, ends: Sequence[End], states: Vector) -> list[Touch]:
        """Return what each probe does."""
        last = self._last
        if last is None or last[0] is not ends:
            last = self._last = ends, self.contact.touches(ends, states)
        return last[1]

    def depth(self, t: float, ends: Sequence[End], states: Vector) -> float:
        """Return the depth of the deepest probe, m."""
        return max(touch.depth for touch in self.touches(ends, states))

    def depth_of(self, i: int, t: float, ends: Sequence[End], states: Vector) -> float:
        """Return the depth of a probe, m."""
        return self.touches(ends, states)[i].depth

    def above_of(self, i: int, t: float, ends: Sequence[End], states: Vector) -> float:
        """Return a number that is above zero while a probe slips."""
        touch = self.touches(ends, states)[i]
        if touch.depth > 0.0 and self._held(states)[i]:
            return touch.reserve + self._nearness * touch.press
        return touch.depth * self.contact.normal.stiffness

    def below_of(self, i: int, t: float, ends: Sequence[End], states: Vector) -> float:
        """Return a number that is below zero while a probe sticks."""
        touch = self.touches(ends, states)[i]
        if touch.depth > 0.0 and not (self._held(states)[i] and self._has_memory):
            return touch.reserve - self._nearness * touch.press
        return -touch.depth * self.contact.normal.stiffness

    def above(self, t: float, ends: Sequence[End], states: Vector) -> float:
        """Return a number that rises above zero where a probe slips that was held; below zero where none touches."""
        touches = self.touches(ends, states)
        held = zip(touches, self._held(states), strict=True)
        pressed = [touch.reserve for touch, is_held in held if touch.depth > 0.0 and is_held]
        return max(pressed) if pressed else min(touch.depth for touch in touches) * self.contact.normal.stiffness

    def below(self, t: float, ends: Sequence[End], states: Vector) -> float:
        """Return a number that falls below zero where a probe sticks that slipped; above zero where none touches."""
        touches = self.touches(ends, states)
        pressed = [(touch, held) for touch, held in zip(touches, self._held(states), strict=True) if touch.depth > 0.0]
        if not pressed:
            return -max(touch.depth for touch in touches) * self.contact.normal.stiffness
        if not self._has_memory:
            return max(touch.reserve for touch, _ in pressed)
        return min((touch.reserve for touch, is_held in pressed if not is_held), default=1.0)

    def impact(self, law: Restitution, t: float, ends: Sequence[End], states: Vector) -> Vector:
        """Return the states to go on with: lambda as of the speed at which what touches arrives."""
        after = states.copy()
        nearest = max(self.touches(ends, states), key=lambda touch: touch.depth)
        v = velocity_past(ends[0], ends[nearest.end], nearest.point)
        after[self.contact.begins - 1] = law.damping_at(-float(v @ nearest.normal))
        return after

    def changed(self, to: float, t: float, ends: Sequence[End], states: Vector) -> Vector:
        """Return the states in which those probes that are at their limit slip (0) or stick (1) from now on."""
        contact, after = self.contact, states.copy()
        sign = 1.0 if to == 0.0 else -1.0
        concerned = [
            (i, sign * touch.reserve, touch.press)
            for i, (touch, is_held) in enumerate(zip(self.touches(ends, states), self._held(states), strict=True))
            if touch.depth > 0.0 and is_held == (to == 0.0)
        ]
        extreme = max((reserve for _, reserve, _ in concerned), default=0.0)
        for i, reserve, press in concerned:
            if reserve >= min(extreme, -AT_THE_LIMIT * press):
                after[contact.begins + contact.each * i + 3] = to
        return after

    def _held(self, states: Vector) -> list[bool]:
        """Return of each probe whether it is held, where that is remembered; else that each may slip."""
        if not self._has_memory:
            return [True] * len(self.contact.probes)
        return [bool(flag > 0.5) for flag in states[self.contact.begins + 3 :: self.contact.each]]

    @property
    def _nearness(self) -> float:
        """How near to its limit a probe slips or sticks, of the normal force: that with which `changed` takes it in."""
        return AT_THE_LIMIT if self._has_memory else 0.0

    @property
    def _has_memory(self) -> bool:
        return self.contact.friction is not None and self.contact.friction.has_memory
