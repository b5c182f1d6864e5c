"""Dry friction along a joint coordinate: an anchor that holds, and slips where the cap is reached."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from kanefe.bodies.marker import CoordinateMarker
from kanefe.frames import Vector
from kanefe.loads.base import Action, End, Load, LoadEvent, LoadKernel, Tangent

FORCE = 0
LARGE_STRETCH = 10.0
"""Times the stretch under the cap: what a run measures errors of stretches against."""
SLIPS, STICKS = 0.0, 1.0


@dataclass(frozen=True, eq=False)
class CoordinateFriction(Load):
    """Friction along a coordinate of a joint, as `kanefe.contact.friction_laws.Coulomb` has it, under given caps.

    With w the stretch of a spring to the anchor, v the rate of the coordinate and ``p = k w + c v``, what acts against
    the motion is p, but not more than the cap; ``dw/dt = (force - k w) / c``, which is v while it sticks. States: w,
    and where the caps differ 1 while it sticks, 0 while it slips.

    Attributes
    ----------
    name : str
    ends : tuple of CoordinateMarker
        One.
    coordinate : str
        Of what its events are told: the body, and the coordinate where its joint has several.
    unit : str
        Of the coordinate: m or rad.
    sliding, static : float
        Cap while it slips, and to begin to, N or N m.
    stiffness, damping : float
        k and c, N/m and N s/m, or N m/rad and N m s/rad.
    rest : float or None
        Coordinate of the rest that it is looked at about: there the stretch follows from the coordinate.
    """

    name: str
    ends: tuple[CoordinateMarker, ...]
    coordinate: str = field(kw_only=True)
    unit: str = field(kw_only=True)
    sliding: float = field(kw_only=True)
    static: float = field(kw_only=True)
    stiffness: float = field(kw_only=True)
    damping: float = field(kw_only=True)
    rest: float | None = field(default=None, kw_only=True)

    kind = "friction"
    acts_at_once = True

    @property
    def columns(self) -> tuple[str, ...]:  # type: ignore[override]
        """Force on the body along the coordinate, stretch of the anchor's spring, and 1 while it sticks."""
        force = "torque [N m]" if self.unit == "rad" else "force [N]"
        return force, f"stretch [{self.unit}]", "sticks [1]"

    @property
    def subject(self) -> str:
        """The coordinate."""
        return self.coordinate

    @property
    def has_memory(self) -> bool:
        """Whether it slips under another cap than it sticks under, so that it has to be known which it does."""
        return self.static > self.sliding

    @property
    def initial_states(self) -> Vector:
        """Unstretched, held."""
        return np.array((0.0, STICKS)) if self.has_memory else np.zeros(1)

    def state_scales(self, acceleration: float) -> Vector:
        """Return small ones: a stretch is small beside the scene, and what holds has to be followed closely."""
        sizes = np.ones(len(self.initial_states))
        sizes[0] = LARGE_STRETCH * self.static / self.stiffness
        return sizes

    @property
    def has_rates(self) -> bool:
        """Its stretch moves, but about a rest, where it follows from the coordinate."""
        return self.rest is None

    def resting(self, ends: Sequence[End], softness: float = 0.0) -> CoordinateFriction:
        """Return the friction about a state of rest: its spring hangs from where the coordinate is now."""
        return replace(self, rest=float(ends[0].p[0]))

    def rested(self, ends: Sequence[End], states: Vector) -> Vector:
        """Return the internal states at rest: the anchor is stretched by what friction holds."""
        after = states.copy()
        after[0] = self._drag(ends[0], states) / self.stiffness
        return after

    def action(self, t: float, ends: Sequence[End], states: Vector) -> Action:
        """Return the force along the coordinate (Eq. 11)."""
        k, w, v = self.stiffness, self._stretch(ends[0], states), float(ends[0].v[0])
        drag = self._drag(ends[0], states)
        stretching = (drag - k * w) / self.damping
        rates = np.zeros(len(states))
        rates[0] = stretching if self.rest is None else 0.0
        wrench = np.zeros((1, 6))
        wrench[0, FORCE] = -drag
        return Action(wrench, 0.5 * k * w * w, drag * v - k * w * stretching, 0.0, rates)

    def tell(self, t: float, ends: Sequence[End], states: Vector) -> Vector:
        """Return the force on the body, the stretch, and whether it sticks."""
        end = ends[0]
        sticks = abs(self._pull(end, states)) <= self._cap(states)
        return np.array((-self._drag(end, states), self._stretch(end, states), sticks))

    def tangent(self, t: float, ends: Sequence[End], states: Vector) -> Tangent | None:
        """Return stiffness and damping of an anchor that holds: it stretches as the coordinate moves."""
        if abs(self._pull(ends[0], states)) > self._cap(states):
            return None
        row = np.zeros((1, 6))
        row[0, FORCE] = 1.0
        return Tangent(row, np.array((self.stiffness,)), np.array((self.damping,)))

    @property
    def kernel(self) -> LoadKernel:
        """Numbers: see `kanefe.kernels.force_elements.coordinate_friction`."""
        from kanefe.kernels.force_elements.coordinate_friction import coordinate_friction, coordinate_friction_watch

        of_rest = (0.0, 0.0) if self.rest is None else (1.0, self.rest)
        numbers = np.array((self.has_memory, self.sliding, self.static, self.stiffness, self.damping, *of_rest))
        return LoadKernel(coordinate_friction, numbers, coordinate_friction, coordinate_friction_watch)

    @property
    def events(self) -> tuple[LoadEvent, ...]:
        """When it slips and sticks."""
        slip, stick = (self._slip, self._stick) if self.has_memory else (None, None)
        return LoadEvent("slip", self._above, 1, slip), LoadEvent("stick", self._below, -1, stick)

    def _is_held(self, states: Vector) -> bool:
        return not self.has_memory or bool(states[1] > 0.5)

    def _cap(self, states: Vector) -> float:
        return self.static if self._is_held(states) else self.sliding

    def _stretch(self, end: End, states: Vector) -> float:
        return float(states[0]) + (0.0 if self.rest is None else float(end.p[0]) - self.rest)

    def _pull(self, end: End, states: Vector) -> float:
        return self.stiffness * self._stretch(end, states) + self.damping * float(end.v[0])

    def _drag(self, end: End, states: Vector) -> float:
        cap = self._cap(states)
        return min(max(self._pull(end, states), -cap), cap)

    def _above(self, t: float, ends: Sequence[End], states: Vector) -> float:
        """Return a number that rises above zero where it slips."""
        if not self._is_held(states):
            return self.static
        return abs(self._pull(ends[0], states)) - self.static

    def _below(self, t: float, ends: Sequence[End], states: Vector) -> float:
        """Return a number that falls below zero where it sticks."""
        if self.has_memory and self._is_held(states):
            return self.static
        return abs(self._pull(ends[0], states)) - self.sliding

    def _slip(self, t: float, ends: Sequence[End], states: Vector) -> Vector:
        return np.array((states[0], SLIPS))

    def _stick(self, t: float, ends: Sequence[End], states: Vector) -> Vector:
        return np.array((states[0], STICKS))
